//! What is known of the other agents: what they said last, and where they were.

use std::collections::{BTreeMap, BTreeSet};

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
    /// Who was asked to take a frontier over, and was not heard as a cleaner since.
    asked: BTreeSet<AgentId>,
    /// Whether a frontier was lost.
    has_lost: bool,
    /// Whose frontier this agent noticed to be lost, until that is taken.
    noticed: Option<AgentId>,
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
        let may_guard = peer.guards() || self.asked.contains(&got.from);
        let has_forgotten = got.incarnation > peer.incarnation && may_guard;
        if got.incarnation > peer.incarnation {
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
        if has_forgotten {
            self.lose(got.from);
        }
        if beat.duty == Duty::Cleaner {
            self.asked.remove(&got.from);
        }
        Ok(is_newest)
    }

    /// Notes that an agent is asked to take a frontier over: from now on it may guard one.
    pub fn ask(&mut self, id: AgentId) {
        self.asked.insert(id);
    }

    /// Notices those who may guard a frontier and were silent for more than `steps` steps. UAV 0 guards the first one,
    /// also if agent `own` has never heard it since it began at step `since`.
    pub fn miss(&mut self, own: AgentId, since: Step, now: Step, steps: u32) {
        let is_silent = |heard: Step| now.0.saturating_sub(heard.0) > steps;
        let silent = self
            .peers
            .iter()
            .find(|(id, peer)| (peer.guards() || self.asked.contains(id)) && is_silent(peer.heard));
        let first = AgentId(0);
        let is_unheard = own != first && !self.peers.contains_key(&first) && is_silent(since);
        if let Some(id) = silent.map(|(id, _)| *id).or(is_unheard.then_some(first)) {
            self.lose(id);
        }
    }

    /// Notes that the frontier of an agent is lost.
    pub fn lose(&mut self, id: AgentId) {
        if !std::mem::replace(&mut self.has_lost, true) {
            self.noticed = Some(id);
        }
    }

    /// Whose frontier this agent was the first to notice to be lost; once.
    pub fn take_noticed(&mut self) -> Option<AgentId> {
        self.noticed.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exchange::message::Message;

    const OWN: AgentId = AgentId(2);
    const PATIENCE: u32 = 10;

    fn hear(fleet: &mut Fleet, now: u32, from: u16, duty: Duty, incarnation: u32) {
        let beat = Beat {
            duty,
            leader: None,
            followers: 0,
            has_frontier: duty == Duty::Cleaner,
            is_waiting: false,
            has_lost: false,
        };
        let got = Received {
            from: AgentId(from),
            incarnation: Incarnation(incarnation),
            step: Step(now),
            message: Message { beat, formation: None, safe: None },
            safe: None,
            offset_m: None,
        };
        fleet.hear(Step(now), [0.0; 2], 0.0, &got).unwrap();
    }

    /// Whose frontier is noticed to be lost after a time in which only this was heard, at step 0.
    fn missed(said: impl Fn(&mut Fleet)) -> Option<AgentId> {
        let mut fleet = Fleet::default();
        said(&mut fleet);
        fleet.miss(OWN, Step(0), Step(PATIENCE), PATIENCE);
        assert_eq!(fleet.take_noticed(), None, "it may still be heard");
        fleet.miss(OWN, Step(0), Step(PATIENCE + 1), PATIENCE);
        let noticed = fleet.take_noticed();
        assert_eq!(fleet.has_lost(), noticed.is_some());
        fleet.miss(OWN, Step(0), Step(PATIENCE + 2), PATIENCE);
        assert_eq!(fleet.take_noticed(), None, "it is said once");
        noticed
    }

    #[test]
    fn who_may_guard_a_frontier_is_missed() {
        let first = |duty| move |fleet: &mut Fleet| hear(fleet, 0, 0, duty, 0);
        assert_eq!(missed(first(Duty::Cleaner)), Some(AgentId(0)));
        assert_eq!(missed(first(Duty::Helper)), None);
        assert_eq!(missed(|_| {}), Some(AgentId(0)), "it was a cleaner from the first frame on");
        let wing = |fleet: &mut Fleet| {
            hear(fleet, 0, 0, Duty::Helper, 0);
            hear(fleet, 0, 1, Duty::Follower, 0);
        };
        assert_eq!(missed(wing), None);
        let asked = |fleet: &mut Fleet| {
            wing(fleet);
            fleet.ask(AgentId(1));
        };
        assert_eq!(missed(asked), Some(AgentId(1)));
        let done = |fleet: &mut Fleet| {
            asked(fleet);
            hear(fleet, 0, 1, Duty::Cleaner, 0);
            hear(fleet, 0, 1, Duty::Helper, 0);
        };
        assert_eq!(missed(done), None);
    }

    #[test]
    fn a_cleaner_that_restarts_has_forgotten_its_frontier() {
        let mut fleet = Fleet::default();
        hear(&mut fleet, 0, 0, Duty::Cleaner, 0);
        hear(&mut fleet, 1, 0, Duty::Helper, 1);
        assert_eq!((fleet.has_lost(), fleet.take_noticed()), (true, Some(AgentId(0))));
        let mut fleet = Fleet::default();
        hear(&mut fleet, 0, 1, Duty::Follower, 0);
        fleet.ask(AgentId(1));
        hear(&mut fleet, 1, 1, Duty::Helper, 1);
        assert_eq!(fleet.take_noticed(), Some(AgentId(1)), "it may have taken one over");
    }
}
