//! Statistics of the links against theory, on at least 10⁶ messages per set of parameters.
//!
//! Every bound is four standard errors of the estimator, which account for the correlation of the
//! losses: standard errors of independent losses raise false alarms. `--nocapture` prints the
//! numbers.

mod delays;
mod estimate;
mod losses;
mod moving;
mod other;
mod theory;

use csat_netem::config::{ChannelConfig, NetemConfig};
use csat_netem::fate::Sent;
use csat_netem::link::Links;
use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use csat_proto::time::SimTime;

/// Links with one radio.
fn links(radio: ChannelConfig, seed: u64) -> Links {
    Links::new(&NetemConfig { radio, ..Default::default() }, seed, None)
}

/// A message of 100 bytes over 50 m, sent at 1 ms per number.
fn sent(sequence: u64) -> Sent {
    Sent {
        src: AgentId(0),
        dst: AgentId(1),
        incarnation: Incarnation(0),
        channel: ChannelId(0),
        sequence,
        time: SimTime(sequence * 1000),
        bytes: 100,
        src_p_world: [0.0, 0.0, 50.0],
        dst_p_world: [30.0, 40.0, 50.0],
    }
}
