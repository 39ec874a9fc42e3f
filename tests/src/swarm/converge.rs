//! What a healed core must agree on.

use std::collections::{BTreeMap, BTreeSet};

use csat_agent::estimate::state::Knowledge;
use csat_proto::envelope::Envelope;
use csat_proto::message::{HeldFacts, Message};

use super::Swarm;
use super::draw::Draw;
use super::laws::Trace;
use crate::geometry::difference_m2;

/// How far sets of two agents may be apart: simplifications of up to 0.15 m a step go different ways.
/// A share of the region, and of a target's set.
const UNEXPLORED_SHARE: f64 = 0.01;
const TARGET_SHARE: f64 = 0.1;
/// The least area that the latter is taken of, m².
const TARGET_M2: f64 = 30.0;

/// A healed core on its way to agreeing.
pub struct Settling<'a> {
    draw: &'a Draw,
    /// Who of the core has said a snapshot.
    said: BTreeSet<u16>,
    /// Whether sets agreed at any step since all have; before that nothing is known.
    sets: Option<Result<(), String>>,
    /// What each of the core held last of what UAVs said: a station's facts prove nothing.
    held: BTreeMap<u16, Vec<HeldFacts>>,
}

impl<'a> Settling<'a> {
    /// The core is healed.
    pub fn new(draw: &'a Draw) -> Self {
        Self { draw, said: BTreeSet::new(), sets: None, held: BTreeMap::new() }
    }

    /// Follows a step.
    ///
    /// Holding the same facts does not make sets the same: what came late is worth less, and sets that
    /// grew in another order were simplified otherwise. What one has excluded and the other has not,
    /// be it a sliver, grows from then on at v_max where nobody looks. Snapshots make up for that, and
    /// digests do not ask for them; so sets are compared from when each has said one, and it is enough
    /// that they agree then, before the next sliver grows.
    pub fn watch(&mut self, engine: &Swarm, trace: &Trace) {
        for passage in &trace.passages {
            self.hear(&passage.bytes);
        }
        let all_said = self.said.len() == self.draw.core.len();
        if self.draw.is_precise() && all_said && self.sets != Some(Ok(())) {
            self.sets = Some(self.compare(engine, check_sets));
        }
    }

    fn hear(&mut self, bytes: &[u8]) {
        let Ok(envelope) = Envelope::decode(bytes) else { return };
        let src = envelope.src.0;
        if !self.draw.core.contains(&src) {
            return;
        }
        let fact = match postcard::from_bytes(&envelope.body) {
            Ok(Message::Fact(fact)) => fact,
            Ok(Message::Snapshot(snapshot)) => {
                self.said.insert(src);
                snapshot.fact
            }
            Ok(Message::Plan(_)) | Err(_) => return,
        };
        let uavs = self.draw.scenario.agents.count;
        let of_uavs = fact.held.facts.into_iter().filter(|held| held.origin.0 < uavs);
        self.held.insert(src, of_uavs.collect());
    }

    /// All of the core know what the first of it knows. Tells whether sets were compared, too.
    ///
    /// # Errors
    /// What they do not agree on.
    pub fn check(self, engine: &Swarm) -> Result<bool, String> {
        self.compare(engine, check_same)?;
        self.check_held()?;
        match self.sets {
            Some(sets) => sets.map(|()| true),
            None if self.draw.is_precise() && self.draw.says_snapshots() => {
                Err(format!("only {:?} said one", self.said))
            }
            None => Ok(false),
        }
    }

    /// Nobody lacks a fact that another holds.
    fn check_held(&self) -> Result<(), String> {
        let mut held = self.held.iter();
        let Some(first) = held.next() else { return Ok(()) };
        match held.find(|(_, facts)| *facts != first.1) {
            Some(other) => Err(format!("{first:?} and {other:?} are held")),
            None => Ok(()),
        }
    }

    /// Compares the first of the core with each of the others.
    fn compare(
        &self,
        engine: &Swarm,
        check: impl Fn(&Knowledge, &Knowledge) -> Result<(), String>,
    ) -> Result<(), String> {
        let knowledge = |i: u16| engine.nodes()[usize::from(i)].agent.inner.knowledge();
        let first = self.draw.core[0];
        self.draw.core[1..].iter().try_for_each(|&other| {
            check(knowledge(first), knowledge(other))
                .map_err(|law| format!("UAVs {first} and {other} of the core: {law}"))
        })
    }
}

/// What is coarse is the same.
fn check_same(first: &Knowledge, second: &Knowledge) -> Result<(), String> {
    if !first.targets.keys().eq(second.targets.keys()) {
        return Err(format!("{:?} and {:?}", first.targets.keys(), second.targets.keys()));
    }
    if first.oem != second.oem {
        let differ = first.oem.cells().iter().zip(second.oem.cells()).filter(|(a, b)| a != b);
        return Err(format!("{} cells of the map differ", differ.count()));
    }
    Ok(())
}

/// Sets are as precise.
fn check_sets(first: &Knowledge, second: &Knowledge) -> Result<(), String> {
    let apart_m2 = difference_m2(first.unexplored.region(), second.unexplored.region());
    if apart_m2 > UNEXPLORED_SHARE * first.ground().area_m2() {
        return Err(format!("what is unexplored differs by {apart_m2:.1} m²"));
    }
    for ((j, a), b) in first.targets.iter().zip(second.targets.values()) {
        let (a, b) = (a.region(), b.region());
        let apart_m2 = difference_m2(a, b);
        if apart_m2 > TARGET_SHARE * a.area_m2().max(b.area_m2()).max(TARGET_M2) {
            return Err(format!("target {j} differs by {apart_m2:.1} m²"));
        }
    }
    Ok(())
}
