//! Tests that need what a machine may lack: an adapter, a browser, a Python with certain packages, public data.
//!
//! What is missing is ignored with its reason. It fails instead where the variable `INBYE_REQUIRE` names it.

use std::process::ExitCode;

use libtest_mimic::{Arguments, Trial};

mod support {
    pub mod adapters;
    pub mod batch_trials;
    pub mod browser;
    pub mod carried;
    pub mod changed_engine;
    pub mod cpu_trials;
    pub mod extremes;
    pub mod gap;
    pub mod gpu_trials;
    pub mod hand_png;
    pub mod kernel;
    pub mod loss_trials;
    pub mod machine_code;
    pub mod map_kinds;
    pub mod mcap_copy;
    pub mod operations;
    pub mod python;
    pub mod radv;
    pub mod requirements;
    pub mod room;
    pub mod trials;
}

mod cases {
    pub mod conditional {
        pub mod barn;
        pub mod carried;
        pub mod engine_parity;
        pub mod fuzzed;
        pub mod live;
        pub mod logs;
        pub mod map_reader;
        pub mod missions;
        pub mod movingai;
        #[cfg(feature = "ros2")]
        pub mod node;
        pub mod planners;
        pub mod player;
        pub mod playground;
        pub mod public_paths;
        pub mod recording;
        pub mod shader_statistics;
        pub mod sweep;
    }
}

/// A subject and its trials.
type Subject = (&'static str, fn() -> Vec<Trial>);

fn main() -> ExitCode {
    match support::radv::print_if_asked() {
        Ok(false) => {}
        Ok(true) => return ExitCode::SUCCESS,
        Err(error) => {
            #[expect(clippy::print_stderr, reason = "the process that asks reads it")]
            {
                eprintln!("{error}");
            }
            return ExitCode::FAILURE;
        }
    }
    let subjects: &[Subject] = &[
        ("barn", cases::conditional::barn::trials),
        ("carried", cases::conditional::carried::trials),
        ("engine parity", cases::conditional::engine_parity::trials),
        ("fuzzed", cases::conditional::fuzzed::trials),
        ("live", cases::conditional::live::trials),
        ("logs", cases::conditional::logs::trials),
        ("map reader", cases::conditional::map_reader::trials),
        ("missions", cases::conditional::missions::trials),
        ("movingai", cases::conditional::movingai::trials),
        #[cfg(feature = "ros2")]
        ("node", cases::conditional::node::trials),
        ("planners", cases::conditional::planners::trials),
        ("player", cases::conditional::player::trials),
        ("playground", cases::conditional::playground::trials),
        ("public paths", cases::conditional::public_paths::trials),
        ("recording", cases::conditional::recording::trials),
        ("shader statistics", cases::conditional::shader_statistics::trials),
        ("sweep", cases::conditional::sweep::trials),
    ];
    let mut all = Vec::new();
    for (subject, trials) in subjects {
        all.extend(trials().into_iter().map(|trial| trial.with_kind(*subject)));
    }
    libtest_mimic::run(&Arguments::from_args(), all).exit_code()
}
