//! All drives of the paper.

use super::{Course, Drive, DriveRun};
use crate::bench::paper::PaperError;
use crate::experiment::{TrafficKind, run_in_order};
use crate::runtime::{Config, Trace};

/// The kinds of traffic, in the order of the tables.
pub const TRAFFIC: [TrafficKind; 3] =
    [TrafficKind::None, TrafficKind::Yielding, TrafficKind::NonYielding];

/// All drives of one kind of traffic.
#[derive(Clone, Debug, PartialEq)]
pub struct Drives {
    /// The kind of traffic.
    pub traffic: TrafficKind,
    /// Course by course, in each seed by seed.
    pub runs: Vec<DriveRun>,
    /// The trace of the first seed's drive on each course.
    pub shown: Vec<Trace>,
}

/// Drives through every course with every seed and every kind of traffic, on this many threads. Neither the figures nor
/// their order depend on the number of threads. `progress` is called after each drive.
///
/// # Errors
/// [`PaperError::Drive`] when one of them cannot start.
pub fn drive_all(
    courses: &[Course],
    seeds: &[u64],
    config: &Config,
    threads: usize,
    progress: impl FnMut(),
) -> Result<Vec<Drives>, PaperError> {
    let mut jobs = Vec::new();
    for traffic in TRAFFIC {
        for course in courses {
            jobs.extend(seeds.iter().map(|&seed| (course, traffic, seed)));
        }
    }
    let drive = |&(course, traffic, seed): &(&Course, TrafficKind, u64)| {
        let drive = Drive::new(course, traffic, seed, config)?;
        let is_shown = seeds.first() == Some(&seed);
        Ok((drive.run, is_shown.then_some(drive.trace)))
    };
    let mut driven = run_in_order(&jobs, threads, drive, progress)?.into_iter();
    let of_traffic = |traffic| {
        let drives = driven.by_ref().take(courses.len() * seeds.len());
        let (runs, shown): (Vec<_>, Vec<_>) = drives.unzip();
        Drives { traffic, runs, shown: shown.into_iter().flatten().collect() }
    };
    Ok(TRAFFIC.into_iter().map(of_traffic).collect())
}
