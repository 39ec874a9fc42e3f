//! `[netem]`: what the links do.

use serde::{Deserialize, Serialize};

/// One table per channel.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NetemConfig {
    /// The radio that every agent has.
    pub radio: ChannelConfig,
}

/// What one channel does to its messages.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ChannelConfig {
    /// Messages farther than this are lost, metres; `inf` for no limit.
    pub range_m: f64,
    /// Random loss.
    pub loss: LossConfig,
    /// Delay.
    pub delay: DelayConfig,
}

impl Default for ChannelConfig {
    fn default() -> Self {
        Self {
            range_m: f64::INFINITY,
            loss: LossConfig::Iid { p: 0.0 },
            delay: DelayConfig::Constant { mean_s: 0.0 },
        }
    }
}

/// Which messages are lost at random.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "model", rename_all = "kebab-case", deny_unknown_fields)]
pub enum LossConfig {
    /// Each with the same probability, independently.
    Iid {
        /// That probability.
        p: f64,
    },
}

/// How long messages take.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "model", rename_all = "kebab-case", deny_unknown_fields)]
pub enum DelayConfig {
    /// Always the same time.
    Constant {
        /// That time, seconds.
        mean_s: f64,
    },
}

impl NetemConfig {
    /// Every impossible value, as (key under `netem`, what is wrong).
    pub fn mistakes(&self) -> Vec<(String, String)> {
        let mut mistakes = Vec::new();
        let mut demand = |holds: bool, key: &str, expected: String| {
            if !holds {
                mistakes.push((key.to_string(), expected));
            }
        };
        let ChannelConfig { range_m, loss, delay } = &self.radio;
        demand(
            *range_m >= 0.0,
            "radio.range_m",
            format!("expected a distance of at least 0 m (or inf), got {range_m}"),
        );
        let LossConfig::Iid { p } = loss;
        demand(
            (0.0..=1.0).contains(p),
            "radio.loss",
            format!("expected a probability p between 0 and 1, got {p}"),
        );
        let DelayConfig::Constant { mean_s } = delay;
        demand(
            mean_s.is_finite() && *mean_s >= 0.0,
            "radio.delay",
            format!("expected a finite mean_s of at least 0 s, got {mean_s}"),
        );
        mistakes
    }
}
