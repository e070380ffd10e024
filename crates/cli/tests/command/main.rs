//! Runs the real command in a new folder and checks its files, messages and errors.

#![allow(clippy::unwrap_used, reason = "test helpers may panic, like tests")]

mod bad_recording;
mod calibrate_camera;
mod calibrate_depth;
mod calibrate_gel;
mod calibrate_guide;
mod damage;
mod elastic;
mod evaluate;
mod folder;
mod foxglove;
mod live;
mod output;
mod part;
mod pattern;
mod profile;
mod profile_command;
mod record;
mod refusals;
mod reproduce;
mod shell;
mod simulate;
mod skipped;
mod threads;
mod track;
mod usage;
mod video;
mod workbench;
mod written;
