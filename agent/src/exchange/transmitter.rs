//! What to send to the other agents, and how often.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use csat_proto::agent::{FIRST_ANSWER, Transmit};
use csat_proto::camera::Pose;
use csat_proto::envelope::Envelope;
use csat_proto::ids::{ChannelId, Incarnation};
use csat_proto::message::{
    Digest, Fact, HeldFacts, Known, Message, Plan, Relay, Snapshot, TargetFact,
};
use csat_proto::oem::{OemCell, OemDelta, OemPatch};
use csat_proto::raster::Raster;
use csat_proto::region::Region;
use csat_proto::time::{SimTime, Step};

use super::budget::{LEVELS, Shortener, encode, fit, fitting};
use super::crossing;
use super::repair::{BLOCKS_PER_FACT, Repair};
use super::worth::{KnownSets, Offer, Price};
use crate::config::{AgentConfig, ExchangeConfig, ExchangeMode};
use crate::estimate::state::Knowledge;
use crate::identity::Identity;
use crate::mutant::{Mutant, is_on};
use crate::sense::Measured;

/// The share of the budget that facts leave to the next snapshot.
const SNAPSHOT_SHARE: f64 = 0.25;
/// How much longer the length of a body is as a number, bytes, than that of an empty one.
const LENGTH_BYTES: usize = 4;
/// Steps until a snapshot that did not fit is tried again.
const RETRY_STEPS: u32 = 4;

/// What the messages of one step are made of.
#[derive(Debug, Clone)]
pub struct StepContent<'a> {
    /// When they are sent.
    pub now: SimTime,
    /// The step of the frame.
    pub step: Step,
    /// The pose of the frame.
    pub pose: Pose,
    /// What the frame proved.
    pub measured: &'a Measured,
    /// Cells of the OEM that the frame changed.
    pub changed: BTreeMap<u32, OemCell>,
    /// What the agent knew before the frame.
    pub knowledge: &'a Knowledge,
    /// The X̄ of that knowledge on [`AgentConfig::raster_grid`].
    pub unexplored_cells: &'a Raster,
    /// The digest of what it held before the frame.
    pub held: Digest,
    /// The last known positions of UAVs, metres.
    pub uavs: Vec<[f64; 2]>,
}

/// The fact of a frame as it was sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SentFact {
    /// The identity of the message.
    pub identity: Identity,
    /// Whether it holds all that the frame proved.
    pub in_full: bool,
}

/// The message of a step before it is simplified.
#[derive(Debug, Clone)]
struct Draft<'a> {
    content: &'a StepContent<'a>,
    /// The fact of the frame.
    fact: Fact,
    /// Blocks of the map that other agents are missing, the longest due first.
    blocks: Vec<usize>,
}

impl Draft<'_> {
    /// The fact at a level of simplification: shorter at higher levels, and complete at level 0.
    fn fact_at(&self, level: u32) -> Fact {
        let mut fact = self.shortener(level).fact(&self.fact);
        fact.oem = self.with_blocks(level, fact.oem);
        fact
    }

    /// A snapshot with `known` at a level of simplification.
    fn snapshot_at(&self, level: u32, known: &Known) -> Snapshot {
        let mut snapshot = self.shortener(level).snapshot(&self.fact, known);
        snapshot.fact.oem = self.with_blocks(level, snapshot.fact.oem);
        snapshot
    }

    fn shortener(&self, level: u32) -> Shortener {
        Shortener::new(level, &self.content.uavs, self.content.knowledge.ground())
    }

    /// The blocks to resend: half as many at each level, each of them whole.
    fn blocks_at(&self, level: u32) -> &[usize] {
        &self.blocks[..self.blocks.len().min(BLOCKS_PER_FACT >> level)]
    }

    /// A patch of `changes` and all known cells of the blocks to resend.
    fn with_blocks(&self, level: u32, changes: OemPatch) -> OemPatch {
        let blocks: BTreeSet<usize> = self.blocks_at(level).iter().copied().collect();
        if blocks.is_empty() {
            return changes;
        }
        let mut cells = cells(self.content.knowledge.oem.known_in(&blocks));
        cells.extend(self::cells(changes.deltas()));
        patch(&cells)
    }
}

/// Makes messages, numbers them and queues them to be sent.
#[derive(Debug, Clone)]
pub struct Transmitter {
    config: AgentConfig,
    sequences: BTreeMap<ChannelId, u64>,
    facts_said: u32,
    answers: u64,
    next_snapshot: Step,
    /// Bytes that may be sent now; plans are sent in any case and may make it negative.
    credit: f64,
    /// The part of the credit that is kept for the next snapshot.
    saved: f64,
    withheld: u64,
    price: Price,
    /// The level of simplification of the last message on a channel.
    levels: BTreeMap<ChannelId, u32>,
    queue: VecDeque<Transmit>,
}

