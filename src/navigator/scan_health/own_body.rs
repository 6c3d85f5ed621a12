//! Returns within the robot's own outline: from dust, from dirt on the lidar, or from a part of the robot.

use crate::geometry::{Pose, Vector};
use crate::map::Scan;
use crate::robot::Footprint;

/// A return within this distance of the robot's body lies in it, metres: the noise of a range.
const OWN_BODY_MARGIN_M: f64 = 0.02;
/// This many neighbouring beams that end so deep within the robot's body, along the beam, metres, show the robot or dirt on the lidar.
const OWN_BODY_BEAMS: usize = 3;
const OWN_BODY_DEPTH_M: f64 = 0.1;

/// Whether a beam ends within the robot's body, by at least a depth along the beam, metres.
fn ends_within(body: &Footprint, scan: &Scan, depth_m: f64) -> impl Fn(usize) -> bool {
    let reach_m = body.body_radius_m() + scan.origin.to_vector().norm() + OWN_BODY_MARGIN_M;
    move |beam| {
        let range_m = scan.ranges[beam] + depth_m;
        range_m > depth_m && range_m <= reach_m && {
            let (sin, cos) = libm::sincos(scan.angle(beam));
            let end = scan.origin + Vector::new(cos, sin) * range_m;
            body.gap_to_disc_m(&Pose::default(), &end, OWN_BODY_MARGIN_M) <= 0.0
        }
    }
}

/// Whether neighbouring beams end deep within the robot's body: on dirt, or on a part of the robot. No obstacle is there.
pub(super) fn sees_own_body(body: &Footprint, scan: &Scan) -> bool {
    let ends_within = ends_within(body, scan, OWN_BODY_DEPTH_M);
    let mut ends = OWN_BODY_BEAMS..=scan.ranges.len();
    ends.any(|end| (end - OWN_BODY_BEAMS..end).all(&ends_within))
}

/// Whether a beam ends within the robot's body and its neighbours do not, as on a grain of dust. An obstacle that touches the robot
/// returns several beams.
pub(super) fn ends_alone_within(body: &Footprint, scan: &Scan) -> impl Fn(usize) -> bool {
    let (ends_within, count) = (ends_within(body, scan, 0.0), scan.ranges.len());
    move |beam| {
        let neighbours = [beam + 1, beam + count - 1].map(|beam| beam % count);
        ends_within(beam) && !neighbours.into_iter().any(&ends_within)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::navigator::scan_visibility::tests::scan;
    use crate::robot::Polygon;

    fn body() -> Footprint {
        Footprint::covering(Polygon::rectangle(0.8, 0.4).expect("a body"))
    }

    #[test]
    fn beam_ends_within_the_polygon_of_the_body_and_not_within_its_discs() {
        let within = |degree: f64, range_m: f64| {
            let (body, scan) =
                (body(), scan(|at| if at == degree { range_m } else { f64::INFINITY }));
            let ends_within = ends_within(&body, &scan, 0.0);
            (0..1440).filter(|&beam| ends_within(beam)).count()
        };
        assert_eq!([within(90.0, 0.01), within(90.0, 0.21), within(-90.0, 0.23)], [1, 1, 0]);
        assert_eq!([within(0.0, 0.41), within(0.0, 0.43), within(0.0, f64::NAN)], [1, 0, 0]);
        assert_eq!(within(90.0, 0.0), 0, "no measurement");
    }

    #[test]
    fn neighbouring_beams_deep_within_the_body_show_it_and_an_obstacle_at_its_side_does_not() {
        let sees = |from: f64, to: f64, range_m: f64| {
            let is_in = |degree: f64| (from..=to).contains(&degree);
            sees_own_body(&body(), &scan(|at| if is_in(at) { range_m } else { f64::INFINITY }))
        };
        assert!(sees(10.0, 10.5, 0.15), "three beams");
        assert!(!sees(10.0, 10.25, 0.15), "two beams");
        assert!(!sees(80.0, 100.0, 0.19), "a wall that the robot touches");
        assert!(!sees(80.0, 100.0, 0.0) && !sees(80.0, 100.0, f64::NAN), "no measurement");
    }
}
