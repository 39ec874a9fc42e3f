//! What is known of the other agents: what they said last, and where they were.

use std::collections::BTreeMap;

use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::Step;

use crate::exchange::message::{Beat, Duty, Formation};
use crate::exchange::validate::{Received, Rejection};

/// What is known of one other agent.
#[derive(Debug, Clone, PartialEq)]
pub struct Peer {
    /// Its life.
    pub incarnation: Incarnation,
    /// The step of its newest message.
    pub step: Step,
    /// When it was heard last.
    pub heard: Step,
    /// The newest thing that it said.
    pub beat: Beat,
    /// Its newest formation.
    pub formation: Option<Formation>,
    /// Where it was at its newest message on `hbsr`, and when that arrived.
    pub near: Option<Near>,
    /// From where its newest message on `lblr` came, counter-clockwise from east, radians, and when.
    pub bearing: Option<(f64, Step)>,
}

/// Where another agent was.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Near {
    /// East and north in the frame of the own odometry, metres.
    pub place_m: [f64; 2],
    /// When that was heard.
    pub heard: Step,
    /// When that was said.
    pub said: Step,
}

impl Peer {
    /// Whether it was heard on `hbsr` in the last `steps` steps.
    pub fn is_near(&self, now: Step, steps: u32) -> bool {
        self.near.is_some_and(|near| now.0.saturating_sub(near.heard.0) <= steps)
    }

    /// Whether it guards a frontier, as far as is known.
    fn guards(&self) -> bool {
        self.beat.duty == Duty::Cleaner && self.beat.has_frontier
    }
}

/// The other agents that were heard.
#[derive(Debug, Clone, Default)]
pub struct Fleet {
    peers: BTreeMap<AgentId, Peer>,
    /// Whether a frontier was lost.
    has_lost: bool,
}

impl Fleet {
    /// What is known of an agent.
    pub fn get(&self, id: AgentId) -> Option<&Peer> {
        self.peers.get(&id)
    }

    /// All agents that were heard.
    pub fn iter(&self) -> impl Iterator<Item = (AgentId, &Peer)> {
        self.peers.iter().map(|(id, peer)| (*id, peer))
    }

    /// Whether a frontier was lost, for all that is known. Once true it stays true.
    pub fn has_lost(&self) -> bool {
        self.has_lost
    }

    /// Notes a message that arrived at step `now` at an agent at `pose_m`. What is older than what is known
    /// changes nothing. Returns whether it is the newest of its sender.
    ///
    /// # Errors
    /// When the sender has restarted since.
    pub fn hear(
        &mut self,
        now: Step,
        pose_m: [f64; 2],
        bearing_rad: f64,
        got: &Received,
    ) -> Result<bool, Rejection> {
        let beat = got.message.beat;
        let peer = self.peers.entry(got.from).or_insert_with(|| Peer {
            incarnation: got.incarnation,
            step: got.step,
            heard: now,
            beat,
            formation: None,
            near: None,
            bearing: None,
        });
        if got.incarnation < peer.incarnation {
            return Err(Rejection::Incarnation { got: got.incarnation, known: peer.incarnation });
        }
        self.has_lost |= beat.has_lost;
        if got.incarnation > peer.incarnation {
            // What it guarded it has forgotten.
            self.has_lost |= peer.guards();
            *peer = Peer {
                incarnation: got.incarnation,
                formation: None,
                step: got.step,
                ..peer.clone()
            };
        }
        peer.heard = now;
        let is_newest = got.step >= peer.step;
        if is_newest {
            (peer.step, peer.beat) = (got.step, beat);
            if beat.duty != Duty::Cleaner {
                peer.formation = None;
            } else if let Some(formation) = &got.message.formation {
                peer.formation = Some(formation.clone());
            }
        }
        match got.offset_m {
            Some(offset) if peer.near.is_none_or(|near| near.said <= got.step) => {
                let place_m = [0, 1].map(|axis| pose_m[axis] + offset[axis]);
                peer.near = Some(Near { place_m, heard: now, said: got.step });
            }
            None if is_newest => peer.bearing = Some((bearing_rad, now)),
            _ => {}
        }
        Ok(is_newest)
    }

    /// Notices cleaners with a frontier that were silent for more than `steps` steps. Returns one of them, the
    /// first time.
    pub fn miss(&mut self, now: Step, steps: u32) -> Option<AgentId> {
        let is_silent = |peer: &Peer| now.0.saturating_sub(peer.heard.0) > steps;
        let silent = self.peers.iter().find(|(_, peer)| peer.guards() && is_silent(peer))?;
        let is_first = !std::mem::replace(&mut self.has_lost, true);
        is_first.then_some(*silent.0)
    }
}
