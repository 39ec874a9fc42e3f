//! A step in lockstep: turns until nothing is left to do; after each the world waits for all processes.

use csat_mission::fleet::Brief;
use csat_mission::mission::Mission;
use csat_proto::control::Order;
use csat_proto::time::SimTime;

use super::error::Awaited;
use super::member::Member;
use super::{FleetError, RemoteFleet};

impl<M: Mission> RemoteFleet<M> {
    pub(super) fn fly_lockstep(&mut self, brief: &Brief) -> Result<(), FleetError> {
        self.send_frames(brief);
        self.take_turns(brief)?;
        self.request_reports(brief.detail);
        self.wait(Awaited::Report(brief.step), |member| member.has_reported)?;
        self.note_silence(brief, 0.0);
        Ok(())
    }

    /// Turns until nothing is left to do before the next step.
    fn take_turns(&mut self, brief: &Brief) -> Result<(), FleetError> {
        let step = brief.step;
        let finished =
            |round: u32| move |member: &Member<M::Report>| member.done == Some((step, round));
        self.wait(Awaited::Frames(step), finished(0))?;
        let (mut now, mut round, mut delivered) = (brief.now, 0, Vec::new());
        loop {
            let said = self.said();
            // New messages need a turn: only their receivers know whether they are due at once.
            if said == delivered {
                match self.next_due() {
                    Some(due) if due < brief.next => now = now.max(due),
                    _ => return Ok(()),
                }
            }
            round += 1;
            self.expected.round = round;
            let order = Order::Turn { step, round, now, said: said.clone() };
            self.port.publishers().order(order);
            delivered = said;
            self.wait(Awaited::Turn(step, round), finished(round))?;
        }
    }

    /// When the first agent is to run next.
    fn next_due(&self) -> Option<SimTime> {
        let present = self.roster.present();
        present.filter_map(|agent| self.members[usize::from(agent.0)].due).min()
    }
}
