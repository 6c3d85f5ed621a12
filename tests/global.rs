//! Global planning: grid search against an independent one, and paths through their three stages.

mod support {
    pub mod gap;
    pub mod random_ground;
}

mod cases {
    mod global {
        mod paths;
        mod planners;
    }
}
