//! Lockstep: turns until nothing is left for the instant; each round waits for everybody.

use csat_proto::control::Order;

use super::account::Asked;
use super::{FleetError, Member, RemoteFleet};
use csat_mission::fleet::Brief;
use csat_mission::mission::{Detail, Mission};

impl<M: Mission> RemoteFleet<M> {
    /// Turns until nothing is left before the next step.
    fn settle(&mut self, brief: &Brief) -> Result<(), FleetError> {
        let step = brief.step;
        let finished =
            |round: u32| move |member: &Member<M::Report>| member.done == Some((step, round));
        self.wait(|| format!("look at their frames of step {step}"), finished(0))?;
        let (mut now, mut round, mut heard) = (brief.now, 0, Vec::new());
        loop {
            let said = self.said();
            // What was said a moment ago may be due at once, which only its receivers know.
            if said == heard {
                let present = self.roster.present();
                let dues = present.filter_map(|agent| self.members[usize::from(agent.0)].due);
                match dues.min() {
                    Some(due) if due < brief.next => now = now.max(due),
                    _ => return Ok(()),
                }
            }
            round += 1;
            self.now.round = round;
            self.port.voice().say(Order::Turn { step, round, now, said: said.clone() });
            heard = said;
            self.wait(|| format!("finish turn {round} of step {step}"), finished(round))?;
        }
    }

    pub(super) fn fly_lockstep(&mut self, brief: &Brief) -> Result<(), FleetError> {
        self.settle(brief)?;
        let step = brief.step;
        self.close(brief.detail);
        self.wait(|| format!("report on step {step}"), |member| member.is_new)
    }

    /// Asks for what the step came to.
    pub(super) fn close(&mut self, detail: Detail) {
        let full = detail == Detail::Full;
        self.now.asked = Some(if full { Asked::Full } else { Asked::Brief });
        self.port.voice().say(Order::Close { step: self.now.step, full });
    }
}
