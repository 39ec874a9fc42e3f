//! What one channel does to its messages.

use serde::{Deserialize, Serialize};

use super::{DelayConfig, LossConfig};

/// `[netem.NAME]`; the default is a perfect link.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ChannelConfig {
    /// Messages over more than this distance are lost, metres; `inf` for no limit.
    pub range_m: f64,
    /// Messages above this size travel as fragments of this size, and one lost fragment loses the
    /// message; bytes, 0 for no limit.
    pub mtu_bytes: u32,
    /// Probability that a message arrives damaged.
    pub corruption: f64,
    /// Probability that a message arrives twice.
    pub duplication: f64,
    /// Whether distance / c adds to the delay.
    pub light_delay: bool,
    /// Random loss.
    pub loss: LossConfig,
    /// Delay.
    pub delay: DelayConfig,
    /// How fast a sender may send.
    pub rate: RateConfig,
    /// The most by which a receiver errs about the bearing of a sender, degrees.
    pub bearing_error_deg: f64,
    /// The most by which a receiver errs about the offset of a sender along each axis, metres; without it the
    /// channel measures no offsets.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset_error_m: Option<f64>,
    /// Radio propagation; none by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub propagation: Option<PropagationConfig>,
}

impl Default for ChannelConfig {
    fn default() -> Self {
        Self {
            range_m: f64::INFINITY,
            mtu_bytes: 0,
            corruption: 0.0,
            duplication: 0.0,
            light_delay: false,
            loss: LossConfig::Iid { p: 0.0 },
            delay: DelayConfig::Constant { mean_s: 0.0 },
            rate: RateConfig::default(),
            bearing_error_deg: 0.0,
            offset_error_m: None,
            propagation: None,
        }
    }
}

/// A token bucket per sender and channel. Messages for which there are no tokens wait in a queue;
/// messages that do not fit the queue are lost.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RateConfig {
    /// Tokens per second, bytes/s; `inf` for no limit.
    pub bytes_s: f64,
    /// Size of the bucket, which is what can leave at once after a pause, bytes.
    pub burst_bytes: u64,
    /// Size of the queue, bytes.
    pub queue_bytes: u64,
}

impl Default for RateConfig {
    fn default() -> Self {
        Self { bytes_s: f64::INFINITY, burst_bytes: 0, queue_bytes: 65_536 }
    }
}

/// Log-distance path loss with log-normal shadowing (`netem::propagation`). The defaults are those
/// of a small 2.4 GHz radio in a town.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PropagationConfig {
    /// Power sent, dBm.
    pub tx_power_dbm: f64,
    /// Power of the noise in the receiver's band, dBm.
    pub noise_dbm: f64,
    /// Path-loss exponent n, without a unit: 2 in free space.
    pub exponent: f64,
    /// Path loss at 1 m, dB.
    pub loss_at_1m_db: f64,
    /// Standard deviation of the shadowing, dB.
    pub shadowing_sigma_db: f64,
    /// Side of the cells in which a link's shadowing is the same, metres.
    pub shadowing_cell_m: f64,
    /// Further loss when a building stands between the ends, dB.
    pub obstruction_db: f64,
}

impl Default for PropagationConfig {
    fn default() -> Self {
        Self {
            tx_power_dbm: 20.0,
            noise_dbm: -95.0,
            exponent: 2.7,
            loss_at_1m_db: 40.0,
            shadowing_sigma_db: 4.0,
            shadowing_cell_m: 10.0,
            obstruction_db: 20.0,
        }
    }
}
