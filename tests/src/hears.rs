//! Reception of messages of which only the bytes matter.

use csat_proto::agent::Agent;
use csat_proto::ids::ChannelId;
use csat_proto::radio::Reception;
use csat_proto::time::SimTime;

/// Hands bytes to an agent as a message.
pub trait Hears: Agent {
    /// A message arrives at `now` on the first radio, from straight ahead.
    fn hear(&mut self, now: SimTime, bytes: &[u8]) {
        let (channel, bytes) = (ChannelId(0), bytes.into());
        self.handle_message(
            now,
            &Reception { channel, at: now, bearing_rad: 0.0, offset_m: None, bytes },
        );
    }
}

impl<A: Agent> Hears for A {}
