//! Which agent proves what, for a fleet in which some agents may lie (docs/liars.md).
//!
//! What an agent says, in facts and in snapshots, is one claim of one origin, however often and on
//! whichever way it arrives. The own frames are beyond doubt.

use std::collections::{BTreeMap, BTreeSet};

use csat_proto::ids::{AgentId, TargetId};
use xxhash_rust::xxh3::Xxh3Default;

use super::evidence::ReceivedFact;
use super::predict::Predicted;
use super::sets::Sets;
use crate::config::AgentConfig;
use crate::mutant::{Mutant, is_on};
use crate::region::{Grown, Outer};
use crate::sense::Measured;

/// What one agent claims.
#[derive(Debug, Clone)]
pub(super) struct Claims {
    /// What holds if all that it said is true.
    pub(super) sets: Sets,
    /// The targets that it claims to have seen itself.
    pub(super) seen: BTreeSet<TargetId>,
}

impl Claims {
    /// Notes which targets frames are claimed to show: an own frame, and those of messages.
    pub(super) fn note(&mut self, measured: Option<&Measured>, heard: &[ReceivedFact]) {
        let own = measured.into_iter().flat_map(|measured| &measured.targets).map(|t| t.target);
        let told = heard.iter().flat_map(|heard| &heard.fact.targets).map(|t| t.target);
        self.seen.extend(own.chain(told));
    }
}

/// What each agent proves on its own.
#[derive(Debug, Clone)]
pub struct Origins {
    /// What the own frames prove; `None` where they may be mistaken as well, and are one claim
    /// among others.
    pub(super) own: Option<Sets>,
    /// The claims of agents that were not proven wrong. An agent without claims excludes nothing.
    pub(super) claims: BTreeMap<Origin, Claims>,
    named: BTreeSet<AgentId>,
}

/// Who makes a claim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Origin {
    pub(super) agent: AgentId,
    /// Tells the snapshots of an agent from its facts, where they are mistaken for two claims.
    is_snapshot: bool,
}

impl Origin {
    /// The origin of an agent's own frames.
    pub(super) fn own(agent: AgentId) -> Self {
        Self { agent, is_snapshot: false }
    }

    /// The origin of a message.
    pub(super) fn of(heard: &ReceivedFact) -> Self {
        let is_snapshot = is_on(Mutant::OriginCountedTwice) && heard.known.is_some();
        Self { agent: heard.src, is_snapshot }
    }
}

impl Origins {
    /// Before the first frame and the first message.
    pub(super) fn at_start(config: &AgentConfig) -> Self {
        let is_trusted = config.camera.misidentify == 0.0;
        Self {
            own: is_trusted.then(|| Sets::at_start(config)),
            claims: BTreeMap::new(),
            named: BTreeSet::new(),
        }
    }

