//! Why there is no world, or a UAV does not follow a command.

use csat_proto::command::Command;
use csat_proto::ids::AgentId;

use super::stations::StationError;
use crate::map::{MapError, MapWarning};
use crate::start_line::StartLineError;
use crate::target::{OffRoadError, PlacementError};
use crate::track::TrackError;

/// One reason why there is no world.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum WorldError {
    /// An impossible value of the scenario.
    #[error("{key}: got {got}, expected {expected}")]
    Config {
        /// The scenario key.
        key: &'static str,
        /// Its value.
        got: String,
        /// What is expected.
        expected: String,
    },
    /// A ground station at an impossible place.
    #[error(transparent)]
    Station(#[from] StationError),
    /// The map.
    #[error(transparent)]
    Map(#[from] MapError),
    /// No start line.
    #[error(transparent)]
    StartLine(#[from] StartLineError),
    /// No room for all cars.
    #[error(transparent)]
    Placement(#[from] PlacementError),
    /// No room for all targets off the roads.
    #[error(transparent)]
    OffRoad(#[from] OffRoadError),
    /// A car that does not keep to the model.
    #[error("targets.tracks: {0}")]
    Track(TrackError),
}

/// Why there is no world.
#[derive(Debug, Clone, PartialEq)]
pub struct WorldErrors {
    /// Every reason; never empty.
    pub errors: Vec<WorldError>,
    /// What was left out of the map, which may be why the map has no room.
    pub map_warnings: Vec<MapWarning>,
}

impl From<Vec<WorldError>> for WorldErrors {
    fn from(errors: Vec<WorldError>) -> Self {
        Self { errors, map_warnings: Vec::new() }
    }
}

impl std::fmt::Display for WorldErrors {
    /// One line per reason.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (index, error) in self.errors.iter().enumerate() {
            let separator = if index > 0 { "\n" } else { "" };
            write!(f, "{separator}{error}")?;
        }
        Ok(())
    }
}

impl std::error::Error for WorldErrors {}

/// The fleet has no such UAV, or its vehicle cannot follow the command.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("UAV {agent} of {count}: {command:?}")]
pub struct CommandError {
    /// The agent to be commanded.
    pub agent: AgentId,
    /// Number of UAVs.
    pub count: usize,
    /// The command.
    pub command: Command,
}
