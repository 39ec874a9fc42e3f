//! The increments that are safe at a decision, and their ways out.

use std::f64::consts::TAU;

use csat_proto::camera::Pose;
use csat_proto::raster::Raster;

use super::super::Decision;
use super::super::criterion::Terms;
use super::super::turning::Turning;
use super::Airspace;
use crate::config::AgentConfig;
use crate::estimate::oem::Oem;
use crate::mutant::{Mutant, is_on};

/// Smaller increments do not count as turns, radians.
const LEAST_TURN_RAD: f64 = 0.1;
/// The most blocks straight ahead before the circle of a way out.
const MOST_STRAIGHT: usize = 12;

/// The tightest circles that can be flown.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Circling {
    /// Indexes in U of the sharpest turns, to either side; empty without a turn.
    pub(super) sides: Vec<usize>,
    /// The number of blocks after which a circle repeats itself.
    pub(super) blocks: usize,
    /// Bound of the error of the flight, metres: turns that have not settled, and, if a round is not
    /// a whole number of blocks, the bulge of a block, by which rounds differ.
    pub(super) doubt_m: f64,
}

impl Circling {
    pub(super) fn of(config: &AgentConfig, increments: &[f64]) -> Self {
        let turns = || increments.iter().copied().filter(|u| u.abs() > LEAST_TURN_RAD);
        let sharpest = |sign: f64| {
            turns().filter(|u| u * sign > 0.0).max_by(|a, b| a.abs().total_cmp(&b.abs()))
        };
        let rads: Vec<f64> = [1.0, -1.0].into_iter().filter_map(sharpest).collect();
        let sides = rads.iter().filter_map(|turn| increments.iter().position(|u| u == turn));
        let rounds = rads.iter().map(|turn| TAU / turn.abs());
        let blocks = rounds.clone().fold(0.0, f64::max).ceil() as usize + 1;
        let block_m = config.fleet.speed_m_s * config.guidance.period_s;
        let bulge_m = |turn: &f64| {
            let round = TAU / turn.abs();
            let is_whole = (round - round.round()).abs() < 1e-6;
            let half = 0.5 * turn.abs();
            if is_whole { 0.0 } else { 0.5 * block_m / half.sin() * (1.0 - half.cos()) }
        };
        let doubts = rads
            .iter()
            .map(|turn| (blocks + 2) as f64 * Turning::doubt_m(config, *turn) + bulge_m(turn));
        let doubt_m = doubts.fold(0.0, f64::max);
        Self { sides: sides.collect(), blocks, doubt_m }
    }
}

/// Blocks that end in a circle.
#[derive(Debug, Clone, PartialEq)]
pub struct WayOut {
    /// Indexes in U, the next one last.
    ahead: Vec<usize>,
    /// The index in U of the turn of the circle.
    side: usize,
}

impl WayOut {
    /// Its next increment, and the rest of it.
    fn next(mut self) -> (usize, Self) {
        let next = self.ahead.pop().unwrap_or(self.side);
        (next, self)
    }
}

/// The ways from a pose at a decision.
#[derive(Debug)]
pub struct Ways<'a> {
    airspace: &'a Airspace,
    pose: Pose,
    /// Where a UAV may be too near to a building.
    closed: Raster,
    /// Where it is too near to a known building; for blocks that are not flown yet.
    standing: Raster,
    /// By increment: the way out behind it; `None` if the increment is not safe.
    behind: Vec<Option<WayOut>>,
    /// The way out of the last decision.
    way_out: Option<WayOut>,
}

impl<'a> Ways<'a> {
    pub(super) fn from(
        airspace: &'a Airspace,
        pose: &Pose,
        oem: &Oem,
        way_out: Option<WayOut>,
    ) -> Self {
        let mut standing = Raster::empty(*airspace.unknown.grid());
        let grid = oem.grid();
        for delta in oem.known().filter(|delta| delta.state != csat_proto::oem::OemCell::Empty) {
            let [x, y] = grid.centre(delta.cell % grid.columns, delta.cell / grid.columns);
            let half_m = 0.5 * grid.cell_m;
            let columns = standing.grid().columns_between(x - half_m, x + half_m);
            for row in standing.grid().rows_between(y - half_m, y + half_m) {
                standing.set_run(row, columns.clone());
            }
        }
        standing.intersect_with(&airspace.unknown);
        let mut ways = Self {
            airspace,
            pose: *pose,
            closed: airspace.unknown.dilated_disc(airspace.margin_m),
            standing: standing.dilated_disc(airspace.margin_m),
            behind: Vec::new(),
            way_out,
        };
        ways.behind = (0..airspace.increments.len()).map(|i| ways.find_behind(i)).collect();
        ways
    }

    /// Whether any increment is safe.
    pub fn is_any_safe(&self) -> bool {
        self.behind.iter().any(Option::is_some)
    }

    /// Whether an increment of U is safe.
    pub fn is_safe(&self, increment_rad: f64) -> bool {
        self.index_of(increment_rad).is_some_and(|index| self.behind[index].is_some())
    }