impl Transmitter {
    /// A transmitter that has sent nothing.
    pub fn new(config: &AgentConfig) -> Self {
        Self {
            config: config.clone(),
            sequences: BTreeMap::new(),
            facts_said: 0,
            answers: 0,
            // Agents take turns, so that not all snapshots fall into the same step.
            next_snapshot: Step(u32::from(config.id.0) + 1),
            credit: 0.0,
            saved: 0.0,
            withheld: 0,
            price: Price::default(),
            levels: BTreeMap::new(),
            queue: VecDeque::new(),
        }
    }

    /// The next message to send.
    pub fn pop(&mut self) -> Option<Transmit> {
        self.queue.pop_front()
    }

    /// How many steps had no message because none fitted the budget or was worth its bytes.
    pub fn withheld(&self) -> u64 {
        self.withheld
    }

    /// How many facts were sent, alone or in snapshots.
    pub fn facts_said(&self) -> u32 {
        self.facts_said
    }

    /// Sends the fact of this step's frame, alone or in a snapshot, as the mode requires. `None` when
    /// nothing was sent.
    pub fn say_step(&mut self, content: &StepContent<'_>, repair: &mut Repair) -> Option<SentFact> {
        let ExchangeConfig { mode, snapshot_period_s, .. } = self.config.exchange;
        // The facts of a station prove nothing: it sends them only for their digests.
        let is_mute = mode == ExchangeMode::Facts && self.config.is_station();
        if mode == ExchangeMode::None || is_mute {
            return None;
        }
        self.earn();
        let draft = self.draft(content, repair);
        let wanted = match mode {
            ExchangeMode::Snapshot => true,
            ExchangeMode::FactsRepair => {
                content.step >= self.next_snapshot || repair.snapshot_due(content.step)
            }
            ExchangeMode::None | ExchangeMode::Facts => false,
        };
        let mut said = if wanted { self.say_snapshot(&draft, repair) } else { None };
        if said.is_some() {
            repair.snapshot_said(content.step);
            self.saved = 0.0;
            let period = self.config.steps(snapshot_period_s).max(1);
            self.next_snapshot = content.step.after(period);
        } else if wanted {
            let retry = content.step.after(RETRY_STEPS);
            repair.snapshot_failed(retry);
            self.next_snapshot = self.next_snapshot.max(retry);
        }
        let limit = match mode {
            ExchangeMode::FactsRepair => self.credit - self.saved,
            _ => self.credit,
        };
        if said.is_none() && mode != ExchangeMode::Snapshot {
            said = self.say_fact(&draft, repair, limit);
        }
        if said.is_some() {
            self.facts_said += 1;
        } else {
            self.withheld += 1;
        }
        said
    }

    /// Adds the bytes of one step to the credit, which is at most that of a snapshot period.
    fn earn(&mut self) {
        let budget_bytes_s = self.config.exchange.budget_bytes_s;
        let (more, most) = (budget_bytes_s * self.config.period_s, self.most_credit());
        self.credit = (self.credit + more).min(most);
        // Finite, so that an infinite credit minus it stays infinite.
        let most_saved = (SNAPSHOT_SHARE * most).min(f64::MAX);
        self.saved = (self.saved + SNAPSHOT_SHARE * more).min(most_saved);
    }

