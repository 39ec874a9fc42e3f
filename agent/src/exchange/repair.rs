//! Who lacks what, and whose turn it is to help.
//!
//! Facts carry a [`Digest`] of what their sender holds. Whoever holds more, and has done so for longer
//! than a message may be on its way, says it again: cells of the map in its next facts, everything
//! else as a snapshot. All neighbours see the same digest, so they take turns: the next in the order
//! of indexes answers at once, the others only if the digest does not get better.

use std::collections::{BTreeMap, BTreeSet};

use csat_proto::ids::AgentId;
use csat_proto::message::Digest;
use csat_proto::time::Step;

use crate::config::AgentConfig;
use crate::mutant::{Mutant, is_on};

/// Steps that each neighbour leaves to the one before it to answer.
const TURN_STEPS: u32 = 2;
/// Neighbours that take turns; the rest answer with the last of them.
const TURNS: u32 = 8;
/// Blocks of the map that one fact repairs at most.
const BLOCKS_PER_FACT: usize = 8;

/// What the others lack.
#[derive(Debug, Clone)]
pub struct Repair {
    own: AgentId,
    fleet: u16,
    /// Steps that a message may be on its way.
    delay: u32,
    period: u32,
    /// Who lacks facts, and when to answer.
    lacking: BTreeMap<AgentId, Step>,
    /// Per neighbour and block that it holds differently, when to say the block again.
    blocks: BTreeMap<(AgentId, usize), Step>,
    /// No snapshot for those who lack something before this.
    next: Step,
}

impl Repair {
    /// Nobody was heard yet.
    pub fn new(config: &AgentConfig) -> Self {
        let steps = |seconds: f64| (seconds / config.period_s).ceil().max(1.0) as u32;
        Self {
            own: config.id,
            fleet: config.fleet.count,
            delay: steps(config.exchange.repair_delay_s),
            period: steps(config.exchange.repair_period_s),
            lacking: BTreeMap::new(),
            blocks: BTreeMap::new(),
            next: Step(0),
        }
    }

    /// A neighbour's digest came, at step `now`; `own` is the own one.
    pub fn hear(&mut self, now: Step, from: AgentId, digest: &Digest, own: &Digest) {
        let answer_at = Step(now.0 + self.turn(from) * TURN_STEPS);
        if self.lacks_facts(from, digest, own) {
            self.lacking.entry(from).or_insert(answer_at);
        } else {
            self.lacking.remove(&from);
        }
        for (block, (theirs, ours)) in digest.oem.iter().zip(&own.oem).enumerate() {
            if theirs == ours {
                self.blocks.remove(&(from, block));
            } else {
                self.blocks.entry((from, block)).or_insert(Step(answer_at.0 + self.delay));
            }
        }
    }

    /// Whether somebody is due a snapshot.
    pub fn snapshot_due(&self, now: Step) -> bool {
        now >= self.next
            && self.lacking.values().any(|&at| at <= now)
            && !is_on(Mutant::NeverRepairs)
    }

    /// A snapshot was said at `now`: it helps everybody who hears it.
    pub fn snapshot_said(&mut self, now: Step) {
        self.next = Step(now.0 + self.period);
        self.lacking.clear();
    }

    /// Somebody else said a snapshot: wait and see whether it helped.
    pub fn snapshot_heard(&mut self, now: Step) {
        let answer_at = |from: AgentId| now.0 + self.delay + self.turn(from) * TURN_STEPS;
        let later: Vec<_> =
            self.lacking.keys().map(|&from| (from, Step(answer_at(from)))).collect();
        self.lacking.extend(later);
    }

    /// The blocks of the map to be said again at `now`, which are then taken as said.
    pub fn blocks_due(&mut self, now: Step) -> BTreeSet<usize> {
        let due = self.blocks.iter().filter(|(_, at)| **at <= now).map(|((_, block), _)| *block);
        let due: BTreeSet<usize> =
            due.collect::<BTreeSet<_>>().into_iter().take(BLOCKS_PER_FACT).collect();
        if is_on(Mutant::MapNeverRepaired) {
            return BTreeSet::new();
        }
        let again = Step(now.0 + self.period);
        for ((_, block), at) in &mut self.blocks {
            if due.contains(block) {
                *at = again;
            }
        }
        due
    }

