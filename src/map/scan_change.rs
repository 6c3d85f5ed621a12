//! Whether a lidar's revolutions differ from each other.
//!
//! A frozen lidar or driver sends the same revolution again and again, with new stamps. The ranges of a working lidar differ by
//! their noise. The comparison needs the ranges as measured: after a compensation for the robot's motion they differ always.

/// With fewer equal returns than this, two revolutions are not taken for the same one: a wide hall has few returns.
const MIN_RETURNS: usize = 10;

/// Finds the time of the latest revolution that differs from the one before.
#[derive(Clone, Debug, Default)]
pub struct ScanChange {
    ranges: Vec<f64>,
    changed_s: Option<f64>,
}

impl ScanChange {
    /// Compares a new revolution, with its time in seconds, to the one before. Returns the time of the latest one that
    /// differed. Beams without a range in one of the two are left out. The same revolution must not be passed twice.
    pub fn update(&mut self, time_s: f64, ranges: impl ExactSizeIterator<Item = f64>) -> f64 {
        if !self.is_repeated(ranges) {
            self.changed_s = Some(time_s);
        }
        *self.changed_s.get_or_insert(time_s)
    }

    /// Compares a new revolution to the one before as [`Self::update`] does. Returns whether it is the same one.
    pub(crate) fn is_repeated(&mut self, ranges: impl ExactSizeIterator<Item = f64>) -> bool {
        let mut is_other = ranges.len() != self.ranges.len();
        let mut equal = 0;
        self.ranges.resize(ranges.len(), f64::NAN);
        for (before, now) in self.ranges.iter_mut().zip(ranges) {
            if before.is_finite() && now.is_finite() {
                is_other |= before.to_bits() != now.to_bits();
                equal += usize::from(before.to_bits() == now.to_bits());
            }
            *before = now;
        }
        !is_other && equal >= MIN_RETURNS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_returns_keep_the_time_of_the_first_revolution() {
        let mut change = ScanChange::default();
        let ranges: Vec<f64> = (0..40).map(|beam| 1.0 + f64::from(beam)).collect();
        assert_eq!(change.update(0.0, ranges.iter().copied()), 0.0);
        assert_eq!(change.update(0.1, ranges.iter().copied()), 0.0);
        // Dropouts do not hide that it is the same.
        let with_dropout = |at: usize| {
            let ranges = ranges.clone();
            (0..40).map(move |beam| if beam == at { f64::NAN } else { ranges[beam] })
        };
        assert_eq!(change.update(0.2, with_dropout(3)), 0.0);
        // The last bit of one range differs.
        let mut other = ranges.clone();
        other[20] = f64::from_bits(other[20].to_bits() + 1);
        assert_eq!(change.update(0.3, other.iter().copied()), 0.3);
        assert_eq!(change.update(0.4, other.iter().take(30).copied()), 0.4);
    }

    #[test]
    fn scan_with_hardly_any_return_counts_as_changed() {
        let mut change = ScanChange::default();
        for tick in 0..5 {
            let time_s = f64::from(tick);
            let ranges = (0..360).map(|beam| if beam < 9 { 2.0 } else { f64::INFINITY });
            assert_eq!(change.update(time_s, ranges), time_s);
        }
    }
}