    /// A snapshot of all knowledge for an agent that joins late. The last frame is part of the
    /// knowledge, so the fact of the snapshot proves nothing. `None` before the first fact was sent,
    /// and when the snapshot has more vertices than receivers accept.
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
        let known = known(knowledge);
        let here = [[pose.p_world[0], pose.p_world[1]]];
        let max_vertices = self.config.exchange.max_vertices;
        let (_, body) = fit(f64::INFINITY, max_vertices, 0, |level| {
            let short = Shortener::new(level, &here, knowledge.ground());
            Message::Snapshot(Box::new(short.snapshot(&fact, &known)))
        })?;
        let channel = self.config.channels.snapshots;
        let sequence = FIRST_ANSWER + self.answers;
        self.answers += 1;
        let bytes = self.envelope(channel, sequence, now, step, pose, body).encode();
        Some(Transmit { channel, sequence, bytes })
    }

    /// Sends a flight plan.
    pub fn say_plan(&mut self, now: SimTime, pose: Pose, plan: Plan) {
        let step = plan.step;
        let body = encode(&Message::Plan(plan));
        self.say(self.config.channels.plans, now, step, pose, body);
    }

    /// Whether the budget allows to send more.
    pub fn has_credit(&self) -> bool {
        self.credit > 0.0
    }

    /// Passes on plans of other UAVs.
    pub fn relay_plans(&mut self, now: SimTime, pose: Pose, relay: Relay) {
        let step = relay.step;
        let body = encode(&Message::Relay(relay));
        self.say(self.config.channels.plans, now, step, pose, body);
    }

    fn draft<'a>(&self, content: &'a StepContent<'a>, repair: &Repair) -> Draft<'a> {
        let blocks = match self.config.exchange.mode {
            ExchangeMode::FactsRepair => repair.blocks_due(content.step),
            _ => Vec::new(),
        };
        Draft { content, fact: self.fact(content), blocks }
    }

    /// The fact of a frame, in full.
    fn fact(&self, content: &StepContent<'_>) -> Fact {
        let StepContent { step, measured, knowledge, held, changed, .. } = content;
        let oem = match self.config.exchange.mode {
            ExchangeMode::Snapshot => {
                let mut cells = cells(knowledge.oem.known());
                cells.extend(changed);
                patch(&cells)
            }
            _ => patch(changed),
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

    fn say_fact(&mut self, draft: &Draft<'_>, repair: &mut Repair, limit: f64) -> Option<SentFact> {
        let channel = self.config.channels.facts;
        if limit.is_finite() {
            return self.say_worthiest(channel, draft, repair, limit);
        }
        self.say_draft(channel, draft, repair, limit, |level| Message::Fact(draft.fact_at(level)))
    }

    /// Sends the version of a fact, of those that fit and are about as fine as the last one, that is worth most above the
    /// price of its bytes, if any is worth it.
    fn say_worthiest(
        &mut self,
        channel: ChannelId,
        draft: &Draft<'_>,
        repair: &mut Repair,
        limit: f64,
    ) -> Option<SentFact> {
        let StepContent { knowledge, unexplored_cells, .. } = *draft.content;
        let header = self.header_bytes(channel, draft.content);
        let sets = KnownSets::of(knowledge, unexplored_cells);
        let last = self.levels.get(&channel).copied().unwrap_or_default();
        let mut offers: Vec<(Offer, u32, Vec<u8>)> = Vec::new();
        for level in last.saturating_sub(1)..=LEVELS {
            if level > last + 1 && !offers.is_empty() {
                break;
            }
            let fact = draft.fact_at(level);
            let worth_m2 = sets.worth_m2(&fact);
            let max_vertices = self.config.exchange.max_vertices;
            if let Some(body) = fitting(limit - header, max_vertices, &Message::Fact(fact)) {
                let bytes = header + body.len() as f64;
                offers.push((Offer { worth_m2, bytes }, level, body));
            }
        }
        let full = limit / (self.most_credit() - self.saved);
        let best = self.price.best(offers.iter().map(|(offer, ..)| *offer), full);
        let (_, level, body) = offers.swap_remove(best?);
        Some(self.say_version(channel, draft, repair, level, body))
    }

    /// The most credit that is kept, bytes.
    fn most_credit(&self) -> f64 {
        self.config.exchange.budget_bytes_s * self.config.exchange.snapshot_period_s
    }

    fn say_snapshot(&mut self, draft: &Draft<'_>, repair: &mut Repair) -> Option<SentFact> {
        let known = known(draft.content.knowledge);
        let channel = self.config.channels.snapshots;
        self.say_draft(channel, draft, repair, self.credit, |level| {
            Message::Snapshot(Box::new(draft.snapshot_at(level, &known)))
        })
    }

    /// Sends the finest version of a message that fits.
    fn say_draft(
        &mut self,
        channel: ChannelId,
        draft: &Draft<'_>,
        repair: &mut Repair,
        limit: f64,
        message: impl Fn(u32) -> Message,
    ) -> Option<SentFact> {
        let first = self.levels.get(&channel).copied().unwrap_or_default();
        let room = limit - self.header_bytes(channel, draft.content);
        let (level, body) = fit(room, self.config.exchange.max_vertices, first, message)?;
        Some(self.say_version(channel, draft, repair, level, body))
    }

    /// Sends the version of a message at a level of simplification.
    fn say_version(
        &mut self,
        channel: ChannelId,
        draft: &Draft<'_>,
        repair: &mut Repair,
        level: u32,
        body: Vec<u8>,
    ) -> SentFact {
        let StepContent { now, step, pose, .. } = *draft.content;
        self.levels.insert(channel, level);
        repair.blocks_said(step, draft.blocks_at(level));
        let identity = self.say(channel, now, step, pose, body);
        SentFact { identity, in_full: level == 0 }
    }

    /// How many bytes of the next message on a channel are no body, at most.
    fn header_bytes(&self, channel: ChannelId, content: &StepContent<'_>) -> f64 {
        let StepContent { now, step, pose, .. } = *content;
        let sequence = self.sequences.get(&channel).copied().unwrap_or_default();
        let empty = self.envelope(channel, sequence, now, step, pose, Vec::new()).encode().len();
        (empty + LENGTH_BYTES) as f64
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
            pose: pose.into(),
            body,
        }
    }
}

