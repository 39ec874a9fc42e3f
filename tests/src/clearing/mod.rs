//! Road clearing.
//!
//! | module | what it holds |
//! |---|---|
//! | [`draw`] | from a seed to a network, noise, links and crashes |
//! | [`swarm`] | missions drawn from one seed, and the laws that hold in them |

pub mod draw;
pub mod swarm;
