//! The wall clock: read here and handed down as a parameter.

use std::time::Instant;

/// A clock in seconds since it was made.
pub fn wall_clock() -> impl FnMut() -> f64 {
    let began = Instant::now();
    move || began.elapsed().as_secs_f64()
}
