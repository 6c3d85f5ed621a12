//! Measurements and experiments: density and quality of sampling, times, the paper, and the soak.

mod support {
    pub mod gap;
}

mod cases {
    mod experiment {
        mod density;
        mod movingai;
        mod paper;
        mod quality;
        mod soak;
        mod timing;
    }
}
