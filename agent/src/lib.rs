//! What one UAV or ground station knows and does: the sans-I/O agent of the set-membership mission.
//!
//! A driver needs [`agent`] and [`config`]; one that runs several agents in a process also
//! [`shared_cache`]. The other modules are the stations of the agent's data, for tests, benchmarks
//! and pictures.
//!
//! | module | what it holds |
//! |---|---|
//! | [`agent`] | the state machine: frames and messages in, messages and commands out |
//! | [`config`] | the configuration of an agent |
//! | [`shared_cache`] | results that the agents of one process share |
//! | [`region`] | outer and inner approximations: the types that carry the guarantee |
//! | [`sense`] | from one frame to measured sets |
//! | [`estimate`] | the knowledge: predict, correct, fuse |
//! | [`settled`] | knowledge between two updates, and what is derived from it |
//! | [`exchange`] | messages to the other agents, and which of their messages are believed |
//! | [`guidance`] | where to fly next |
//! | [`identity`] | hashes that identify messages and knowledge |
//! | [`memo`] | results of functions, by what went in |
//! | [`mutant`] | known mistakes, to test the tests |
//! | [`work`] | counts of work, to test its amount |
//!
//! Two agents and their driver; a UAV with a camera gets `handle_frame` in place of `handle_step`:
//!
//! ```
//! use csat_agent::agent::SetMembershipAgent;
//! use csat_agent::config::{AgentConfig, Channels, EstimatorConfig, ExchangeConfig, GuidanceConfig};
//! use csat_proto::agent::Agent;
//! use csat_proto::camera::{CameraModel, Pose, PoseError};
//! use csat_proto::ids::{AgentId, Incarnation, RunId};
//! use csat_proto::model::{FleetModel, Ground, TargetsModel};
//! use csat_proto::radio::Reception;
//! use csat_proto::time::{SimTime, Step};
//!
//! let config = |index| AgentConfig {
//!     run: RunId(1),
//!     id: AgentId(index),
//!     incarnation: Incarnation(0),
//!     period_s: 0.5,
//!     ground: Ground { size_m: [200.0, 200.0] },
//!     targets: TargetsModel::default(),
//!     fleet: FleetModel { count: 2, ..FleetModel::default() },
//!     stations: 0,
//!     camera: CameraModel::default(),
//!     pose_error: PoseError::NONE,
//!     estimator: EstimatorConfig::default(),
//!     guidance: GuidanceConfig::default(),
//!     exchange: ExchangeConfig::default(),
//!     channels: Channels::default(),
//!     radio_range_m: f64::INFINITY,
//! };
//! let mut agents = [0, 1].map(|index| SetMembershipAgent::new(&config(index)));
//! let now = SimTime(0);
//! for agent in &mut agents {
//!     agent.handle_step(now, Step(0), Pose::level([0.0, 0.0, 52.0], 0.0));
//! }
//! let [first, second] = &mut agents;
//! while let Some(sent) = first.poll_transmit() {
//!     let bytes = sent.bytes.into();
//!     let message = Reception { channel: sent.channel, at: now, bearing_rad: 0.0, offset_m: None, bytes };
//!     second.handle_message(now, &message);
//! }
//! assert!(second.poll_timeout().is_some_and(|at| at <= now));
//! second.handle_timeout(now);
//! assert_eq!(second.rejected().len(), 0);
//! ```

pub mod agent;
pub mod config;
pub mod estimate;
pub mod exchange;
pub mod guidance;
pub mod identity;
pub mod memo;
pub mod mutant;
pub mod region;
pub mod sense;
pub mod settled;
pub mod shared_cache;
pub mod work;
