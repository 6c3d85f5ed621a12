//! The paper's experiments, repeated: its paths, and the same scenes driven.

mod drives;
#[path = "../paths/gap.rs"]
mod gap;
mod paths;
