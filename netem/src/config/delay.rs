//! How long messages take.

use serde::{Deserialize, Serialize};

/// `delay` of a channel.
///
/// `correlation` ρ is that of normal scores: z_n = ρ z_{n-1} + √(1-ρ²) ε_n over the messages of a
/// link, u = Φ(z), and the delay is the u-quantile. So the delays have exactly the named distribution
/// for every ρ, and ρ is the lag-1 correlation of z (the correlation of the delays is a little less).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "model", rename_all = "kebab-case", deny_unknown_fields)]
pub enum DelayConfig {
    /// The same delay for every message.
    Constant {
        /// The delay, seconds.
        mean_s: f64,
    },
    /// The uniform distribution on [mean - spread, mean + spread]: F(x) = (x - mean + spread) / (2
    /// spread).
    Uniform {
        /// The middle, seconds.
        mean_s: f64,
        /// Half the width, seconds; at most the mean.
        spread_s: f64,
        /// ρ in [0, 1).
        #[serde(default)]
        correlation: f64,
    },
    /// The normal distribution under the condition that the delay is not negative:
    /// F(x) = [Φ((x - mean)/sd) - Φ(-mean/sd)] / [1 - Φ(-mean/sd)] for x >= 0. Its own mean is above
    /// `mean_s` by sd φ(mean/sd)/Φ(mean/sd), which matters when the mean is below three sd.
    Normal {
        /// Mean before the condition, seconds.
        mean_s: f64,
        /// Standard deviation before the condition, seconds.
        sd_s: f64,
        /// ρ in [0, 1).
        #[serde(default)]
        correlation: f64,
    },
    /// Pareto, type I: F(x) = 1 - (m/x)^shape from m = mean (shape - 1)/shape on.
    Pareto {
        /// The mean, seconds.
        mean_s: f64,
        /// The shape, above 1; the variance is finite above 2.
        #[serde(default = "three")]
        shape: f64,
        /// ρ in [0, 1).
        #[serde(default)]
        correlation: f64,
    },
    /// A measured distribution: the quantiles at 0, 1/(n-1), ..., 1, interpolated linearly.
    Table {
        /// The quantiles, seconds, none below the one before.
        quantiles_s: Vec<f64>,
        /// ρ in [0, 1).
        #[serde(default)]
        correlation: f64,
    },
}

fn three() -> f64 {
    3.0
}
