//! The processes of a fleet: the world, the agents, and what starts them all.
//!
//! | module | what it is |
//! |---|---|
//! | [`world`] | the process of the world: town, cars, cameras, monitor, recorder |
//! | [`truth`] | what the world shows to people |
//! | [`spawn`] | starts the world and the agents, and ends them all |

pub mod spawn;
pub mod truth;
pub mod world;
