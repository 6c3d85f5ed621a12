//! The simulator: lidar, base, people, settings.

mod cases {
    mod sim {
        mod lidar_mounting;
        mod pedestrians;
        mod plant;
        mod simulated_base;
        mod simulation;
        mod simulator_settings;
        mod timed_path;
    }
}
