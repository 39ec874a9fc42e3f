//! Code that the tests share.
//!
//! | module | what it holds |
//! |---|---|
//! | [`replay`] | tests over many seeds, and the replay of one seed |
//! | [`geometry`] | distances, samples and a second pinhole camera, without code of the agent |
//! | [`scenes`] | random scenes, poses and cameras that keep every assumption |
//! | [`truth`] | checks of a frame's sets and of an agent's knowledge against a scene |
//! | [`pair`] | agents and links that lose, delay, repeat and reorder packets |
//! | [`flight`] | a small world around a pair |
//! | [`bayes`] | the Bayesian search: its swarm, its calibration, and its equations once more |
//! | [`clearing`] | road clearing: its swarm |
//! | [`swarm`] | missions with every fault, drawn from one seed, and the laws that hold in them |
//! | [`drawn`] | legal scenarios, also extreme ones, drawn from one seed |
//! | [`faulty`] | agents whose clocks are ahead and which miss frames |
//! | [`fuzz`] | the checks of the fuzzers on arbitrary bytes |
//! | [`missions`] | whole missions through the engine |

pub mod bayes;
pub mod clearing;
pub mod drawn;
pub mod faulty;
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