    /// Whether `from` is behind by more than messages on their way explain.
    fn lacks_facts(&self, from: AgentId, digest: &Digest, own: &Digest) -> bool {
        own.facts.iter().filter(|facts| facts.origin != from).any(|ours| {
            let key = (ours.origin, ours.incarnation);
            let theirs = digest.facts.iter().find(|f| (f.origin, f.incarnation) == key);
            theirs.map_or(0, |f| f.count).saturating_add(self.delay) < ours.count
        })
    }

    /// The own place in the order of those who answer `from`.
    fn turn(&self, from: AgentId) -> u32 {
        let fleet = u32::from(self.fleet.max(2));
        let turn = (u32::from(self.own.0) + fleet - u32::from(from.0) % fleet + fleet - 1) % fleet;
        turn.min(TURNS - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::ids::Incarnation;
    use csat_proto::message::HeldFacts;

    fn repair(own: u16) -> Repair {
        let empty = (BTreeMap::new(), BTreeMap::new());
        Repair {
            own: AgentId(own),
            fleet: 4,
            delay: 4,
            period: 10,
            lacking: empty.0,
            blocks: empty.1,
            next: Step(0),
        }
    }

    fn digest(counts: [u32; 4], oem: [u16; 2]) -> Digest {
        let facts = counts.iter().zip(0..).map(|(&count, i)| HeldFacts {
            origin: AgentId(i),
            incarnation: Incarnation(0),
            count,
        });
        Digest { facts: facts.collect(), oem: oem.to_vec() }
    }

    #[test]
    fn what_may_be_on_its_way_is_not_lacking() {
        let mut repair = repair(2);
        let own = digest([20, 20, 20, 20], [7, 7]);
        repair.hear(Step(20), AgentId(1), &digest([16, 16, 16, 16], [7, 7]), &own);
        assert!(!repair.snapshot_due(Step(100)));
        // Its own facts it need not hold from others.
        repair.hear(Step(20), AgentId(1), &digest([16, 0, 16, 16], [7, 7]), &own);
        assert!(!repair.snapshot_due(Step(100)));
        repair.hear(Step(20), AgentId(1), &digest([15, 16, 16, 16], [7, 7]), &own);
        assert!(repair.snapshot_due(Step(20)));
        repair.snapshot_said(Step(20));
        repair.hear(Step(21), AgentId(1), &digest([15, 16, 16, 16], [7, 7]), &own);
        assert!(!repair.snapshot_due(Step(29)) && repair.snapshot_due(Step(30)));
        repair.hear(Step(31), AgentId(1), &digest([20, 16, 20, 20], [7, 7]), &own);
        assert!(!repair.snapshot_due(Step(31)));
    }

    #[test]
    fn neighbours_take_turns() {
        let own = digest([20, 20, 20, 20], [7, 7]);
        let behind = digest([0, 20, 20, 20], [7, 7]);
        let first_due = |own_id| {
            let mut repair = repair(own_id);
            repair.hear(Step(20), AgentId(1), &behind, &own);
            (20..).find(|&step| repair.snapshot_due(Step(step))).unwrap()
        };
        assert_eq!([2, 3, 0].map(first_due), [20, 22, 24]);
        let mut second = repair(3);
        second.hear(Step(20), AgentId(1), &behind, &own);
        second.snapshot_heard(Step(21));
        assert!(!second.snapshot_due(Step(26)) && second.snapshot_due(Step(27)));
    }

    #[test]
    fn blocks_that_stay_different_are_said_again() {
        let mut repair = repair(2);
        let (own, other) = (digest([0; 4], [7, 7]), digest([0; 4], [7, 8]));
        repair.hear(Step(20), AgentId(1), &other, &own);
        assert!(repair.blocks_due(Step(23)).is_empty());
        repair.hear(Step(23), AgentId(1), &other, &own);
        assert_eq!(repair.blocks_due(Step(24)), BTreeSet::from([1]));
        assert!(repair.blocks_due(Step(33)).is_empty(), "not before the period is over");
        assert_eq!(repair.blocks_due(Step(34)), BTreeSet::from([1]));
        repair.hear(Step(35), AgentId(1), &own, &own);
        assert!(repair.blocks_due(Step(99)).is_empty());
    }
}
