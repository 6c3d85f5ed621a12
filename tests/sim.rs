//! The simulator: lidar, base, people, settings.

mod cases {
    mod sim {
        mod pedestrians;
        mod plant;
        mod simulated_base;
        mod simulation;
        mod simulator_settings;
        mod timed_path;
    }
}
