//! What one UAV knows and does: the sans-I/O agent of the set-membership mission.
//!
//! | module | station |
//! |---|---|
//! | [`agent`] | the state machine: frames and messages in, messages and commands out |
//! | [`identity`] | what messages and knowledge are recognised by |
//! | [`shared_cache`] | results that the agents of one process share |
//! | [`settled`] | knowledge between two updates, and what is derived from it |
//! | [`config`] | everything it is told before the start |
//! | [`region`] | outer and inner sets: the types that carry the guarantee |
//! | [`sense`] | one frame to measured sets |
//! | [`estimate`] | predict, correct, fuse |
//! | [`exchange`] | what is said, and what of the others is believed |
//! | [`guidance`] | where to fly next |
//! | [`mutant`] | known mistakes, for tests of the tests |
//! | [`work`] | counts of work, for tests of cost |

pub mod agent;
pub mod config;
pub mod estimate;
pub mod exchange;
pub mod guidance;
pub mod identity;
pub mod mutant;
pub mod region;
pub mod sense;
pub mod settled;
pub mod shared_cache;
pub mod work;
