//! The engines: all of them return the same bits, near those of a naive f64 oracle, also where a GPU fails.

mod support {
    pub mod any_scene;
    pub mod closeness;
    pub mod extremes;
    pub mod naive;
    pub mod ranges;
    pub mod scenes;
}

mod cases {
    mod engine {
        mod batches;
        mod failover;
        mod lanes;
        mod numeric;
        mod oracle;
        mod rollout;
        mod shaders;
        mod shared;
        mod window;
    }
}
