//! What is said: the types that the world, the agents and the links exchange.
//!
//! | module | what it holds |
//! |---|---|
//! | [`ids`] | identifiers of agents, targets, incarnations, runs and radios |
//! | [`time`] | simulated time and steps |
//! | [`model`] | what all are told before the start: region, targets, fleet |
//! | [`camera`] | the pinhole camera: rays, projection, image-to-ground homography |
//! | [`detector`] | a detector with misses and false alarms |
//! | [`frame`] | what a camera and its computer-vision system report |
//! | [`fixed_wing`] | how a fixed-wing aircraft flies |
//! | [`region`] | planar sets on an integer grid |
//! | [`raster`] | planar sets as rows of bits, for what needs no guarantee |
//! | [`oem`] | cells of the occupancy-elevation map |
//! | [`grid_pose`] | poses as messages have them |
//! | [`message`] | the messages of the set-membership mission |
//! | [`envelope`] | the wire format of messages: header, checksum, body |
//! | [`radio`] | the physical properties of a message, and what a receiver gets |
//! | [`agent`] | the interface of a sans-I/O agent |
//! | [`command`] | commands of agents to their vehicles |
//! | [`control`] | the protocol between a world and the processes of its agents |
//! | [`frame_wire`] | the wire format of a frame's pixels in that protocol |
//! | [`keys`] | the Zenoh key expressions of a run |
//!
//! Frame `world`: metres, East-North-Up, origin at the centre of the region of interest.
//!
//! ```
//! use csat_proto::camera::Pose;
//! use csat_proto::envelope::Envelope;
//! use csat_proto::ids::{AgentId, ChannelId, Incarnation, RunId};
//! use csat_proto::time::{SimTime, Step};
//!
//! let envelope = Envelope {
//!     run: RunId(7),
//!     src: AgentId(2),
//!     incarnation: Incarnation(0),
//!     channel: ChannelId(0),
//!     sequence: 41,
//!     step: Step(20),
//!     time: SimTime::from_seconds(10.0),
//!     pose: Pose::level([12.0, -3.5, 52.0], 0.0).into(),
//!     body: b"the encoded message".to_vec(),
//! };
//! let mut bytes = envelope.encode();
//! assert_eq!(Envelope::decode(&bytes), Ok(envelope));
//! bytes[20] ^= 1;
//! assert!(Envelope::decode(&bytes).is_err(), "the checksum detects the damage");
//! ```

pub mod agent;
pub mod camera;
pub mod command;
pub mod control;
pub mod detector;
pub mod envelope;
pub mod fixed_wing;
pub mod frame;
pub mod frame_wire;
pub mod grid_pose;
pub mod ids;
pub mod keys;
pub mod message;
pub mod model;
pub mod oem;
pub mod radio;
pub mod raster;
pub mod region;
pub mod time;
