//! A polygon covered by discs.

use crate::robot::Disc;

/// Most discs of a cover: what the planner takes.
const MOST: usize = 8;

/// Discs that cover a polygon: the circle around it where that is no wider than a row of discs along the longer side of its
/// bounding box, else that row. Corners in metres, at least one.
pub(super) fn cover(corners: &[[f64; 2]]) -> Vec<Disc> {
    let side = |at: usize| {
        let along = || corners.iter().map(move |corner| corner[at]);
        (
            along().fold(f64::INFINITY, f64::min),
            along().fold(f64::NEG_INFINITY, f64::max),
        )
    };
    let [(back, front), (right, left)] = [side(0), side(1)];
    let (length, width) = (front - back, left - right);
    let (x, y) = (f64::midpoint(back, front), f64::midpoint(right, left));
    let reach = |corner: &[f64; 2]| libm::hypot(corner[0] - x, corner[1] - y);
    let around = corners.iter().map(reach).fold(0.0, f64::max);
    let (longer, shorter) = (length.max(width), length.min(width));
    // One more than squares fit: it halves what the discs reach over the sides.
    let squares = (longer / shorter.max(longer / MOST as f64)).ceil();
    let count = (squares as usize + 1).clamp(2, MOST);
    let piece = longer / count as f64;
    let radius = libm::hypot(piece / 2.0, shorter / 2.0);
    if around <= radius {
        return vec![Disc {
            x,
            y,
            radius: around,
        }];
    }
    let disc = |at: usize| {
        let along = (at as f64 + 0.5) * piece - longer / 2.0;
        let (x, y) = if length >= width {
            (x + along, y)
        } else {
            (x, y + along)
        };
        Disc { x, y, radius }
    };
    (0..count).map(disc).collect()
}

#[cfg(test)]
mod tests {
    use core::f64::consts::TAU;

    use super::cover;

    /// Whether every point of the box around these corners, and every corner, is in a disc.
    fn covers(corners: &[[f64; 2]], inside: &[[f64; 2]]) -> bool {
        let discs = cover(corners);
        corners.iter().chain(inside).all(|point| {
            discs.iter().any(|disc| {
                libm::hypot(point[0] - disc.x, point[1] - disc.y) <= disc.radius + 1e-12
            })
        })
    }

    #[test]
    fn rectangles_are_covered_whichever_way_they_lie() {
        for (length, width) in [
            (0.7, 0.5),
            (0.5, 0.7),
            (1.0, 1.0),
            (3.0, 0.2),
            (0.01, 2.0),
            (40.0, 0.1),
        ] {
            let (x, y) = (0.1, -0.05);
            let at = |share_x: f64, share_y: f64| [x + share_x * length, y + share_y * width];
            let corners = [at(0.5, 0.5), at(0.5, -0.5), at(-0.5, -0.5), at(-0.5, 0.5)];
            let mut inside = Vec::new();
            for i in 0..=100 {
                for j in 0..=20 {
                    inside.push(at(f64::from(i) / 100.0 - 0.5, f64::from(j) / 20.0 - 0.5));
                }
            }
            assert!(covers(&corners, &inside), "{length} x {width}");
            assert!(cover(&corners).len() <= super::MOST);
        }
    }

    #[test]
    fn a_round_robot_is_one_disc() {
        let corner = |index: u32| {
            let angle = TAU * f64::from(index) / 16.0;
            [0.22 * libm::cos(angle), 0.22 * libm::sin(angle)]
        };
        let discs = cover(&(0..16).map(corner).collect::<Vec<_>>());
        assert_eq!(discs.len(), 1);
        assert!((discs[0].radius - 0.22).abs() < 1e-12 && discs[0].x.abs() < 1e-12);
    }

    /// The discs of the default robot reach less than a fifth of its width over its sides.
    #[test]
    fn a_tracked_rectangle_is_covered_tightly() {
        let discs = cover(&[[0.35, 0.25], [0.35, -0.25], [-0.35, -0.25], [-0.35, 0.25]]);
        assert_eq!(discs.len(), 3);
        assert!(discs.iter().all(|disc| disc.radius < 0.3), "{discs:?}");
    }
}
