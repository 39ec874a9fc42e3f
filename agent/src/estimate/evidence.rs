//! What own and received frames prove about the step of the knowledge.

use std::sync::Arc;

use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::message::{Fact, Known};
use csat_proto::region::Region;
use csat_proto::time::Step;

use crate::config::AgentConfig;
use crate::identity::Identity;
use crate::mutant::{Mutant, is_on};
use crate::region::{Inner, Outer, Reach};
use crate::sense::{Measured, MeasuredTarget};

/// A valid fact with its sender, and the knowledge of the sender if it came in a snapshot.
#[derive(Debug, Clone, PartialEq)]
pub struct ReceivedFact {
    /// The sender.
    pub src: AgentId,
    /// Its incarnation.
    pub incarnation: Incarnation,
    /// What its frame proved.
    pub fact: Arc<Fact>,
    /// What it knew before the frame.
    pub known: Option<Arc<Known>>,
    /// Whether it is an answer to an agent that joined late, which has the number of another fact.
    pub is_answer: bool,
    /// The identity of the message.
    pub identity: Identity,
}

/// What one frame proves about a later step.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// Contains no target location at that step.
    pub clear_ground: Inner,
    /// Contains no target location at any step.
    pub obstacle_margin: Inner,
    /// The identified targets, by increasing index: where they may be, and where no other can be.
    pub targets: Vec<MeasuredTarget>,
}

impl Evidence {
    /// What an own frame proves about its own step.
    pub fn fresh(measured: &Measured) -> Self {
        Self {
            clear_ground: measured.clear_ground.clone(),
            obstacle_margin: measured.obstacle_margin.clone(),
            targets: measured.targets.clone(),
        }
    }
}

/// Turns old sets into sets of the current step.
///
/// A target moves by at most d = v_max·(age + bound of the clock skew), so outer approximations are
/// dilated by d and inner ones eroded.
#[derive(Debug, Clone)]
pub struct Ager {
    v_max_m_s: f64,
    period_s: f64,
    clock_skew_s: f64,
    vertices: u16,
    ground: Region,
}

impl Ager {
    /// For targets of `config`'s v_max.
    pub fn new(config: &AgentConfig) -> Self {
        Self {
            v_max_m_s: config.targets.v_max_m_s,
            period_s: config.period_s,
            clock_skew_s: config.exchange.clock_skew_s,
            vertices: config.estimator.disc_vertices,
            ground: Region::rectangle(config.ground.size_m),
        }
    }

    /// The disc within which a target may move between two steps of two clocks; `None` if it cannot
    /// move.
    pub fn reach(&self, a: Step, b: Step) -> Option<Reach> {
        let age_s = f64::from(a.0.abs_diff(b.0)) * self.period_s;
        let radius_m = self.v_max_m_s * (age_s + self.clock_skew_s);
        (radius_m > 0.0).then(|| Reach::new(radius_m, self.vertices))
    }

    /// The same disc; without clock skew if `mistake` is on.
    pub(super) fn reach_unless(&self, mistake: Mutant, a: Step, b: Step) -> Option<Reach> {
        match is_on(mistake) {
            true => Self { clock_skew_s: 0.0, ..self.clone() }.reach(a, b),
            false => self.reach(a, b),
        }
    }

    /// What a fact proves at step `now`.
    pub fn evidence(&self, fact: &Fact, now: Step) -> Evidence {
        let reach = self.reach_unless(Mutant::ClockSkewOfFactsIgnored, now, fact.step);
        let reach = reach.as_ref();
        let unless = |mutant| reach.filter(|_| !is_on(mutant));
        let targets = fact.targets.iter().map(|seen| MeasuredTarget {
            target: seen.target,
            location: self.dilated(seen.location.clone(), unless(Mutant::DetectionNotDilated)),
            exclusion: eroded(seen.exclusion.clone(), unless(Mutant::ExclusionNotEroded)),
        });
        let clear_ground = match is_on(Mutant::ClearGroundDilated) {
            true => Inner::within(self.dilated(fact.clear_ground.clone(), reach).into_region()),
            false => eroded(fact.clear_ground.clone(), unless(Mutant::ClearGroundNotEroded)),
        };
        Evidence {
            targets: targets.collect(),
            clear_ground,
            // Obstacles do not move, so the age does not matter.
            obstacle_margin: Inner::within(fact.obstacle_margin.clone()),
        }
    }

    /// A received outer set, grown by what a target can do within `reach`.
    pub fn dilated(&self, region: Region, reach: Option<&Reach>) -> Outer {
        let set = Outer::containing(region);
        match reach {
            Some(reach) => set.dilated_far(reach, &self.ground),
            None => set,
        }
    }
}

fn eroded(region: Region, reach: Option<&Reach>) -> Inner {
    let set = Inner::within(region);
    match reach {
        Some(reach) => set.eroded_far(reach),
        None => set,
    }
}
