//! What to say, and how often.

use std::collections::{BTreeMap, VecDeque};

use csat_proto::agent::{FIRST_ANSWER, Transmit};
use csat_proto::camera::Pose;
use csat_proto::envelope::Envelope;
use csat_proto::ids::{ChannelId, Incarnation};
use csat_proto::message::{Digest, Fact, HeldFacts, Known, Message, Plan, Snapshot, TargetFact};
use csat_proto::oem::{OemCell, OemDelta, OemPatch};
use csat_proto::raster::Raster;
use csat_proto::region::Region;
use csat_proto::time::{SimTime, Step};

use super::budget::{Shortener, fit};
use super::repair::Repair;
use crate::commons::Identity;
use crate::config::{AgentConfig, ExchangeConfig, ExchangeMode};
use crate::estimate::state::Knowledge;
use crate::mutant::{Mutant, is_on};
use crate::sense::Measured;

/// The share of its allowance per step that a fact may use where snapshots must be saved for.
const FACT_SHARE: f64 = 0.75;
/// Steps until a snapshot that did not fit is tried again.
const RETRY_STEPS: u32 = 4;

/// What an agent has to tell of one step.
#[derive(Debug, Clone)]
pub struct Account<'a> {
    /// When it tells.
    pub now: SimTime,
    /// The step of the frame.
    pub step: Step,
    /// Where the camera was.
    pub pose: Pose,
    /// What the frame proved.
    pub measured: &'a Measured,
    /// Cells of the OEM that the frame changed.
    pub changed: BTreeMap<u32, OemCell>,
    /// What the agent knew before.
    pub knowledge: &'a Knowledge,
    /// What it held before.
    pub held: Digest,
    /// Where UAVs are, as far as the agent knows, metres.
    pub uavs: Vec<[f64; 2]>,
}

/// What was said of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Said {
    /// Of the message.
    pub identity: Identity,
    /// Whether it tells all that the frame proved.
    pub in_full: bool,
}

/// Messages waiting to be sent, and the numbering of those that were.
#[derive(Debug, Clone)]
pub struct Outbox {
    config: AgentConfig,
    sequences: BTreeMap<ChannelId, u64>,
    facts_said: u32,
    answers: u64,
    next_snapshot: Step,
    /// Bytes that may be said now; plans are said anyway and may make it negative.
    credit: f64,
    withheld: u64,
    queue: VecDeque<Transmit>,
}

impl Outbox {
    /// An outbox that has sent nothing.
    pub fn new(config: &AgentConfig) -> Self {
        Self {
            config: config.clone(),
            sequences: BTreeMap::new(),
            facts_said: 0,
            answers: 0,
            // Agents take turns, so that not all snapshots fall into the same step.
            next_snapshot: Step(u32::from(config.id.0) + 1),
            credit: 0.0,
            withheld: 0,
            queue: VecDeque::new(),
        }
    }

    /// The next message to send.
    pub fn pop(&mut self) -> Option<Transmit> {
        self.queue.pop_front()
    }

    /// How many steps were not told of because nothing fitted the budget.
    pub fn withheld(&self) -> u64 {
        self.withheld
    }

    /// How many facts were said, alone or in snapshots.
    pub fn facts_said(&self) -> u32 {
        self.facts_said
    }

    /// Says what this step's frame proved or what is known with it, as the mode demands. `None` when
    /// nothing was said.
    pub fn say_step(&mut self, account: &Account<'_>, repair: &mut Repair) -> Option<Said> {
        let ExchangeConfig { mode, budget_bytes_s, snapshot_period_s, .. } =
            self.config.exchange.clone();
        if mode == ExchangeMode::None {
            return None;
        }
        let allowance = budget_bytes_s * self.config.period_s;
        self.credit = (self.credit + allowance).min(budget_bytes_s * snapshot_period_s);
        let fact = self.fact(account, repair);
        let wanted = match mode {
            ExchangeMode::Snapshot => true,
            ExchangeMode::FactsRepair => {
                account.step >= self.next_snapshot || repair.snapshot_due(account.step)
            }
            ExchangeMode::None | ExchangeMode::Facts => false,
        };
        let mut said = if wanted { self.say_snapshot(account, &fact) } else { None };
        if said.is_some() {
            repair.snapshot_said(account.step);
            let period = self.config.steps(snapshot_period_s).max(1);
            self.next_snapshot = account.step.after(period);
        } else if wanted {
            self.next_snapshot = self.next_snapshot.max(account.step.after(RETRY_STEPS));
        }
        let limit = match mode {
            ExchangeMode::FactsRepair => self.credit.min(FACT_SHARE * allowance),
            _ => self.credit,
        };
        if said.is_none() && mode != ExchangeMode::Snapshot {
            said = self.say_fact(account, &fact, limit);
        }
        if said.is_some() {
            self.facts_said += 1;
        } else {
            self.withheld += 1;
        }
        said
    }

