//! Following of given routes: polylines by pure pursuit, and way points.

use csat_proto::camera::Pose;

use super::navigation::{Airframe, wrapped};
use crate::config::AgentConfig;

/// How far ahead on the route the point is to which the aircraft flies, in seconds of flight.
const LOOK_AHEAD_S: f64 = 2.0;
/// How far along the route the nearest point is looked for, metres.
const WINDOW_M: f64 = 120.0;
/// A way point that is nearer than this is reached, seconds of flight.
const CAPTURE_S: f64 = 1.0;

/// Points that are flown along in order; from the last one it goes on at `first_again`.
#[derive(Debug, Clone, PartialEq)]
pub struct Route {
    points: Vec<[f64; 2]>,
    first_again: usize,
    nearest: usize,
}

impl Route {
    /// A route from the first point. Points are a few metres apart.
    pub fn new(points: Vec<[f64; 2]>, first_again: usize) -> Self {
        debug_assert!(first_again < points.len());
        Self { points, first_again, nearest: 0 }
    }

    /// Its points, `world`, metres.
    #[cfg(test)]
    pub fn points(&self) -> &[[f64; 2]] {
        &self.points
    }

    fn after(&self, index: usize) -> usize {
        if index + 1 < self.points.len() { index + 1 } else { self.first_again }
    }

    /// The point `ahead_m` along the route from the one that is nearest to `p`, and moves on to that one.
    fn pursue(&mut self, p: [f64; 2], ahead_m: f64) -> [f64; 2] {
        let mut at = self.nearest;
        let (mut least, mut along) = (distance(self.points[at], p), 0.0);
        while along < WINDOW_M {
            let next = self.after(at);
            along += distance(self.points[at], self.points[next]).max(1e-3);
            at = next;
            let d = distance(self.points[at], p);
            if d < least {
                (least, self.nearest) = (d, at);
            }
        }
        self.ahead(ahead_m)
    }

    fn ahead(&self, ahead_m: f64) -> [f64; 2] {
        let (mut at, mut along) = (self.nearest, 0.0);
        while along < ahead_m {
            let next = self.after(at);
            along += distance(self.points[at], self.points[next]).max(1e-3);
            at = next;
        }
        self.points[at]
    }

    /// The heading to fly now, radians.
    pub fn yaw(&mut self, pose: &Pose, airframe: &Airframe) -> f64 {
        let [x, y, _] = pose.p_world;
        let aim = self.pursue([x, y], LOOK_AHEAD_S * airframe.airspeed_m_s);
        yaw_towards(pose, aim, airframe)
    }
}

/// Points that are flown to in order, again and again.
#[derive(Debug, Clone, PartialEq)]
pub struct Waypoints {
    points: Vec<[f64; 2]>,
    next: usize,
    /// The distance to the next one at the step before, metres.
    before_m: f64,
}

impl Waypoints {
    /// The way points of an agent, from the first one.
    pub fn new(config: &AgentConfig) -> Self {
        let lists = &config.guidance.waypoints;
        let own = lists.get(usize::from(config.id.0)).or(lists.first());
        let points = own.cloned().unwrap_or_default();
        Self { points, next: 0, before_m: f64::INFINITY }
    }

    /// The heading to fly now, radians; `None` without way points. A point counts as reached when the aircraft
    /// is near, or when it recedes from a point that it cannot come nearer to without a turn of its own.
    pub fn yaw(&mut self, pose: &Pose, airframe: &Airframe) -> Option<f64> {
        let mut aim = *self.points.get(self.next)?;
        let [x, y, _] = pose.p_world;
        let d = distance(aim, [x, y]);
        let receding = d > self.before_m && d < 1.5 * airframe.turn_radius_m();
        self.before_m = d;
        if d < CAPTURE_S * airframe.airspeed_m_s || receding {
            self.next = (self.next + 1) % self.points.len();
            self.before_m = f64::INFINITY;
            aim = self.points[self.next];
        }
        Some(yaw_towards(pose, aim, airframe))
    }
}

/// The heading at which the way over ground leads to a point, radians, by the shorter turn: the wind's part
/// across the way is compensated.
fn yaw_towards(pose: &Pose, aim: [f64; 2], airframe: &Airframe) -> f64 {
    let [x, y, _] = pose.p_world;
    let course = (aim[1] - y).atan2(aim[0] - x);
    let [east, north] = airframe.model.wind_m_s;
    let across = north * course.cos() - east * course.sin();
    let crab = (across / airframe.airspeed_m_s).clamp(-1.0, 1.0).asin();
    pose.yaw_rad + wrapped(course - crab - pose.yaw_rad)
}

pub(super) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}
