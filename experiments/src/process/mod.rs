//! A fleet of processes: the world's, and what starts them all.
//!
//! | module | what it is |
//! |---|---|
//! | [`world`] | the world's process: town, cars, cameras, monitor, recorder |
//! | [`agent`] | the process of one agent |
//! | [`truth`] | what the world shows to people |
//! | [`spawn`] | starts the world and the agents, and leaves none behind |

pub mod agent;
pub mod spawn;
pub mod truth;
pub mod world;
