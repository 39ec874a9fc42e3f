//! The agreement of the core after its links are healed.

use std::collections::{BTreeMap, BTreeSet};

use csat_agent::estimate::state::Knowledge;
use csat_proto::envelope::Envelope;
use csat_proto::message::{HeldFacts, Message};

use super::Swarm;
use super::draw::Draw;
use super::laws::Trace;
use crate::geometry::difference_m2;

/// The allowed difference of the sets of two agents, whose simplifications of up to 0.15 m per step
/// differ: a share of the region, and of the set of a target.
const UNEXPLORED_SHARE: f64 = 0.01;
const TARGET_SHARE: f64 = 0.1;
/// The least area of which that share is taken, m².
const TARGET_M2: f64 = 30.0;

/// A healed core until it agrees.
pub struct Settling<'a> {
    draw: &'a Draw,
    /// The agents of the core that have sent a snapshot.
    said: BTreeSet<u16>,
    /// Whether the sets agreed at any step since all of them have sent one; `None` before that.
    sets: Option<Result<(), String>>,
    /// The facts of UAVs that each agent of the core held last; the facts of stations prove nothing.
    held: BTreeMap<u16, Vec<HeldFacts>>,
}

impl<'a> Settling<'a> {
    /// The state when the core is healed.
    pub fn new(draw: &'a Draw) -> Self {
        Self { draw, said: BTreeSet::new(), sets: None, held: BTreeMap::new() }
    }

    /// Follows a step.
    ///
    /// Agents with the same facts need not have the same sets: late facts prove less, and the order
    /// of updates changes simplifications. A sliver that one agent has excluded and another has not
    /// grows at v_max where no UAV looks. Snapshots correct that, and digests do not ask for them. So
    /// sets are compared after each agent of the core has sent a snapshot, and they need to agree at
    /// one step, before the next sliver grows.
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
            Ok(Message::Plan(_) | Message::Relay(_)) | Err(_) => return,
        };
        let uavs = self.draw.scenario.agents.count;
        let of_uavs = fact.held.facts.into_iter().filter(|held| held.origin.0 < uavs);
        self.held.insert(src, of_uavs.collect());
    }

    /// Checks that all agents of the core have the knowledge of the first one. Returns whether sets
    /// were compared.
    ///
    /// # Errors
    /// What differs.
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

    /// Checks that no agent of the core is missing a fact that another one holds.
    fn check_held(&self) -> Result<(), String> {
        let mut held = self.held.iter();
        let Some(first) = held.next() else { return Ok(()) };
        match held.find(|(_, facts)| *facts != first.1) {
            Some(other) => Err(format!("{first:?} and {other:?} are held")),
            None => Ok(()),
        }
    }

    /// Compares the first agent of the core with each other one.
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

/// Checks the parts of the knowledge that must be equal.
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

/// Checks that the sets have about the same areas.
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
