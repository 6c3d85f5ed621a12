//! Measurements and experiments: density and quality of sampling, contacts, times, the paper, cells and their records, and the soak.

mod support {
    pub mod changed_engine;
    pub mod gap;
    pub mod room;
}

mod cases {
    mod experiment {
        mod blind_lidar;
        mod cells;
        mod contact;
        mod density;
        mod fault_matrix;
        mod lockstep;
        mod movingai;
        mod paper;
        mod perception;
        mod quality;
        mod records;
        mod reference;
        mod soak;
        mod timing;
    }
}
