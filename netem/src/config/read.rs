//! Reading and writing `[netem]`, whose keys are channels except for a few.
//!
//! Written by hand, because `serde(flatten)` loses the positions of values in a file.

use std::fmt;

use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::ser::{SerializeMap, Serializer};
use serde::{Deserialize, Serialize};

use super::{ChannelConfig, NetemConfig, RADIO};

/// Keys that are not further channels.
const KEYS: [&str; 5] = [RADIO, "outage", "partition", "jammer", "trace"];

/// Whether this is a valid name of a channel.
pub(super) fn is_channel_name(name: &str) -> bool {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-' || c == '_';
    !name.is_empty() && name.chars().all(allowed) && !KEYS.contains(&name)
}

impl<'de> Deserialize<'de> for NetemConfig {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(Whole)
    }
}

impl Serialize for NetemConfig {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { radio, channels, outage, partition, jammer, trace } = self;
        let mut map = serializer.serialize_map(Some(KEYS.len() + channels.len()))?;
        map.serialize_entry("trace", trace)?;
        map.serialize_entry("outage", outage)?;
        map.serialize_entry("partition", partition)?;
        map.serialize_entry("jammer", jammer)?;
        map.serialize_entry(RADIO, radio)?;
        for (name, channel) in channels {
            map.serialize_entry(name, channel)?;
        }
        map.end()
    }
}

struct Whole;

impl<'de> Visitor<'de> for Whole {
    type Value = NetemConfig;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<NetemConfig, A::Error> {
        let mut config = NetemConfig::default();
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                RADIO => config.radio = map.next_value()?,
                "outage" => config.outage = map.next_value()?,
                "partition" => config.partition = map.next_value()?,
                "jammer" => config.jammer = map.next_value()?,
                "trace" => config.trace = map.next_value()?,
                name if is_channel_name(name) => {
                    let channel = map.next_value_seed(ChannelEntry(name))?;
                    config.channels.insert(key, channel);
                }
                _ => return Err(Error::unknown_field(&key, &KEYS)),
            }
        }
        Ok(config)
    }
}

/// A further channel; a value that is no table is a misspelt key.
struct ChannelEntry<'a>(&'a str);

impl<'de> DeserializeSeed<'de> for ChannelEntry<'_> {
    type Value = ChannelConfig;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<ChannelConfig, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl ChannelEntry<'_> {
    fn unknown<T, E: Error>(self) -> Result<T, E> {
        Err(E::unknown_field(self.0, &KEYS))
    }
}

impl<'de> Visitor<'de> for ChannelEntry<'_> {
    type Value = ChannelConfig;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<ChannelConfig, A::Error> {
        ChannelConfig::deserialize(MapAccessDeserializer::new(map))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<ChannelConfig, A::Error> {
        while seq.next_element::<IgnoredAny>()?.is_some() {}
        self.unknown()
    }

    fn visit_bool<E: Error>(self, _: bool) -> Result<ChannelConfig, E> {
        self.unknown()
    }

    fn visit_i64<E: Error>(self, _: i64) -> Result<ChannelConfig, E> {
        self.unknown()
    }

    fn visit_u64<E: Error>(self, _: u64) -> Result<ChannelConfig, E> {
        self.unknown()
    }

    fn visit_f64<E: Error>(self, _: f64) -> Result<ChannelConfig, E> {
        self.unknown()
    }

    fn visit_str<E: Error>(self, _: &str) -> Result<ChannelConfig, E> {
        self.unknown()
    }
}
