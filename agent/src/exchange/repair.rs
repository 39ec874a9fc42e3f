//! Anti-entropy: which agent is missing facts, and which agent resends them.
//!
//! Facts carry a [`Digest`] of what their sender holds. Another agent resends what the sender is
//! missing if it held more when the digest was made, and had done so for longer than a message may be
//! in flight. It resends cells of the map in its next facts, and everything else in a snapshot. All
//! agents see the same digest, so they take turns: the next agent by index answers at once, the
//! others only if the digest does not improve. Where some agents may lie, each resends its own facts
//! only, and none waits for another.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::message::{Digest, HeldFacts};
use csat_proto::time::Step;

use crate::config::AgentConfig;
use crate::estimate::oem::BlockHashes;
use crate::mutant::{Mutant, is_on};

/// Steps from the turn of one agent to the turn of the next.
const TURN_STEPS: u32 = 2;
/// Number of turns; all further agents answer in the last one.
const TURNS: u32 = 8;
/// The most blocks of the map that one fact resends.
pub const BLOCKS_PER_FACT: usize = 8;

/// What the other agents are missing.
#[derive(Debug, Clone)]
pub struct Repair {
    own: AgentId,
    /// Number of agents.
    agents: u16,
    /// Number of UAVs; facts of the other agents prove nothing.
    uavs: u16,
    /// Whether each agent resends its own facts only: where some agents may lie, what another agent
    /// says of them does not replace them.
    only_own: bool,
    /// Steps that a message may be in flight.
    delay: u32,
    period: u32,
    /// Steps for which digests are accepted.
    max_age: u32,
    /// The facts held at each step with which a digest may still be compared.
    past: VecDeque<(Step, Vec<HeldFacts>)>,
    /// The incarnation and the step of the newest digest of each agent.
    newest: BTreeMap<AgentId, (Incarnation, Step)>,
    /// The own map.
    map: BlockHashes,
    /// The hashes of the own map in a digest of this step.
    told: Option<(Step, Vec<u16>)>,
    /// The agents that are missing facts, and when to answer them.
    lacking: BTreeMap<AgentId, Step>,
    /// Per agent and block in which its map differs, when to resend the block.
    blocks: BTreeMap<(AgentId, usize), Step>,
    /// The earliest step of the next snapshot for agents that are missing facts.
    next: Step,
}

impl Repair {
    /// The state before the first digest.
    pub fn new(config: &AgentConfig) -> Self {
        let steps = |seconds| config.steps(seconds).max(1);
        Self {
            own: config.id,
            agents: config.agents(),
            uavs: config.fleet.count,
            only_own: config.exchange.liars > 0,
            delay: steps(config.exchange.repair_delay_s),
            period: steps(config.exchange.repair_period_s),
            max_age: steps(config.exchange.max_age_s),
            past: VecDeque::new(),
            newest: BTreeMap::new(),
            map: BlockHashes::default(),
            told: None,
            lacking: BTreeMap::new(),
            blocks: BTreeMap::new(),
            next: Step(0),
        }
    }

    /// The digest of what is held before the frame of step `now`.
    pub fn hold(&mut self, now: Step, facts: Vec<HeldFacts>, map: &BlockHashes) -> Digest {
        let oem = map.told_at(now);
        self.map.clone_from(map);
        self.told = Some((now, oem.clone()));
        self.past.push_back((now, facts.clone()));
        let is_early = |step: &Step| step.after(self.delay).after(self.max_age) <= now;
        while self.past.get(1).is_some_and(|(step, _)| is_early(step)) {
            self.past.pop_front();
        }
        Digest { facts, oem }
    }

    /// Compares the digest of step `then` of an agent, which arrived at step `now`. A digest older
    /// than the newest one of that agent is skipped.
    pub fn hear(
        &mut self,
        now: Step,
        from: AgentId,
        incarnation: Incarnation,
        then: Step,
        digest: &Digest,
    ) {
        let newest = self.newest.entry(from).or_default();
        if (incarnation, then) < *newest {
            return;
        }
        *newest = (incarnation, then);
        let answer_at = now.after(self.turn(from) * TURN_STEPS);
        if self.lacks_facts((from, incarnation), then, &digest.facts) {
            self.lacking.entry(from).or_insert(answer_at);
        } else if !digest.facts.is_empty() {
            self.lacking.remove(&from);
        }
        let differing = self.differing_blocks(then, &digest.oem);
        let heard = 0..digest.oem.len();
        let agrees = |block: &usize| heard.contains(block) && !differing.contains(block);
        self.blocks.retain(|(who, block), _| *who != from || !agrees(block));
        for block in differing {
            self.blocks.entry((from, block)).or_insert(answer_at.after(self.delay));
        }
    }

