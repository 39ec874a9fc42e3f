//! Whether any process takes part, and whether one that ended comes back.

use std::sync::atomic::Ordering;
use std::time::Duration;

use csat_mission::mission::Mission;
use csat_mission::timing::Stopwatch;
use csat_proto::control::Pace;
use csat_proto::time::Step;

use super::wait::CHECK_PERIOD;
use super::{FleetError, RemoteFleet};

/// How long the world may take to notice the end of its parent.
const NOTICE_LIMIT: Duration = Duration::from_secs(2);

impl<M: Mission> RemoteFleet<M> {
    /// In lockstep, when no process takes part: waits for one that is started again.
    pub(super) fn await_restart(&mut self) {
        if !self.restarts {
            return;
        }
        let watch = Stopwatch::start();
        while self.is_deserted()
            && !self.interrupted.load(Ordering::SeqCst)
            && !watch.left(self.patience).is_zero()
        {
            if let Some(input) = self.port.next(CHECK_PERIOD) {
                self.take(input);
            }
            self.roster.admit();
        }
    }

    fn is_deserted(&self) -> bool {
        self.roster.present().next().is_none()
    }

    /// Whether the mission is to end early. A parent that ends takes the agents and the world with it, and the
    /// agents may be gone before the world has noticed.
    fn is_ending(&self) -> bool {
        let watch = Stopwatch::start();
        while !self.interrupted.load(Ordering::SeqCst) && !watch.left(NOTICE_LIMIT).is_zero() {
            std::thread::sleep(CHECK_PERIOD);
        }
        self.interrupted.load(Ordering::SeqCst)
    }

    /// Whether a step can be flown: a process takes part or, if processes are started again, may come back.
    pub(super) fn check_presence(&mut self, step: Step) -> Result<(), FleetError> {
        if !self.is_deserted() {
            self.deserted = None;
            return Ok(());
        }
        let since = *self.deserted.get_or_insert_with(Stopwatch::start);
        if !self.restarts {
            return if self.is_ending() { Ok(()) } else { Err(FleetError::NoneLeft { step }) };
        }
        // In lockstep the world has waited already; in real time it goes on meanwhile.
        let may_come = self.expected.pace != Pace::Lockstep && !since.left(self.patience).is_zero();
        if may_come || self.interrupted.load(Ordering::SeqCst) {
            return Ok(());
        }
        Err(FleetError::NoneBack { limit_s: self.patience.as_secs(), step })
    }
}
