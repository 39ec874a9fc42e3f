//! The processes of a fleet, each a Zenoh peer; generic over the mission.
//!
//! | to | use |
//! |---|---|
//! | run the process of one agent | [`agent::join`], then [`agent::Welcomed::fly`] |
//! | fly a mission with agents in other processes | [`world::RemoteFleet`], a fleet of the engine |
//! | open a Zenoh session | [`wire::session::open`] |
//! | show documents to people | [`view`] |
//! | parse the arguments of processes | [`arguments`] |
//! | end a process with its parent | [`parent_death`] |
//! | write to standard output and error | [`terminal`] |
//!
//! `csat agent` and `csat world` are some fifty lines each on top of these: see `commands::fleet` and
//! `process::world` of the crate `csat-experiments`.

#![warn(clippy::print_stdout, clippy::print_stderr)] // They panic: see `terminal`.

pub mod agent;
pub mod arguments;
pub mod parent_death;
pub mod terminal;
pub mod view;
pub mod wire;
pub mod world;

/// What the fuzz targets reach; not meant for anything else.
#[doc(hidden)]
pub mod fuzzing {
    pub use crate::agent::input::RawMessage;
    pub use crate::agent::queue::MessageQueue;
    pub use crate::world::report::StepReport;
}

/// A random number that names a process: no other process has it.
pub fn process_number() -> u64 {
    use std::hash::{BuildHasher, Hasher, RandomState};
    // The standard library's only source of randomness. It decides nothing. It has 53 bits, so that
    // languages whose numbers are doubles can read it from JSON.
    RandomState::new().build_hasher().finish() >> 11
}
