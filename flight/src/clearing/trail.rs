//! What each UAV has called cleared so far, for observers: agents remember their image only.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;

use csat_clearing::bitmap::Bitmap;
use csat_mission::picture::Cells;
use csat_proto::ids::AgentId;
use csat_world::contamination::Square;

/// The side of a cell, metres.
const CELL_M: f64 = 1.0;

/// The trails of the agents of this process. Nothing that agents or judges do depends on them.
#[derive(Debug, Default)]
pub struct Trails(Mutex<BTreeMap<AgentId, BTreeSet<[i32; 2]>>>);

impl Trails {
    /// Adds what an agent calls cleared of its image over `square`.
    pub fn add(&self, agent: AgentId, square: &Square, claims: &Bitmap) {
        let pixel_m = square.side_m / f64::from(claims.columns());
        let [west, north] =
            [square.middle[0] - square.side_m / 2.0, square.middle[1] + square.side_m / 2.0];
        let cell = |[row, column]: [u16; 2]| {
            let x = west + (f64::from(column) + 0.5) * pixel_m;
            let y = north - (f64::from(row) + 0.5) * pixel_m;
            [(y / CELL_M).floor() as i32, (x / CELL_M).floor() as i32]
        };
        let mut trails = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        trails.entry(agent).or_default().extend(claims.pixels().map(cell));
    }

    /// What an agent has called cleared so far.
    pub fn of(&self, agent: AgentId) -> Cells {
        let trails = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let cells = trails.get(&agent);
        let first = |axis: usize| {
            cells.into_iter().flatten().map(move |cell| cell[axis]).min().unwrap_or_default()
        };
        let (south, west) = (first(0), first(1));
        let origin_m = [west, south].map(|index| f64::from(index) * CELL_M);
        let place = |[row, column]: &[i32; 2]| ((column - west) as u32, (row - south) as u32);
        Cells::of(CELL_M, origin_m, cells.into_iter().flatten().map(place))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trail_grows_with_what_is_claimed() {
        let trails = Trails::default();
        let agent = AgentId(1);
        assert!(trails.of(agent).runs.is_empty());
        let mut claims = Bitmap::new(4, 4);
        claims.set(0, 0);
        claims.set(0, 1);
        trails.add(agent, &Square { middle: [10.0, 20.0], side_m: 4.0 }, &claims);
        trails.add(agent, &Square { middle: [11.0, 19.0], side_m: 4.0 }, &claims);
        let cells = trails.of(agent);
        assert_eq!(cells.origin_m, [8.0, 20.0]);
        assert_eq!(cells.runs, [[0, 1, 3], [1, 0, 2]]);
        assert!(trails.of(AgentId(0)).runs.is_empty());
    }
}
