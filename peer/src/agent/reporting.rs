//! What the process says of its agent: to the world, to other agents and to spectators.

use csat_mission::fleet::Passage;
use csat_mission::mission::Mission;
use csat_proto::agent::FIRST_ANSWER;
use csat_proto::control::{Done, SaidSoFar};
use csat_proto::time::Step;
use zenoh::Wait;
use zenoh::query::Query;

use super::input::{RawFrame, RawMessage};
use super::queue;
use super::shell::{CurrentStep, Shell};
use super::views::ShownStep;
use crate::wire::publish::to_json;
use crate::world::report::{ReportHeader, Scope, StepReport};

/// How many snapshot queries may wait.
const MAX_QUERIES: usize = 256;

impl<M: Mission> Shell<M> {
    /// Another agent asks for a snapshot. It waits while the agent has a frame that it has not applied yet.
    pub fn take_query(&mut self, query: Query, now: Option<&CurrentStep>) {
        self.queries.push(query);
        self.queries.truncate(MAX_QUERIES);
        if let Some(now) = now {
            self.answer_queries(now);
        }
    }

    /// Answers the snapshot queries, if the agent has applied its frame.
    pub fn answer_queries(&mut self, now: &CurrentStep) {
        if self.queries.is_empty() {
            return;
        }
        let Some(answer) = self.node.answer(now.time) else { return };
        let key = self.keys.state(self.id, "snapshot");
        let physical = to_json(&self.node.physical());
        tracing::debug!(own = %self.id, queries = self.queries.len(), "is asked");
        for query in self.queries.drain(..) {
            // The key of the query may be a pattern.
            let reply = query.reply(&key, &answer.bytes).attachment(&physical);
            if let Err(error) = reply.wait() {
                tracing::warn!(%error, "cannot answer a query");
            }
        }
    }

    /// Asks the other agents for snapshots, if the first frame of this process is of an agent that lived
    /// before.
    pub fn catch_up(&self, first: &RawFrame) {
        if first.header.incarnation.is_some_and(|life| life.0 > 0) {
            self.port.request_snapshots();
        }
    }

    /// Another agent sent its snapshot. It passes the links like every message: an agent out of range
    /// teaches nothing.
    pub fn take_snapshot(&mut self, message: RawMessage) {
        tracing::debug!(own = %self.id, agent = %message.key, bytes = message.bytes.len(), "answers");
        match queue::read(message) {
            Ok((said, _)) if said.sequence >= FIRST_ANSWER => self.node.hear(&said),
            Ok(_) => self.port.refusals().count("message", &"an answer numbered as a message"),
            Err(error) => self.port.refusals().count("message", &error),
        }
    }

    /// Tells the world that a frame or a turn is done.
    pub fn done(&mut self, step: Step, round: u32) {
        let said = SaidSoFar {
            agent: self.id,
            incarnation: self.node.incarnation(),
            next: self.next_number.clone(),
        };
        self.port.done(&Done {
            process: self.process,
            step,
            round,
            said: self.node.is_alive().then_some(said),
            due: self.node.next_due(),
            commands: self.node.take_commands(),
        });
    }

    /// Refuses an order to take a turn that cannot be the next one.
    pub fn refuse_turn(&self, step: Step, round: u32) {
        let reason = format!("turn {round} of step {step} cannot be next");
        self.port.refusals().count("order", &reason);
    }

    /// Refuses an order to report on a step that cannot be over.
    pub fn refuse_end(&self, step: Step, now: &CurrentStep) {
        let reason = format!("the end of step {step} during step {}", now.step);
        self.port.refusals().count("order", &reason);
    }

    /// Reports on the present step to the world, as often as the world asks, and shows it to spectators.
    pub fn report(&mut self, now: &CurrentStep, round: u32, scope: Scope) {
        let mut flown = self.node.finish(&self.mission, scope.detail());
        if scope == Scope::Final {
            flown.report = Some(self.node.show(&self.mission));
        } else if self.views.is_due() && self.node.is_alive() {
            let step = self.shown_step(Some(now), flown.passages.clone(), flown.bytes_sent);
            self.views.publish(step);
        }
        self.log.add(&flown);
        let header = ReportHeader {
            process: self.process,
            step: now.step,
            round,
            scope,
            frames: self.frames,
            refused: self.port.refusals().counts(),
        };
        let report = StepReport::new(header, flown, &self.log, self.node.links());
        self.port.report(report.encode());
    }

    /// What spectators may see of the agent now.
    pub fn shown_step(
        &mut self,
        now: Option<&CurrentStep>,
        passages: Vec<Passage>,
        bytes_sent: u64,
    ) -> ShownStep<M::Report> {
        let (step, time_s) = now.map_or((Step(0), 0.0), |now| (now.step, now.time.seconds()));
        let report = self.node.show(&self.mission);
        let incarnation = self.node.incarnation();
        ShownStep { incarnation, step, time_s, report, passages, bytes_sent }
    }
}
