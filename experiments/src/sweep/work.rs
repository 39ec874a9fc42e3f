//! Several missions at a time, each on one thread of its own.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;

use super::SweepError;
use super::fly::{Hangar, THREAD, catch_panics};
use super::plan::Run;
use super::record::RunRecord;

/// What becomes of a run.
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// It takes off.
    Started(&'a Run),
    /// It has ended, with a result.
    Ended(&'a Run, &'a RunRecord),
}

/// Flies `runs` in order, `jobs` at a time, and tells `watch` what becomes of each, as it happens; `false`
/// from it stops all missions after their current step.
///
/// # Errors
/// When a run's file cannot be written or the threads do not start.
pub fn work(
    hangar: &Hangar<'_>,
    runs: &[Run],
    jobs: usize,
    mut watch: impl FnMut(Event<'_>) -> bool,
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
                    let told = sender.send((run, None));
                    let result = hangar.fly(run).transpose();
                    let lost = result.is_some_and(|r| sender.send((run, Some(r))).is_err());
                    if told.is_err() || lost {
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
                None => watch(Event::Started(run)),
                Some(Ok(record)) => watch(Event::Ended(run, &record)),
                Some(Err(error)) => {
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
