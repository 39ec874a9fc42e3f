//! The world's inputs: it takes what processes send, or refuses it.

use csat_mission::mission::Mission;
use csat_proto::control::Done;
use csat_proto::ids::AgentId;

use super::RemoteFleet;
use super::expected::Unexpected;
use super::port::WorldInput;
use super::report::StepReport;

impl<M: Mission> RemoteFleet<M> {
    pub(super) fn take(&mut self, input: WorldInput) {
        match input {
            WorldInput::Join(request) => self.roster.join(request),
            WorldInput::Ready(agent, ready) => self.roster.ready(agent, &ready),
            WorldInput::Alive(agent) => self.roster.alive(agent),
            WorldInput::Gone(agent) => {
                if self.roster.gone(agent) {
                    self.member_mut(agent).lose_process();
                }
            }
            WorldInput::Done(agent, done) => match self.check_done(agent, &done) {
                Ok(()) => self.member_mut(agent).answer(done),
                Err(error) => self.refuse("answer", agent, &error),
            },
            WorldInput::Report(agent, bytes) => match self.read_report(agent, &bytes) {
                Ok(report) if self.expected.is_in_full(&report.header) => {
                    self.member_mut(agent).take_report(report);
                }
                Ok(_) => {}
                Err(error) => self.refuse("report", agent, &error),
            },
        }
    }

    fn check_done(&self, agent: AgentId, done: &Done) -> Result<(), Unexpected> {
        self.check_process(agent, done.process)?;
        let member = &self.members[usize::from(agent.0)];
        self.expected.check_done(agent, member.done, member.said.as_ref(), done)
    }

    fn read_report(
        &self,
        agent: AgentId,
        bytes: &[u8],
    ) -> Result<StepReport<M::Report>, Unexpected> {
        let report = StepReport::<M::Report>::decode(bytes)?;
        self.check_process(agent, report.header.process)?;
        self.expected.check_report(&report.header)?;
        Ok(report)
    }

    fn check_process(&self, agent: AgentId, process: u64) -> Result<(), Unexpected> {
        match self.roster.process(agent) {
            Some(own) if own == process => Ok(()),
            _ => Err(Unexpected::Process(process)),
        }
    }

    fn refuse(&self, kind: &str, agent: AgentId, error: &Unexpected) {
        self.port.refusals().count(kind, &format!("agent {agent}: {error}"));
    }
}
