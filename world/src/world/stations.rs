//! Where ground stations may stand: near the region, on the ground or above it, and in no building.

use csat_proto::model::{Ground, Station};

use crate::obstacle::{Obstacle, Walls};

/// How far outside the region a station may stand, metres: the map has no buildings there.
pub const MAX_OUTSIDE_M: f64 = 1000.0;
/// How high an antenna may be, metres.
pub const MAX_HEIGHT_M: f64 = 1000.0;
/// The most stations.
pub const MAX_STATIONS: usize = 64;
/// The most agents, UAVs and stations together.
pub const MAX_AGENTS: usize = 1024;

/// A station within this distance of a wall is in the building, metres.
const ON_WALL_M: f64 = 1e-6;

/// Why a ground station cannot be at its place.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StationError {
    /// Too many, or too many agents.
    #[error(
        "{stations} stations beside {uavs} UAVs: expected at most {MAX_STATIONS}, and at most \
         {MAX_AGENTS} agents in all"
    )]
    TooMany {
        /// How many stations.
        stations: usize,
        /// N^u.
        uavs: u16,
    },
    /// A coordinate that is not a number, or too far away.
    #[error("stations[{index}] cannot have {axis} = {got}: expected {low} m to {high} m")]
    Far {
        /// Its place in the list.
        index: usize,
        /// The key.
        axis: &'static str,
        /// Its value, metres.
        got: f64,
        /// The least it may be, metres.
        low: f64,
        /// The most it may be, metres.
        high: f64,
    },
    /// Inside a building.
    #[error(
        "stations[{index}] at ({x_m}, {y_m}) m, {z_m} m high, is inside a building, {name}: expected \
         another place, or its roof: z_m above {roof_m} m"
    )]
    Indoors {
        /// Its place in the list.
        index: usize,
        /// East, metres.
        x_m: f64,
        /// North, metres.
        y_m: f64,
        /// Height, metres.
        z_m: f64,
        /// The name of the building.
        name: String,
        /// The height of the building, metres.
        roof_m: f64,
    },
}

impl StationError {
    /// The station's position in the list; `None` where their number is wrong.
    pub fn index(&self) -> Option<usize> {
        match self {
            Self::TooMany { .. } => None,
            Self::Far { index, .. } | Self::Indoors { index, .. } => Some(*index),
        }
    }
}

/// The mistakes that can be found without a map.
pub(super) fn far_away(stations: &[Station], uavs: u16, ground: &Ground) -> Vec<StationError> {
    let mut errors = Vec::new();
    let agents = stations.len() + usize::from(uavs);
    if stations.len() > MAX_STATIONS || (!stations.is_empty() && agents > MAX_AGENTS) {
        errors.push(StationError::TooMany { stations: stations.len(), uavs });
    }
    if !ground.size_m.iter().all(|size_m| size_m.is_finite()) {
        // The size of the region is reported elsewhere.
        return errors;
    }
    let [east_m, north_m] = ground.size_m.map(|size_m| size_m / 2.0 + MAX_OUTSIDE_M);
    for (index, station) in stations.iter().enumerate() {
        let ranges = [
            ("x_m", station.x_m, [-east_m, east_m]),
            ("y_m", station.y_m, [-north_m, north_m]),
            ("z_m", station.z_m, [0.0, MAX_HEIGHT_M]),
        ];
        let wrong = ranges.into_iter().filter(|(_, got, [low, high])| !(low..=high).contains(&got));
        errors.extend(wrong.map(|(axis, got, [low, high])| StationError::Far {
            index,
            axis,
            got,
            low,
            high,
        }));
    }
    errors
}

/// The stations that are inside of buildings. A station on a roof has to be above it.
pub(super) fn indoors(
    stations: &[Station],
    walls: &Walls,
    obstacles: &[Obstacle],
) -> Vec<StationError> {
    let inside = |(index, station): (usize, &Station)| {
        let Station { x_m, y_m, z_m } = *station;
        let (building, _) = walls.nearest_within([x_m, y_m], ON_WALL_M)?;
        let Obstacle { name, height_m: roof_m, .. } = obstacles.get(building)?;
        let name = name.clone();
        (z_m <= *roof_m).then_some(StationError::Indoors {
            index,
            x_m,
            y_m,
            z_m,
            name,
            roof_m: *roof_m,
        })
    };
    stations.iter().enumerate().filter_map(inside).collect()
}
