//! What people get to see of a mission: documents (docs/topics.md), recordings of them, and
//! recordings played again.
//!
//! | module | what it does |
//! |---|---|
//! | [`truth`] | what the world shows: the town, the cars, the metrics, lives |
//! | [`schema`] | what the fields of documents are, for viewers |
//! | [`map`], [`scene`], [`mesh`], [`drawn`] | the same for Foxglove and Lichtblick |
//! | [`tape`] | `recording.mcap`, channel by channel |
//! | [`recording`] | writes it while the mission flies |
//! | [`read`] | reads it again, as far as it is whole |
//! | [`replay`] | plays it at its own pace or another |

pub mod drawn;
pub mod map;
pub mod mesh;
pub mod read;
pub mod recording;
pub mod replay;
pub mod scene;
pub mod schema;
mod seen;
pub mod tape;
pub mod truth;

/// The name of a recording in its run folder.
pub const FILE: &str = "recording.mcap";
