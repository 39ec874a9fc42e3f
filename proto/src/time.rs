//! Simulated time. No core crate reads a clock.

use serde::{Deserialize, Serialize};

/// A step index k; frames are taken at t = k·T.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
#[serde(transparent)]
pub struct Step(pub u32);

impl Step {
    /// The step that is `steps` later, at most the greatest step.
    pub fn after(self, steps: u32) -> Self {
        Self(self.0.saturating_add(steps))
    }
}

impl std::fmt::Display for Step {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

/// A simulated instant, in microseconds since the start of the mission.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
#[serde(transparent)]
pub struct SimTime(pub u64);

impl SimTime {
    /// The instant `seconds` after the start, rounded to a microsecond; negative values are the start.
    pub fn from_seconds(seconds: f64) -> Self {
        Self((seconds.max(0.0) * 1e6).round() as u64)
    }

    /// Seconds since the start.
    pub fn seconds(self) -> f64 {
        self.0 as f64 * 1e-6
    }

    /// Seconds from `earlier` to `self`; 0 if `earlier` is later.
    pub fn seconds_since(self, earlier: SimTime) -> f64 {
        self.0.saturating_sub(earlier.0) as f64 * 1e-6
    }

    /// The instant `seconds` later.
    pub fn after(self, seconds: f64) -> Self {
        Self(self.0.saturating_add(Self::from_seconds(seconds).0))
    }
}
