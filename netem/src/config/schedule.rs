//! Scheduled outages, partitions and jammers. Times are seconds since the start; the first instant
//! belongs to a span, its end does not.

use serde::{Deserialize, Serialize};

/// `[[netem.outage]]`: an agent neither sends nor receives.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutageConfig {
    /// Index of the agent.
    pub agent: u16,
    /// From this time, seconds.
    pub from_s: f64,
    /// Until this time, seconds; `inf` for the rest of the run.
    #[serde(default = "forever")]
    pub until_s: f64,
    /// What failed.
    #[serde(default)]
    pub kind: OutageKind,
}

/// What failed in an outage. The links treat both the same, except that a crash loses the queue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum OutageKind {
    /// The radio only: the agent flies on and keeps its knowledge.
    #[default]
    Radio,
    /// The agent's process: it restarts with a higher incarnation and without knowledge.
    Crash,
}

/// `[[netem.partition]]`: agents in different groups cannot hear each other. Agents in no group are
/// not affected.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartitionConfig {
    /// From this time, seconds.
    #[serde(default)]
    pub from_s: f64,
    /// Until this time, seconds; `inf` for the rest of the run.
    #[serde(default = "forever")]
    pub until_s: f64,
    /// Indexes of agents; an agent is in one group at most.
    pub groups: Vec<Vec<u16>>,
    /// When true, only messages from an earlier group to a later one are lost.
    #[serde(default)]
    pub one_way: bool,
}

/// `[[netem.jammer]]`: receivers in a disc (of any height) lose messages.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JammerConfig {
    /// Centre, `world`, metres.
    pub p_m: [f64; 2],
    /// Radius, metres.
    pub radius_m: f64,
    /// From this time, seconds.
    #[serde(default)]
    pub from_s: f64,
    /// Until this time, seconds; `inf` for the rest of the run.
    #[serde(default = "forever")]
    pub until_s: f64,
    /// Probability that a message is lost.
    #[serde(default = "certainly")]
    pub loss: f64,
    /// Name of the channel that it jams; all by default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channel: Option<String>,
}

fn forever() -> f64 {
    f64::INFINITY
}

fn certainly() -> f64 {
    1.0
}
