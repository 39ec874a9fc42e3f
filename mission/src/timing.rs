//! The only clock of the project: how long the computer takes, never what happens.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

/// Measures the time since its start.
#[derive(Debug, Clone, Copy)]
pub struct Stopwatch(Instant);

impl Stopwatch {
    /// Starts now.
    #[expect(
        clippy::disallowed_methods,
        reason = "measures the computer, decides nothing: results are the same at any speed"
    )]
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// Milliseconds since the start.
    pub fn elapsed_ms(&self) -> f64 {
        self.0.elapsed().as_secs_f64() * 1e3
    }

    /// Seconds since the start.
    pub fn elapsed_s(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }

    /// The time left until `limit` after the start; zero when that is over.
    pub fn left(&self, limit: Duration) -> Duration {
        limit.saturating_sub(self.0.elapsed())
    }
}

/// What the stages of one agent-step took, milliseconds. `None`: the stage did not run.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct StageTimes {
    /// Rendering the frame: the world's cost.
    pub render: Option<f64>,
    /// From frame to measured sets.
    pub sense: Option<f64>,
    /// Prediction and correction.
    pub estimate: Option<f64>,
    /// Fusing what all others sent.
    pub fuse: Option<f64>,
    /// Planning; only when the agent decided in this step.
    pub guidance: Option<f64>,
}
