//! How the world waits for agents' processes.

use std::time::Duration;

use csat_mission::mission::Mission;
use csat_mission::timing::Stopwatch;
use csat_mission::words::named;
use csat_proto::control::Order;
use csat_proto::ids::AgentId;

use super::error::Awaited;
use super::member::Member;
use super::{FleetError, RemoteFleet};
use crate::wire::notice::WaitNotice;

/// How often a world that waits for processes checks whether the user has ended the mission.
pub(super) const CHECK_PERIOD: Duration = Duration::from_millis(100);

/// How long processes may take to end.
const END_LIMIT: Duration = Duration::from_secs(2);

impl<M: Mission> RemoteFleet<M> {
    /// Waits until every agent has a process and all hear each other. Names the missing ones on standard
    /// error meanwhile.
    ///
    /// # Errors
    /// When a process is missing for too long, or `is_interrupted`.
    pub fn gather(&mut self, is_interrupted: impl Fn() -> bool) -> Result<(), FleetError> {
        let watch = Stopwatch::start();
        let mut notice = WaitNotice::start();
        loop {
            self.roster.admit();
            let Some((missing, what)) = self.roster.awaited() else { return Ok(()) };
            if is_interrupted() {
                return Err(FleetError::Interrupted);
            }
            let left = watch.left(self.patience);
            if left.is_zero() {
                return Err(self.late(&missing, what));
            }
            notice.tell(|| format!("{} to {what}", self.names(&missing)));
            if let Some(input) = self.port.next(left.min(CHECK_PERIOD)) {
                self.take(input);
            }
        }
    }

    /// Ends the mission for all processes and waits until they are gone, but not long: the order must
    /// reach them before this process ends.
    pub fn end(&mut self, reason: &str) {
        self.port.publishers().order(Order::End { reason: reason.to_owned() });
        let watch = Stopwatch::start();
        while self.roster.has_processes() {
            match self.port.next(watch.left(END_LIMIT)) {
                Some(input) => self.take(input),
                None => break,
            }
        }
    }

    /// Waits until `is_finished` holds for every agent whose process takes part.
    pub(super) fn wait(
        &mut self,
        what: Awaited,
        is_finished: impl Fn(&Member<M::Report>) -> bool,
    ) -> Result<(), FleetError> {
        let watch = Stopwatch::start();
        loop {
            let is_open = |agent: &AgentId| !is_finished(&self.members[usize::from(agent.0)]);
            let open: Vec<AgentId> = self.roster.present().filter(is_open).collect();
            if open.is_empty() {
                return Ok(());
            }
            match self.port.next(watch.left(self.patience)) {
                Some(input) => self.take(input),
                None => return Err(self.late(&open, what)),
            }
        }
    }

    fn names(&self, agents: &[AgentId]) -> String {
        let uavs = self.sensors.iter().flatten().count() as u16;
        named(agents.iter().map(|agent| agent.0), uavs)
    }

    fn late(&self, agents: &[AgentId], what: Awaited) -> FleetError {
        FleetError::Late { limit_s: self.patience.as_secs(), whom: self.names(agents), what }
    }
}
