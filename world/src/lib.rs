//! What is true: the town, the cars, the UAVs, what their cameras report, and the monitor that
//! checks the guarantee from outside.

pub mod camera;
pub mod map;
pub mod obstacle;
mod plane;
pub mod radio;
mod random;
pub mod road;
pub mod scene;
pub mod target;
pub mod truth;
pub mod uav;
pub mod world;