fn known(knowledge: &Knowledge) -> Known {
    let targets = knowledge.targets.iter().map(|(&j, set)| (j, set.region().clone()));
    // A shape of X° that grew may reach over its neighbour by a unit, which receivers refuse.
    let obstacle_margin = match crossing::check(knowledge.margin.region()) {
        Ok(()) => knowledge.margin.clone(),
        Err(_) => knowledge.margin.resolved(),
    };
    Known {
        step: knowledge.step,
        targets: targets.collect(),
        unexplored: knowledge.unexplored.region().clone(),
        obstacle_margin: obstacle_margin.into_region(),
    }
}

fn cells(deltas: impl Iterator<Item = OemDelta>) -> BTreeMap<u32, OemCell> {
    deltas.map(|delta| (delta.cell, delta.state)).collect()
}

fn patch(cells: &BTreeMap<u32, OemCell>) -> OemPatch {
    OemPatch::of(cells.iter().map(|(&cell, &state)| OemDelta { cell, state }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::ids::AgentId;
    use csat_proto::region::{Ring, grid_point};

    use crate::config::tests::default_config;
    use crate::region::Inner;

    #[test]
    fn receivers_accept_a_margin_whose_shapes_reach_over_each_other() {
        let square = |x: f64| -> Ring {
            let corners = [[x, 0.0], [x + 9.0, 0.0], [x + 9.0, 9.0], [x, 9.0]];
            corners.map(grid_point).to_vec()
        };
        let mut knowledge = Knowledge::at_start(&default_config([500.0; 2]));
        let mut bent = square(9.0);
        bent[0].x += 1;
        bent[3].x -= 1;
        let shapes = vec![vec![square(0.0)], vec![bent]];
        knowledge.sets.margin = Inner::within(Region::from_shapes(shapes));
        assert!(crossing::check(knowledge.margin.region()).is_err());
        let said = known(&knowledge).obstacle_margin;
        assert!(crossing::check(&said).is_ok());
        assert!((said.area_m2() - 2.0 * 81.0).abs() < 1e-3);
    }

    /// Knowledge of a map in which no two neighbouring cells are the same.
    fn chequered(config: &AgentConfig) -> Knowledge {
        let mut knowledge = Knowledge::at_start(config);
        let columns = config.oem_grid().columns;
        for cell in 0..config.oem_grid().cells() as u32 {
            let height_dm = ((cell % columns + cell / columns) % 2) as u16;
            knowledge.oem.join(OemDelta { cell, state: OemCell::Occupied { height_dm } });
        }
        knowledge
    }

    /// An agent without knowledge is gone, and facts have room for one or two blocks of the map.
    #[test]
    fn every_block_is_said_though_few_fit() {
        let mut config = default_config([500.0; 2]);
        config.exchange.budget_bytes_s = 4000.0;
        config.exchange.snapshot_period_s = 1e6;
        let measured = Measured::nothing(config.raster_grid());
        let knowledge = chequered(&config);
        let unexplored_cells =
            Raster::of_region(config.raster_grid(), knowledge.unexplored.region());
        let hashes = knowledge.oem.block_hashes();
        let (mut transmitter, mut repair) = (Transmitter::new(&config), Repair::new(&config));
        transmitter.next_snapshot = Step(u32::MAX);
        repair.hold(Step(0), Vec::new(), &hashes);
        let lost = Knowledge::at_start(&config).oem.block_hashes().told_at(Step(0));
        let digest = Digest { facts: Vec::new(), oem: lost };
        repair.hear(Step(0), AgentId(1), Incarnation(0), Step(0), &digest);
        let mut lacking: BTreeSet<u32> = knowledge.oem.known().map(|delta| delta.cell).collect();
        let cells = lacking.len();
        for step in (20..140).map(Step) {
            let content = StepContent {
                now: SimTime(0),
                step,
                pose: Pose::default(),
                measured: &measured,
                changed: BTreeMap::new(),
                knowledge: &knowledge,
                unexplored_cells: &unexplored_cells,
                held: repair.hold(step, Vec::new(), &hashes),
                uavs: Vec::new(),
            };
            if transmitter.say_step(&content, &mut repair).is_none() {
                continue;
            }
            let bytes = transmitter.pop().expect("it was said").bytes;
            let body = Envelope::decode(&bytes).unwrap().body;
            let Message::Fact(fact) = postcard::from_bytes(&body).unwrap() else { continue };
            fact.oem.deltas().for_each(|delta| {
                lacking.remove(&delta.cell);
            });
        }
        assert_eq!(lacking.len(), 0, "of {cells} cells are never said");
    }
}
