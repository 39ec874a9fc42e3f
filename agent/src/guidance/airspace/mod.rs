//! Flying around buildings: a UAV enters only airspace that it has seen to be free, and only where it
//! can stay in free airspace for ever.
//!
//! | module | what it holds |
//! |---|---|
//! | `seen` | the airspace that a frame proves to be free |
//! | `ways` | the increments that are safe at a decision, and their ways out |
//!
//! # What is proven
//!
//! *Proposition.* Let a Ground pixel show a point g, seen by a camera at altitude z above the nadir
//! o. Then over p = o + s·(g - o), 0 ≤ s ≤ 1, no building is higher than z·(1 - s). *Proof.* The ray
//! passes over p at that height and ends on the ground (Assumption 4), so no building has that point.
//! Buildings are Z-convex (3.1): one with a point above it over p would have it, too. ∎
//!
//! So all airspace from the UAV to the ground that it sees is free at its altitude, with
//! [`FLIGHT_CLEARANCE_M`] below it wherever z·(1 - s) ≤ z - [`FLIGHT_CLEARANCE_M`]. It stays free,
//! because no building is added during a mission. Also free are the airspace outside the region,
//! where no building stands, and the launch site
//! ([`csat_proto::model::FleetModel::launch_radius_m`]). All other airspace counts as a building of
//! unlimited height, whether an obstacle was seen there or not. Messages of other agents are not
//! used: whether a UAV hits a wall must not depend on its radio.
//!
//! *Proposition.* Let a UAV fly, at every decision, an increment whose way through its block stays in
//! free airspace, and after which further blocks are known that also stay in free airspace and end in
//! a circle (a *way out*). Then it never leaves free airspace, as long as decisions are made in time.
//! *Proof.* At the next decision the first increment of the way out is such an increment, with the
//! rest of the way out behind it. Free airspace stays free, and a circle that can be flown once can
//! be flown for ever. At the start, the circle in the launch site is a way out. ∎

use csat_proto::camera::{CameraView, Pose};
use csat_proto::frame::Frame;
use csat_proto::ids::Incarnation;
use csat_proto::model::{FLIGHT_CLEARANCE_M, Ground};
use csat_proto::raster::{Grid, Raster};
use csat_proto::time::Step;

use super::turning::Turning;
use crate::config::AgentConfig;
use crate::estimate::oem::Oem;
use crate::mutant::{Mutant, is_on};

mod seen;
mod ways;

use seen::SeenGround;
use ways::Circling;
pub use ways::{WayOut, Ways};

/// Side of a cell of airspace, metres.
const CELL_M: f64 = 1.0;

/// What a UAV knows of the airspace at its altitude.
#[derive(Debug, Clone)]
pub struct Airspace {
    turning: Turning,
    /// U, radians, the gentlest first.
    increments: Vec<f64>,
    circling: Circling,
    /// Cells not known to be free.
    unknown: Raster,
    /// The distance that ways keep from the middle of such a cell, metres.
    margin_m: f64,
    /// `None` for an incarnation that did not start at the launch site.
    launch_m: Option<f64>,
    blocks: usize,
    steps_per_block: u32,
    /// The way out from a decision on, if no other increment is found to be safe.
    way_out: Option<(Step, WayOut)>,
    is_lost: bool,
}

impl Airspace {
    /// The airspace that is known at the start; `None` if all buildings are below the UAVs.
    pub fn new(config: &AgentConfig) -> Option<Self> {
        if !config.fleet.avoid_buildings {
            return None;
        }
        let increments = config.guidance.gentlest_first_rad();
        let circling = Circling::of(config, &increments);
        let margin_m = margin_m(config, &circling);
        let side_m = |size_m: f64| size_m + 2.0 * (margin_m + CELL_M).ceil();
        let grid = Grid::covering(&Ground { size_m: config.ground.size_m.map(side_m) }, CELL_M);
        let mut unknown = Raster::empty(grid);
        let [x, y] = config.ground.size_m.map(|size_m| 0.5 * (size_m + CELL_M));
        let columns = grid.columns_between(-x, x.next_up());
        if !is_on(Mutant::UnseenAirspaceFree) {
            let rows = grid.rows_between(-y, y.next_up());
            rows.for_each(|row| unknown.set_run(row, columns.clone()));
        }
        Some(Self {
            turning: Turning::new(config, &increments),
            increments,
            circling,
            unknown,
            margin_m,
            launch_m: (config.incarnation == Incarnation(0))
                .then(|| config.fleet.launch_radius_m()),
            blocks: config.guidance.blocks(),
            steps_per_block: (config.guidance.period_s / config.period_s).round().max(1.0) as u32,
            way_out: None,
            is_lost: false,
        })
    }

