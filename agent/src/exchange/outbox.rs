//! What to say, and how often.

use std::collections::VecDeque;

use csat_proto::agent::Transmit;
use csat_proto::camera::Pose;
use csat_proto::envelope::Envelope;
use csat_proto::ids::ChannelId;
use csat_proto::message::{Fact, Message, Plan, Snapshot, TargetFact};
use csat_proto::time::{SimTime, Step};

use crate::config::{AgentConfig, ExchangeMode};
use crate::estimate::correct::Changes;
use crate::estimate::state::Knowledge;
use crate::sense::Measured;

/// Messages waiting to be sent, and the numbering of those that were.
#[derive(Debug, Clone)]
pub struct Outbox {
    config: AgentConfig,
    sequence: u64,
    next_snapshot: Step,
    queue: VecDeque<Transmit>,
}

impl Outbox {
    /// An outbox that has sent nothing.
    pub fn new(config: &AgentConfig) -> Self {
        // Agents take turns, so that not all snapshots fall into the same step.
        let next_snapshot = Step(u32::from(config.id.0) + 1);
        Self { config: config.clone(), sequence: 0, next_snapshot, queue: VecDeque::new() }
    }

    /// The next message to send.
    pub fn pop(&mut self) -> Option<Transmit> {
        self.queue.pop_front()
    }

    /// Says what this step's frame proved or what is known after it, as the mode demands.
    pub fn say_step(
        &mut self,
        now: SimTime,
        pose: Pose,
        knowledge: &Knowledge,
        measured: &Measured,
        changes: &Changes,
    ) {
        let mode = self.config.exchange.mode;
        let step = knowledge.step;
        let fact = matches!(mode, ExchangeMode::Facts | ExchangeMode::FactsRepair);
        if fact {
            self.say(now, step, pose, &Message::Fact(fact_of(step, measured, changes)));
        }
        let snapshot = match mode {
            ExchangeMode::Snapshot => true,
            ExchangeMode::FactsRepair => step >= self.next_snapshot,
            ExchangeMode::None | ExchangeMode::Facts => false,
        };
        if snapshot {
            let period_s = self.config.exchange.snapshot_period_s;
            let steps = (period_s / self.config.period_s).round().max(1.0);
            self.next_snapshot = Step(step.0 + steps as u32);
            self.say(now, step, pose, &Message::Snapshot(snapshot_of(knowledge, measured)));
        }
    }

    /// Announces a flight plan.
    pub fn say_plan(&mut self, now: SimTime, pose: Pose, plan: Plan) {
        self.say(now, plan.step, pose, &Message::Plan(plan));
    }

    fn say(&mut self, time: SimTime, step: Step, pose: Pose, message: &Message) {
        let channel = ChannelId(0);
        let envelope = Envelope {
            run: self.config.run,
            src: self.config.id,
            incarnation: self.config.incarnation,
            channel,
            sequence: self.sequence,
            step,
            time,
            pose,
            body: postcard::to_stdvec(message).expect("a message always serialises"),
        };
        self.queue.push_back(Transmit {
            channel,
            sequence: self.sequence,
            bytes: envelope.encode(),
        });
        self.sequence += 1;
    }
}

fn fact_of(step: Step, measured: &Measured, changes: &Changes) -> Fact {
    let targets = measured.targets.iter().map(|t| TargetFact {
        target: t.target,
        location: t.location.region().clone(),
        exclusion: t.exclusion.region().clone(),
    });
    Fact {
        step,
        clear_ground: measured.clear_ground.region().clone(),
        obstacle_margin: measured.obstacle_margin.region().clone(),
        targets: targets.collect(),
        hidden: measured.hidden.clone(),
        seen: measured.seen.clone(),
        oem: changes.oem.clone(),
    }
}

fn snapshot_of(knowledge: &Knowledge, measured: &Measured) -> Snapshot {
    Snapshot {
        step: knowledge.step,
        targets: knowledge.targets.iter().map(|(&j, set)| (j, set.region().clone())).collect(),
        unexplored: knowledge.unexplored.region().clone(),
        obstacle_margin: knowledge.margin.region().clone(),
        hidden: measured.hidden.clone(),
        seen: measured.seen.clone(),
        oem: knowledge.oem.known(),
    }
}
