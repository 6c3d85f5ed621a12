//! The wire to a base, without a wire: frames in damaged streams, conversations in memory, track speeds, and the judge of
//! what a base does.

mod conversations;
mod emulator;
mod fault_detector;
mod goldens;
mod ld19;
mod line;
mod mixing;
#[cfg(all(unix, feature = "serial"))]
mod port;
mod safety;
mod stops;
mod streams;
mod supervisor;
mod sure;
