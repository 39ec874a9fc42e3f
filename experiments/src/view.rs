//! `view.json`: all that `map.svg` is drawn from, in metres of `world`.

use csat_proto::model::Station;
use csat_proto::oem::OemCell;
use csat_proto::raster::{Grid, Raster};
use csat_world::obstacle::Obstacle;
use serde::{Deserialize, Serialize};

use crate::rounding::{PER_METRE, polygons};
use crate::scenario::Loaded;
use crate::words;

/// A closed ring; the last point is not repeated.
pub type Ring = Vec<[f64; 2]>;
/// Shapes, each an outer ring and its holes.
pub type Shapes = Vec<Vec<Ring>>;

/// The world and what the agents know of it at the end of a mission.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct View {
    /// Name of the scenario.
    pub scenario: String,
    /// Its seed.
    pub seed: u64,
    /// Simulated time, seconds.
    pub time_s: f64,
    /// Width (east) and depth (north) of the region.
    pub size_m: [f64; 2],
    /// Buildings.
    pub obstacles: Vec<Building>,
    /// Centre lines of roads.
    pub roads: Vec<Vec<[f64; 2]>>,
    /// The UAVs, by index.
    pub uavs: Vec<UavTrack>,
    /// The ground stations; the first is the agent after the last UAV.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stations: Vec<Station>,
    /// The true locations of each target, by index and step.
    pub targets: Vec<Vec<[f64; 2]>>,
    /// What each agent knows, by index: the UAVs, then the stations.
    pub agents: Vec<Knowledge>,
    /// The line that whoever shows the map has to show with it.
    pub attribution: Option<String>,
}

impl View {
    /// An agent by name, for people: `UAV 0`, `station 4`.
    pub fn name_of(&self, agent: usize) -> String {
        words::named([agent as u16], self.uavs.len() as u16)
    }
}

/// A building.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Building {
    /// Outer ring, then holes.
    pub rings: Vec<Ring>,
    /// Height.
    pub height_m: f64,
}

impl Building {
    /// An obstacle to the nearest millimetre: one building, unless nothing is left of it or rounding
    /// takes apart what hung together by less.
    pub fn of(obstacle: &Obstacle) -> impl Iterator<Item = Self> {
        let height_m = to_millimetre(obstacle.height_m);
        let shapes = polygons(&[obstacle.rings().collect()], PER_METRE);
        shapes.into_iter().map(move |rings| Self { rings, height_m })
    }
}

/// How a UAV flew.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct UavTrack {
    /// Position by step.
    pub path: Vec<[f64; 2]>,
    /// Last heading, radians counter-clockwise from east.
    pub yaw_rad: f64,
    /// Last footprint.
    pub footprint: Ring,
}

/// What one agent knows.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Knowledge {
    /// X̄.
    pub unexplored: Shapes,
    /// X_j with j.
    pub targets: Vec<(u16, Shapes)>,
    /// X°.
    pub obstacle_margin: Shapes,
    /// X^h.
    pub hidden: Cells,
    /// The OEM.
    pub oem: Oem,
}

/// A raster.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Cells {
    /// Side of a cell.
    pub cell_m: f64,
    /// South-west corner of cell (0, 0).
    pub origin_m: [f64; 2],
    /// Runs of cells: row, first column, column after the last.
    pub runs: Vec<[u32; 3]>,
}

/// An occupancy-elevation map.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Oem {
    /// Side of a cell.
    pub cell_m: f64,
    /// South-west corner of cell (0, 0).
    pub origin_m: [f64; 2],
    /// Occupied cells: column, row, height in decimetres.
    pub occupied: Vec<(u32, u32, u16)>,
    /// Empty cells.
    pub empty: Cells,
}

