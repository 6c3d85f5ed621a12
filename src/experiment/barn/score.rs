//! What a run is worth.

/// The challenge's score of a run: nothing unless it reached the goal, else `OT / clip(T, 2 OT, 8 OT)`, from 0.125 to
/// 0.5. `time_s` is T, `optimal_time_s` OT, above zero.
///
/// Here T is counted from the first tick; the challenge's clock starts when the robot has moved 0.1 m.
#[must_use]
pub fn score(reached: bool, time_s: f64, optimal_time_s: f64) -> f64 {
    if !reached {
        return 0.0;
    }
    optimal_time_s / time_s.clamp(2.0 * optimal_time_s, 8.0 * optimal_time_s)
}
