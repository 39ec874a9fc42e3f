//! What one UAV of the road clearing knows and does: a sans-I/O agent after Gagliardi, Oriolo, Bülthoff and Franchi,
//! *Image-based road network clearing without localization and without maps using a team of UAVs*, ECC 2014
//! (equations (n)).
//!
//! | module | what it holds |
//! |---|---|
//! | [`agent`] | the state machine: frames and messages in, messages and commands out |
//! | [`config`] | the configuration of an agent |
//! | [`radii`] | how far masks are dilated and shrunk, from the bounds of all errors |
//! | [`bitmap`] | sets of pixels |
//! | [`registration`] | where the image is on the lattice of the masks |
//! | [`masks`] | what a cleaner knows of the road in its image, and why that is enough |
//! | [`frontier`] | the frontier and its runs |
//! | [`motion`] | where a cleaner moves |
//! | [`giving`] | which runs it gives away |
//! | [`formation`] | who follows whom, and where |
//! | [`fleet`] | what is known of the other agents |
//! | [`exchange`] | messages, and which are believed |
//! | [`mutant`] | known mistakes, to test the tests |

pub mod agent;
pub mod bitmap;
pub mod config;
pub mod exchange;
pub mod fleet;
pub mod formation;
pub mod frontier;
pub mod giving;
pub mod masks;
pub mod motion;
pub mod mutant;
pub mod radii;
pub mod registration;