    /// The blocks whose hashes `theirs`, told at step `then`, differ from those of the own map.
    fn differing_blocks(&mut self, then: Step, theirs: &[u16]) -> BTreeSet<usize> {
        // Most digests are of the same step and of the same map.
        if self.told.as_ref().is_none_or(|(step, _)| *step != then) {
            self.told = Some((then, self.map.told_at(then)));
        }
        let told = self.told.iter().flat_map(|(_, told)| told);
        let differs = |(block, (theirs, ours))| (theirs != ours).then_some(block);
        theirs.iter().zip(told).enumerate().filter_map(differs).collect()
    }

    /// Whether a snapshot is due for an agent that is missing facts.
    pub fn snapshot_due(&self, now: Step) -> bool {
        now >= self.next
            && self.lacking.values().any(|&at| at <= now)
            && !is_on(Mutant::NeverRepairs)
    }

    /// Notes that a snapshot was sent at `now`: later digests show which agents are still missing
    /// facts.
    pub fn snapshot_said(&mut self, now: Step) {
        self.next = now.after(self.period);
        self.lacking.clear();
    }

    /// Postpones snapshots to `retry`, because none fitted the budget.
    pub fn snapshot_failed(&mut self, retry: Step) {
        self.next = self.next.max(retry);
    }

    /// Notes that a snapshot of another agent arrived at `now`: postpones answers until its effect
    /// shows.
    pub fn snapshot_heard(&mut self, now: Step) {
        let answer_at = |from| now.after(self.delay).after(self.turn(from) * TURN_STEPS);
        let later: Vec<_> = self.lacking.keys().map(|&from| (from, answer_at(from))).collect();
        self.lacking.extend(later);
    }

    /// The blocks of the map to resend at `now`, the longest due first.
    pub fn blocks_due(&self, now: Step) -> Vec<usize> {
        if is_on(Mutant::MapNeverRepaired) {
            return Vec::new();
        }
        let waiting = self.blocks.iter().map(|((_, block), at)| (*at, *block));
        let waiting: BTreeSet<_> = waiting.filter(|(at, _)| *at <= now).collect();
        let mut due = Vec::new();
        for (_, block) in waiting {
            if due.len() < BLOCKS_PER_FACT && !due.contains(&block) {
                due.push(block);
            }
        }
        due
    }

    /// Notes that these blocks were sent at `now`. They are due again only after a period: the map of
    /// an agent that is gone differs for ever, and its blocks must not displace others.
    pub fn blocks_said(&mut self, now: Step, said: &[usize]) {
        let again = now.after(self.period);
        for ((_, block), at) in &mut self.blocks {
            if said.contains(block) {
                *at = again;
            }
        }
    }

    /// Whether `from` was missing facts at step `then` that are not in flight any more: facts that
    /// were held here already when the oldest message in flight was sent. The number of missing facts
    /// does not matter, because of an incarnation that is over the last fact may be missing. A digest
    /// without facts does not tell what its sender holds. The facts of its earlier incarnations the
    /// sender may be missing too.
    fn lacks_facts(&self, from: (AgentId, Incarnation), then: Step, theirs: &[HeldFacts]) -> bool {
        if theirs.is_empty() {
            return false;
        }
        let later = self.past.partition_point(|(step, _)| step.after(self.delay) <= then);
        let held = self.past.range(..later).next_back().into_iter().flat_map(|(_, facts)| facts);
        let is_own = |facts: &HeldFacts| (facts.origin, facts.incarnation) == from;
        let is_needed = |facts: &&HeldFacts| {
            let is_mine = facts.origin == self.own || !self.only_own;
            !is_own(facts) && facts.origin.0 < self.uavs && is_mine
        };
        held.filter(is_needed).any(|ours| {
            let key = (ours.origin, ours.incarnation);
            let index = theirs.binary_search_by_key(&key, |f| (f.origin, f.incarnation));
            index.map_or(0, |index| theirs[index].count) < ours.count
        })
    }

