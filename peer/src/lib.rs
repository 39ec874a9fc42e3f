//! The processes of a fleet, each a Zenoh peer; generic over the mission.
//!
//! | module | what it holds |
//! |---|---|
//! | [`agent`] | the process of one agent |
//! | [`world`] | the world's side: agents in processes of their own, as a fleet of the engine |
//! | [`wire`] | opening Zenoh sessions, reading and refusing samples |
//! | [`arguments`] | the command lines of processes |
//! | [`parent_death`] | how a process notices that its parent is gone |
//! | [`terminal`] | writing to readers that may be gone |

#![warn(clippy::print_stdout, clippy::print_stderr)] // They panic: see `terminal`.

pub mod agent;
pub mod arguments;
pub mod parent_death;
pub mod terminal;
pub mod wire;
pub mod world;

/// A number that no other process has.
pub fn process_number() -> u64 {
    use std::hash::{BuildHasher, Hasher, RandomState};
    // The standard library's only source of randomness; it names a process and decides nothing. As
    // JSON it must fit the numbers of other languages.
    RandomState::new().build_hasher().finish() >> 11
}
