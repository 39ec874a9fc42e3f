//! From the factors that an agent holds to its belief.
//!
//! For a target that stands, the belief is the product of all factors, whenever they arrive. For one that moves,
//! the order counts: factors that are late by up to `belief.lag_s` are put where they belong and what follows is
//! filtered again; those that are later are left out and counted.

use std::collections::BTreeMap;
use std::sync::Arc;

use csat_proto::time::Step;

use crate::belief::Belief;
use crate::config::{AgentConfig, Fusion};
use crate::factor::{Factor, FactorId};
use crate::likelihood::{Likelihood, Sensor};
use crate::mutant::{Mutant, is_on};
use crate::survival::Survival;
use crate::tiles::Tiles;

/// The belief of an agent, and how it follows from factors.
#[derive(Debug, Clone)]
pub struct Filter {
    sensor: Sensor,
    belief: Belief,
    survival: Survival,
    step: Step,
    /// For a target that moves.
    lag: Option<Lag>,
    walk_m: f64,
}

/// The recent past of a target that moves.
#[derive(Debug, Clone)]
struct Lag {
    steps: u32,
    /// The belief with all factors of the steps before `next`.
    past: Belief,
    next: Step,
    /// The factors of the other steps.
    recent: BTreeMap<(Step, FactorId), Arc<Likelihood>>,
    left_out: u64,
}

impl Filter {
    /// The filter before the first frame.
    pub fn new(config: &AgentConfig) -> Self {
        let belief = Belief::new(config);
        let lag = (config.walk_m > 0.0).then(|| Lag {
            steps: config.steps(config.belief.lag_s),
            past: belief.clone(),
            next: Step(0),
            recent: BTreeMap::new(),
            left_out: 0,
        });
        Self {
            sensor: Sensor::new(config),
            belief,
            survival: Survival::new(&config.ground),
            step: Step(0),
            lag,
            walk_m: config.walk_m,
        }
    }

    /// The belief at [`Self::step`].
    pub fn belief(&self) -> &Belief {
        &self.belief
    }

    /// The step of the belief.
    pub fn step(&self) -> Step {
        self.step
    }

    /// P(D) of the frames whose factors it has (8).
    pub fn cumulative_detection(&self) -> f64 {
        self.survival.cumulative_detection()
    }

    /// How many factors were too late to be filtered.
    pub fn left_out(&self) -> u64 {
        self.lag.as_ref().map_or(0, |lag| lag.left_out)
    }

    /// Time has come to a step: the belief is predicted up to it.
    pub fn advance(&mut self, step: Step) {
        while self.step < step {
            self.step.0 += 1;
            if !is_on(Mutant::WalkForgotten) {
                self.belief.predict(self.step);
            }
            if self.walk_m > 0.0 {
                self.survival.diffuse(self.walk_m);
            }
            if let Some(lag) = &mut self.lag {
                lag.follow(self.step);
            }
        }
    }

    /// Applies factors that were not applied yet, all of this step or earlier, in the order of steps and numbers: equal
    /// news make equal bits.
    pub fn apply(&mut self, mut news: Vec<Factor>) {
        if !is_on(Mutant::OrderOfArrival) {
            news.sort_unstable_by_key(|factor| (factor.step, factor.id));
        }
        if is_on(Mutant::LateLeftOut) {
            news.retain(|factor| factor.step >= self.step);
        }
        if is_on(Mutant::NoDetectionDropped) {
            news.retain(|factor| factor.sighting.is_some());
        }
        let likelihood = |factor: &Factor| Arc::new(Likelihood::new(&self.sensor, factor));
        let frames: Vec<Arc<Likelihood>> = news.iter().map(likelihood).collect();
        let counts = |frame: &&Arc<Likelihood>| {
            !(is_on(Mutant::DetectionsNotCounted) && frame.is_detection())
        };
        frames.iter().filter(counts).for_each(|frame| self.survival.look(frame));
        let Some(lag) = &mut self.lag else { return self.belief.update(&frames) };
        let is_late =
            news.iter().any(|factor| factor.step < self.step) && !is_on(Mutant::LateAsNow);
        for (factor, frame) in news.iter().zip(&frames) {
            lag.keep(factor, frame);
        }
        if is_late {
            self.belief = lag.filtered(self.step);
        } else {
            self.belief.update(&frames);
        }
    }

    /// Fuses the belief of another agent.
    pub fn fuse(&mut self, other: &Arc<Tiles>, fusion: Fusion) {
        self.belief.fuse(other, fusion);
        if let Some(lag) = &mut self.lag {
            // What was fused cannot be filtered again: the past begins now.
            lag.past = self.belief.clone();
            lag.next = self.step.after(1);
            lag.recent.clear();
        }
    }

    /// The likelihood of a factor.
    pub fn likelihood(&self, factor: &Factor) -> Likelihood {
        Likelihood::new(&self.sensor, factor)
    }
}

impl Lag {
    /// The past follows a step at its distance.
    fn follow(&mut self, now: Step) {
        while self.next.0.saturating_add(self.steps) < now.0 {
            let frames = self.frames_of(self.next);
            step_on(&mut self.past, self.next, &frames);
            self.next.0 += 1;
            let next = self.next;
            self.recent.retain(|(step, _), _| *step >= next);
        }
    }

    fn frames_of(&self, step: Step) -> Vec<Arc<Likelihood>> {
        let of_step = self.recent.iter().filter(|((of, _), _)| *of == step);
        of_step.map(|(_, frame)| frame.clone()).collect()
    }

    /// Keeps a factor, unless it is of the past.
    fn keep(&mut self, factor: &Factor, frame: &Arc<Likelihood>) {
        if factor.step < self.next {
            self.left_out += 1;
        } else {
            self.recent.insert((factor.step, factor.id), frame.clone());
        }
    }

    /// The past and all that came after it, filtered up to a step.
    fn filtered(&self, now: Step) -> Belief {
        let mut belief = self.past.clone();
        for step in self.next.0..=now.0 {
            step_on(&mut belief, Step(step), &self.frames_of(Step(step)));
        }
        belief
    }
}

/// Predicts a belief from the step before and applies the frames of a step. Before step 0 nothing moves.
fn step_on(belief: &mut Belief, step: Step, frames: &[Arc<Likelihood>]) {
    if step.0 > 0 {
        belief.predict(step);
    }
    belief.update(frames);
}

#[cfg(test)]
#[path = "filter_tests.rs"]
mod tests;
