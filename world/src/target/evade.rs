//! Cars that evade: off the roads, at v_max, in reaction to the UAVs, as far as the model allows.
//!
//! The guarantee assumes v_max, the separations (3.8) and (3.11) and the region of a car, and no
//! more. Cars on roads drive at half of v_max on average and use little of that freedom; these cars
//! use all of it.

use std::f64::consts::TAU;

use csat_proto::region::is_inside;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::off_road::OffRoad;
use super::{Car, MAX_TURN_RATE_RAD_S, TargetTruth, Traffic, turned};
use crate::plane::{Point, distance_m, distance_to_segment_m};

/// Headings that a car chooses from in each period.
const HEADINGS: u32 = 16;

/// How a car evades.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Manner {
    /// Straight on; along a wall where one is in the way.
    Straight,
    /// Away from the nearest UAV.
    Flee,
    /// Out of all footprints, and onto the ground that the nearest UAV has just seen.
    Tail,
}

impl Manner {
    pub(super) fn draw(rng: &mut ChaCha8Rng) -> Self {
        [Self::Straight, Self::Flee, Self::Tail][rng.random_range(0..3)]
    }
}

/// What an evading car knows of a UAV.
#[derive(Debug, Clone)]
pub(crate) struct Watcher {
    p_world: Point,
    /// The border of the footprint.
    edges: Vec<[Point; 2]>,
    /// The middle of the footprint's corners.
    middle: Point,
}

impl Watcher {
    /// A UAV above `p_world` that sees the ground in the polygon `footprint`; `world`, metres.
    pub(crate) fn new(p_world: Point, footprint: &[Point]) -> Self {
        let count = footprint.len().max(1) as f64;
        let middle = footprint.iter().fold([0.0; 2], |m, p| [0, 1].map(|i| m[i] + p[i] / count));
        let ends = footprint.iter().cycle().skip(1);
        let edges = footprint.iter().zip(ends).map(|(a, b)| [*a, *b]).collect();
        Self { p_world, edges, middle }
    }

    fn sees(&self, place: Point) -> bool {
        is_inside(&self.edges, place)
    }

    /// How far a place is from the border of the footprint, metres.
    fn depth_m(&self, place: Point) -> f64 {
        let distances = self.edges.iter().map(|[a, b]| distance_to_segment_m(place, *a, *b));
        distances.fold(f64::INFINITY, f64::min)
    }
}

/// Where cars may drive, and the UAVs that look for them.
pub(crate) struct Chase<'a> {
    /// Where they may be.
    pub(crate) ground: OffRoad<'a>,
    /// The UAVs.
    pub(crate) watchers: &'a [Watcher],
}

/// Where a car could be at the end of a period.
struct CarMove {
    /// Whether a UAV sees the car there, then the cost by the manner of the car.
    cost: (u8, f64),
    course_rad: f64,
    to: Point,
}

impl Chase<'_> {
    /// The cost, for a car of this manner, of `place` after a turn of `turn_rad`; the car takes the
    /// least.
    fn cost(&self, manner: Manner, place: Point, turn_rad: f64) -> (u8, f64) {
        let by_distance = |a: &&Watcher, b: &&Watcher| {
            distance_m(a.p_world, place).total_cmp(&distance_m(b.p_world, place))
        };
        let nearest = self.watchers.iter().min_by(by_distance);
        let Some(nearest) = nearest.filter(|_| manner != Manner::Straight) else {
            return (0, turn_rad.abs());
        };
        if manner == Manner::Flee {
            return (0, -distance_m(nearest.p_world, place));
        }
        let seen_by = self.watchers.iter().filter(|watcher| watcher.sees(place));
        match seen_by.map(|watcher| watcher.depth_m(place)).reduce(f64::max) {
            Some(depth_m) => (1, depth_m),
            None => {
                let far_m = self.watchers.iter().map(|w| distance_m(w.middle, place));
                (0, far_m.fold(f64::INFINITY, f64::min))
            }
        }
    }
}

impl Traffic {
    /// Lets one period of `period_s` seconds pass in which every car evades.
    pub(crate) fn evade(&mut self, chase: &Chase<'_>, period_s: f64) {
        for index in 0..self.cars.len() {
            let from = self.truths[index].location;
            let moves = self.moves(index, chase, period_s);
            let next = moves.into_iter().find(|next| self.is_free(index, chase, from, next.to));
            if let Some(next) = next {
                self.cars[index].course_rad = next.course_rad;
                self.truths[index].location = next.to;
            }
            let course_rad = self.cars[index].course_rad;
            let heading_rad = &mut self.truths[index].heading_rad;
            *heading_rad = turned(*heading_rad, course_rad, MAX_TURN_RATE_RAD_S * period_s);
        }
    }

    /// Where a car could be after a period at its speed, by increasing cost.
    fn moves(&mut self, index: usize, chase: &Chase<'_>, period_s: f64) -> Vec<CarMove> {
        let TargetTruth { location: [x, y], speed_m_s, .. } = self.truths[index];
        let reach_m = speed_m_s * period_s;
        let Car { rng, manner, course_rad, .. } = &mut self.cars[index];
        let step_rad = TAU / f64::from(HEADINGS);
        let offset_rad = rng.random_range(0.0..step_rad);
        let fan = (0..HEADINGS).map(|i| offset_rad + step_rad * f64::from(i));
        let next = |turn_rad: f64| {
            let course_rad = *course_rad + turn_rad;
            let (sin, cos) = course_rad.sin_cos();
            let to = [x + reach_m * cos, y + reach_m * sin];
            let cost = chase.cost(*manner, to, turned(0.0, turn_rad, TAU));
            CarMove { cost, course_rad: turned(0.0, course_rad, TAU), to }
        };
        // Exactly straight on is one of them.
        let mut moves: Vec<CarMove> = std::iter::once(0.0).chain(fan).map(next).collect();
        moves.sort_by(|CarMove { cost: a, .. }, CarMove { cost: b, .. }| {
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        moves
    }

    /// Whether a car may drive straight from a place to another.
    fn is_free(&self, index: usize, chase: &Chase<'_>, from: Point, to: Point) -> bool {
        chase.ground.is_free(from, to, |place| self.has_room(Some(index), place))
    }
}
