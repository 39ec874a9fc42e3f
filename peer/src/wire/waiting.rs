//! What a process waits for, told on standard error while it waits: after five seconds, and whenever
//! it has waited twice as long as when it last said so.

use std::time::Duration;

use crate::tell;
use csat_mission::timing::Stopwatch;

/// How long a process waits before it says so: shorter waits are part of any start.
const FIRST: Duration = Duration::from_secs(5);

/// A process that waits.
#[derive(Debug)]
pub struct Waiting {
    since: Stopwatch,
    next: Duration,
}

impl Waiting {
    /// Begins to wait.
    pub fn start() -> Self {
        Self { since: Stopwatch::start(), next: FIRST }
    }

    /// Says what is waited for, if it is time to.
    pub fn tell(&mut self, what: impl FnOnce() -> String) {
        if self.since.left(self.next).is_zero() {
            self.next *= 2;
            tell!("waiting for {}", what());
        }
    }
}
