//! Prediction (4.24)-(4.27): what was known one period ago, now.

use csat_proto::time::Step;

use super::state::Knowledge;
use crate::config::AgentConfig;
use crate::region::Disc;

/// Grows the sets by whatever a target may do in one period.
#[derive(Debug, Clone)]
pub struct Predictor {
    reach: Disc,
    simplify_m: f64,
    simplify_margin_m: f64,
    hidden_steps: u32,
}

impl Predictor {
    /// A predictor for targets of `config`'s v_max.
    pub fn new(config: &AgentConfig) -> Self {
        let guidance = &config.guidance;
        let horizon_s = f64::from(guidance.n_mpc) * guidance.period_s;
        let radius_m = config.targets.v_max_m_s * config.period_s;
        Self {
            reach: Disc::circumscribed(radius_m, config.estimator.disc_vertices),
            simplify_m: config.estimator.simplify_m,
            simplify_margin_m: config.estimator.simplify_margin_m,
            hidden_steps: (horizon_s / config.period_s).round() as u32,
        }
    }

    /// Advances the knowledge, one period at a time, to `step`. X° stays (4.27)
    /// but for its simplification.
    ///
    /// An agent that missed frames grows its sets for each of them: the targets moved all the same.
    pub fn advance(&self, knowledge: &mut Knowledge, step: Step) {
        while knowledge.step < step {
            self.advance_one(knowledge);
        }
        knowledge.forget_views_before(Step((step.0 + 1).saturating_sub(self.hidden_steps)));
    }

    fn advance_one(&self, knowledge: &mut Knowledge) {
        let ground = knowledge.ground().clone();
        for set in knowledge.targets.values_mut() {
            *set = std::mem::take(set).simplified(self.simplify_m).dilated(&self.reach, &ground);
        }
        let unexplored = std::mem::take(&mut knowledge.unexplored);
        knowledge.unexplored =
            unexplored.simplified(self.simplify_m).dilated(&self.reach, &ground);
        knowledge.margin = std::mem::take(&mut knowledge.margin).simplified(self.simplify_margin_m);
        knowledge.step = Step(knowledge.step.0 + 1);
    }
}