    /// The agents that were proven to have said something false.
    pub(super) fn named(&self) -> impl Iterator<Item = AgentId> + '_ {
        self.named.iter().copied()
    }

    /// Whether what an agent claims is still counted.
    pub(super) fn counts(&self, agent: AgentId) -> bool {
        !self.has_named(agent) || is_on(Mutant::NamedLiarHeard)
    }

    fn has_named(&self, agent: AgentId) -> bool {
        self.named.contains(&agent)
    }

    /// Leaves the claims of agents out from now on: they were proven to be false.
    pub(super) fn name(&mut self, liars: &BTreeSet<AgentId>) {
        self.named.extend(liars);
        if !is_on(Mutant::NamedLiarBelieved) {
            self.claims.retain(|origin, _| !liars.contains(&origin.agent));
        }
    }

    /// How many of the agents whose claims are left may lie, of `liars` in the fleet.
    pub(super) fn liars_left(&self, liars: usize) -> usize {
        match is_on(Mutant::ClaimsBelievedAtOnce) {
            true => 0,
            false => liars.saturating_sub(self.named.len()),
        }
    }

    /// What holds of `predicted` if at most `liars` of the claims are false: the q-relaxed
    /// intersection of the claims, within the own sets and the predicted ones.
    pub(super) fn combined(&self, predicted: &Predicted, liars: usize) -> Combined {
        let claims = || self.claims.values().map(|claims| &claims.sets);
        let identified = self.own.iter().chain(claims()).flat_map(|sets| sets.targets.keys());
        let all: BTreeSet<TargetId> = identified.chain(predicted.targets.keys()).copied().collect();
        let meet = |before: &Grown, target: Option<TargetId>| {
            let before = before.resolved();
            let within = match &self.own {
                Some(own) => before.intersection(set(own, target)),
                None => before,
            };
            let claimed: Vec<&Outer> = claims().map(|sets| set(sets, target)).collect();
            within.in_all_but(liars, &claimed)
        };
        let targets = all.into_iter().map(|j| {
            let before = predicted.targets.get(&j).unwrap_or(&predicted.unexplored);
            (j, meet(before, Some(j)))
        });
        Combined { targets: targets.collect(), unexplored: meet(&predicted.unexplored, None) }
    }

    /// Targets that exist, whoever lies: the agent itself saw them, or more agents claim to have seen
    /// them than may lie.
    pub(super) fn real(&self, liars: usize) -> BTreeSet<TargetId> {
        let own = self.own.iter().flat_map(|own| own.targets.keys().copied());
        let mut seen: BTreeMap<TargetId, usize> = BTreeMap::new();
        for j in self.claims.values().flat_map(|claims| &claims.seen) {
            *seen.entry(*j).or_default() += 1;
        }
        own.chain(seen.into_iter().filter(|(_, n)| *n > liars).map(|(j, _)| j)).collect()
    }

    /// The agents that claim a target of `real`, or one that they claim to have seen themselves, to
    /// be where it is not according to `sets`, which hold.
    ///
    /// An agent that only passes on what others say may tell in good faith of a target that does not
    /// exist.
    pub(super) fn refuted<'a>(
        &self,
        real: &BTreeSet<TargetId>,
        set_of: impl Fn(TargetId) -> &'a Outer,
    ) -> BTreeSet<AgentId> {
        let is_false = |claims: &Claims, j: TargetId| {
            let (claimed, holds) = (claims.sets.set_of(j), set_of(j));
            match is_on(Mutant::DoubtIsProof) {
                true => claimed.intersection(holds) != *holds,
                // An empty set of a real target proves that an assumption failed, not who lied.
                false if holds.is_empty() && real.contains(&j) => false,
                false => claimed.misses(holds, claims.sets.ground()),
            }
        };
        let is_refuted = |claims: &Claims| {
            let targets = real.iter().chain(claims.seen.difference(real));
            targets.copied().any(|j| is_false(claims, j))
        };
        // Agents are named once.
        let left = self.claims.iter().filter(|(origin, _)| !self.has_named(origin.agent));
        let refuted = left.filter(|(_, claims)| is_refuted(claims));
        refuted.map(|(origin, _)| origin.agent).collect()
    }

    /// Forgets what all agents claim of a target, because too many claims of it are false.
    pub(super) fn restart(&mut self, target: TargetId) {
        let all = self.claims.values_mut().map(|claims| &mut claims.sets);
        let empty = self.own.iter_mut().filter(|own| own.set_of(target).is_empty());
        for sets in all.chain(empty) {
            let anywhere = Outer::containing(sets.ground().clone());
            sets.targets.insert(target, anywhere);
        }
    }

    /// Adds all of it to a hash.
    pub(super) fn hash(&self, hasher: &mut Xxh3Default) {
        self.own.iter().for_each(|own| own.hash(hasher));
        for (origin, claims) in &self.claims {
            hasher.update(&origin.agent.0.to_le_bytes());
            claims.sets.hash(hasher);
        }
        self.named.iter().for_each(|agent| hasher.update(&agent.0.to_le_bytes()));
    }
}

/// X_j, or X̄ for no target.
fn set(sets: &Sets, target: Option<TargetId>) -> &Outer {
    target.map_or(&sets.unexplored, |j| sets.set_of(j))
}

/// Outer sets that hold although some claims are false.
#[derive(Debug, Clone)]
pub(super) struct Combined {
    /// L and X_j.
    pub(super) targets: BTreeMap<TargetId, Outer>,
    /// X̄.
    pub(super) unexplored: Outer,
}

impl Combined {
    /// X_j, or X̄ if j is not identified.
    pub(super) fn set_of(&self, target: TargetId) -> &Outer {
        self.targets.get(&target).unwrap_or(&self.unexplored)
    }
}
