//! Measurements and experiments: density and quality of sampling, contacts, times, the paper, and the soak.

mod support {
    pub mod gap;
}

mod cases {
    mod experiment {
        mod contact;
        mod density;
        mod movingai;
        mod paper;
        mod quality;
        mod soak;
        mod timing;
    }
}
