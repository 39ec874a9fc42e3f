//! Until a process flies: signs of life, and whom it hears.

use csat_proto::control::{Probe, Ready};
use csat_proto::ids::AgentId;

use super::{AgentError, PROBE_PERIOD, Shell};
use csat_mission::mission::Mission;
use csat_mission::timing::Stopwatch;
use csat_mission::words::named;

impl<M: Mission> Shell<M> {
    /// Until it flies, whatever it hears meanwhile.
    pub(super) fn give_signs_of_life(&mut self) -> Result<(), AgentError> {
        if self.clock.is_some() || !self.since_probe.left(PROBE_PERIOD).is_zero() {
            return Ok(());
        }
        // Without its token the end of the world would not be noticed.
        if !self.is_world_here && self.since_start.left(self.patience).is_zero() {
            let (key, limit_s) = (self.keys.alive_world(), self.patience.as_secs());
            return Err(AgentError::NoToken { key, limit_s });
        }
        self.since_probe = Stopwatch::start();
        self.tell_who_is_missing();
        self.desk.probe(&Probe { process: self.process, answer: true });
        // Said again in case the world was not listening yet.
        self.desk.ready(&self.readiness());
        Ok(())
    }

    /// Says now and then why it does not fly yet.
    fn tell_who_is_missing(&mut self) {
        let Self { id, heard, fleet: [uavs, all], waiting: Some(waiting), .. } = self else {
            return;
        };
        waiting.tell(|| {
            let is_silent = |agent: &u16| *agent != id.0 && !heard.contains_key(&AgentId(*agent));
            let (silent, own) = (named((0..*all).filter(is_silent), *uavs), named([id.0], *uavs));
            match silent.is_empty() {
                true => format!("the world's first frame: {own} hears all others"),
                false => format!("{silent} to be heard by {own}"),
            }
        });
    }

    fn readiness(&self) -> Ready {
        let heard = self.heard.iter().map(|(agent, process)| (*agent, *process));
        Ready { process: self.process, heard: heard.collect() }
    }

    /// Another process gives a sign of life.
    pub(super) fn probed(&mut self, agent: AgentId, probe: Probe) {
        tracing::debug!(own = %self.id, %agent, ?probe, "is heard");
        self.lost.remove(&agent);
        let is_new = self.heard.insert(agent, probe.process) != Some(probe.process);
        if probe.answer && self.clock.is_some() {
            self.desk.probe(&Probe { process: self.process, answer: false });
        }
        if is_new {
            self.desk.ready(&self.readiness());
        }
    }

    /// Another process is gone. A lease runs out for each of its peers at a time of its own: a successor
    /// may be known already. It answers if there is one.
    pub(super) fn miss(&mut self, agent: AgentId) {
        self.heard.remove(&agent);
        self.lost.insert(agent);
        self.desk.probe(&Probe { process: self.process, answer: true });
        self.try_turn();
    }
}
