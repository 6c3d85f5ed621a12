//! Jobs on several threads.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread;
use std::time::Duration;

/// Longest time between two checks of the caller: short enough for a person who presses Ctrl-C.
const CHECK_PERIOD: Duration = Duration::from_millis(100);

/// Runs jobs on this many threads, at least one, and passes each result to `take` as it finishes, in no fixed order.
///
/// A result must depend on its job alone; then only the order depends on the threads. After the first error, of `work` or
/// of `take`, no further job starts, and the results of those in progress are dropped.
///
/// # Errors
/// Returns the first error.
pub fn run_jobs<J: Sync, R: Send, E: Send>(
    jobs: &[J],
    threads: usize,
    work: impl Fn(&J) -> Result<R, E> + Sync,
    take: impl FnMut(R) -> Result<(), E>,
) -> Result<(), E> {
    run_jobs_checked(jobs, threads, work, take, || Ok(()))
}

/// As [`run_jobs`]. It also calls `check` in the calling thread, after each result and at least every 100 ms.
fn run_jobs_checked<J: Sync, R: Send, E: Send>(
    jobs: &[J],
    threads: usize,
    work: impl Fn(&J) -> Result<R, E> + Sync,
    mut take: impl FnMut(R) -> Result<(), E>,
    mut check: impl FnMut() -> Result<(), E>,
) -> Result<(), E> {
    let next = AtomicUsize::new(0);
    let (sender, results) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..threads.clamp(1, jobs.len().max(1)) {
            let (sender, next, work) = (sender.clone(), &next, &work);
            scope.spawn(move || {
                while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
                    // After an error the receiver is gone.
                    if sender.send(work(job)).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        let outcome = loop {
            let taken = match results.recv_timeout(CHECK_PERIOD) {
                Ok(result) => result.and_then(&mut take),
                Err(RecvTimeoutError::Timeout) => Ok(()),
                Err(RecvTimeoutError::Disconnected) => break Ok(()),
            };
            if let Err(error) = taken.and_then(|()| check()) {
                break Err(error);
            }
        };
        drop(results);
        outcome
    })
}

/// The results of all jobs in the order of the jobs.
///
/// # Errors
/// Returns the first error.
pub fn run_in_order<J: Sync, R: Send, E: Send>(
    jobs: &[J],
    threads: usize,
    work: impl Fn(&J) -> Result<R, E> + Sync,
    progress: impl FnMut(),
) -> Result<Vec<R>, E> {
    let (results, outcome) = run_in_order_checked(jobs, threads, work, progress, || Ok(()));
    outcome.map(|()| results)
}

/// As [`run_in_order`]. It also calls `check` in the calling thread, after each result and at least every 100 ms. This is for a
/// caller whose signals only one thread can see, such as Python.
///
/// Returns the results before the first error, also of `check`, and that error.
pub fn run_in_order_checked<J: Sync, R: Send, E: Send>(
    jobs: &[J],
    threads: usize,
    work: impl Fn(&J) -> Result<R, E> + Sync,
    mut progress: impl FnMut(),
    check: impl FnMut() -> Result<(), E>,
) -> (Vec<R>, Result<(), E>) {
    let numbered: Vec<(usize, &J)> = jobs.iter().enumerate().collect();
    let mut done = Vec::with_capacity(jobs.len());
    let work = |&(index, job): &(usize, &J)| Ok((index, work(job)?));
    let take = |result| {
        progress();
        done.push(result);
        Ok(())
    };
    let outcome = run_jobs_checked(&numbered, threads, work, take, check);
    done.sort_by_key(|&(index, _)| index);
    (done.into_iter().map(|(_, result)| result).collect(), outcome)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn check_ends_the_work_while_a_job_is_in_progress() {
        let stop = AtomicUsize::new(0);
        let work = |_: &u8| -> Result<(), &str> {
            while stop.load(Ordering::Relaxed) == 0 {
                thread::sleep(Duration::from_millis(1));
            }
            Ok(())
        };
        let check = || {
            stop.store(1, Ordering::Relaxed);
            Err("interrupted")
        };
        let (_, outcome) = run_in_order_checked(&[0; 4], 2, work, || (), check);
        assert_eq!(outcome, Err("interrupted"));
    }

    #[test]
    fn results_are_in_the_order_of_the_jobs() {
        let jobs: Vec<u64> = (0..20).collect();
        let work = |&job: &u64| {
            thread::sleep(Duration::from_millis(20 - job));
            Ok::<_, ()>(job)
        };
        let mut checks = 0;
        let check = || {
            checks += 1;
            Ok(())
        };
        let done = run_in_order_checked(&jobs, 3, work, || (), check);
        assert_eq!(done, (jobs.clone(), Ok(())));
        assert!(checks >= jobs.len());
    }

    #[test]
    fn results_before_an_error_are_kept() {
        let work = |&job: &u64| if job < 3 { Ok(job) } else { Err("late") };
        let done = run_in_order_checked(&[0, 1, 2, 3, 4], 1, work, || (), || Ok(()));
        assert_eq!(done, (vec![0, 1, 2], Err("late")));
    }
}
