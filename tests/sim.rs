//! The simulator: lidar, base, people, settings.

mod cases {
    mod sim {
        mod simulated_base;
        mod simulation;
        mod simulator_settings;
        mod walkers;
    }
}
