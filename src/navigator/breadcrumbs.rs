//! The way back: where the robot came from.

use crate::geometry::Point;

/// Places the robot passed, oldest first.
#[derive(Clone, Debug, Default)]
pub struct Breadcrumbs(Vec<Point>);

/// Distance between two places of a trail, metres.
const SPACING_M: f64 = 0.25;
/// A place to back out to lies further off than this, metres.
const AWAY_M: f64 = 0.5;

impl Breadcrumbs {
    /// Notes where the robot is.
    pub fn note(&mut self, robot: &Point) {
        let moved = |last: &Point| (robot - last).norm() >= SPACING_M;
        if self.0.last().is_none_or(moved) {
            self.0.push(*robot);
        }
    }

    /// The last place that is not near the robot. Nearer ones are forgotten: it is back there.
    pub fn behind(&mut self, robot: &Point) -> Option<Point> {
        while self
            .0
            .pop_if(|last| (*robot - *last).norm() < AWAY_M)
            .is_some()
        {}
        self.0.last().copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_leads_back_place_by_place() {
        let mut trail = Breadcrumbs::default();
        for step in 0..31 {
            trail.note(&Point::new(f64::from(step) * 0.1, 0.0));
        }
        let mut behind = |x| trail.behind(&Point::new(x, 0.0)).map(|point| x - point.x);
        for x in [3.0, 2.0, 1.1, 0.7] {
            let back_m = behind(x);
            assert!(
                back_m.is_some_and(|back_m| (0.5..0.9).contains(&back_m)),
                "from {x}: {back_m:?}"
            );
        }
        assert_eq!(behind(0.2), None);
        assert_eq!(behind(3.0), None);
    }
}
