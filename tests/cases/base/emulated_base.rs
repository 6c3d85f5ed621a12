//! The program with an emulated base in another process: commands, signals, a panic, a kill, and missions.
#![cfg(all(unix, feature = "serial", feature = "cli"))]

mod base_with_lidar;
mod commands;
mod faults;
mod missions;
mod processes;
mod shutdown;
