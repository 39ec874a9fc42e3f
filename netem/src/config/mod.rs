//! `[netem]`: the configuration of the links.
//!
//! ```toml
//! [netem.radio]                      # channel 0, always there
//! range_m = 150
//! loss = { model = "gilbert-elliott", p = 0.05, r = 0.25 }
//! delay = { model = "pareto", mean_s = 0.2, shape = 3 }
//!
//! [netem.long-range]                 # any further name: channels 1, 2, ... sorted by name
//! rate = { bytes_s = 1200, burst_bytes = 600, queue_bytes = 4000 }
//!
//! [[netem.outage]]
//! agent = 2
//! from_s = 60
//! until_s = 90
//! kind = "crash"
//! ```

mod channel;
mod delay;
mod judge;
mod judge_channel;
mod loss;
mod read;
mod schedule;

use std::collections::BTreeMap;

use csat_proto::ids::ChannelId;
use serde::{Deserialize, Serialize};

pub use channel::{ChannelConfig, PropagationConfig, RateConfig};
pub use delay::DelayConfig;
pub use loss::LossConfig;
pub use schedule::{JammerConfig, OutageConfig, OutageKind, PartitionConfig};

/// The configuration of all links. The default is a perfect radio.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NetemConfig {
    /// `[netem.radio]`: the radio that every agent has, channel 0.
    pub radio: ChannelConfig,
    /// Every other `[netem.NAME]`: channels 1, 2, ... in the order of their names.
    pub channels: BTreeMap<String, ChannelConfig>,
    /// `[[netem.outage]]`: when agents cannot send or receive.
    pub outage: Vec<OutageConfig>,
    /// `[[netem.partition]]`: when groups of agents cannot hear each other.
    pub partition: Vec<PartitionConfig>,
    /// `[[netem.jammer]]`: where and when receivers hear nothing.
    pub jammer: Vec<JammerConfig>,
    /// Which messages go into the run's events.
    pub trace: TraceLevel,
}

/// Which messages a run records one by one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TraceLevel {
    /// None; counts only.
    None,
    /// The lost ones.
    #[default]
    Losses,
    /// All.
    All,
}

/// The name of channel 0.
pub const RADIO: &str = "radio";

impl NetemConfig {
    /// The channel of this name.
    pub fn channel_id(&self, name: &str) -> Option<ChannelId> {
        let index = self.channel_names().position(|n| n == name)?;
        u8::try_from(index).ok().map(ChannelId)
    }

    /// The configuration of a channel.
    pub fn channel(&self, id: ChannelId) -> Option<&ChannelConfig> {
        self.all_channels().nth(usize::from(id.0)).map(|(_, channel)| channel)
    }

    /// The names of all channels, by id.
    pub fn channel_names(&self) -> impl Iterator<Item = &str> {
        self.all_channels().map(|(name, _)| name)
    }

    /// Names and channels, by id.
    pub fn all_channels(&self) -> impl Iterator<Item = (&str, &ChannelConfig)> {
        let others = self.channels.iter().map(|(name, channel)| (name.as_str(), channel));
        std::iter::once((RADIO, &self.radio)).chain(others)
    }

    /// Names and channels, by id; the channels can be changed.
    pub fn all_channels_mut(&mut self) -> impl Iterator<Item = (&str, &mut ChannelConfig)> {
        let others = self.channels.iter_mut().map(|(name, channel)| (name.as_str(), channel));
        std::iter::once((RADIO, &mut self.radio)).chain(others)
    }

    /// Whether any channel needs to know what stands between antennas.
    pub fn has_propagation(&self) -> bool {
        self.all_channels().any(|(_, channel)| channel.propagation.is_some())
    }

    /// The outages in which the agent's process ends and restarts with a higher incarnation.
    pub fn crashes(&self) -> impl Iterator<Item = &OutageConfig> {
        self.outage.iter().filter(|outage| outage.kind == OutageKind::Crash)
    }
}

#[cfg(test)]
mod tests;
