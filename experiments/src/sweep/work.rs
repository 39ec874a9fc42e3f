//! Several missions at a time, each on one thread of its own.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

use super::SweepError;
use super::fly::{Hangar, THREAD, catch_panics};
use super::plan::Run;
use super::record::RunRecord;

/// Flies `runs` in order, `jobs` at a time, and calls `done` for each that has ended, in the order in
/// which they end; `false` from it stops all missions after their current step.
///
/// # Errors
/// When a run's file cannot be written or the threads do not start.
pub fn work(
    hangar: &Hangar<'_>,
    runs: &[Run],
    jobs: usize,
    mut done: impl FnMut(&Run, &RunRecord) -> bool,
) -> Result<(), SweepError> {
    catch_panics();
    let jobs = jobs.clamp(1, runs.len().max(1));
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    let pools: Vec<rayon::ThreadPool> =
        (0..jobs).map(|job| pool(job, jobs)).collect::<Result<_, _>>()?;
    std::thread::scope(|scope| {
        for pool in &pools {
            let (sender, next) = (sender.clone(), &next);
            // Inside the pool, what a mission does in parallel stays on this one thread: stage times
            // are per thread, and a panic ends where it is caught.
            let flight = move || {
                while !hangar.stop.load(Ordering::SeqCst) {
                    let Some(run) = runs.get(next.fetch_add(1, Ordering::SeqCst)) else { break };
                    let result = hangar.fly(run).transpose();
                    if result.is_some_and(|result| sender.send((run, result)).is_err()) {
                        break;
                    }
                }
            };
            scope.spawn(move || pool.install(flight));
        }
        drop(sender);
        let mut first_error = None;
        for (run, result) in receiver {
            let goes_on = match result {
                Ok(record) => done(run, &record),
                Err(error) => {
                    first_error.get_or_insert(error);
                    false
                }
            };
            if !goes_on {
                hangar.stop.store(true, Ordering::SeqCst);
            }
        }
        first_error.map_or(Ok(()), Err)
    })
}

fn pool(job: usize, jobs: usize) -> Result<rayon::ThreadPool, SweepError> {
    rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .thread_name(move |_| format!("{THREAD}-{job}"))
        .build()
        .map_err(|error| SweepError::Threads { jobs, reason: error.to_string() })
}