    /// Whether a block that begins with an increment of U at `pose` keeps clear of known buildings.
    /// It is used for later blocks and guarantees nothing.
    pub fn is_open(&self, pose: &Pose, increment_rad: f64) -> bool {
        let index = self.index_of(increment_rad);
        index.is_some_and(|index| self.is_clear(&self.standing, pose, index))
    }

    /// Whether a place is known to be too near to a building.
    pub fn is_built(&self, p_world: [f64; 2]) -> bool {
        is_in(&self.standing, p_world)
    }

    /// The way out behind an increment of U, if the increment is safe.
    pub fn behind(&self, increment_rad: f64) -> Option<WayOut> {
        self.index_of(increment_rad).and_then(|index| self.behind[index].clone())
    }

    /// The way out behind the first block of [`Self::retreat`].
    pub fn behind_retreat(&self) -> Option<WayOut> {
        self.way_out.clone().map(|way| way.next().1)
    }

    /// The decision when no increment is safe: the way out of the last decision, which is still one;
    /// without it, the increment that keeps clear longest of places where a building may be.
    pub fn retreat(&self) -> Decision {
        let increments = &self.airspace.increments;
        let mut rest = self.way_out.clone().unwrap_or_else(|| self.least_bad());
        let (mut increments_rad, mut poses, mut pose) = (Vec::new(), Vec::new(), self.pose);
        for _ in 0..self.airspace.blocks {
            let next;
            (next, rest) = rest.next();
            pose = self.airspace.turning.advance(&pose, next);
            increments_rad.push(increments[next]);
            poses.push(pose);
        }
        Decision { increments_rad, poses, cost: 0.0, terms: Terms::default(), nodes: 0 }
    }

    fn least_bad(&self) -> WayOut {
        let sides = &self.airspace.circling.sides;
        let all = (0..self.airspace.increments.len())
            .flat_map(|first| sides.iter().map(move |&side| (first, side)));
        let steps = |&(first, side): &(usize, usize)| {
            let mut pose = self.pose;
            let mut steps = 0;
            let turns = std::iter::once(first).chain(std::iter::repeat(side));
            for turn in turns.take(self.airspace.circling.blocks) {
                let mut way = self.airspace.turning.way(&pose, turn);
                let total = way.size_hint().0;
                match way.position(|p| is_in(&self.closed, p)) {
                    Some(position) => return steps + position,
                    None => steps += total,
                }
                pose = self.airspace.turning.advance(&pose, turn);
            }
            steps
        };
        // The first one of the longest, which has the gentlest turn.
        let best = all.min_by_key(|way| std::cmp::Reverse(steps(way)));
        let (first, side) = best.unwrap_or((0, 0));
        WayOut { ahead: vec![first], side }
    }

    fn index_of(&self, increment_rad: f64) -> Option<usize> {
        self.airspace.increments.iter().position(|u| *u == increment_rad)
    }

    fn is_clear(&self, cells: &Raster, pose: &Pose, increment: usize) -> bool {
        self.airspace.turning.way(pose, increment).all(|p| !is_in(cells, p))
    }

    /// A way out behind an increment, if its own block is clear: a circle at once, or after some
    /// blocks straight ahead, or the same after another turn.
    fn find_behind(&self, increment: usize) -> Option<WayOut> {
        let end = self.fly(&self.pose, increment)?;
        if is_on(Mutant::NoWayOutNeeded) {
            return Some(WayOut { ahead: Vec::new(), side: increment });
        }
        let straight_on = self.find_ahead(&end, Vec::new());
        straight_on.or_else(|| {
            let turns = (0..self.airspace.increments.len())
                .filter(|&turn| self.airspace.increments[turn] != 0.0);
            turns.clone().find_map(|turn| self.find_ahead(&self.fly(&end, turn)?, vec![turn]))
        })
    }

    /// A way out with a circle at `pose` or straight ahead of it; `flown` leads to `pose`.
    fn find_ahead(&self, pose: &Pose, flown: Vec<usize>) -> Option<WayOut> {
        let straight = self.index_of(0.0);
        let (mut pose, mut flown) = (*pose, flown);
        for _ in 0..=MOST_STRAIGHT {
            if let Some(side) = self.circle_at(&pose) {
                flown.reverse();
                return Some(WayOut { ahead: flown, side });
            }
            pose = self.fly(&pose, straight?)?;
            flown.push(straight?);
        }
        None
    }

    /// The pose at the end of a block, if its way is clear.
    fn fly(&self, pose: &Pose, increment: usize) -> Option<Pose> {
        let is_clear = self.is_clear(&self.closed, pose, increment);
        is_clear.then(|| self.airspace.turning.advance(pose, increment))
    }

    /// The side to which a whole circle can be flown from `pose`.
    fn circle_at(&self, pose: &Pose) -> Option<usize> {
        let Circling { sides, blocks, .. } = &self.airspace.circling;
        let round =
            |side: usize| (0..*blocks).try_fold(*pose, |pose, _| self.fly(&pose, side)).is_some();
        sides.iter().copied().find(|&side| round(side))
    }
}

/// Whether a point, `world`, metres, is in a cell of a set.
fn is_in(cells: &Raster, p_world: [f64; 2]) -> bool {
    cells.grid().cell_of(p_world).is_some_and(|(column, row)| cells.get(column, row))
}
