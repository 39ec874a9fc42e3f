//! Which other processes this one hears, by their probes.

use csat_mission::mission::Mission;
use csat_proto::control::{Probe, Ready};
use csat_proto::ids::AgentId;

use super::shell::Shell;

impl<M: Mission> Shell<M> {
    /// Sends a probe to the other agents.
    pub fn probe(&self, answer: bool) {
        self.port.probe(&Probe { process: self.process, answer });
    }

    /// Tells the world which agents this process hears.
    pub fn tell_ready(&self) {
        let heard = self.heard.iter().map(|(agent, process)| (*agent, *process));
        self.port.ready(&Ready { process: self.process, heard: heard.collect() });
    }

    /// The process of another agent sent a probe. Before the first frame this process sends probes anyway,
    /// so that only one that `flies` answers.
    pub fn take_probe(&mut self, agent: AgentId, probe: Probe, flies: bool) {
        tracing::debug!(own = %self.id, %agent, ?probe, "is heard");
        self.gone.remove(&agent);
        let is_new = self.heard.insert(agent, probe.process) != Some(probe.process);
        if probe.answer && flies {
            self.probe(false);
        }
        if is_new {
            self.tell_ready();
        }
    }

    /// The process of another agent is gone. A lease runs out for each of its peers at a time of its own,
    /// so that its successor may be known already: that one answers the probe.
    pub fn lose(&mut self, agent: AgentId) {
        self.heard.remove(&agent);
        self.gone.insert(agent);
        self.probe(true);
    }
}
