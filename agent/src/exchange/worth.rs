//! What a fact is worth to the other agents, and which one pays (docs/links.md).
//!
//! A fact is worth what it removes from the sets of an agent that knows what its sender knew before. Where bytes are
//! scarce, the version of a fact is said that is worth most above the price of its bytes, and none if none is worth
//! its price: the bytes are kept for a fact that removes more. A byte costs what bytes have bought lately, and less the
//! more of them there are.

use std::collections::BTreeMap;

use csat_proto::ids::TargetId;
use csat_proto::message::Fact;
use csat_proto::raster::Raster;

use crate::estimate::state::Knowledge;

/// What a cell of the map is worth, m²: it helps guidance and removes nothing.
const MAP_CELL_M2: f64 = 1.0;
/// The weight of the newest fact in what bytes have bought lately.
const NEWEST: f64 = 0.1;

/// The sets of an agent, from which facts remove something.
#[derive(Debug, Clone)]
pub struct KnownSets<'a> {
    unexplored: &'a Raster,
    targets: BTreeMap<TargetId, Raster>,
}

impl<'a> KnownSets<'a> {
    /// The sets X_j of `knowledge`, whose X̄ is `unexplored`, on the same grid.
    pub fn of(knowledge: &Knowledge, unexplored: &'a Raster) -> Self {
        let (grid, targets) = (*unexplored.grid(), knowledge.targets.iter());
        Self {
            unexplored,
            targets: targets.map(|(j, set)| (*j, Raster::of_region(grid, set.region()))).collect(),
        }
    }

    /// The area that a fact removes from the sets, and its cells of the map, m².
    pub fn worth_m2(&self, fact: &Fact) -> f64 {
        let grid = *self.unexplored.grid();
        let mut cleared = Raster::of_region(grid, &fact.clear_ground);
        cleared.fill_region(&fact.obstacle_margin);
        let mut of_targets = 0.0;
        for seen in &fact.targets {
            let before = self.targets.get(&seen.target).unwrap_or(self.unexplored);
            let mut removed = before.clone();
            removed.subtract(&Raster::of_region(grid, &seen.location));
            of_targets += removed.area_m2();
            cleared.fill_region(&seen.exclusion);
        }
        let unseen =
            self.targets.iter().filter(|(j, _)| fact.targets.iter().all(|t| t.target != **j));
        let sets = std::iter::once(self.unexplored).chain(unseen.map(|(_, set)| set));
        let cells: u32 = sets.map(|set| set.count_common(&cleared)).sum();
        let map = fact.oem.deltas().count() as f64 * MAP_CELL_M2;
        f64::from(cells) * grid.cell_m * grid.cell_m + of_targets + map
    }
}

/// A message that may be said.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Offer {
    /// What it is worth, m².
    pub worth_m2: f64,
    /// Its length.
    pub bytes: f64,
}

/// What a byte costs.
#[derive(Debug, Clone, Default)]
pub struct Price {
    /// What a byte has bought lately, m².
    lately_m2: f64,
}

