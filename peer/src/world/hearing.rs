//! What processes say, and what of it is believed.

use csat_proto::control::Done;
use csat_proto::ids::AgentId;

use super::account::Account;
use super::port::News;
use super::{Member, RemoteFleet};
use crate::wire::refusals;
use csat_mission::mission::Mission;

impl<M: Mission> RemoteFleet<M> {
    /// Takes note of what a process says.
    pub(super) fn take(&mut self, news: News) {
        match news {
            News::Join(query) => self.roster.join(query),
            News::Ready(agent, ready) => self.roster.ready(agent, &ready),
            News::Here(agent) => self.roster.here(agent),
            News::Gone(agent) => {
                if self.roster.gone(agent) {
                    self.bury(agent);
                }
            }
            News::Done(agent, done) => self.done(agent, done),
            News::Account(agent, bytes) => self.account(agent, &bytes),
        }
    }

    fn done(&mut self, agent: AgentId, done: Done) {
        if let Err(reason) = self.check_done(agent, &done) {
            self.port.refusals().count("answer", &format!("agent {agent}: {reason}"));
            return;
        }
        let member = &mut self.members[usize::from(agent.0)];
        member.is_heard = true;
        member.done = Some((done.step, done.round));
        member.said = done.said;
        member.due = done.due;
        member.commands.extend(done.commands);
    }

    fn check_done(&self, agent: AgentId, done: &Done) -> Result<(), String> {
        self.check_process(agent, done.process)?;
        let Member { done: last, said, .. } = &self.members[usize::from(agent.0)];
        self.now.check_done(agent, *last, said.as_ref(), done)
    }

    fn check_process(&self, agent: AgentId, process: u64) -> Result<(), String> {
        match self.roster.process(agent) {
            Some(own) if own == process => Ok(()),
            _ => Err(format!("process {process} does not fly it")),
        }
    }

    fn account(&mut self, agent: AgentId, bytes: &[u8]) {
        let account = Account::<M::Report>::decode(bytes).map_err(|error| error.to_string());
        let checked = account.and_then(|account| {
            self.check_process(agent, account.head.process)?;
            self.now.check_report(&account.head)?;
            Ok(account)
        });
        match checked {
            Ok(account) if self.now.is_all(&account.head) => {
                let member = &mut self.members[usize::from(agent.0)];
                member.account = Some(account);
                (member.is_new, member.is_heard) = (true, true);
            }
            Ok(_) => {}
            Err(reason) => {
                self.port.refusals().count("report", &format!("agent {agent}: {reason}"));
            }
        }
    }

    /// A process is gone, and with it what was on its way to it.
    fn bury(&mut self, agent: AgentId) {
        let member = &mut self.members[usize::from(agent.0)];
        if let Some(account) = &mut member.account {
            let counters = std::mem::take(&mut account.counters);
            member.ended.bury(counters, std::mem::take(&mut account.links));
            member.ended.looked += std::mem::take(&mut account.head.looked);
            refusals::add(&mut member.ended.refused, &std::mem::take(&mut account.head.refused));
        }
        (member.done, member.said, member.due, member.is_new) = (None, None, None, false);
        member.commands.clear();
    }
}
