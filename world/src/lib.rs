//! What is true: the town, the cars, the UAVs, what their cameras report, and the monitor that
//! checks the guarantee from outside.
//!
//! | module | what it holds |
//! |---|---|
//! | [`world`] | everything that is true, one period at a time |
//! | [`map`] | the town: generated from a seed, or from a GeoJSON file |
//! | [`obstacle`] | buildings, and exact distances to them |
//! | [`road`] | where cars can drive |
//! | [`target`] | the cars |
//! | [`track`] | cars that follow tracks instead of driving on their own |
//! | [`uav`] | how UAVs move: what else flies implements its trait |
//! | [`scene`] | what a camera can see of all that |
//! | [`camera`] | a frame with exact labels, and the oracle that checks it |
//! | [`radio`] | what buildings do to radio |
//! | [`truth`] | the monitor |
//!
//! Lengths are metres in the frame `world` of [`csat_proto`] (East-North-Up, origin in the middle of
//! the region), angles radians counter-clockwise from east, times seconds.

pub mod camera;
pub mod map;
pub mod obstacle;
mod plane;
pub mod radio;
mod random;
pub mod road;
pub mod scene;
pub mod target;
pub mod track;
pub mod truth;
pub mod uav;
pub mod world;
