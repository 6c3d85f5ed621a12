//! The runs of a campaign on several threads.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

/// Works off cells on so many threads, at least one, and hands over what each gives as it finishes, in no fixed order.
///
/// What a cell gives must depend on the cell alone; then nothing but the order depends on the threads. After the first
/// error, of the work or of the taker, no further cell is begun, and those under way are dropped.
///
/// # Errors
/// The first.
pub fn run_cells<C: Sync, R: Send, E: Send>(
    cells: &[C],
    threads: usize,
    work: impl Fn(&C) -> Result<R, E> + Sync,
    mut take: impl FnMut(R) -> Result<(), E>,
) -> Result<(), E> {
    let next = AtomicUsize::new(0);
    let (sender, results) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..threads.clamp(1, cells.len().max(1)) {
            let (sender, next, work) = (sender.clone(), &next, &work);
            scope.spawn(move || {
                while let Some(cell) = cells.get(next.fetch_add(1, Ordering::Relaxed)) {
                    // Nobody listens any more after an error.
                    if sender.send(work(cell)).is_err() {
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
