//! Runs shared out to threads.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;

use crate::row::Row;

/// Makes the row of a run. One worker belongs to one thread and may keep instances, but nothing
/// that could change the row of a later run. A run that fails is a row that says so.
pub trait Worker {
    /// The row of this run.
    fn run(&mut self, run: u64) -> Row;
}

impl<W: Worker + ?Sized> Worker for Box<W> {
    fn run(&mut self, run: u64) -> Row {
        (**self).run(run)
    }
}

/// Runs `runs` on `threads` threads, each with a worker of its own made by `hire`; `keep` gets each
/// row as it comes, in any order, on the calling thread. Ends early where `stopped` says so or
/// `keep` fails.
///
/// # Errors
/// The first worker that cannot be made, or what `keep` says.
pub fn work<W: Worker, E: Send>(
    runs: &[u64],
    threads: usize,
    hire: impl Fn() -> Result<W, E> + Sync,
    stopped: impl Fn() -> bool + Sync,
    mut keep: impl FnMut(Row) -> Result<(), E>,
) -> Result<(), E> {
    let next = AtomicUsize::new(0);
    let failed = AtomicBool::new(false);
    let threads = threads.clamp(1, runs.len().max(1));
    // Rows wait here, and workers wait where too many do.
    let (sender, rows) = mpsc::sync_channel::<Result<Row, E>>(1024);
    std::thread::scope(|scope| {
        let mut hired = 0;
        for _ in 0..threads {
            let sender = sender.clone();
            let (next, failed, hire, stopped) = (&next, &failed, &hire, &stopped);
            let spawned = std::thread::Builder::new().spawn_scoped(scope, move || {
                let mut worker = match hire() {
                    Ok(worker) => worker,
                    Err(error) => {
                        failed.store(true, Ordering::Relaxed);
                        let _ = sender.send(Err(error));
                        return;
                    }
                };
                while !failed.load(Ordering::Relaxed) && !stopped() {
                    let Some(run) = runs.get(next.fetch_add(1, Ordering::Relaxed)) else { break };
                    let row = worker.run(*run);
                    // What was at work when the end was asked for may have been broken off; and the
                    // receiver is gone where a row could not be kept.
                    if stopped() || sender.send(Ok(row)).is_err() {
                        break;
                    }
                }
            });
            // Where the system gives no more threads, those that there are do the work.
            if spawned.is_err() {
                break;
            }
            hired += 1;
        }
        drop(sender);
        if hired == 0 {
            return alone(runs, &hire, &stopped, &mut keep);
        }
        let mut outcome = Ok(());
        for row in rows {
            if outcome.is_ok() {
                outcome = row.and_then(&mut keep);
                if outcome.is_err() {
                    failed.store(true, Ordering::Relaxed);
                }
            }
        }
        outcome
    })
}

/// Does the runs on the calling thread.
fn alone<W: Worker, E>(
    runs: &[u64],
    hire: impl Fn() -> Result<W, E>,
    stopped: impl Fn() -> bool,
    mut keep: impl FnMut(Row) -> Result<(), E>,
) -> Result<(), E> {
    let mut worker = hire()?;
    for run in runs {
        if stopped() {
            break;
        }
        let row = worker.run(*run);
        if !stopped() {
            keep(row)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::Cell;

    struct Square;

    impl Worker for Square {
        fn run(&mut self, run: u64) -> Row {
            Row { run, cells: vec![Cell::Real((run * run) as f64)] }
        }
    }

    fn all(threads: usize) -> Vec<Row> {
        let (mut rows, runs) = (Vec::new(), (10..510).collect::<Vec<u64>>());
        let keep = |row| {
            rows.push(row);
            Ok::<(), String>(())
        };
        work(&runs, threads, || Ok(Square), || false, keep).unwrap();
        rows.sort_by_key(|row| row.run);
        rows
    }

    #[test]
    fn each_run_is_done_once_whatever_the_threads() {
        assert_eq!(all(1).len(), 500);
        assert_eq!(all(1), all(7));
        let (mut rows, runs) = (Vec::new(), (10..510).collect::<Vec<u64>>());
        let keep = |row| {
            rows.push(row);
            Ok::<(), String>(())
        };
        alone(&runs, || Ok(Square), || false, keep).unwrap();
        assert_eq!(rows, all(1));
    }

    #[test]
    fn what_fails_ends_the_work() {
        let runs: Vec<u64> = (0..5000).collect();
        let mut kept = 0;
        let keep = |_| {
            kept += 1;
            if kept == 5 { Err("the disk is full") } else { Ok(()) }
        };
        assert_eq!(work(&runs, 3, || Ok(Square), || false, keep), Err("the disk is full"));
        let refused = work(&runs, 3, || Err::<Square, _>("no FMU"), || false, |_| Ok(()));
        assert_eq!(refused, Err("no FMU"));
        let stopped = work(&runs, 2, || Ok(Square), || true, |_| Err("no row is wanted"));
        assert_eq!(stopped, Ok(()));
    }
}
