//! Many drives at once.

use core::sync::atomic::{AtomicUsize, Ordering};
use std::panic::resume_unwind;
use std::thread;

use super::{Course, Drive, DriveRun, Traffic};
use crate::bench::paper::PaperError;
use crate::runtime::{Config, Trace};

/// All drives of one kind of traffic.
#[derive(Clone, Debug, PartialEq)]
pub struct Drives {
    /// What moves.
    pub traffic: Traffic,
    /// Course by course, in each seed by seed.
    pub runs: Vec<DriveRun>,
    /// Every tick of the first seed's drive on each course.
    pub shown: Vec<Trace>,
}

/// Drives through every course with every seed and every kind of traffic, on so many threads. Neither the figures nor their
/// order depend on how many. `progress` is called after each drive, on the thread that drove.
///
/// # Errors
/// [`PaperError::Drive`] when one of them cannot begin.
pub fn drive_all(
    courses: &[Course],
    seeds: &[u64],
    config: &Config,
    threads: usize,
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<Drives>, PaperError> {
    let mut jobs = Vec::new();
    for traffic in Traffic::ALL {
        for course in courses {
            jobs.extend(seeds.iter().map(|&seed| (course, traffic, seed)));
        }
    }
    let driven = in_order(&jobs, threads, &|&(course, traffic, seed)| {
        let drive = Drive::new(course, traffic, seed, config).map(|drive| {
            let is_shown = seeds.first() == Some(&seed);
            (drive.run, is_shown.then_some(drive.trace))
        });
        progress();
        drive
    });
    let mut driven = driven.into_iter();
    Traffic::ALL
        .into_iter()
        .map(|traffic| {
            let mut drives = Drives {
                traffic,
                runs: Vec::new(),
                shown: Vec::new(),
            };
            for drive in driven.by_ref().take(courses.len() * seeds.len()) {
                let (run, trace) = drive?;
                drives.runs.push(run);
                drives.shown.extend(trace);
            }
            Ok(drives)
        })
        .collect()
}

/// What a function makes of each job, in their order, on so many threads. Each takes the next job that none has taken.
fn in_order<Job: Sync, Done: Send>(
    jobs: &[Job],
    threads: usize,
    work: &(dyn Fn(&Job) -> Done + Sync),
) -> Vec<Done> {
    let next = AtomicUsize::new(0);
    let take = || {
        let mut done = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(job) = jobs.get(index) else {
                return done;
            };
            done.push((index, work(job)));
        }
    };
    let mut done: Vec<(usize, Done)> = thread::scope(|scope| {
        let workers: Vec<_> = (0..threads.clamp(1, jobs.len().max(1)))
            .map(|_| scope.spawn(take))
            .collect();
        let joined = workers.into_iter().map(thread::ScopedJoinHandle::join);
        joined
            .flat_map(|taken| taken.unwrap_or_else(|panic| resume_unwind(panic)))
            .collect()
    });
    done.sort_by_key(|&(index, _)| index);
    done.into_iter().map(|(_, done)| done).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_is_that_of_the_jobs() {
        let jobs: Vec<u64> = (0..100).collect();
        // The first jobs take longest, so that threads do finish them out of order.
        let work = |job: &u64| (0..(100 - job) * 1000).fold(*job, |sum, step| sum ^ step) ^ job;
        let expected: Vec<u64> = jobs.iter().map(work).collect();
        for threads in [0, 1, 3, 200] {
            assert_eq!(in_order(&jobs, threads, &work), expected);
        }
        assert_eq!(in_order(&[], 4, &work), [0_u64; 0]);
    }
}
