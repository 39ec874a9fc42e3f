//! What the tests share.
//!
//! | module | what it holds |
//! |---|---|
//! | [`replay`] | tests over many seeds, and how to fly a failing one again |
//! | [`geometry`] | distances, samples and a second pinhole camera, sharing nothing with the agent |
//! | [`scenes`] | random scenes, poses and cameras that keep every assumption |
//! | [`truth`] | what a frame's sets and an agent's knowledge must say about a scene |
//! | [`pair`] | agents and a post office that loses, delays, repeats and reorders |
//! | [`flight`] | a small world around a pair |
//! | [`swarm`] | missions with every fault, drawn from one seed, and what must hold in them |
//! | [`drawn`] | legal scenarios of every kind, extreme ones too, drawn from one seed |
//! | [`fuzz`] | what fuzzers do with arbitrary bytes |
//! | [`missions`] | whole missions through the engine |

pub mod drawn;
pub mod flight;
pub mod fuzz;
pub mod geometry;
pub mod hears;
pub mod missions;
pub mod pair;
pub mod replay;
pub mod scenes;
pub mod swarm;
pub mod truth;
