//! The interface of a sans-I/O agent: a state machine that is told what arrives and asked what to do.
//!
//! An agent has no clock, socket, file, thread or random source of its own: simulated time is an
//! argument and its seed part of its configuration. So the same agent runs in a single-process
//! mission, behind a Zenoh session, in a test of two agents and a lost message, in a fuzzer.

use crate::camera::Pose;
use crate::envelope::Envelope;
use crate::frame::Frame;
use crate::ids::ChannelId;
use crate::radio::Reception;
use crate::time::{SimTime, Step};

/// Something an agent wants to be sent to all others on a channel: a whole encoded envelope.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Transmit {
    /// The radio to use.
    pub channel: ChannelId,
    /// The sequence number inside the envelope, which names the message's fate.
    pub sequence: u64,
    /// The encoded [`Envelope`].
    pub bytes: Vec<u8>,
}

/// A sans-I/O agent of some mission.
///
/// Within one simulated instant the driver calls `handle_frame`, or `handle_step` for an agent without
/// camera, then alternates `poll_transmit`, `handle_message` and `handle_timeout` until nothing is left
/// for that instant.
pub trait Agent: Send {
    /// What the agent tells its vehicle.
    type Command: Send;
    /// What the agent reports to whoever observes it.
    type Event: Send;

    /// A frame of the agent's own camera arrived.
    fn handle_frame(&mut self, now: SimTime, frame: &Frame);

    /// Step k begins for an agent without a frame of it, such as a ground station; it is at `pose`.
    fn handle_step(&mut self, now: SimTime, step: Step, pose: Pose);

    /// A message of another agent arrived. Anything may be in it: what is not valid is counted,
    /// reported as an event and changes nothing else.
    fn handle_message(&mut self, now: SimTime, message: &Reception);

    /// The instant that [`Self::poll_timeout`] named has come, and every message for it was handled.
    fn handle_timeout(&mut self, now: SimTime);

    /// The next message to send.
    fn poll_transmit(&mut self) -> Option<Transmit>;

    /// Everything the agent knows, as a message for one that joins late and asked; `None` while there
    /// is nothing to tell. It is numbered from [`FIRST_ANSWER`] on, apart from what all others hear,
    /// and whoever asked lets its links decide whether it hears it.
    fn answer(&mut self, now: SimTime) -> Option<Transmit>;

    /// The next command to the vehicle.
    fn poll_command(&mut self) -> Option<Self::Command>;

    /// The next event to report.
    fn poll_event(&mut self) -> Option<Self::Event>;

    /// When the agent next wants [`Self::handle_timeout`], if at all.
    fn poll_timeout(&self) -> Option<SimTime>;

    /// A hash of what the agent knows of the world: equal digests mean equal knowledge. What only serves
    /// to come by it (messages that wait, views, plans) is left out.
    fn digest(&self) -> u64;
}

/// The sequence number of the first answer of a life.
pub const FIRST_ANSWER: u64 = 1 << 63;

/// The largest message that is decoded, in bytes.
pub const MAX_MESSAGE_BYTES: usize = Envelope::HEADER_BYTES_MAX + (4 << 20);
