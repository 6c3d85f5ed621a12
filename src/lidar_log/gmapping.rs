//! GMapping's `.gfs` files (Grisetti, Stachniss and Burgard, "Improved Techniques for Grid Mapping with Rao-Blackwellized
//! Particle Filters", IEEE Transactions on Robotics, 2007): odometry, scans, and the poses of all particles.
//!
//! `SM_UPDATE` holds pose and log weight of each particle after a scan, and `RESAMPLE` the parent of each particle. The
//! corrected poses are those of the ancestors of the particle with the largest sum of log weights, as in `gfs2log`.

use super::beams::{self, SICK_RANGE_M};
use super::fields::Fields;
use super::{LogError, LogRecord};
use crate::geometry::Pose;

/// Poses and log weights of the particles after a scan, and the parent of each after the resampling that follows.
struct Update {
    /// Index of the scan's record.
    record: usize,
    particles: Vec<(Pose, f64)>,
    /// The particle before the resampling of each particle after it.
    parents: Option<Vec<usize>>,
}

pub(super) fn parse(text: &str) -> Result<Vec<LogRecord>, LogError> {
    let mut records: Vec<LogRecord> = Vec::new();
    let mut updates: Vec<Update> = Vec::new();
    let mut range_max = SICK_RANGE_M;
    let mut last_stamp_s = None;
    for (index, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let name = words.next();
        let fields = |record| Fields::new(index + 1, record, words);
        match name {
            Some("PARAM") => {
                let mut fields = fields("PARAM");
                if fields.word("name")? == "maxrange" {
                    let value = fields.number("value")?;
                    if value <= 0.0 {
                        return Err(fields.bad("maximum range", &value.to_string(), "above zero"));
                    }
                    range_max = value.min(SICK_RANGE_M);
                }
            }
            Some("ODOM") => {
                let mut fields = fields("ODOM");
                let odometry = fields.pose("pose")?;
                let stamp_s = fields.number("time")?;
                // GMapping prints the pose at the reading before with the time of the reading at hand.
                let time_s = last_stamp_s.replace(stamp_s).unwrap_or(stamp_s);
                records.push(LogRecord { time_s, odometry, corrected: None, scan: None });
            }
            Some("LASER_READING") => {
                let mut fields = fields("LASER_READING");
                let count = fields.count("number of readings")?;
                let readings = fields.numbers(count, "readings")?;
                let odometry = fields.pose("pose")?;
                let time_s = fields.number("time")?;
                let angles = beams::half_turn(count);
                let scan = beams::scan(&readings, angles, range_max, &Pose::default(), time_s);
                records.push(LogRecord { time_s, odometry, corrected: None, scan: Some(scan) });
            }
            Some("SM_UPDATE") => updates.push(update(fields("SM_UPDATE"), &records)?),
            Some("RESAMPLE") => resample(fields("RESAMPLE"), &mut updates)?,
            _ => {}
        }
    }
    correct(&mut records, &updates);
    Ok(records)
}

fn update(mut fields: Fields<'_>, records: &[LogRecord]) -> Result<Update, LogError> {
    let needed = "LASER_READING";
    let missing = LogError::OutOfOrder { line: fields.line, record: "SM_UPDATE", needed };
    let record = records.iter().rposition(|record| record.scan.is_some()).ok_or(missing)?;
    let count = fields.count("number of particles")?;
    let mut particle = || Ok((fields.pose("particle pose")?, fields.number("particle weight")?));
    let particles = (0..count).map(|_| particle()).collect::<Result<_, LogError>>()?;
    Ok(Update { record, particles, parents: None })
}

fn resample(mut fields: Fields<'_>, updates: &mut [Update]) -> Result<(), LogError> {
    let needed = "SM_UPDATE";
    let missing = LogError::OutOfOrder { line: fields.line, record: "RESAMPLE", needed };
    let update = updates.last_mut().ok_or(missing)?;
    let count = fields.count("number of particles")?;
    let before = update.particles.len();
    let mut parent = || {
        let word = fields.word("parent")?;
        let parent = word.parse().ok().filter(|parent| *parent < before);
        parent.ok_or_else(|| fields.bad("parent", word, "the index of a particle"))
    };
    update.parents = Some((0..count).map(|_| parent()).collect::<Result<_, LogError>>()?);
    Ok(())
}

