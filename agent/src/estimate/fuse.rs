//! Fusion of what others sent (4.34)-(4.37), over links that delay, lose, repeat and reorder.
//!
//! Each message is applied whole. Its sets describe its own step s; at step k ≥ s a target has moved
//! at most d = v_max·((k-s)·T + clock skew bound), so outer sets are dilated by d and inner ones
//! eroded. Intersections commute, so the order of messages and repeats do not matter.

use std::collections::BTreeMap;

use csat_proto::ids::TargetId;
use csat_proto::message::{Fact, Snapshot};
use csat_proto::region::Region;
use csat_proto::time::Step;

use super::state::Knowledge;
use crate::config::AgentConfig;
use crate::region::{Disc, Inner, Outer};

/// Targets that a fusion identified, and those whose set became empty and was restarted.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Fused {
    /// Identified by others.
    pub identified: Vec<TargetId>,
    /// Restarted: an assumption failed or somebody lied.
    pub inconsistent: Vec<TargetId>,
}

/// Applies facts and snapshots to knowledge.
#[derive(Debug, Clone)]
pub struct Fuser {
    v_max_m_s: f64,
    period_s: f64,
    clock_skew_s: f64,
    vertices: u16,
    ground: Region,
}

impl Fuser {
    /// A fuser for `config`.
    pub fn new(config: &AgentConfig) -> Self {
        Self {
            v_max_m_s: config.targets.v_max_m_s,
            period_s: config.period_s,
            clock_skew_s: config.exchange.clock_skew_s,
            vertices: config.estimator.disc_vertices,
            ground: Region::rectangle(config.ground.size_m),
        }
    }

    /// Applies messages whose steps are at most the knowledge's.
    pub fn fuse(&self, knowledge: &mut Knowledge, facts: &[Fact], snapshots: &[Snapshot]) -> Fused {
        let before: Vec<TargetId> = knowledge.targets.keys().copied().collect();
        for snapshot in snapshots {
            self.apply_snapshot(knowledge, snapshot);
        }
        self.apply_facts(knowledge, facts);
        for fact in facts {
            knowledge.note_view(fact.step, &fact.hidden, &fact.seen);
        }
        for snapshot in snapshots {
            knowledge.note_view(snapshot.step, &snapshot.hidden, &snapshot.seen);
        }
        let oem = facts.iter().flat_map(|f| &f.oem).chain(snapshots.iter().flat_map(|s| &s.oem));
        for &delta in oem {
            knowledge.oem.join(delta);
        }
        let inconsistent = knowledge.restart_empty_sets();
        let identified =
            knowledge.targets.keys().filter(|j| before.binary_search(j).is_err()).copied();
        Fused { identified: identified.collect(), inconsistent }
    }

    /// The disc a target may have moved in since `step`; `None` if it cannot have moved.
    fn reach_since(&self, knowledge: &Knowledge, step: Step) -> Option<Disc> {
        let age_s = f64::from(knowledge.step.0.saturating_sub(step.0)) * self.period_s;
        let radius_m = self.v_max_m_s * (age_s + self.clock_skew_s);
        (radius_m > 0.0).then(|| Disc::circumscribed(radius_m, self.vertices))
    }

    fn apply_snapshot(&self, knowledge: &mut Knowledge, snapshot: &Snapshot) {
        let reach = self.reach_since(knowledge, snapshot.step);
        let aged = |set: &Region| self.dilated(set, reach.as_ref());
        let unexplored = aged(&snapshot.unexplored);
        let theirs: BTreeMap<TargetId, Outer> =
            snapshot.targets.iter().map(|(j, set)| (*j, aged(set))).collect();
        let mut merged = BTreeMap::new();
        for &j in knowledge.targets.keys().chain(theirs.keys()) {
            let their_set = theirs.get(&j).unwrap_or(&unexplored);
            merged.insert(j, knowledge.set_of(j).intersection(their_set));
        }
        knowledge.targets = merged;
        knowledge.unexplored = knowledge.unexplored.intersection(&unexplored);
        knowledge.learn_margin([&Inner::within(snapshot.obstacle_margin.clone())]);
    }

    /// All facts at once: first every detection, against X̄ as it stands, then everything that is
    /// excluded. A detection must not meet an X̄ from which its own exclusion was taken already.
    fn apply_facts(&self, knowledge: &mut Knowledge, facts: &[Fact]) {
        let mut everywhere: Vec<Inner> = Vec::new();
        let mut exclusions: Vec<(TargetId, Inner)> = Vec::new();
        let mut margins: Vec<Inner> = Vec::new();
        for fact in facts {
            let reach = self.reach_since(knowledge, fact.step);
            for seen in &fact.targets {
                let location = self.dilated(&seen.location, reach.as_ref());
                let set = knowledge.set_of(seen.target).intersection(&location);
                knowledge.targets.insert(seen.target, set);
                exclusions.push((seen.target, eroded(&seen.exclusion, reach.as_ref())));
            }
            everywhere.push(eroded(&fact.clear_ground, reach.as_ref()));
            margins.push(Inner::within(fact.obstacle_margin.clone()));
        }
        knowledge.learn_margin(&margins);
        everywhere.extend(margins);
        for (&target, set) in &mut knowledge.targets {
            let others = exclusions.iter().filter(|(j, _)| *j != target).map(|(_, part)| part);
            *set = set.minus(everywhere.iter().chain(others));
        }
        let all = everywhere.iter().chain(exclusions.iter().map(|(_, part)| part));
        knowledge.unexplored = knowledge.unexplored.minus(all);
    }

    fn dilated(&self, region: &Region, reach: Option<&Disc>) -> Outer {
        let set = Outer::containing(region.clone());
        match reach {
            Some(disc) => set.dilated(disc, &self.ground),
            None => set,
        }
    }
}

fn eroded(region: &Region, reach: Option<&Disc>) -> Inner {
    let set = Inner::within(region.clone());
    match reach {
        Some(disc) => set.eroded(disc),
        None => set,
    }
}
