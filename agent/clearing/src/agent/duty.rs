//! The duties of an agent, and how it gets from one to another.
//!
//! | from | to | when |
//! |---|---|---|
//! | follower | cleaner | it takes over what its leader asked it to |
//! | follower | follower of another | its new leader, which followed its old one, took it along |
//! | follower | helper | its leader is no cleaner any more, or is not heard on `hbsr` |
//! | cleaner | helper | its frontier is empty |
//! | helper | follower | it hears a cleaner on `hbsr` |

use csat_proto::ids::AgentId;
use csat_proto::time::Step;

use super::cleaner::Cleaner;
use super::{ClearingAgent, Event};
use crate::config::AgentConfig;
use crate::exchange::message::{Duty, Formation};
use crate::fleet::Peer;
use crate::formation::{Place, place_of};

/// Who is not heard on `hbsr` for this time is out of range, seconds.
pub const RANGE_S: f64 = 6.0;

/// What an agent does.
#[derive(Debug, Clone)]
pub enum State {
    /// A ground station.
    Station,
    /// UAV 0 before its first frame, and whoever has a frontier.
    Cleaner(Box<Cleaner>),
    /// It follows a cleaner.
    Follower {
        /// Whom.
        leader: AgentId,
        /// Its place, when the leader has said it.
        place: Option<Place>,
        /// Since when.
        since: Step,
    },
    /// It looks for a cleaner.
    Helper {
        /// To whom it flies.
        target: Option<AgentId>,
    },
}

impl State {
    /// That before the first frame. UAV 0 becomes a cleaner at its first frame.
    pub fn initial(config: &AgentConfig) -> Self {
        if config.is_station() {
            Self::Station
        } else if config.incarnation.0 > 0 || config.id == AgentId(0) {
            Self::Helper { target: None }
        } else {
            Self::Follower { leader: AgentId(0), place: None, since: Step(0) }
        }
    }

    /// Whom it follows or flies to.
    pub fn leader(&self) -> Option<AgentId> {
        match self {
            Self::Station | Self::Cleaner(_) => None,
            Self::Follower { leader, .. } => Some(*leader),
            Self::Helper { target } => *target,
        }
    }

    /// What it tells the others.
    pub fn duty(&self) -> Duty {
        match self {
            Self::Cleaner(_) => Duty::Cleaner,
            Self::Follower { .. } => Duty::Follower,
            Self::Helper { .. } | Self::Station => Duty::Helper,
        }
    }
}

impl ClearingAgent {
    pub(super) fn enter(&mut self, state: State) {
        let role = self.role();
        let leader = match &state {
            State::Cleaner(cleaner) => cleaner.parent,
            other => other.leader(),
        };
        let is_call = matches!(state, State::Helper { .. });
        self.state = state;
        self.counters.calls += u32::from(is_call);
        if self.role() != role {
            self.events.push_back(Event::Role { step: self.step, role: self.role(), leader });
        }
    }

    pub(super) fn range_steps(&self) -> u32 {
        self.config.steps(RANGE_S)
    }

    /// A follower's place, and whether it still has one.
    pub(super) fn update_follower(&mut self) {
        let State::Follower { leader, since, .. } = self.state else { return };
        let range = self.range_steps();
        if let Some(leader) = self.called_away(leader) {
            let since = self.step;
            return self.enter(State::Follower { leader, place: None, since });
        }
        let peer = self.fleet.get(leader);
        let is_new = self.step.0.saturating_sub(since.0) <= range;
        let is_there = peer
            .is_some_and(|peer| peer.beat.duty == Duty::Cleaner && peer.is_near(self.step, range));
        let has_left = peer.is_some_and(|peer| peer.beat.duty != Duty::Cleaner);
        if has_left || !is_there && !is_new {
            return self.enter(State::Helper { target: None });
        }
        let told = peer.and_then(|peer| place_of(peer.formation.as_ref()?, self.config.id));
        if let State::Follower { place, .. } = &mut self.state {
            *place = told.or(*place);
        }
    }

    /// A cleaner that took a frontier over from the leader, and this agent along.
    fn called_away(&self, leader: AgentId) -> Option<AgentId> {
        let calls = |formation: &Formation| {
            formation.parent == Some(leader) && place_of(formation, self.config.id).is_some()
        };
        let is_calling = |peer: &Peer| {
            peer.beat.duty == Duty::Cleaner
                && peer.is_near(self.step, self.range_steps())
                && peer.formation.as_ref().is_some_and(calls)
        };
        self.fleet.iter().find(|(id, peer)| *id != leader && is_calling(peer)).map(|(id, _)| id)
    }

    /// A helper that hears a cleaner on `hbsr` follows it.
    pub(super) fn update_helper(&mut self) {
        let State::Helper { target } = self.state else { return };
        let chosen = self.choose(target);
        let range = self.range_steps();
        let is_reached =
            |id: &AgentId| self.fleet.get(*id).is_some_and(|peer| peer.is_near(self.step, range));
        if let Some(leader) = chosen.filter(is_reached) {
            self.counters.merges += 1;
            let since = self.step;
            self.enter(State::Follower { leader, place: None, since });
        } else {
            self.state = State::Helper { target: chosen };
        }
    }

    /// The cleaner to help: one that waits, then the one with the fewest followers and helpers on their way, then
    /// the one that was chosen before.
    fn choose(&self, before: Option<AgentId>) -> Option<AgentId> {
        let heard = self.config.steps(self.config.clearing.lost_after_s);
        let is_heard = |peer: &Peer| self.step.0.saturating_sub(peer.heard.0) <= heard;
        let coming = |to: AgentId| {
            let is_coming = |peer: &Peer| {
                is_heard(peer) && peer.beat.duty == Duty::Helper && peer.beat.leader == Some(to)
            };
            self.fleet.iter().filter(|(_, peer)| is_coming(peer)).count()
        };
        let candidates = self.fleet.iter().filter(|(_, peer)| {
            peer.beat.duty == Duty::Cleaner && peer.beat.has_frontier && is_heard(peer)
        });
        let rank = |(id, peer): &(AgentId, &Peer)| {
            let helped = usize::from(peer.beat.followers) + coming(*id);
            (
                !peer.beat.is_waiting || helped > 0 && before != Some(*id),
                helped,
                before != Some(*id),
                *id,
            )
        };
        candidates.min_by_key(rank).map(|(id, _)| id)
    }
}
