//! The best sequence of yaw increments: the whole tree U^N_MPC, prefixes shared (thesis §5.3.1).

use csat_proto::camera::Pose;
use csat_proto::raster::Raster;

use super::criterion::{Sight, Terms, Weights};
use super::footprint::Footprint;
use super::rollout::{Level, Motion, Surroundings};
use crate::estimate::oem::Oem;

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
    pub(super) sight: &'a mut Sight,
    pub(super) motion: Motion,
    pub(super) weights: Weights,
    /// U, radians, in the order of preference among equals.
    pub(super) increments: &'a [f64],
    pub(super) around: Surroundings<'a>,
    pub(super) hidden_now: &'a Raster,
    pub(super) oem: &'a Oem,
    /// The choices from the root to the current node.
    pub(super) trail: Vec<Choice>,
    pub(super) best: Option<Best>,
    /// Poses looked from, neighbours' not counted.
    pub(super) nodes: u32,
}

impl Search<'_> {
    /// Tries every sequence that continues the trail from `pose`; `levels[0]` holds X^Δ there, and
    /// there is one more level for every further block.
    pub(super) fn descend(&mut self, levels: &mut [Level], pose: &Pose) {
        let Some((level, deeper)) = levels.split_first_mut() else { return };
        level.pass_block(self.trail.len(), &self.around);
        for &increment_rad in self.increments {
            let next = self.motion.advance(pose, increment_rad);
            let footprint = self.sight.look(&next);
            self.nodes += 1;
            self.trail.push((increment_rad, next));
            match deeper.first_mut() {
                Some(child) => {
                    self.observe(&level.base, &footprint, &mut child.remaining);
                    self.descend(deeper, &next);
                }
                None => self.judge(level, &footprint, &next),
            }
            self.trail.pop();
        }
    }

    /// remaining = base without what is seen.
    fn observe(&self, base: &Raster, footprint: &Footprint, remaining: &mut Raster) {
        remaining.clone_from(base);
        for (row, word, bits) in footprint.words() {
            let candidates = bits & base.row(row)[word];
            remaining.row_mut(row)[word] &= !self.seen(row, word, candidates);
        }
    }

    fn seen(&self, row: u32, word: usize, bits: u64) -> u64 {
        self.sight.seen(Some(self.hidden_now), row, word, bits)
    }

    /// Keeps the trail if it costs less than every one before it.
    fn judge(&mut self, level: &Level, footprint: &Footprint, pose: &Pose) {
        let (mut seen_cells, mut seen_hidden) = (0, 0);
        for (row, word, bits) in footprint.words() {
            let seen = self.seen(row, word, bits & level.base.row(row)[word]);
            seen_cells += seen.count_ones();
            seen_hidden += (seen & self.around.hidden_recent.row(row)[word]).count_ones();
        }
        let cell_m2 = level.base.grid().cell_m.powi(2);
        let mut terms = Terms {
            remaining_m2: f64::from(level.base_cells - seen_cells) * cell_m2,
            distance_m: 0.0,
            hidden_m2: f64::from(level.base_hidden - seen_hidden) * cell_m2,
        };
        // The distance is the dear term and never negative: it need not be known to lose.
        let best_cost = self.best.as_ref().map_or(f64::INFINITY, |best| best.cost);
        if self.weights.cost(&terms) >= best_cost {
            return;
        }
        terms.distance_m =
            self.sight.distance_m(&level.base, self.hidden_now, self.oem, pose, footprint);
        let cost = self.weights.cost(&terms);
        if cost < best_cost {
            self.best = Some(Best { cost, terms, choices: self.trail.clone() });
        }
    }
}
