//! The world's side of `proto::control`: a fleet of the engine with each agent in a process of its own.
//!
//! | module | what it does |
//! |---|---|
//! | `fleet` | [`RemoteFleet`], the fleet of the engine |
//! | `port` | the world's Zenoh keys |
//! | `input` | takes what processes send, or refuses it |
//! | `expected` | what the world waits for: it refuses everything else |
//! | `lockstep`, `realtime` | one step of each pacing |
//! | `frames` | renders frames and sends them |
//! | `wait` | waits for all processes, at the start and in lockstep |
//! | `presence` | whether any process is left |
//! | `roster` | which processes there are, and which take part |
//! | `member` | what the world knows of one process |
//! | `report` | the report of a process at the end of a step |
//! | `silence` | when the world received nothing from a process |
//! | `past` | the counters of processes that are gone |
//!
//! In lockstep a step is a frame for each agent, then turns until nothing is left to do before the next
//! step, then a report of each agent; after each of these the world waits for all processes. In real time
//! the world sends frames and asks for reports by the clock, and does not wait.

mod error;
mod expected;
mod fleet;
mod frames;
mod input;
mod lockstep;
mod member;
mod past;
mod port;
mod presence;
mod realtime;
pub(crate) mod report;
mod roster;
mod silence;
mod wait;

pub use error::{Awaited, FleetError};
pub use fleet::RemoteFleet;
