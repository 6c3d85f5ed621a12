//! The robot of the BARN benchmark.

use inbye::experiment::barn::barn_config;
use inbye::geometry::{Point, Pose};

#[test]
fn barn_discs_cover_the_footprint_closely() {
    let footprint = barn_config(2.0).robot.footprint;
    for step_x in 0..=84 {
        for step_y in 0..=66 {
            let (x, y) = (f64::from(step_x) * 0.005, f64::from(step_y) * 0.005);
            let point = Point::new(x - 0.21, y - 0.165);
            let gap_m = footprint.gap_to_disc_m(&Pose::default(), &point, 0.0);
            assert!(gap_m <= 1e-12, "{point:?} is {gap_m} m outside");
        }
    }
    assert!(footprint.circumscribed_radius_m() < libm::hypot(0.21, 0.165) + 0.001);
}
