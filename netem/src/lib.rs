//! What gets through: the fate of every message between agents (docs/links.md).
//!
//! | module | what it holds |
//! |---|---|
//! | [`config`] | the scenario's `[netem]`, and what is impossible in it |
//! | [`link`] | messages in flight, delivered in order |
//! | [`fate`] | a message's identity, and what becomes of it |
//! | [`counters`] | counters of what the links did |
//! | [`rule`] | what a rule is, and the rules of a channel in their order |
//! | [`propagation`] | rule 4; the owner of the buildings implements its [`Obstruction`](propagation::Obstruction) |
//! | [`trace`] | recorded losses |
//!
//! A message meets the rules of its channel in a fixed order. The first rule that loses the message
//! gives the reason; a message that no rule loses arrives, perhaps damaged, perhaps twice, after a
//! delay.
//!
//! | rule | module | loses or changes a message |
//! |---|---|---|
//! | 1 | `outage` | when its sender has an outage as it is sent, or its receiver as it arrives |
//! | 2 | `partition` | between groups that are apart when it is sent |
//! | 3 | `range` | beyond the range |
//! | 4 | [`propagation`] | by packet errors after path loss, shadowing and buildings |
//! | 5 | `jam` | when its receiver is jammed |
//! | 6 | `loss` | at random: i.i.d., Gilbert-Elliott, four states, a recording ([`trace`]) |
//! | 7 | `repeat` | damages one byte |
//! | 8 | `repeat` | makes a copy |
//! | 9 | `rate` | delays it in its sender's queue, or loses it when the queue is full |
//! | 10 | `delay` | delays it |
//!
//! A fate is a *function* of the seed, the message's identity, the time and the positions of its
//! ends. It is never drawn from a shared stream: another message changes no fate, and one process and
//! many processes decide the same. State matters in two places, and it belongs to one link or one
//! sender: chains of losses and delays, which advance by sequence number, and queues.
//!
//! A message in flight survives the failure of its sender and partitions that begin later.
//!
//! ```
//! use csat_netem::config::NetemConfig;
//! use csat_netem::fate::Sent;
//! use csat_netem::link::Links;
//! use csat_proto::ids::{AgentId, ChannelId, Incarnation};
//! use csat_proto::time::SimTime;
//!
//! let mut links = Links::new(&NetemConfig::default(), 1, None);
//! let sent = Sent {
//!     src: AgentId(0),
//!     dst: AgentId(1),
//!     incarnation: Incarnation(0),
//!     channel: ChannelId(0),
//!     sequence: 0,
//!     time: SimTime::from_seconds(1.0),
//!     bytes: 5,
//!     src_p_world: [0.0, 0.0, 50.0],
//!     dst_p_world: [100.0, 0.0, 50.0],
//! };
//! links.send(&sent, b"hello"[..].into());
//! let arrival = links.receive(sent.time).expect("the default radio is perfect");
//! assert_eq!(&arrival.bytes[..], b"hello");
//! ```

mod chain;
pub mod config;
pub mod counters;
mod delay;
mod draw;
pub mod fate;
mod jam;
pub mod link;
mod loss;
mod outage;
mod partition;
pub mod propagation;
mod range;
mod rate;
mod repeat;
pub mod rule;
pub mod trace;

pub use draw::normal_quantile;
