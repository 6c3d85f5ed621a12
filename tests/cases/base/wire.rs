//! The wire to a base, without a wire: frames in damaged streams, conversations in memory, track speeds, and the judge of
//! what a base does.

mod conversations;
mod emulator;
mod goldens;
mod guard;
mod keeper;
mod ld19;
mod line;
mod mixing;
mod plausibility;
#[cfg(all(unix, feature = "serial"))]
mod port;
mod stops;
mod streams;
mod sure;
