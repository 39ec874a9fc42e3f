//! Notices of a process that waits: on standard error after five seconds, and again whenever it has
//! waited twice as long as at the last notice.

use std::time::Duration;

use crate::tell;
use csat_mission::timing::Stopwatch;

/// How long a process waits before the first notice: shorter waits are part of every start.
const FIRST: Duration = Duration::from_secs(5);

/// The notices of one wait.
#[derive(Debug)]
pub struct WaitNotice {
    since: Stopwatch,
    next: Duration,
}

impl WaitNotice {
    /// The wait begins.
    pub fn start() -> Self {
        Self { since: Stopwatch::start(), next: FIRST }
    }

    /// Writes what the process waits for, if the next notice is due.
    pub fn tell(&mut self, what: impl FnOnce() -> String) {
        if self.since.left(self.next).is_zero() {
            self.next *= 2;
            tell!("waiting for {}", what());
        }
    }
}
