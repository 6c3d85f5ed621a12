//! Global planning: grid search against an independent one, and paths through their three stages.

mod support {
    pub mod gap;
    pub mod random_grid;
}

mod cases {
    mod global {
        mod curvature;
        mod heuristics;
        mod paths;
        mod planners;
        mod polyline;
        mod reachable;
        mod smoothing;
    }
}
