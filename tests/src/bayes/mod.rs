//! The Bayesian search.
//!
//! | module | what it holds |
//! |---|---|
//! | [`missions`] | scenarios of the Bayesian search for tests |
//! | [`quiet`] | the mission without judge and measures, for many missions |
//! | [`swarm`] | missions with every fault, drawn from one seed, and the laws that hold in them |
//! | [`calibration`] | how often the target is where it is believed to be |
//! | [`script`] | two aircraft that fly a script |
//! | [`equations`] | the equations of the paper once more, and what a script has to make agents believe |
//! | [`liar`] | an aircraft that says two different things of one frame |

pub mod calibration;
pub mod equations;
pub mod liar;
pub mod missions;
pub mod quiet;
pub mod script;
pub mod swarm;