    /// All that is known, for one that joins late. The frame is told as part of what is known: as a
    /// fact of its own it proves nothing more. `None` before the first fact was said.
    pub fn answer(
        &mut self,
        now: SimTime,
        pose: Pose,
        knowledge: &Knowledge,
        held: Vec<HeldFacts>,
        hidden: Raster,
    ) -> Option<Transmit> {
        let step = knowledge.step;
        let fact = Fact {
            step,
            number: self.facts_said.checked_sub(1)?,
            held: Digest { facts: held, oem: Vec::new() },
            clear_ground: Region::EMPTY,
            obstacle_margin: Region::EMPTY,
            targets: Vec::new(),
            seen: Raster::empty(*hidden.grid()),
            hidden,
            oem: OemPatch::of(knowledge.oem.known()),
        };
        let body = encode(&Message::Snapshot(Box::new(Snapshot { fact, known: known(knowledge) })));
        let channel = self.config.channels.snapshots;
        let sequence = FIRST_ANSWER + self.answers;
        self.answers += 1;
        let bytes = self.envelope(channel, sequence, now, step, pose, body).encode();
        Some(Transmit { channel, sequence, bytes })
    }

    /// Announces a flight plan.
    pub fn say_plan(&mut self, now: SimTime, pose: Pose, plan: Plan) {
        let step = plan.step;
        let body = encode(&Message::Plan(plan));
        self.say(self.config.channels.plans, now, step, pose, body);
    }

    /// The fact of a frame, in full.
    fn fact(&self, account: &Account<'_>, repair: &mut Repair) -> Fact {
        let Account { step, measured, knowledge, held, changed, .. } = account;
        let with_changes = |known: &mut dyn Iterator<Item = OemDelta>| {
            let mut cells: BTreeMap<_, _> = known.map(|delta| (delta.cell, delta.state)).collect();
            cells.extend(changed);
            patch(&cells)
        };
        let oem = match self.config.exchange.mode {
            ExchangeMode::Snapshot => with_changes(&mut knowledge.oem.known()),
            ExchangeMode::FactsRepair => {
                let due = repair.blocks_due(*step);
                with_changes(&mut knowledge.oem.known_in(&due))
            }
            ExchangeMode::None | ExchangeMode::Facts => patch(changed),
        };
        let targets = measured.targets.iter().map(|t| TargetFact {
            target: t.target,
            location: t.location.region().clone(),
            exclusion: t.exclusion.region().clone(),
        });
        Fact {
            step: *step,
            number: self.facts_said,
            held: held.clone(),
            clear_ground: measured.clear_ground.region().clone(),
            obstacle_margin: measured.obstacle_margin.region().clone(),
            targets: targets.collect(),
            hidden: measured.hidden.clone(),
            seen: measured.seen.clone(),
            oem,
        }
    }

    fn say_fact(&mut self, account: &Account<'_>, fact: &Fact, limit: f64) -> Option<Said> {
        let ground = account.knowledge.ground();
        let body = fit(limit, |level| {
            encode(&Message::Fact(Shortener::new(level, &account.uavs, ground).fact(fact)))
        });
        self.say_body(self.config.channels.facts, account, body)
    }

    fn say_snapshot(&mut self, account: &Account<'_>, fact: &Fact) -> Option<Said> {
        let knowledge = account.knowledge;
        let known = known(knowledge);
        let body = fit(self.credit, |level| {
            let short = Shortener::new(level, &account.uavs, knowledge.ground());
            encode(&Message::Snapshot(Box::new(short.snapshot(fact, &known))))
        });
        self.say_body(self.config.channels.snapshots, account, body)
    }

    fn say_body(
        &mut self,
        channel: ChannelId,
        account: &Account<'_>,
        fitting: Option<(u32, Vec<u8>)>,
    ) -> Option<Said> {
        let (level, body) = fitting?;
        let identity = self.say(channel, account.now, account.step, account.pose, body);
        Some(Said { identity, in_full: level == 0 })
    }

    fn say(
        &mut self,
        channel: ChannelId,
        time: SimTime,
        step: Step,
        pose: Pose,
        body: Vec<u8>,
    ) -> Identity {
        let next = self.sequences.entry(channel).or_default();
        let sequence = *next;
        *next += 1;
        let bytes = self.envelope(channel, sequence, time, step, pose, body).encode();
        self.credit -= bytes.len() as f64;
        let identity = Identity::of(&bytes);
        self.queue.push_back(Transmit { channel, sequence, bytes });
        identity
    }

    fn envelope(
        &self,
        channel: ChannelId,
        sequence: u64,
        time: SimTime,
        step: Step,
        pose: Pose,
        body: Vec<u8>,
    ) -> Envelope {
        Envelope {
            run: self.config.run,
            src: self.config.id,
            incarnation: match is_on(Mutant::SequenceReused) {
                true => Incarnation(0),
                false => self.config.incarnation,
            },
            channel,
            sequence,
            step,
            time,
            pose,
            body,
        }
    }
}

fn known(knowledge: &Knowledge) -> Known {
    let targets = knowledge.targets.iter().map(|(&j, set)| (j, set.region().clone()));
    Known {
        step: knowledge.step,
        targets: targets.collect(),
        unexplored: knowledge.unexplored.region().clone(),
        obstacle_margin: knowledge.margin.region().clone(),
    }
}

fn patch(cells: &BTreeMap<u32, OemCell>) -> OemPatch {
    OemPatch::of(cells.iter().map(|(&cell, &state)| OemDelta { cell, state }))
}

fn encode(message: &Message) -> Vec<u8> {
    postcard::to_stdvec(message).expect("a message always serialises")
}
