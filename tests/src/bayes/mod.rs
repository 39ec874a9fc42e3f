//! The Bayesian search.
//!
//! | module | what it holds |
//! |---|---|
//! | [`missions`] | scenarios of the Bayesian search for tests |
//! | [`quiet`] | the mission without judge and measures, for many missions |
//! | [`swarm`] | missions with every fault, drawn from one seed, and the laws that hold in them |
//! | [`calibration`] | how often the target is where it is believed to be |

pub mod calibration;
pub mod missions;
pub mod quiet;
pub mod swarm;
