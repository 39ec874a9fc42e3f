//! What one UAV knows and does: the sans-I/O agent of the set-membership mission.

pub mod agent;
pub mod config;
pub mod estimate;
pub mod exchange;
pub mod guidance;
pub mod region;
pub mod sense;
