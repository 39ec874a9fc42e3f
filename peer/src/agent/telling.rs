//! What a process tells of its agent: to the world, to agents that ask, to people.

use csat_proto::agent::FIRST_ANSWER;
use csat_proto::control::{Done, Pace, SaidSoFar};
use csat_proto::ids::AgentId;
use csat_proto::radio::PhysicalHeader;
use csat_proto::time::Step;
use zenoh::Wait;

use super::Shell;
use crate::agent::desk::text;
use crate::agent::mirror::Picture;
use crate::agent::queue;
use crate::world::account::{Account, Asked, Head};
use csat_mission::fleet::Passage;
use csat_mission::mission::Mission;

impl<M: Mission> Shell<M> {
    /// Answers those who want to know what the agent knows, or lets them wait while it has a frame
    /// that it has not applied yet.
    pub(super) fn tell(&mut self) {
        let Some(clock) = self.clock.filter(|_| !self.asked.is_empty()) else { return };
        let Some(answer) = self.node.answer(clock.time) else { return };
        let key = self.keys.state(self.id, "snapshot");
        let physical = text(&self.node.physical());
        tracing::debug!(own = %self.id, askers = self.asked.len(), "is asked");
        for query in self.asked.drain(..) {
            // The key that was asked for may be a pattern.
            let reply = query.reply(&key, &answer.bytes).attachment(&physical);
            if let Err(error) = reply.wait() {
                tracing::warn!(%error, "cannot answer a query");
            }
        }
    }

    /// What another agent answered. It passes the links like everything that agents know: what
    /// cannot be heard from there is not learnt.
    pub(super) fn catch_up(
        &mut self,
        agent: AgentId,
        physical: Option<PhysicalHeader>,
        bytes: Vec<u8>,
    ) {
        tracing::debug!(own = %self.id, %agent, bytes = bytes.len(), "answers");
        match queue::read(agent, physical, bytes) {
            Ok((said, _)) if said.sequence >= FIRST_ANSWER => self.node.hear(&said),
            Ok(_) => self.desk.refusals().count("message", &"an answer numbered as a message"),
            Err(error) => self.desk.refusals().count("message", &error),
        }
    }

    /// Tells the world that a frame or a turn is done.
    pub(super) fn answer(&mut self, step: Step, round: u32) {
        let said = SaidSoFar {
            agent: self.id,
            incarnation: self.node.incarnation(),
            next: self.next.clone(),
        };
        self.desk.done(&Done {
            process: self.process,
            step,
            round,
            said: self.node.is_alive().then_some(said),
            due: self.node.next_due(),
            commands: self.node.take_commands(),
        });
    }

    /// What people may see of the agent now.
    pub(super) fn picture(
        &mut self,
        passages: Vec<Passage>,
        bytes_sent: u64,
    ) -> Picture<M::Report> {
        let (step, time_s) = self.clock.map_or((Step(0), 0.0), |c| (c.step, c.time.seconds()));
        let report = self.node.show(&self.mission);
        let incarnation = self.node.incarnation();
        Picture { incarnation, step, time_s, report, passages, bytes_sent }
    }

    /// Tells the world what a step came to, as often as it asks: it knows what it asked for.
    pub(super) fn report(&mut self, step: Step, asked: Asked) {
        let Some(clock) = self.clock else { return };
        // In real time the step that is over may be one whose frame was missed.
        let newest = self.desk.newest_frame().filter(|_| self.pace != Pace::Lockstep);
        if !(clock.step..=newest.unwrap_or(clock.step)).contains(&step) {
            let reason = format!("the end of step {step} during step {}", clock.step);
            self.desk.refusals().count("order", &reason);
            return;
        }
        let mut flown = self.node.finish(&self.mission, asked.detail());
        if asked == Asked::All {
            flown.report = Some(self.node.show(&self.mission));
        } else if self.mirror.is_wanted() && self.node.is_alive() {
            let picture = self.picture(flown.passages.clone(), flown.bytes_sent);
            self.mirror.show(picture);
        }
        self.told.add(&flown);
        let head = Head {
            process: self.process,
            step: clock.step,
            round: self.round,
            asked,
            looked: self.looked,
            refused: self.desk.refusals().counts(),
        };
        let account = Account::new(head, flown, &self.told, self.node.links());
        self.desk.report(account.encode());
    }
}
