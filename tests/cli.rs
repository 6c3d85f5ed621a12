//! The program as users and scripts meet it: what goes in, what comes out, and the exit status.

mod support {
    pub mod mcap_copy;
    pub mod room;
}

mod cases {
    mod cli {
        mod barn;
        mod config;
        #[cfg(feature = "png")]
        mod drawing;
        mod drive;
        mod dynabarn;
        mod evaluate;
        #[cfg(unix)]
        mod files;
        mod first_steps;
        mod help;
        mod localization;
        mod logs;
        mod map_masks;
        mod memory;
        mod movingai;
        #[cfg(unix)]
        mod own_global_planners;
        #[cfg(unix)]
        mod own_programs;
        mod paper;
        mod plan;
        mod program;
        mod recording;
        mod records;
        mod ros_logs;
        mod shells;
        mod soak;
        #[cfg(unix)]
        mod surplus_lines;
        mod tools;
        mod tune;
        mod unusable_input;
        mod unusable_plans;
        mod unusable_problems;
        mod verbosity;
    }
}