impl View {
    /// The scenario and its town, with nobody in it yet.
    pub fn of_town(loaded: &Loaded) -> Self {
        let map = loaded.world.map();
        let rounded = |ring: &[[f64; 2]]| ring.iter().map(|p| p.map(to_millimetre)).collect();
        Self {
            scenario: loaded.name.clone(),
            seed: loaded.scenario.seed,
            size_m: loaded.scenario.map.size_m,
            obstacles: map.obstacles.iter().flat_map(Building::of).collect(),
            roads: map.roads.iter().map(|road| rounded(road)).collect(),
            attribution: map.attribution.clone(),
            ..Self::default()
        }
    }

    /// With every length of a line to the nearest millimetre: what is drawn is what is written down, and a
    /// large fleet's file stays small.
    pub fn rounded(mut self) -> Self {
        let roads = self.roads.iter_mut();
        let footprints_and_paths =
            self.uavs.iter_mut().flat_map(|u| [&mut u.path, &mut u.footprint]);
        let lines = roads.chain(footprints_and_paths).chain(&mut self.targets);
        for point in lines.flatten() {
            *point = point.map(to_millimetre);
        }
        for uav in &mut self.uavs {
            uav.yaw_rad = (uav.yaw_rad * 1e6).round() / 1e6;
        }
        self
    }
}

/// Area of shapes, m²: outer rings without their holes.
pub fn area_m2(shapes: &Shapes) -> f64 {
    let ring_m2 = |ring: &Ring| {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>().abs() / 2.0
    };
    let shape_m2 = |shape: &Vec<Ring>| match shape.split_first() {
        Some((outer, holes)) => ring_m2(outer) - holes.iter().map(ring_m2).sum::<f64>(),
        None => 0.0,
    };
    shapes.iter().map(shape_m2).sum()
}

/// A length to the nearest millimetre.
pub fn to_millimetre(metres: f64) -> f64 {
    (metres * 1e3).round() / 1e3
}

/// A raster as runs.
pub fn cells(raster: &Raster) -> Cells {
    runs(raster.grid(), raster.iter())
}

/// An OEM from the states of its cells in row-major order.
pub fn oem(grid: &Grid, states: &[OemCell]) -> Oem {
    let place = |index: usize| (index as u32 % grid.columns, index as u32 / grid.columns);
    let of = |wanted: fn(&OemCell) -> bool| {
        states.iter().enumerate().filter(move |(_, s)| wanted(s)).map(move |(i, _)| place(i))
    };
    let occupied = states.iter().enumerate().filter_map(|(i, state)| match state {
        OemCell::Occupied { height_dm } => Some((place(i).0, place(i).1, *height_dm)),
        _ => None,
    });
    Oem {
        cell_m: grid.cell_m,
        origin_m: grid.origin(),
        occupied: occupied.collect(),
        empty: runs(grid, of(|s| *s == OemCell::Empty)),
    }
}

fn runs(grid: &Grid, cells: impl Iterator<Item = (u32, u32)>) -> Cells {
    let mut runs: Vec<[u32; 3]> = Vec::new();
    for (column, row) in cells {
        match runs.last_mut() {
            Some([last_row, _, end]) if *last_row == row && *end == column => *end += 1,
            _ => runs.push([row, column, column + 1]),
        }
    }
    Cells { cell_m: grid.cell_m, origin_m: grid.origin(), runs }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::model::Ground;

    #[test]
    fn rasters_and_oems_become_runs() {
        let grid = Grid::covering(&Ground { size_m: [20.0, 10.0] }, 5.0);
        let mut raster = Raster::empty(grid);
        raster.set_run(0, 1..4);
        raster.set(0, 1);
        assert_eq!(cells(&raster).runs, [[0, 1, 4], [1, 0, 1]]);
        let mut states = vec![OemCell::Unexplored; 8];
        states[2] = OemCell::Empty;
        states[3] = OemCell::Empty;
        states[4] = OemCell::Occupied { height_dm: 123 };
        let oem = oem(&grid, &states);
        assert_eq!(oem.occupied, [(0, 1, 123)]);
        assert_eq!(oem.empty.runs, [[0, 2, 4]]);
        assert_eq!(oem.origin_m, [-10.0, -5.0]);
    }
}
