//! What one problem may ask of the playground's server: far less than the engines take, so that nobody's request holds up the
//! others for long.

use hyper::StatusCode;
use inbye::local::Problem;

use super::refusal::Refusal;

/// Most samples.
pub const MOST_SAMPLES: usize = 1 << 19;
/// Most moving obstacles.
pub const MOST_OBSTACLES: usize = 32;
/// Most meetings of a disc with the ground or a moving obstacle, over all samples and steps: well below a second on one core.
pub const MOST_MEETINGS: usize = 1 << 28;

/// Refuses a problem that is too large.
pub fn check(problem: &Problem) -> Result<(), Refusal> {
    let samples = problem.window.len();
    let obstacles = problem.obstacles.len();
    let steps = problem.steps as usize;
    let meetings = samples
        .saturating_mul(steps)
        .saturating_mul(problem.footprint.discs().len())
        .saturating_mul(1 + obstacles);
    for (what, number, most, mend) in [
        ("samples", samples, MOST_SAMPLES, "sample less densely"),
        ("moving obstacles", obstacles, MOST_OBSTACLES, "remove some"),
        (
            "samples x steps x discs x (1 + obstacles)",
            meetings,
            MOST_MEETINGS,
            "sample less densely, look less far ahead, or remove obstacles",
        ),
    ] {
        if number > most {
            let what = format!("{number} {what}: at most {most} here: {mend}");
            return Err(Refusal::new(StatusCode::BAD_REQUEST, what));
        }
    }
    Ok(())
}