/// Sets the corrected poses to those of the best particle's ancestors.
fn correct(records: &mut [LogRecord], updates: &[Update]) {
    // Sums of log weights along the ancestry of each particle.
    let mut sums: Vec<f64> = Vec::new();
    for update in updates {
        sums.resize(update.particles.len(), 0.0);
        for (sum, (_, weight)) in sums.iter_mut().zip(&update.particles) {
            *sum += weight;
        }
        if let Some(parents) = &update.parents {
            sums = parents.iter().map(|&parent| sums[parent]).collect();
        }
    }
    let best = sums.iter().enumerate().max_by(|one, other| one.1.total_cmp(other.1));
    let Some((mut particle, _)) = best else {
        return;
    };
    for update in updates.iter().rev() {
        if let Some(parents) = &update.parents {
            particle = parents.get(particle).copied().unwrap_or_default();
        }
        let pose = update.particles.get(particle).map(|(pose, _)| *pose);
        records[update.record].corrected = pose;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lidar_log::LidarLog;

    #[test]
    fn maximum_range_must_be_above_zero() {
        let scan = "LASER_READING 1 3.0 0 0 0 1\n";
        for (value, is_valid) in [("8", true), ("0", false), ("-1", false)] {
            let log = parse(&format!("PARAM maxrange {value}\n{scan}"));
            let names_it = |error: &LogError| {
                error.to_string().contains("line 1: PARAM has `")
                    && error.to_string().contains("maximum range: it must be above zero")
            };
            assert_eq!(
                (log.is_ok(), log.as_ref().err().is_some_and(names_it)),
                (is_valid, !is_valid)
            );
        }
    }

    #[test]
    fn gfs_poses_are_those_of_the_best_ancestors() {
        // Particle 0 is better at the first scan; the second scan's best particle stems from particle 1.
        let text = "PARAM maxrange 80\nODOM 0 0 0 1\nLASER_READING 1 3 0 0 0 1\n\
            SM_UPDATE 2 0 0 0 9 0 1 0 5\nRESAMPLE 2 1 0\nODOM 0 0 0 2\n\
            LASER_READING 1 3 1 0 0 2\nSM_UPDATE 2 1 7 0 9 1 8 0 1\n";
        let log = LidarLog::parse(text).expect("it is valid");
        let corrected: Vec<Pose> = log.records.iter().filter_map(|it| it.corrected).collect();
        assert_eq!(corrected, [Pose::new(0.0, 1.0, 0.0), Pose::new(1.0, 7.0, 0.0)]);
    }

    #[test]
    fn last_line_that_ends_within_its_time_is_left_out() {
        // The names of the logger are not printed by all.
        let carmen = "# a comment\nODOM 0 0 0 0.1 0 0 101.0\nFLASER 1 1 0 0 0 0 0 0 101.5\n\
            FLASER 1 1 0 0 0 0 0 0 102.5\n";
        let gfs = "ODOM 0 0 0 101.0\nLASER_READING 1 3 0 0 0 101.0\nODOM 0 0 0 101.5\n\
            LASER_READING 1 3 1 0 0 102.5\n";
        for text in [carmen, gfs] {
            let of = |text: &str| {
                let log = LidarLog::parse(text).expect("a valid log");
                (log.scans(), log.cut_line)
            };
            let open = text.trim_end();
            // The time 102.5, and what cuts leave of it.
            for cut in 0..=4 {
                let expected = if cut <= 2 { (2, None) } else { (1, Some(4)) };
                assert_eq!(of(&open[..open.len() - cut]), expected, "{text}: {cut} bytes");
            }
            // A line end shows that the line is whole.
            let back = text.replace("102.5\n", "10\n");
            assert_eq!(of(&back), (2, None), "{back}");
            // A line without a record is no cut one.
            assert_eq!(of(&format!("{back}NEFF 1")).1, None);
        }
    }
}
