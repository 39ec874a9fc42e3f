//! How followers and helpers fly.

use csat_proto::ids::AgentId;

use super::ClearingAgent;
use super::duty::State;
use crate::exchange::message::Request;
use crate::formation::station_m;

/// A bearing is good for this time, seconds.
const BEARING_S: f64 = 6.0;

impl ClearingAgent {
    /// What the leader asks this agent to take over.
    pub(super) fn request(&self) -> Option<(AgentId, Request)> {
        let State::Follower { leader, .. } = self.state else { return None };
        let formation = self.fleet.get(leader)?.formation.as_ref()?;
        let request = formation.requests.iter().find(|request| request.to == self.config.id)?;
        Some((leader, *request))
    }

    /// From the middle of an image to the middle of a rectangle in it, east and north, metres.
    pub(super) fn middle_m(&self, request: &Request) -> [f64; 2] {
        let [row, column] = request.rect().middle().map(f64::from);
        let half = f64::from(self.sight.size) / 2.0;
        [column + 0.5 - half, half - row - 0.5].map(|pixels| pixels * self.config.pixel_m())
    }

    /// The displacement of a follower or helper, metres.
    pub(super) fn fly(&self) -> [f64; 2] {
        let wanted = match &self.state {
            State::Follower { leader, place, .. } => {
                let near = self.fleet.get(*leader).and_then(|peer| peer.near);
                near.map(|near| {
                    let from_leader = match (self.request(), place) {
                        (Some((_, request)), _) => self.middle_m(&request),
                        (None, Some(place)) => self.station(*leader, *place),
                        (None, None) => [0.0; 2],
                    };
                    let place = self.place_m();
                    [0, 1].map(|axis| near.place_m[axis] + from_leader[axis] - place[axis])
                })
            }
            State::Helper { target: Some(target) } => self.towards(*target),
            _ => None,
        };
        let most_m = self.config.fleet.speed_m_s * self.config.period_s;
        let [east, north] = wanted.unwrap_or_default();
        let scale = (most_m / east.hypot(north).max(1e-9)).min(1.0);
        [east * scale, north * scale]
    }

    fn station(&self, leader: AgentId, place: crate::formation::Place) -> [f64; 2] {
        let formation = self.fleet.get(leader).and_then(|peer| peer.formation.as_ref());
        let heading = formation.map_or([0, 0], |formation| formation.heading);
        let side_m = f64::from(self.sight.size) * self.config.pixel_m();
        station_m(place, heading, side_m, self.config.clearing.spacing_m)
    }

    /// Far in the direction of a cleaner.
    fn towards(&self, target: AgentId) -> Option<[f64; 2]> {
        let (bearing_rad, heard) = self.fleet.get(target)?.bearing?;
        let is_good = self.step.0.saturating_sub(heard.0) <= self.config.steps(BEARING_S);
        let (sin, cos) = bearing_rad.sin_cos();
        is_good.then_some([1e3 * cos, 1e3 * sin])
    }
}