    /// Marks the airspace that a frame proves to be free.
    pub fn see(&mut self, view: &CameraView, frame: &Frame) {
        if let Some(launch_m) = self.launch_m.filter(|_| frame.step == Step(0)) {
            self.clear_disc([frame.pose.p_world[0], frame.pose.p_world[1]], launch_m);
        }
        SeenGround::through(view, frame).clear_from(&mut self.unknown);
    }

    /// The cells that are not known to be free.
    pub fn unknown(&self) -> &Raster {
        &self.unknown
    }

    fn clear_disc(&mut self, centre: [f64; 2], radius_m: f64) {
        let grid = *self.unknown.grid();
        let inner_m = radius_m - CELL_M * std::f64::consts::FRAC_1_SQRT_2;
        let rows = grid.rows_between(centre[1] - inner_m, centre[1] + inner_m);
        for row in rows {
            let y = grid.centre(0, row)[1] - centre[1];
            let x = (inner_m * inner_m - y * y).max(0.0).sqrt();
            let columns = grid.columns_between(centre[0] - x, centre[0] + x);
            columns.for_each(|column| self.unknown.clear(column, row));
        }
    }

    /// The ways from `pose` (`world`, metres; its yaw is the last commanded one) at the decision of
    /// `step`.
    pub fn ways(&self, pose: &Pose, oem: &Oem, step: Step) -> Ways<'_> {
        let way_out = self.way_out.as_ref().filter(|(at, _)| *at == step).map(|(_, way)| way);
        Ways::from(self, pose, oem, way_out.cloned())
    }

    /// Notes the way out `behind` the block that is flown from the decision of `step` on. True if
    /// this is the first decision without a way out.
    pub fn fly(&mut self, step: Step, behind: Option<WayOut>) -> bool {
        let was_lost = std::mem::replace(&mut self.is_lost, behind.is_none());
        self.way_out = behind.map(|way| (Step(step.0 + self.steps_per_block), way));
        self.is_lost && !was_lost
    }
}

/// The greatest distance of a UAV from its start in its tightest circle, plus the distance that it
/// keeps from buildings, metres; infinite if it cannot turn.
pub fn turning_room_m(config: &AgentConfig) -> f64 {
    let increments = config.guidance.gentlest_first_rad();
    let circling = Circling::of(config, &increments);
    let turning = Turning::new(config, &increments);
    let mut pose = Pose::default();
    let mut farthest_m = if circling.sides.is_empty() { f64::INFINITY } else { 0.0 };
    for _ in 0..circling.blocks {
        let Some(&side) = circling.sides.first() else { break };
        let ways = turning.way(&pose, side).map(|[x, y]| x.hypot(y));
        farthest_m = ways.fold(farthest_m, f64::max);
        pose = turning.advance(&pose, side);
    }
    farthest_m + margin_m(config, &circling) + CELL_M
}

/// The distance that ways keep from the middle of a cell that may hold a building, metres: the
/// clearance, half the diagonals of that cell and of the own cell, half a step, and the bound of the
/// error of the flight.
fn margin_m(config: &AgentConfig, circling: &Circling) -> f64 {
    let diagonal_m = CELL_M * std::f64::consts::SQRT_2;
    FLIGHT_CLEARANCE_M + diagonal_m + 0.5 * Turning::step_m(config) + circling.doubt_m
}

#[cfg(test)]
mod tests;
