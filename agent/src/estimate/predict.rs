//! Prediction (4.24)-(4.27): the sets of one step at the next step.

use std::collections::BTreeMap;
use std::sync::Arc;

use csat_proto::ids::TargetId;
use csat_proto::time::Step;

use super::sets::Sets;
use crate::config::AgentConfig;
use crate::mutant::{Mutant, is_on};
use crate::region::{Grown, Memo, Outer, Reach};

/// Sets are simplified by at least this before they grow, metres. Where two sets are equal up to
/// rounding, as those of two agents often are, their intersection has details of that size. The
/// simplification fills notches and gaps. It keeps slivers of the set, because an outer approximation
/// must not lose them.
const SLIVER_M: f64 = 1e-3;

/// The sets of step k, predicted from step k-1 (4.24)-(4.26).
#[derive(Debug, Clone)]
pub struct Predicted {
    /// X_{ij,k|k-1}.
    pub targets: BTreeMap<TargetId, Grown>,
    /// X̄_{i,k|k-1}.
    pub unexplored: Grown,
}

/// Grows the sets by the motion of a target in one period.
#[derive(Debug, Clone)]
pub struct Predictor {
    reach: Reach,
    simplify_m: f64,
    /// The most vertices of a set before it grows. Sets are limited here, not when they are cut, so
    /// that the result of a merge does not depend on its order.
    max_vertices: usize,
    hidden_steps: u32,
    memo: Arc<Memo>,
}

impl Predictor {
    /// A predictor for targets of `config`'s v_max.
    pub fn new(config: &AgentConfig) -> Self {
        Self::with_memo(config, Arc::default())
    }

    /// One whose sets look up what others with the same `memo` computed.
    pub fn with_memo(config: &AgentConfig, memo: Arc<Memo>) -> Self {
        let guidance = &config.guidance;
        let horizon_s = f64::from(guidance.n_mpc) * guidance.period_s;
        let radius_m = config.targets.v_max_m_s * config.period_s;
        let vertices = config.estimator.disc_vertices;
        let shrunk = match is_on(Mutant::ReachInscribed) {
            true => (std::f64::consts::PI / f64::from(vertices)).cos(),
            false => 1.0,
        };
        Self {
            reach: Reach::of_period(shrunk * radius_m, vertices),
            simplify_m: config.estimator.simplify_m.max(SLIVER_M),
            max_vertices: config.estimator.max_vertices as usize,
            hidden_steps: (horizon_s / config.period_s).round() as u32,
            memo,
        }
    }

    /// Takes sets to the step before `step`.
    ///
    /// An agent that missed frames grows its sets for each of them, because the targets moved.
    pub fn catch_up(&self, sets: &mut Sets, step: Step) {
        let behind = if is_on(Mutant::GapOnePeriodShort) { 2 } else { 1 };
        while sets.step.0 + behind < step.0 {
            let Predicted { targets, unexplored } = self.grown(sets);
            sets.targets = targets.iter().map(|(&j, set)| (j, set.resolved())).collect();
            if !is_on(Mutant::GapGrowsTargetsOnly) {
                sets.unexplored = unexplored.resolved();
            }
            sets.step.0 += 1;
        }
    }

    /// Takes sets to `step`, or without it leaves them at their step, and returns them as predicted;
    /// the sets themselves are those of the step before until they are corrected. X° stays (4.27).
    pub fn predict(&self, sets: &mut Sets, step: Option<Step>) -> Predicted {
        let Some(step) = step else { return self.still(sets) };
        self.catch_up(sets, step);
        // The first frame is of the first step of the knowledge: no target has moved yet.
        let predicted = if step > sets.step && !is_on(Mutant::NoPrediction) {
            self.grown(sets)
        } else {
            self.still(sets)
        };
        sets.step = sets.step.max(step);
        predicted
    }

    /// The first step whose views are remembered at `step`.
    pub fn views_from(&self, step: Step) -> Step {
        Step((step.0 + 1).saturating_sub(self.hidden_steps))
    }

    /// The sets as they are.
    fn still(&self, sets: &Sets) -> Predicted {
        let still = |set: &Outer| Grown::still(set, sets.ground(), &self.memo);
        let targets = sets.targets.iter();
        Predicted {
            targets: targets.map(|(&j, set)| (j, still(set))).collect(),
            unexplored: still(&sets.unexplored),
        }
    }

    fn grown(&self, sets: &Sets) -> Predicted {
        self.memo.begin(Step(sets.step.0 + 1));
        let ground = sets.ground();
        let grown = |set: &Outer| {
            let set = set.clone().limited(self.max_vertices, ground);
            Grown::new(&set, self.simplify_m, &self.reach, ground, &self.memo)
        };
        let targets = sets.targets.iter();
        Predicted {
            targets: targets.map(|(&j, set)| (j, grown(set))).collect(),
            unexplored: grown(&sets.unexplored),
        }
    }
}
