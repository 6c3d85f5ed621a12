//! The program against an emulated base in another process: commands, signals, a panic, a kill, and missions.
#![cfg(all(unix, feature = "serial", feature = "cli"))]

mod commands;
mod endings;
mod missions;
mod processes;
mod whole_robot;
