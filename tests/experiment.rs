//! Experiments: the soak and the paper.

mod support {
    pub mod gap;
}

mod cases {
    mod experiment {
        mod paper;
        mod soak;
    }
}
