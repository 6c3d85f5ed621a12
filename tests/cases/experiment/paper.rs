//! The paper's experiments, repeated: its paths, and drives through its scenes.

mod drives;
mod findings;
mod paths;
