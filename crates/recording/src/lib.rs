//! Recordings.

#![allow(dead_code)]

mod container;
