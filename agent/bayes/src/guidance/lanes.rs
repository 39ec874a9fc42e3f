//! The route of `lawnmower`: parallel lanes over a strip of the region.

use csat_proto::camera::Pose;

use super::dubins::{Path, Place};
use super::navigation::Airframe;
use super::route::Route;
use crate::config::AgentConfig;

/// U-turns are planned wider than the tightest ones by this factor.
const RADIUS_RESERVE: f64 = 1.05;
/// From one point of the route to the next, metres.
const STEP_M: f64 = 5.0;

/// The lanes of one aircraft. The region is divided into strips side by side from west to east, one for each
/// aircraft; lanes lead along the longer side of the strip, at most `lane_m` apart.
#[derive(Debug, Clone, PartialEq)]
pub struct Lanes {
    /// Both ends of each lane, metres.
    ends: Vec<[[f64; 2]; 2]>,
    radius_m: f64,
}

impl Lanes {
    /// The lanes of an aircraft.
    pub fn new(config: &AgentConfig, airframe: &Airframe) -> Self {
        let fleet = &config.fleet;
        let count = fleet.count.max(1);
        let [east, north] = config.ground.size_m;
        let width = east / f64::from(count);
        let west = -east / 2.0 + f64::from(config.id.0.min(count - 1)) * width;
        let (low, high) = ([west, -north / 2.0], [west + width, north / 2.0]);
        // Lanes are `across` from each other and lead along the other axis.
        let across = usize::from(width > north);
        let extent = high[across] - low[across];
        let lanes = (extent / config.guidance.lane_m - 1e-9).ceil().max(1.0);
        let lane = |index: u32| {
            let place = low[across] + (f64::from(index) + 0.5) * extent / lanes;
            let end = |along: f64| match across {
                0 => [place, along],
                _ => [along, place],
            };
            [end(low[1 - across]), end(high[1 - across])]
        };
        Self {
            ends: (0..lanes as u32).map(lane).collect(),
            radius_m: airframe.turn_radius_m() * RADIUS_RESERVE,
        }
    }

    /// The route over all lanes and back to the first one. Of all orders (every `stride`-th lane out and others
    /// back, from each of the four corners) it is the one with the least way between lanes.
    pub fn route(&self, pose: &Pose) -> Route {
        let from = Place { p: [pose.p_world[0], pose.p_world[1]], yaw_rad: pose.yaw_rad };
        let mut best = (f64::INFINITY, Vec::new());
        for stride in 1..=self.ends.len() {
            for mirrored in [false, true] {
                for reversed in [false, true] {
                    let order = self.order(stride, mirrored, reversed);
                    let length = self.turns_m(from, &order);
                    if length < best.0 - 1e-6 {
                        best = (length, order);
                    }
                }
            }
        }
        self.points(from, &best.1)
    }

    /// The lanes as they are flown one after the other: each as start and end.
    fn order(&self, stride: usize, mirrored: bool, reversed: bool) -> Vec<[Place; 2]> {
        let count = self.ends.len();
        let mut order = Vec::with_capacity(count);
        for first in 0..stride {
            let sweep = (first..count).step_by(stride);
            match first % 2 {
                0 => order.extend(sweep),
                _ => order.extend(sweep.rev()),
            }
        }
        let flown = |(turn, index): (usize, usize)| {
            let index = if mirrored { count - 1 - index } else { index };
            let [a, b] = self.ends[index];
            let [start, end] = if (turn % 2 == 1) != reversed { [b, a] } else { [a, b] };
            let yaw_rad = (end[1] - start[1]).atan2(end[0] - start[0]);
            [start, end].map(|p| Place { p, yaw_rad })
        };
        order.into_iter().enumerate().map(flown).collect()
    }

    /// The way to the first lane and between lanes, metres.
    fn turns_m(&self, from: Place, order: &[[Place; 2]]) -> f64 {
        let Some((first, others)) = order.split_first() else { return 0.0 };
        let mut at = first[1];
        let turn = |lane: &[Place; 2]| {
            let length = Path::shortest(at, lane[0], self.radius_m).length_m();
            at = lane[1];
            length
        };
        self.join(from, first).1 + others.iter().map(turn).sum::<f64>()
    }

    /// Where the way from a place joins a lane, and its length plus what it leaves out of the lane, metres. An
    /// aircraft that is beside the start of the lane does not fly a full circle to get there.
    fn join(&self, from: Place, [start, _]: &[Place; 2]) -> (Place, f64) {
        let (sin, cos) = start.yaw_rad.sin_cos();
        let at = |step: u32| {
            let along = f64::from(step) * 4.0 * STEP_M;
            let p = [start.p[0] + along * cos, start.p[1] + along * sin];
            let place = Place { p, ..*start };
            (place, Path::shortest(from, place, self.radius_m).length_m() + along)
        };
        let shorter = |best: (Place, f64), next: (Place, f64)| {
            if next.1 < best.1 { next } else { best }
        };
        (1..=8).map(at).fold(at(0), shorter)
    }

    fn points(&self, from: Place, order: &[[Place; 2]]) -> Route {
        let (mut points, mut at, mut first_again) = (vec![from.p], from, 0);
        for (index, lane) in order.iter().chain(order.first()).enumerate() {
            let [mut start, end] = *lane;
            if index == 0 {
                start = self.join(from, lane).0;
            }
            points.extend(Path::shortest(at, start, self.radius_m).points(STEP_M));
            if index == 0 {
                first_again = points.len();
            }
            if index < order.len() {
                points.extend(Path::shortest(start, end, self.radius_m).points(STEP_M));
                at = end;
            }
        }
        Route::new(points, first_again)
    }
}
