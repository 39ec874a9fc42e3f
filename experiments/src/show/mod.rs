//! What people get to see of a mission: documents (docs/topics.md), recordings of them, and
//! recordings played again.
//!
//! | module | what it does |
//! |---|---|
//! | [`documents`] | what one agent's step looks like as JSON |
//! | [`truth`] | what the world shows: the town, the cars, the metrics, lives |
//! | [`shape`] | sets and lines as valid GeoJSON |
//! | [`schema`] | what the fields of documents are, for viewers |
//! | [`map`], [`scene`], [`mesh`] | the same for Foxglove and Lichtblick |
//! | [`tape`] | `recording.mcap`, channel by channel |
//! | [`recording`] | writes it while the mission flies |
//! | [`read`] | reads it again, as far as it is whole |
//! | [`replay`] | plays it at its own pace or another |

pub mod documents;
pub mod map;
pub mod mesh;
pub mod read;
pub mod recording;
pub mod replay;
pub mod scene;
pub mod schema;
pub mod shape;
pub mod tape;
pub mod truth;

/// The name of a recording in its run folder.
pub const FILE: &str = "recording.mcap";
