//! A fleet of processes, each a Zenoh peer.
//!
//! | module | what it is |
//! |---|---|
//! | [`world`] | the world's process: town, cars, cameras, monitor, recorder |
//! | [`agent`] | the process of one agent |
//! | [`join`] | how that process gets to know its mission |
//! | [`spawn`] | starts both and leaves none behind |
//! | [`leash`] | how a child notices that its parent is gone |
//! | [`gate`] | which frames it believes to be its world's |
//! | [`queue`] | what others say on the links, until it is heard |
//! | [`desk`] | an agent's Zenoh keys |
//! | [`mirror`] | what an agent shows to people |
//! | [`truth`] | what the world shows to people |
//! | [`arguments`] | their command lines |

pub mod agent;
pub mod arguments;
pub mod desk;
pub mod gate;
pub mod join;
pub mod leash;
pub mod mirror;
pub mod queue;
pub mod spawn;
pub mod truth;
pub mod world;

/// A number that no other process has.
pub fn process_number() -> u64 {
    use std::hash::{BuildHasher, Hasher, RandomState};
    // The standard library's only source of randomness; it names a process and decides nothing. As
    // JSON it must fit the numbers of other languages.
    RandomState::new().build_hasher().finish() >> 11
}
