//! The best sequence of yaw increments: the whole tree U^N_MPC, prefixes shared (thesis §5.3.1).

use csat_proto::camera::Pose;

use super::criterion::{Sight, Terms, VisibilityModel, Weights};
use super::rollout::{Level, Motion, Surroundings};
use super::rounded_views::VisibleCells;
use super::{BlockKind, PlannerInput};

/// A block of a candidate: its yaw increment, radians, and the pose at its end.
pub(super) type Choice = (f64, Pose);

/// The best candidate so far.
#[derive(Debug, Clone)]
pub(super) struct Best {
    pub(super) cost: f64,
    pub(super) terms: Terms,
    pub(super) choices: Vec<Choice>,
}

/// One search.
pub(super) struct Search<'a> {
    pub(super) visibility: &'a mut VisibilityModel,
    pub(super) motion: Motion,
    pub(super) weights: Weights,
    /// U, radians, in the order of preference among increments of equal cost.
    pub(super) increments: &'a [f64],
    pub(super) around: Surroundings<'a>,
    pub(super) input: &'a PlannerInput<'a>,
    pub(super) sight: Sight<'a>,
    /// How blocks after the first are chosen.
    pub(super) later: BlockKind,
    /// The choices from the root to the current node.
    pub(super) trail: Vec<Choice>,
    pub(super) best: Option<Best>,
    /// Number of own poses whose views were predicted.
    pub(super) nodes: u32,
}

impl Search<'_> {
    /// Tries every sequence that continues the trail from `pose`; `levels[0]` holds X^Δ there, and
    /// there is one more level for every further block.
    pub(super) fn descend(&mut self, levels: &mut [Level], pose: &Pose) {
        let Some((level, deeper)) = levels.split_first_mut() else { return };
        level.pass_block(self.trail.len(), &self.around);
        let block = if self.trail.is_empty() { BlockKind::First } else { self.later };
        for (_, increment_rad) in self.input.choices(self.increments, pose, block) {
            let next = self.motion.advance(pose, increment_rad);
            let seen = self.visibility.look(&next, Some(self.input.hidden_now), &self.sight);
            self.nodes += 1;
            self.trail.push((increment_rad, next));
            match deeper.first_mut() {
                Some(child) => {
                    child.remaining.clone_from(&level.base);
                    seen.take_from(&mut child.remaining);
                    self.descend(deeper, &next);
                }
                None => self.judge(level, &seen, &next),
            }
            self.trail.pop();
        }
    }

    /// Keeps the trail if it costs less than every one before it.
    fn judge(&mut self, level: &Level, seen: &VisibleCells, pose: &Pose) {
        let seen_cells = seen.count_in(&level.base);
        let seen_hidden = seen.count_in_both(&level.base, self.around.hidden_recent);
        let cell_m2 = level.base.grid().cell_m.powi(2);
        let mut terms = Terms {
            remaining_m2: f64::from(level.base_cells - seen_cells) * cell_m2,
            distance_m: 0.0,
            hidden_m2: f64::from(level.base_hidden - seen_hidden) * cell_m2,
        };
        // The distance takes most time and is not negative: a candidate may lose without it.
        let best_cost = self.best.as_ref().map_or(f64::INFINITY, |best| best.cost);
        if self.weights.cost(&terms) >= best_cost {
            return;
        }
        terms.distance_m = self.visibility.distance_m(
            &level.base,
            seen,
            self.input.hidden_now,
            self.input.oem,
            pose,
        );
        let cost = self.weights.cost(&terms);
        if cost < best_cost {
            self.best = Some(Best { cost, terms, choices: self.trail.clone() });
        }
    }
}
