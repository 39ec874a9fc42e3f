//! The interface of a sans-I/O agent: a state machine whose driver hands over inputs and polls outputs.
//!
//! An agent has no clock, socket, file, thread or random source. Simulated time is an argument, and
//! the seed is part of the configuration. So the same agent runs in a single-process mission, behind
//! a Zenoh session, in a test of two agents and a lost message, and in a fuzzer.

use crate::camera::Pose;
use crate::envelope::Envelope;
use crate::frame::Frame;
use crate::ids::ChannelId;
use crate::radio::Reception;
use crate::time::{SimTime, Step};

/// A message that an agent sends to all others on a channel: a whole encoded envelope.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Transmit {
    /// The radio to use.
    pub channel: ChannelId,
    /// The sequence number in the envelope, on which the fate of the message depends.
    pub sequence: u64,
    /// The encoded [`Envelope`].
    pub bytes: Vec<u8>,
}

/// A sans-I/O agent of some mission.
///
/// Within one simulated instant the driver calls `handle_frame`, or `handle_step` for an agent
/// without camera. Then it alternates `poll_transmit`, `handle_message` and `handle_timeout` until no
/// message is to be sent and no timeout is due at that instant.
pub trait Agent: Send {
    /// A command to the agent's vehicle.
    type Command: Send;
    /// What the agent reports to its observers.
    type Event: Send;

    /// A frame of the agent's own camera arrived.
    fn handle_frame(&mut self, now: SimTime, frame: &Frame);

    /// Step k begins for an agent without a frame of it, such as a ground station; it is at `pose`.
    fn handle_step(&mut self, now: SimTime, step: Step, pose: Pose);

    /// A message of another agent arrived. Its bytes are not trusted: the agent counts an invalid
    /// message, reports it as an event, and changes nothing else.
    fn handle_message(&mut self, now: SimTime, message: &Reception);

    /// The instant of [`Self::poll_timeout`] has come, and all messages of that instant were handled.
    fn handle_timeout(&mut self, now: SimTime);

    /// The next message to send.
    fn poll_transmit(&mut self) -> Option<Transmit>;

    /// Everything the agent knows, as a message for an agent that joins late and asked for it; `None`
    /// while there is nothing to tell. Answers are numbered from [`FIRST_ANSWER`] on, apart from the
    /// messages to all agents. The links of the agent that asked decide whether the answer arrives.
    fn answer(&mut self, now: SimTime) -> Option<Transmit>;

    /// The next command to the vehicle.
    fn poll_command(&mut self) -> Option<Self::Command>;

    /// The next event to report.
    fn poll_event(&mut self) -> Option<Self::Event>;

    /// When the agent next wants [`Self::handle_timeout`], if at all.
    fn poll_timeout(&self) -> Option<SimTime>;

    /// A hash of what the agent knows of the world: equal digests mean equal knowledge. Messages that
    /// wait, views and plans are not part of it.
    fn digest(&self) -> u64;
}

/// The sequence number of the first answer of an incarnation.
pub const FIRST_ANSWER: u64 = 1 << 63;

/// The largest message that is decoded, in bytes.
pub const MAX_MESSAGE_BYTES: usize = Envelope::HEADER_BYTES_MAX + (4 << 20);
