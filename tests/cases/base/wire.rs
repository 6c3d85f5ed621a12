//! Protocols and safety without a serial port: frames in damaged streams, sessions with simulated devices, ramps, the fault
//! detector and the supervisor.

mod emulated_machine;
mod emulator;
mod encoder_speed;
mod fault_detector;
mod goldens;
mod harness;
mod late_loop;
mod ld19;
mod mixer;
mod own_protocol;
#[cfg(all(unix, feature = "serial"))]
mod port;
mod property;
mod protection;
mod roboclaw_status;
mod safety;
mod safety_limits;
mod sessions;
mod settings;
mod simulated_link;
mod stops;
mod streams;
mod supervisor;
