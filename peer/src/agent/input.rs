//! The inputs of an agent's process, in one queue: samples, queries, timers and requests to end.

use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::time::Duration;

use csat_proto::control::{FrameHeader, Order, Probe};
use csat_proto::ids::AgentId;
use csat_proto::radio::PhysicalHeader;
use zenoh::query::Query;

use super::EndedBy;
use crate::wire::receive::QUEUE;

/// An input of an agent's process.
#[derive(Debug)]
pub enum AgentInput {
    /// A frame of the world.
    Frame(Box<RawFrame>),
    /// An order of the world to all agents.
    Order(Order),
    /// A message of another agent.
    Message(RawMessage),
    /// A probe of another agent's process.
    Probe(AgentId, Probe),
    /// The liveliness token of another agent's process is gone.
    Gone(AgentId),
    /// The world's liveliness token appeared.
    WorldAlive,
    /// The world's liveliness token is gone.
    WorldGone,
    /// Another agent's process asks for a snapshot of what the agent knows.
    SnapshotQuery(Query),
    /// A spectator asks for documents of the agent.
    ViewQuery(Query),
    /// The snapshot of another agent, in answer to this process.
    Snapshot(RawMessage),
    /// No other input came until this timer expired.
    Timeout(Timer),
    /// The user or the parent process ends this one.
    End(EndedBy),
}

/// Why a process wakes though no input came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Timer {
    /// To ask again for a world.
    Join,
    /// To send the next probe.
    Probe,
    /// Lockstep: to give up a turn whose messages do not come.
    Patience,
    /// Real time: to run the agent.
    Due,
}

/// A frame as it came.
#[derive(Debug)]
pub struct RawFrame {
    /// All but the pixels.
    pub header: FrameHeader,
    /// The pixels, encoded.
    pub pixels: Vec<u8>,
}

/// A message as it came.
#[derive(Debug, Clone)]
pub struct RawMessage {
    /// The agent under whose key it came.
    pub key: AgentId,
    /// Where it was sent; `None` if its attachment does not say so.
    pub physical: Option<PhysicalHeader>,
    /// The envelope, encoded.
    pub bytes: Vec<u8>,
}

/// The queue of inputs. It is bounded: its writers drop what it has no room for. It exists before the
/// port, because the process can be ended before it has joined.
pub struct Inlet {
    sender: SyncSender<AgentInput>,
    receiver: Receiver<AgentInput>,
}

impl Default for Inlet {
    fn default() -> Self {
        let (sender, receiver) = sync_channel(QUEUE);
        Self { sender, receiver }
    }
}

impl Inlet {
    /// The next input; [`AgentInput::Timeout`] if none comes until the timer expires.
    pub fn next(&self, timer: Option<(Timer, Duration)>) -> AgentInput {
        let Some((timer, left)) = timer else {
            return self.receiver.recv().expect("the inlet holds a sender itself");
        };
        self.receiver.recv_timeout(left).unwrap_or(AgentInput::Timeout(timer))
    }

    /// A writer of the queue.
    pub fn sender(&self) -> SyncSender<AgentInput> {
        self.sender.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_timer_expires_only_while_no_input_waits() {
        let inlet = Inlet::default();
        inlet.sender().send(AgentInput::WorldAlive).unwrap();
        let timer = Some((Timer::Probe, Duration::ZERO));
        assert!(matches!(inlet.next(timer), AgentInput::WorldAlive));
        assert!(matches!(inlet.next(timer), AgentInput::Timeout(Timer::Probe)));
    }
}
