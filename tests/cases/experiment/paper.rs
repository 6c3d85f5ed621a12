//! The paper's experiments, repeated: its paths, and the same scenes driven.

mod drives;
mod paths;
