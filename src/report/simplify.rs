//! Fewer points for the same picture.

/// How far, in drawing units, a drawn line may lie from the data: about a third of a pixel.
pub(super) const TOLERANCE: f64 = 0.3;

/// The points of a line that must stay so that no point left out lies farther than the tolerance from the drawn
/// line (Ramer 1972; Douglas and Peucker 1973). The ends stay.
pub(super) fn simplify(points: &[[f64; 2]], tolerance: f64) -> Vec<[f64; 2]> {
    let Some(last) = points.len().checked_sub(1) else {
        return Vec::new();
    };
    let mut keep = vec![false; points.len()];
    keep[0] = true;
    keep[last] = true;
    let mut spans = vec![(0, last)];
    while let Some((from, to)) = spans.pop() {
        let farthest = (from + 1..to)
            .map(|index| {
                let distance = squared_distance(points[index], points[from], points[to]);
                (distance, index)
            })
            .max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((distance, index)) = farthest
            && distance > tolerance * tolerance
        {
            keep[index] = true;
            spans.push((from, index));
            spans.push((index, to));
        }
    }
    points
        .iter()
        .zip(keep)
        .filter_map(|(&point, kept)| kept.then_some(point))
        .collect()
}

/// The squared distance from a point to the segment between two others.
fn squared_distance(point: [f64; 2], from: [f64; 2], to: [f64; 2]) -> f64 {
    let (along, across) = (to[0] - from[0], to[1] - from[1]);
    let (x, y) = (point[0] - from[0], point[1] - from[1]);
    let length = along * along + across * across;
    let share = if length > 0.0 {
        ((x * along + y * across) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let (dx, dy) = (x - share * along, y - share * across);
    dx * dx + dy * dy
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_keeps_its_ends_and_a_spike_its_tip() {
        let mut line: Vec<[f64; 2]> = (0..100).map(|x| [f64::from(x), 0.0]).collect();
        assert_eq!(simplify(&line, 0.3), [[0.0, 0.0], [99.0, 0.0]]);
        line[50][1] = 5.0;
        let kept = simplify(&line, 0.3);
        assert!(kept.contains(&[50.0, 5.0]) && kept.len() == 5, "{kept:?}");
    }

    #[test]
    fn a_closed_loop_does_not_collapse() {
        let square = [[0.0, 0.0], [9.0, 0.0], [9.0, 9.0], [0.0, 9.0], [0.0, 0.0]];
        assert_eq!(simplify(&square, 0.3), square);
    }

    #[test]
    fn every_point_left_out_is_within_the_tolerance() {
        let wave: Vec<[f64; 2]> = (0..500)
            .map(|index| {
                let x = f64::from(index) * 0.8;
                [x, 40.0 * libm::sin(x / 17.0)]
            })
            .collect();
        let kept = simplify(&wave, TOLERANCE);
        assert!(kept.len() < 120, "{} of 500 points kept", kept.len());
        for &point in &wave {
            let nearest = kept
                .windows(2)
                .map(|ends| squared_distance(point, ends[0], ends[1]))
                .fold(f64::INFINITY, f64::min);
            assert!(nearest <= TOLERANCE * TOLERANCE, "{point:?}");
        }
    }
}
