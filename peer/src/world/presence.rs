//! Whether any process is left, and whether those that ended come back.

use std::sync::atomic::Ordering;

use csat_proto::control::Pace;
use csat_proto::time::Step;

use super::{FleetError, LOOK, RemoteFleet};
use csat_mission::mission::Mission;
use csat_mission::timing::Stopwatch;

impl<M: Mission> RemoteFleet<M> {
    /// In lockstep, when no process is left: waits until one that was started again takes part.
    pub(super) fn await_restart(&mut self) {
        let Some(interrupted) = self.restarts.clone() else { return };
        let watch = Stopwatch::start();
        while self.is_deserted()
            && !interrupted.load(Ordering::SeqCst)
            && !watch.left(self.patience).is_zero()
        {
            if let Some(news) = self.port.next(LOOK) {
                self.take(news);
            }
            self.roster.admit();
        }
    }

    pub(super) fn is_deserted(&self) -> bool {
        self.roster.present().next().is_none()
    }

    /// Whether a step can be flown: somebody is there or, if processes are started again, may still come.
    pub(super) fn check_presence(&mut self, step: Step) -> Result<(), FleetError> {
        if !self.is_deserted() {
            self.deserted = None;
            return Ok(());
        }
        let since = *self.deserted.get_or_insert_with(Stopwatch::start);
        let Some(interrupted) = &self.restarts else { return Err(FleetError::Deserted { step }) };
        // In lockstep they have been waited for; in real time it goes on meanwhile.
        let may_come = self.pace != Pace::Lockstep && !since.left(self.patience).is_zero();
        if may_come || interrupted.load(Ordering::SeqCst) {
            return Ok(());
        }
        Err(FleetError::Abandoned { limit_s: self.patience.as_secs(), step })
    }
}
