//! What is said: the types that the world, the agents and the links exchange.
//!
//! | module | what it holds |
//! |---|---|
//! | [`ids`] | who is who |
//! | [`time`] | simulated time and steps |
//! | [`model`] | what every party agrees on before the start: region, targets, fleet, period |
//! | [`camera`] | the pinhole camera: rays, projection, image-to-ground homography |
//! | [`command`] | what agents tell their vehicles |
//! | [`frame`] | what a camera and its computer-vision system report |
//! | [`frame_wire`] | its pixels on their way to an agent's process |
//! | [`control`] | what a world and the processes of its agents say to each other |
//! | [`keys`] | where in Zenoh's space of names what is said |
//! | [`region`] | planar sets on an integer grid |
//! | [`raster`] | coarse planar sets as bit rows, for what needs no guarantee |
//! | [`oem`] | cells of the occupancy-elevation map |
//! | [`message`] | what agents of the set-membership mission say |
//! | [`envelope`] | how any message travels: header, checksum, body |
//! | [`radio`] | what is physical about a message, and what a receiver gets |
//! | [`agent`] | the interface of a sans-I/O agent |
//!
//! Frame `world`: metres, East-North-Up, origin at the centre of the region of interest.

pub mod agent;
pub mod camera;
pub mod command;
pub mod control;
pub mod envelope;
pub mod frame;
pub mod frame_wire;
pub mod ids;
pub mod keys;
pub mod message;
pub mod model;
pub mod oem;
pub mod radio;
pub mod raster;
pub mod region;
pub mod time;