impl Price {
    /// The index of the offer of a step that is worth most above the price of its bytes, if any is worth that. `full` is
    /// the credit, as a share of the most that is kept.
    pub fn best(
        &mut self,
        offers: impl Iterator<Item = Offer> + Clone,
        full: f64,
    ) -> Option<usize> {
        let of_a_byte = offers.clone().map(|offer| offer.worth_m2 / offer.bytes);
        self.lately_m2 += NEWEST * (of_a_byte.fold(0.0, f64::max) - self.lately_m2);
        let price_m2 = self.lately_m2 * (1.0 - full.clamp(0.0, 1.0)).powi(2);
        let profits = offers.map(|offer| offer.worth_m2 - price_m2 * offer.bytes).enumerate();
        let (index, profit_m2) = profits.max_by(|(_, a), (_, b)| a.total_cmp(b))?;
        (profit_m2 > 0.0).then_some(index)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::message::{Digest, TargetFact};
    use csat_proto::oem::{OemCell, OemDelta, OemPatch};
    use csat_proto::raster::Grid;
    use csat_proto::region::{Region, grid_point};
    use csat_proto::time::Step;

    use crate::config::tests::default_config;
    use crate::region::Outer;

    fn square([x, y]: [f64; 2], side_m: f64) -> Region {
        let corners = [[x, y], [x + side_m, y], [x + side_m, y + side_m], [x, y + side_m]];
        Region::from_shapes(vec![vec![corners.map(grid_point).to_vec()]])
    }

    fn nothing(grid: Grid) -> Fact {
        Fact {
            step: Step(3),
            number: 0,
            held: Digest::default(),
            clear_ground: Region::EMPTY,
            obstacle_margin: Region::EMPTY,
            targets: Vec::new(),
            hidden: Raster::empty(grid),
            seen: Raster::empty(grid),
            oem: OemPatch::default(),
        }
    }

    #[test]
    fn a_fact_is_worth_what_it_removes() {
        let config = default_config([500.0; 2]);
        let grid = config.raster_grid();
        let mut knowledge = Knowledge::at_start(&config);
        knowledge.sets.unexplored = Outer::containing(square([0.0, 0.0], 100.0));
        let known = TargetId(4);
        let set = Outer::containing(square([-100.0, -100.0], 40.0));
        knowledge.sets.targets.insert(known, set);
        let unexplored = Raster::of_region(grid, knowledge.unexplored.region());
        let sets = KnownSets::of(&knowledge, &unexplored);
        let worth_m2 = |change: &dyn Fn(&mut Fact)| {
            let mut fact = nothing(grid);
            change(&mut fact);
            sets.worth_m2(&fact)
        };
        let near = |a: f64, b: f64| assert!((a - b).abs() < 0.05 * b + 1.0, "{a} {b}");
        near(worth_m2(&|_| {}), 0.0);
        near(worth_m2(&|f| f.clear_ground = square([60.0, 0.0], 80.0)), 40.0 * 80.0);
        near(worth_m2(&|f| f.clear_ground = square([-200.0, 0.0], 80.0)), 0.0);
        near(worth_m2(&|f| f.obstacle_margin = square([0.0, 0.0], 20.0)), 400.0);
        // Ground that is cleared twice is removed once, and from the set of a car as well.
        let both = |f: &mut Fact| {
            f.clear_ground = square([-120.0, -120.0], 200.0);
            f.obstacle_margin = square([0.0, 0.0], 20.0);
        };
        near(worth_m2(&both), 80.0 * 80.0 + 1600.0);
        let seen = |target| TargetFact {
            target,
            location: square([-100.0, -100.0], 10.0),
            exclusion: square([0.0, 0.0], 10.0),
        };
        near(worth_m2(&|f| f.targets = vec![seen(known)]), 1500.0 + 100.0);
        // A car that was not known could be anywhere in X̄.
        near(worth_m2(&|f| f.targets = vec![seen(TargetId(1))]), 1e4 + 100.0);
        let cells =
            (0..7).map(|cell| OemDelta { cell, state: OemCell::Occupied { height_dm: 90 } });
        near(worth_m2(&|f| f.oem = OemPatch::of(cells.clone())), 7.0);
    }

    fn offer(worth_m2: f64, bytes: f64) -> Offer {
        Offer { worth_m2, bytes }
    }

    #[test]
    fn what_is_worth_less_than_usual_waits_while_bytes_are_scarce() {
        let mut price = Price::default();
        for _ in 0..100 {
            assert_eq!(price.best([offer(1000.0, 100.0)].into_iter(), 0.2), Some(0));
        }
        let poor = [offer(300.0, 100.0)];
        assert_eq!(price.clone().best(poor.into_iter(), 0.2), None);
        assert_eq!(price.clone().best(poor.into_iter(), 1.0), Some(0), "the credit is full");
        let versions = [offer(1000.0, 300.0), offer(900.0, 80.0), offer(100.0, 60.0)];
        assert_eq!(price.clone().best(versions.into_iter(), 0.2), Some(1));
        assert_eq!(price.clone().best(versions.into_iter(), 1.0), Some(0), "the finest");
        assert_eq!(price.best([].into_iter(), 1.0), None);
    }
}