    /// The turn of this agent among those that answer `from`.
    fn turn(&self, from: AgentId) -> u32 {
        if self.only_own {
            return 0;
        }
        let all = u32::from(self.agents.max(2));
        let turn = (u32::from(self.own.0) + all - u32::from(from.0) % all + all - 1) % all;
        turn.min(TURNS - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::model::Ground;
    use csat_proto::oem::{OemCell, OemDelta};
    use csat_proto::raster::Grid;

    use crate::estimate::oem::{BLOCK, Oem};

    const DELAY: u32 = 4;

    fn repair(own: u16) -> Repair {
        Repair {
            own: AgentId(own),
            agents: 4,
            uavs: 4,
            only_own: false,
            delay: DELAY,
            period: 10,
            max_age: 100,
            past: VecDeque::new(),
            newest: BTreeMap::new(),
            map: BlockHashes::default(),
            told: None,
            lacking: BTreeMap::new(),
            blocks: BTreeMap::new(),
            next: Step(0),
        }
    }

    /// A digest of step `then` of the first incarnation of another agent arrives at step `now`.
    fn hear(repair: &mut Repair, now: u32, then: u32, digest: &Digest) {
        repair.hear(Step(now), AgentId(1), Incarnation(0), Step(then), digest);
    }

    fn facts(counts: [u32; 4]) -> Vec<HeldFacts> {
        let held =
            |(count, i)| HeldFacts { origin: AgentId(i), incarnation: Incarnation(0), count };
        counts.into_iter().zip(0..).map(held).collect()
    }

    fn digest(counts: [u32; 4]) -> Digest {
        Digest { facts: facts(counts), oem: Vec::new() }
    }

    /// An agent that has held these facts for a long time.
    fn helper(own: u16, counts: [u32; 4]) -> Repair {
        let mut repair = repair(own);
        repair.hold(Step(20 - DELAY), facts(counts), &BlockHashes::default());
        repair
    }

    /// The hashes of a map of `blocks` blocks, of which these are known.
    fn map(blocks: usize, known: &[usize]) -> BlockHashes {
        let side_m = BLOCK as f64;
        let ground = Ground { size_m: [side_m * blocks as f64, side_m] };
        let mut oem = Oem::unexplored(Grid::covering(&ground, 1.0));
        for block in known {
            oem.join(OemDelta { cell: (block * BLOCK) as u32, state: OemCell::Empty });
        }
        oem.block_hashes()
    }

    /// The digest of an agent with this map at a step.
    fn map_digest(step: u32, map: &BlockHashes) -> Digest {
        Digest { facts: Vec::new(), oem: map.told_at(Step(step)) }
    }

    #[test]
    fn what_may_be_on_its_way_is_not_lacking() {
        let mut repair = repair(2);
        for step in 0..=20 {
            repair.hold(Step(step), facts([step; 4]), &BlockHashes::default());
        }
        hear(&mut repair, 20, 20, &digest([16, 16, 16, 16]));
        assert!(!repair.snapshot_due(Step(100)));
        // An agent does not count its own facts as missing.
        hear(&mut repair, 20, 20, &digest([16, 0, 16, 16]));
        assert!(!repair.snapshot_due(Step(100)));
        hear(&mut repair, 20, 20, &digest([15, 16, 16, 16]));
        assert!(repair.snapshot_due(Step(20)));
        repair.snapshot_said(Step(20));
        hear(&mut repair, 21, 21, &digest([15, 16, 16, 16]));
        assert!(!repair.snapshot_due(Step(29)) && repair.snapshot_due(Step(30)));
        hear(&mut repair, 31, 31, &digest([20, 16, 20, 20]));
        assert!(!repair.snapshot_due(Step(31)));
    }

    /// Facts and digests of one link have the same delay.
    #[test]
    fn a_late_digest_is_compared_with_what_its_sender_could_hold() {
        let mut repair = repair(2);
        for step in 0..=30 {
            repair.hold(Step(step), facts([step; 4]), &BlockHashes::default());
            let Some(then) = step.checked_sub(DELAY) else { continue };
            hear(&mut repair, step, then, &digest([then.saturating_sub(DELAY); 4]));
            assert!(!repair.snapshot_due(Step(100)), "at {step}");
        }
        hear(&mut repair, 30, 26, &digest([21; 4]));
        assert!(repair.snapshot_due(Step(30)));
    }

    #[test]
    fn a_digest_without_facts_tells_nothing_of_them() {
        let mut helper = helper(2, [20; 4]);
        hear(&mut helper, 20, 20, &Digest::default());
        assert!(!helper.snapshot_due(Step(100)));
        hear(&mut helper, 21, 21, &digest([0, 20, 20, 20]));
        hear(&mut helper, 22, 22, &Digest::default());
        assert!(helper.snapshot_due(Step(22)));
    }

    #[test]
    fn a_digest_that_was_overtaken_tells_nothing() {
        let mut helper = helper(2, [20; 4]);
        hear(&mut helper, 25, 25, &digest([20; 4]));
        hear(&mut helper, 25, 21, &digest([0; 4]));
        assert!(!helper.snapshot_due(Step(100)));
        helper.hear(Step(25), AgentId(1), Incarnation(1), Step(21), &digest([0; 4]));
        assert!(helper.snapshot_due(Step(25)), "a new incarnation knows nothing yet");
        hear(&mut helper, 26, 26, &digest([20; 4]));
        assert!(helper.snapshot_due(Step(26)), "the old one is over");
    }

    #[test]
    fn the_past_is_forgotten_when_no_digest_can_be_so_old() {
        let mut repair = repair(2);
        for step in 0..1000 {
            repair.hold(Step(step), facts([step; 4]), &BlockHashes::default());
        }
        assert_eq!(repair.past.len() as u32, repair.max_age + DELAY + 1);
        let oldest = 999 - repair.max_age;
        hear(&mut repair, 999, oldest, &digest([oldest - DELAY - 1; 4]));
        assert!(repair.snapshot_due(Step(999)));
    }

    #[test]
    fn the_last_fact_of_a_life_that_is_over_is_lacking_once_it_is_old() {
        let mut repair = repair(2);
        for step in 20..=24 {
            repair.hold(Step(step), facts([9, step, step, step]), &BlockHashes::default());
            hear(&mut repair, step, step, &digest([8, step, step, step]));
            assert_eq!(repair.snapshot_due(Step(100)), step >= 20 + DELAY, "at {step}");
        }
    }

    #[test]
    fn who_was_restarted_lacks_what_it_said_before() {
        let mut helper = helper(2, [20; 4]);
        let own = |incarnation, count| HeldFacts { origin: AgentId(1), incarnation, count };
        let said = |before| {
            let mut digest = digest([20; 4]);
            digest.facts[1] = own(Incarnation(0), before);
            digest.facts.insert(2, own(Incarnation(1), 3));
            digest
        };
        helper.hear(Step(20), AgentId(1), Incarnation(1), Step(20), &said(19));
        assert!(helper.snapshot_due(Step(20)));
        helper.hear(Step(21), AgentId(1), Incarnation(1), Step(21), &said(20));
        assert!(
            !helper.snapshot_due(Step(100)),
            "of its current incarnation it is missing nothing"
        );
    }

    #[test]
    fn neighbours_take_turns() {
        let behind = digest([0, 20, 20, 20]);
        let first_due = |own_id| {
            let mut repair = helper(own_id, [20; 4]);
            hear(&mut repair, 20, 20, &behind);
            (20..).find(|&step| repair.snapshot_due(Step(step))).unwrap()
        };
        assert_eq!([2, 3, 0].map(first_due), [20, 22, 24]);
        let mut second = helper(3, [20; 4]);
        hear(&mut second, 20, 20, &behind);
        second.snapshot_heard(Step(21));
        assert!(!second.snapshot_due(Step(26)) && second.snapshot_due(Step(27)));
    }

    #[test]
    fn a_snapshot_without_room_is_tried_again_later() {
        let mut helper = helper(2, [20; 4]);
        hear(&mut helper, 20, 20, &digest([0, 20, 20, 20]));
        assert!(helper.snapshot_due(Step(20)));
        helper.snapshot_failed(Step(24));
        assert!(!helper.snapshot_due(Step(23)) && helper.snapshot_due(Step(24)));
    }

    #[test]
    fn blocks_that_stay_different_are_said_again() {
        let mut repair = repair(2);
        let (own, other) = (map(2, &[1]), map(2, &[]));
        repair.hold(Step(20), Vec::new(), &own);
        hear(&mut repair, 20, 20, &map_digest(20, &other));
        assert_eq!(repair.blocks_due(Step(23)), []);
        // A late digest is compared with the hashes of its own step.
        hear(&mut repair, 23, 21, &map_digest(21, &other));
        assert_eq!(repair.blocks_due(Step(24)), [1]);
        assert_eq!(repair.blocks_due(Step(25)), [1], "it did not fit");
        repair.blocks_said(Step(25), &[1]);
        assert_eq!(repair.blocks_due(Step(34)), [], "not before the period is over");
        assert_eq!(repair.blocks_due(Step(35)), [1]);
        hear(&mut repair, 35, 30, &map_digest(30, &own));
        assert_eq!(repair.blocks_due(Step(99)), []);
    }

    #[test]
    fn every_block_has_its_turn_though_somebody_is_gone() {
        const BLOCKS: usize = 100;
        let mut repair = repair(2);
        let all: Vec<usize> = (0..BLOCKS).collect();
        repair.hold(Step(20), Vec::new(), &map(BLOCKS, &all));
        hear(&mut repair, 20, 20, &map_digest(20, &map(BLOCKS, &[])));
        let steps = 24..24 + BLOCKS.div_ceil(BLOCKS_PER_FACT) as u32;
        let mut said = BTreeSet::new();
        for step in steps.map(Step) {
            let due = repair.blocks_due(step);
            repair.blocks_said(step, &due);
            said.extend(due);
        }
        assert_eq!(said.len(), BLOCKS);
    }
}
