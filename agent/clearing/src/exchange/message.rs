//! What agents tell each other: the body of an envelope, in postcard.

use csat_proto::ids::AgentId;
use serde::{Deserialize, Serialize};

use crate::bitmap::{Bitmap, Rect};
use crate::config::Coding;
use crate::motion::Direction;

/// The body of a message. On the channel of long range there is only the beat.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Message {
    /// What the sender does.
    pub beat: Beat,
    /// A cleaner's formation.
    pub formation: Option<Formation>,
    /// What a cleaner knows to be cleared, in its present image.
    pub safe: Option<Mask>,
}

/// What an agent does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Beat {
    /// Its duty.
    pub duty: Duty,
    /// Whom it follows, or flies to.
    pub leader: Option<AgentId>,
    /// How many follow it.
    pub followers: u16,
    /// Whether it holds a frontier.
    pub has_frontier: bool,
    /// Whether it cannot move on without help.
    pub is_waiting: bool,
    /// Whether a frontier was lost, for all that it knows.
    pub has_lost: bool,
}

/// The duties of agents.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Duty {
    /// It clears.
    Cleaner,
    /// It follows a cleaner.
    Follower,
    /// It looks for a cleaner to follow. To say so calls the cleaners, whose beats answer.
    Helper,
}

/// Who follows a cleaner where, and what they are asked to do.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Formation {
    /// Where the cleaner moves, or moved last: east and north.
    pub heading: Direction,
    /// The left and the right wing.
    pub wings: [Option<AgentId>; 2],
    /// The tails, the first one first.
    pub tails: Vec<AgentId>,
    /// The cleaner that this one took a frontier over from.
    pub parent: Option<AgentId>,
    /// Which followers are asked to take a frontier over.
    pub requests: Vec<Request>,
}

/// A request to take a sub-frontier over.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Request {
    /// Who is asked.
    pub to: AgentId,
    /// First and last row of the sub-frontier in the image of who asks.
    pub rows: [u16; 2],
    /// First and last column.
    pub columns: [u16; 2],
}

impl Request {
    /// The rectangle around the sub-frontier.
    pub fn rect(&self) -> Rect {
        Rect { rows: self.rows, columns: self.columns }
    }
}

/// A set of pixels of an image.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Mask {
    /// See [`Bitmap::to_bytes`].
    Bitmap(Vec<u8>),
    /// See [`Bitmap::runs`].
    Runs(Vec<u32>),
}

impl Mask {
    /// Writes a set of pixels.
    pub fn new(bitmap: &Bitmap, coding: Coding) -> Self {
        match coding {
            Coding::Bitmap => Self::Bitmap(bitmap.to_bytes()),
            Coding::Runs => Self::Runs(bitmap.runs()),
        }
    }

    /// Reads it; `None` if it is no set of pixels of an image of this size.
    pub fn read(&self, size: u16) -> Option<Bitmap> {
        match self {
            Self::Bitmap(bytes) => Bitmap::from_bytes(size, size, bytes),
            Self::Runs(runs) => Bitmap::from_runs(size, size, runs),
        }
    }
}
