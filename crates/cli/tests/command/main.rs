//! The real command in a fresh folder: what it writes, what it says, and how it fails.

#![allow(clippy::unwrap_used, reason = "what helps a test may panic like one")]

mod calibrate_camera;
mod calibrate_depth;
mod calibrate_gel;
mod calibrate_guide;
mod damage;
mod elastic;
mod evaluate;
mod output;
mod part;
mod pattern;
mod profile;
mod profile_command;
mod refusals;
mod reproduce;
mod shell;
mod simulate;
mod skipped;
mod threads;
mod track;
mod usage;
mod workbench;
mod written;
