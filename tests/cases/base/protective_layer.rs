//! The protective layer: what stops and slows a command, and drives into obstacles with a plant that brakes as stated.

mod body;
mod checks;
mod drives;
mod limits;
mod scans;
mod zones;
