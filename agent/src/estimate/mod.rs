//! What one UAV knows (`spec/sets.md`): predict, correct with the own frame, fuse what others sent.
//!
//! | module | equations |
//! |---|---|
//! | [`state`] | the sets an agent holds |
//! | [`predict`] | (4.24)-(4.27) |
//! | [`correct`] | (4.28)-(4.33), (5.43) |
//! | [`fuse`] | (4.34)-(4.37), (5.44), for facts and snapshots of any age |
//! | [`oem`] | the occupancy-elevation map |

pub mod correct;
pub mod fuse;
pub mod oem;
pub mod predict;
pub mod state;
