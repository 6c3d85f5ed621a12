//! Jobs on several threads.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

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
    mut take: impl FnMut(R) -> Result<(), E>,
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
        let outcome = results.iter().try_for_each(|result| take(result?));
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
    mut progress: impl FnMut(),
) -> Result<Vec<R>, E> {
    let numbered: Vec<(usize, &J)> = jobs.iter().enumerate().collect();
    let mut done = Vec::with_capacity(jobs.len());
    let work = |&(index, job): &(usize, &J)| Ok((index, work(job)?));
    run_jobs(&numbered, threads, work, |result| {
        progress();
        done.push(result);
        Ok(())
    })?;
    done.sort_by_key(|&(index, _)| index);
    Ok(done.into_iter().map(|(_, result)| result).collect())
}
