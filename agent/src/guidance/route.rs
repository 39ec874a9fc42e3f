//! Baselines without planning: `circles` and `lawnmower` do not use the knowledge of the agent.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use csat_proto::camera::Pose;

use super::criterion::Terms;
use super::division::Share;
use super::rollout::Motion;
use super::{BlockKind, Decision, PlannerInput};
use crate::config::{AgentConfig, Criterion};

/// Lanes are at most this far apart, metres: less than a footprint is wide.
const LANE_M: f64 = 100.0;
/// Circles keep this distance from the border, metres, because the camera looks far ahead and outward.
const BORDER_M: f64 = 160.0;
/// A waypoint in a building counts as reached at this multiple of the distance.
const BUILT_CAPTURES: f64 = 4.0;
/// A smaller increment is no turn, radians.
const LEAST_TURN_RAD: f64 = 0.1;

/// A course to fly.
#[derive(Debug, Clone, PartialEq)]
enum Course {
    /// Counter-clockwise about a centre, `world`, metres.
    Circle { centre: [f64; 2], radius_m: f64 },
    /// From one waypoint to the next and round again, `world`, metres; the UAV flies to `next`.
    Lanes { waypoints: Vec<[f64; 2]>, next: usize },
}

/// Flies a course by the nearest yaw increments of U.
#[derive(Debug, Clone)]
pub(super) struct Route {
    course: Course,
    motion: Motion,
    increments: Vec<f64>,
    blocks: usize,
    /// A waypoint nearer than this is reached, metres.
    capture_m: f64,
}

impl Route {
    /// The route of this agent by `config.guidance.criterion`; `None` for criteria that plan.
    pub(super) fn new(config: &AgentConfig, increments: &[f64]) -> Option<Self> {
        let block_m = config.fleet.speed_m_s * config.guidance.period_s;
        let course = match config.guidance.criterion {
            Criterion::Circles => circle(config, increments, block_m),
            Criterion::Lawnmower => Course::Lanes { waypoints: lanes(config), next: 0 },
            _ => return None,
        };
        Some(Self {
            course,
            motion: Motion::new(config),
            increments: increments.to_vec(),
            blocks: config.guidance.blocks(),
            capture_m: 1.5 * block_m,
        })
    }

    /// The next blocks along the course. Its only state is the waypoint that the UAV flies to.
    pub(super) fn plan(&mut self, input: &PlannerInput<'_>, pose: &Pose) -> Decision {
        self.course.pass(input, pose, self.capture_m);
        let mut ahead = self.course.clone();
        let (mut increments_rad, mut poses, mut pose) = (Vec::new(), Vec::new(), *pose);
        for block in 0..self.blocks {
            ahead.pass(input, &pose, self.capture_m);
            let turn_rad = ahead.heading_rad(&pose) - pose.yaw_rad;
            let mut choices = input.choices(&self.increments, &pose, BlockKind::at(block));
            if choices.is_empty() {
                choices = input.choices(&self.increments, &pose, BlockKind::Hopeless);
            }
            let increment_rad = nearest(&choices, turn_rad);
            pose = self.motion.advance(&pose, increment_rad);
            increments_rad.push(increment_rad);
            poses.push(pose);
        }
        Decision { increments_rad, poses, cost: 0.0, terms: Terms::default(), nodes: 0 }
    }
}

/// The increment nearest to a turn.
fn nearest(choices: &[(usize, f64)], turn_rad: f64) -> f64 {
    let gap = |u: f64| ((turn_rad - u + PI).rem_euclid(TAU) - PI).abs();
    let increments = choices.iter().map(|(_, increment)| *increment);
    increments.min_by(|a, b| gap(*a).total_cmp(&gap(*b))).unwrap_or_default()
}

impl Course {
    /// Advances to the next waypoint if `pose` is within `capture_m` of this one, or within a
    /// multiple of that if a building stands there.
    fn pass(&mut self, input: &PlannerInput<'_>, pose: &Pose, capture_m: f64) {
        if let Self::Lanes { waypoints, next } = self {
            let [x, y] = waypoints[*next];
            let is_built = input.ways.is_some_and(|ways| ways.is_built([x, y]));
            let capture_m = if is_built { BUILT_CAPTURES * capture_m } else { capture_m };
            if (x - pose.p_world[0]).hypot(y - pose.p_world[1]) < capture_m {
                *next = (*next + 1) % waypoints.len();
            }
        }
    }

    /// The heading from `pose` along the course, radians.
    fn heading_rad(&self, pose: &Pose) -> f64 {
        let [x, y, _] = pose.p_world;
        match self {
            Self::Lanes { waypoints, next } => {
                let [to_x, to_y] = waypoints[*next];
                (to_y - y).atan2(to_x - x)
            }
            Self::Circle { centre, radius_m } => {
                let (east, north) = (x - centre[0], y - centre[1]);
                // On the circle along it, from outside straight to it, from inside straight outward.
                let off = (east.hypot(north) - radius_m) / radius_m;
                north.atan2(east) + FRAC_PI_2 * (1.0 + off.clamp(-1.0, 1.0))
            }
        }
    }
}

/// The circle of the sharpest turn, about the middle of this UAV's share, with a
/// distance from the border so that the camera does not mostly look out of the region.
fn circle(config: &AgentConfig, increments: &[f64], block_m: f64) -> Course {
    let [width, depth] = config.ground.size_m;
    let middle = Share::of(config, config.id).middle();
    let turns = increments.iter().map(|u| u.abs()).filter(|&u| u > LEAST_TURN_RAD);
    let turn_rad = turns.max_by(f64::total_cmp).unwrap_or(FRAC_PI_2).min(PI);
    let within = |part: f64, side_m: f64| {
        // In small regions the distance is smaller, so that UAVs keep apart.
        let most_m = (0.5 * side_m - BORDER_M).max(0.18 * side_m);
        ((part - 0.5) * side_m).clamp(-most_m, most_m)
    };
    Course::Circle {
        centre: [within(middle[0], width), within(middle[1], depth)],
        radius_m: 0.5 * block_m / (0.5 * turn_rad).sin(),
    }
}

/// The ends of the east-west lanes of this UAV's band of the region, there and back again.
fn lanes(config: &AgentConfig) -> Vec<[f64; 2]> {
    let [width, depth] = config.ground.size_m;
    let count = f64::from(config.fleet.count.max(config.id.0.saturating_add(1)));
    let band_m = depth / count;
    let south = -0.5 * depth + f64::from(config.id.0) * band_m;
    let lanes = (band_m / LANE_M).ceil().max(1.0);
    let lane = |i: u32| {
        let y = south + (f64::from(i) + 0.5) * band_m / lanes;
        let (west, east) = ([-0.5 * width, y], [0.5 * width, y]);
        if i.is_multiple_of(2) { [west, east] } else { [east, west] }
    };
    let there: Vec<[f64; 2]> = (0..lanes as u32).flat_map(lane).collect();
    let back: Vec<[f64; 2]> = there.iter().rev().copied().collect();
    there.into_iter().chain(back).collect()
}

#[cfg(test)]
#[path = "route_tests.rs"]
mod tests;
