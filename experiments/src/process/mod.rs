//! The processes of a fleet: the world, the agents, and what starts them all.
//!
//! | module | what it is |
//! |---|---|
//! | [`world`] | the command line of the process of the world |
//! | [`agent`] | the process of one agent |
//! | [`spawn`] | starts the world and the agents, and ends them all |

pub mod agent;
pub mod spawn;
pub mod world;
