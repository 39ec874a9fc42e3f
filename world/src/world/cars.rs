//! The cars of a world.

use csat_proto::model::{Driving, Ground, TargetsModel};

use super::{WorldConfig, WorldError};
use crate::map::Map;
use crate::obstacle::Walls;
use crate::road::RoadGraph;
use crate::target::{OffRoad, Traffic, Walkers, road_clearance_m};
use crate::track::Scripted;

/// Room between the border of the region and the cylinder of a car on any road, metres.
const BORDER_M: f64 = 0.5;

/// How far inside the region's border the locations of cars stay, metres.
pub(super) fn inset_m(targets: &TargetsModel) -> f64 {
    targets.radius_m + BORDER_M
}

/// How the cars move.
#[derive(Debug)]
pub(super) enum Cars {
    /// They drive on their own.
    Driving(Traffic),
    /// They stand or walk off the roads.
    Walking(Walkers),
    /// They follow tracks.
    Scripted(Scripted),
}

/// Where targets may be off the roads.
pub(super) fn off_road<'a>(config: &WorldConfig, map: &Map, walls: &'a Walls) -> OffRoad<'a> {
    let inset_m = inset_m(&config.targets);
    OffRoad {
        ground: Ground { size_m: map.ground.size_m.map(|side_m| side_m - 2.0 * inset_m) },
        walls,
        clearance_m: road_clearance_m(&config.targets),
    }
}

impl Cars {
    /// The cars at step 0.
    pub fn start(
        config: &WorldConfig,
        map: &Map,
        walls: &Walls,
        roads: &RoadGraph,
        seed: u64,
    ) -> Result<Self, Vec<WorldError>> {
        let Some(tracks) = &config.tracks else {
            if matches!(config.targets.driving, Driving::Static | Driving::RandomWalk) {
                let ground = off_road(config, map, walls);
                let walkers = Walkers::place(&ground, &config.targets, seed);
                return walkers.map(Self::Walking).map_err(|error| vec![error.into()]);
            }
            let traffic = Traffic::place(roads, map.roads.len(), &config.targets, seed);
            return traffic.map(Self::Driving).map_err(|error| vec![error.into()]);
        };
        let faults = tracks.faults(&config.targets, &map.ground, &map.obstacles);
        let mut errors: Vec<WorldError> = faults.into_iter().map(WorldError::Track).collect();
        if tracks.count() != usize::from(config.targets.count) {
            let (got, expected) = (config.targets.count.to_string(), tracks.count().to_string());
            errors.push(WorldError::Config { key: "targets.count", got, expected });
        }
        if errors.is_empty() {
            Ok(Self::Scripted(Scripted::new(tracks.clone())))
        } else {
            Err(errors)
        }
    }
}
