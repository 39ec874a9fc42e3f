//! Prediction, block by block of T_MPC: the pose of a UAV (5.35) and the X^Δ that remains
//! (5.12)-(5.25).

use csat_proto::camera::Pose;
use csat_proto::raster::{Grid, Raster};

use crate::config::AgentConfig;

/// The guidance model of motion (5.35).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// v^u·T_MPC, metres.
    block_m: f64,
}

impl Motion {
    /// The motion of the fleet over one block.
    pub fn new(config: &AgentConfig) -> Self {
        Self { block_m: config.fleet.speed_m_s * config.guidance.period_s }
    }

    /// The level pose one block after `pose` with a yaw increment: first the turn, then the way.
    pub fn advance(&self, pose: &Pose, increment_rad: f64) -> Pose {
        let yaw_rad = pose.yaw_rad + increment_rad;
        self.straight(&Pose { yaw_rad, ..*pose }, 1)
    }

    /// The level pose `blocks` after `pose`, straight ahead.
    pub fn straight(&self, pose: &Pose, blocks: usize) -> Pose {
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let way_m = self.block_m * blocks as f64;
        let [x, y, z] = pose.p_world;
        Pose::level([x + way_m * cos, y + way_m * sin, z], pose.yaw_rad)
    }

    /// The poses at the ends of the next `count` blocks by a plan of which `elapsed` blocks are over:
    /// the rest of the plan, then straight ahead (thesis §5.3.2). Empty for an empty plan.
    pub fn forecast(&self, plan: &[Pose], elapsed: usize, count: usize) -> Vec<Pose> {
        let Some((last, past_end)) = plan.last().map(|last| (last, plan.len() - 1)) else {
            return Vec::new();
        };
        (elapsed..elapsed.saturating_add(count))
            .map(|block| {
                plan.get(block).copied().unwrap_or_else(|| self.straight(last, block - past_end))
            })
            .collect()
    }
}

/// Which other UAVs may have views that overlap the own ones within the horizon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ViewOverlap {
    /// Beyond this distance views cannot overlap, metres.
    reach_m: f64,
}

impl ViewOverlap {
    pub(super) fn new(config: &AgentConfig) -> Self {
        let way_m = Motion::new(config).block_m * config.guidance.blocks() as f64;
        Self { reach_m: way_m + 2.0 * config.planning_camera().d_max_m }
    }

    /// Whether a point may be seen both from `theirs` and from a pose that `own` can reach within the
    /// horizon.
    pub(super) fn may_see_the_same(&self, own: &Pose, theirs: &Pose) -> bool {
        let gap = |axis: usize| own.p_world[axis] - theirs.p_world[axis];
        gap(0).hypot(gap(1)) <= self.reach_m
    }
}

/// One depth of the search tree.
#[derive(Debug, Clone)]
pub(super) struct Level {
    /// X^Δ at this depth.
    pub(super) remaining: Raster,
    /// X^Δ a block later, before the own look; it is the same for all children.
    pub(super) base: Raster,
    /// Cells of `base`.
    pub(super) base_cells: u32,
    /// Cells of `base` that were recently hidden.
    pub(super) base_hidden: u32,
}

/// What changes X^Δ in a block apart from the own look.
pub(super) struct Surroundings<'a> {
    /// v_max·T_MPC, metres.
    pub(super) growth_m: f64,
    /// X°, unless the criterion ignores it.
    pub(super) margin: Option<&'a Raster>,
    /// What all neighbours would see at the end of each block.
    pub(super) seen_by_others: &'a [Raster],
    /// ⋃ H^CVS of the last h steps (5.30).
    pub(super) hidden_recent: &'a Raster,
}

impl Level {
    pub(super) fn new(grid: Grid) -> Self {
        let empty = Raster::empty(grid);
        Self { remaining: empty.clone(), base: empty, base_cells: 0, base_hidden: 0 }
    }

    /// Computes `base`, the X^Δ after the next block: X^Δ grows by f^t (4.24) and loses X° and what
    /// the other UAVs see.
    pub(super) fn pass_block(&mut self, depth: usize, around: &Surroundings<'_>) {
        self.remaining.dilate_disc_into(around.growth_m, &mut self.base);
        if let Some(margin) = around.margin {
            self.base.subtract(margin);
        }
        if let Some(seen) = around.seen_by_others.get(depth) {
            self.base.subtract(seen);
        }
        self.base_cells = self.base.count();
        self.base_hidden = self.base.count_common(around.hidden_recent);
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    const MOTION: Motion = Motion { block_m: 15.0 };

    fn at(x: f64, y: f64, yaw_rad: f64) -> Pose {
        Pose::level([x, y, 52.0], yaw_rad)
    }

    fn close(a: &Pose, b: &Pose) -> bool {
        let gap = |axis: usize| (a.p_world[axis] - b.p_world[axis]).abs();
        gap(0) + gap(1) + gap(2) + (a.yaw_rad - b.yaw_rad).abs() < 1e-9
    }

    #[test]
    fn the_turn_comes_before_the_way() {
        let turned = MOTION.advance(&at(1.0, 2.0, 0.0), FRAC_PI_2);
        assert!(close(&turned, &at(1.0, 17.0, FRAC_PI_2)), "{turned:?}");
    }

    #[test]
    fn a_forecast_is_the_rest_of_the_plan_and_then_straight() {
        let plan = [at(15.0, 0.0, 0.0), at(15.0, 15.0, FRAC_PI_2)];
        let expected =
            [at(15.0, 15.0, FRAC_PI_2), at(15.0, 30.0, FRAC_PI_2), at(15.0, 45.0, FRAC_PI_2)];
        let forecast = MOTION.forecast(&plan, 1, 3);
        assert!(forecast.iter().zip(&expected).all(|(a, b)| close(a, b)), "{forecast:?}");
        let late = MOTION.forecast(&plan, 4, 1);
        assert!(close(&late[0], &at(15.0, 60.0, FRAC_PI_2)), "{late:?}");
        assert_eq!(MOTION.forecast(&[], 0, 2), vec![]);
    }
}
