//! The cars and their true locations ((5.34), (3.8), (3.11)).

use std::f64::consts::{PI, TAU};

use csat_proto::ids::TargetId;
use csat_proto::model::{Driving, TargetsModel};
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

use crate::plane::{Point, distance_m};
use crate::random::{StreamPurpose, stream};
use crate::road::{Arm, RoadGraph};
use crate::scene::{Entity, Prism};

mod evade;
mod off_road;

pub(crate) use evade::{Chase, Watcher};
pub use off_road::OffRoadError;
pub(crate) use off_road::{OffRoad, Walkers};

/// Bound on the rate at which a car's body turns, rad/s.
pub(crate) const MAX_TURN_RATE_RAD_S: f64 = 1.0;

/// Added to the separations that the model requires, so that rounding cannot break them, metres.
pub(crate) const SEPARATION_MARGIN_M: f64 = 0.05;

/// Random places that are tried for a car before the roads are searched from end to end.
const PLACEMENT_DRAWS: u32 = 1000;
/// Distance between the places of that search, metres.
const PLACEMENT_STEP_M: f64 = 0.5;
/// A car passes at most this many junctions in one step.
const MAX_JUNCTIONS_PER_STEP: u32 = 1000;

/// What is true of one target.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TargetTruth {
    /// Its index.
    pub id: TargetId,
    /// x^g: projection of the centre on the ground, `world`, metres.
    pub location: [f64; 2],
    /// The direction of the body, counter-clockwise from east, radians.
    pub heading_rad: f64,
    /// The speed it drives at unless it yields, m/s; 0 for a target that stands or walks at random.
    pub speed_m_s: f64,
}

impl TargetTruth {
    /// The solid that cameras see: an oriented box of `body_m` (length, width, height).
    pub fn prism(&self, body_m: [f64; 3]) -> Prism {
        let (sin, cos) = self.heading_rad.sin_cos();
        let [l, w, height_m] = [body_m[0] / 2.0, body_m[1] / 2.0, body_m[2]];
        let corner = |a: f64, b: f64| {
            [self.location[0] + a * cos - b * sin, self.location[1] + a * sin + b * cos]
        };
        let ring = vec![corner(-l, -w), corner(l, -w), corner(l, w), corner(-l, w)];
        Prism { entity: Entity::Target(self.id), rings: vec![ring], height_m }
    }
}

/// How far a car's location has to stay from every wall, margin included, metres: r_s^to, and no
/// less than half the body's diagonal, so that solids never overlap.
pub(crate) fn road_clearance_m(model: &TargetsModel) -> f64 {
    let half_diagonal_m = model.body_m[0].hypot(model.body_m[1]) / 2.0;
    model.obstacle_distance_m.max(half_diagonal_m) + SEPARATION_MARGIN_M
}

/// How far two cars' locations have to stay apart, margin included, metres.
fn separation_m(model: &TargetsModel) -> f64 {
    let diagonal_m = model.body_m[0].hypot(model.body_m[1]);
    model.target_distance_m.max(diagonal_m) + SEPARATION_MARGIN_M
}

/// Whether `location` is farther than `separation_m` from all targets but `except`.
fn has_room(
    truths: &[TargetTruth],
    separation_m: f64,
    except: Option<usize>,
    location: Point,
) -> bool {
    truths.iter().enumerate().all(|(index, other)| {
        Some(index) == except || distance_m(other.location, location) > separation_m
    })
}

/// Not all cars found room on the roads.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "targets.count: {placed} of {count} cars found room on {road_m:.0} m of usable road, \
     {separation_m} m apart and clear of walls: lower targets.count or targets.target_distance_m, \
     or take a map with more roads (now {roads_mapped} mapped)"
)]
pub struct PlacementError {
    /// Number of cars that found room.
    pub placed: u16,
    /// Number of cars.
    pub count: u16,
    /// Usable road, metres.
    pub road_m: f64,
    /// How far apart they have to be, metres.
    pub separation_m: f64,
    /// Number of centre lines on the map, usable or not.
    pub roads_mapped: usize,
}

/// All cars on the roads of a town.
///
/// Each car drives at its own constant speed, takes a random turn at every junction and turns round
/// at dead ends. Cars move one after the other. A car moves only if it stays far enough from the
/// current locations of all others, so by induction the separation always holds. A car that waited
/// for a while turns round.
#[derive(Debug, Clone)]
pub(crate) struct Traffic {
    cars: Vec<Car>,
    truths: Vec<TargetTruth>,
    separation_m: f64,
}

#[derive(Debug, Clone)]
struct Car {
    place: RoadPlace,
    rng: ChaCha8Rng,
    /// Steps spent waiting.
    waited: u32,
    /// Steps after which it turns round. It differs from car to car, so that no two block each other
    /// for ever.
    patience: u32,
    /// Its manner when it evades.
    manner: evade::Manner,
    /// Its last direction when it evades, counter-clockwise from east, radians.
    course_rad: f64,
}

/// A place on the road graph, and a direction.
#[derive(Debug, Clone, Copy)]
struct RoadPlace {
    arm: Arm,
    /// Arc length from the beginning of the edge, for either direction of the car, metres.
    along_m: f64,
}

impl RoadPlace {
    fn point(&self, roads: &RoadGraph) -> Point {
        roads.edges()[self.arm.edge].at(self.along_m).0
    }

    fn heading_rad(&self, roads: &RoadGraph) -> f64 {
        let edge = &roads.edges()[self.arm.edge];
        // At a bend, a car that drives against the line is on the segment ahead of it.
        let along_m = if self.arm.forward { self.along_m } else { self.along_m - 1e-9 };
        let direction = edge.at(along_m).1;
        if self.arm.forward { direction } else { direction + PI }
    }
}

impl Traffic {
    /// Puts `model.count` cars on the roads, each at a random place with room around it.
    ///
    /// `roads_mapped` is used in the text of the error only.
    ///
    /// # Errors
    /// When no place is left for some of them.
    pub(crate) fn place(
        roads: &RoadGraph,
        roads_mapped: usize,
        model: &TargetsModel,
        seed: u64,
    ) -> Result<Self, PlacementError> {
        let separation_m = separation_m(model);
        let mut traffic = Self { cars: Vec::new(), truths: Vec::new(), separation_m };
        for id in (0..model.count).map(TargetId) {
            let mut rng = stream(seed, StreamPurpose::Car(id));
            let drawn_m_s = rng.random_range(0.0..=model.v_max_m_s);
            let speed_m_s = match model.driving {
                Driving::Evasive => model.v_max_m_s,
                _ => drawn_m_s,
            };
            let patience = rng.random_range(4..=12);
            let forward = rng.random_bool(0.5);
            let Some((edge, along_m)) = traffic.find_room(roads, &mut rng) else { continue };
            let place = RoadPlace { arm: Arm { edge, forward }, along_m };
            let manner = evade::Manner::draw(&mut stream(seed, StreamPurpose::Evader(id)));
            let heading_rad = place.heading_rad(roads);
            let car = Car { place, rng, waited: 0, patience, manner, course_rad: heading_rad };
            traffic.cars.push(car);
            let location = place.point(roads);
            traffic.truths.push(TargetTruth { id, location, heading_rad, speed_m_s });
        }
        let placed = traffic.cars.len() as u16;
        if placed == model.count {
            return Ok(traffic);
        }
        // Without roads the sum is -0, which would be printed.
        let road_m = roads.length_m() + 0.0;
        Err(PlacementError { placed, count: model.count, road_m, separation_m, roads_mapped })
    }

    fn find_room(&self, roads: &RoadGraph, rng: &mut ChaCha8Rng) -> Option<(usize, f64)> {
        let total_m = roads.length_m();
        if total_m <= 0.0 {
            return None;
        }
        let fits = |&(edge, along_m): &(usize, f64)| {
            self.has_room(None, roads.edges()[edge].at(along_m).0)
        };
        let drawn = (0..PLACEMENT_DRAWS)
            .filter_map(|_| roads.locate(rng.random_range(0.0..total_m)))
            .find(fits);
        let steps = (total_m / PLACEMENT_STEP_M) as u64;
        drawn.or_else(|| {
            let places = (0..=steps).filter_map(|i| roads.locate(i as f64 * PLACEMENT_STEP_M));
            places.into_iter().find(fits)
        })
    }

    /// Whether `location` is far enough from all cars but `except`.
    fn has_room(&self, except: Option<usize>, location: Point) -> bool {
        has_room(&self.truths, self.separation_m, except, location)
    }

    /// Lets one period of `period_s` seconds pass on the roads.
    pub(crate) fn advance(&mut self, roads: &RoadGraph, period_s: f64) {
        for index in 0..self.cars.len() {
            let truth = self.truths[index];
            let mut car = self.cars[index].clone();
            car.drive(roads, truth.speed_m_s * period_s);
            let location = car.place.point(roads);
            if self.has_room(Some(index), location) {
                car.waited = 0;
                self.cars[index] = car;
                self.truths[index].location = location;
            } else {
                self.cars[index].wait();
            }
            let wanted = self.cars[index].place.heading_rad(roads);
            let heading = turned(truth.heading_rad, wanted, MAX_TURN_RATE_RAD_S * period_s);
            self.truths[index].heading_rad = heading;
        }
    }

    /// What is true of every car, by index.
    pub(crate) fn truths(&self) -> &[TargetTruth] {
        &self.truths
    }
}

impl Car {
    /// Follows the road for `distance_m` of arc length.
    fn drive(&mut self, roads: &RoadGraph, distance_m: f64) {
        let mut rest = distance_m;
        for _ in 0..MAX_JUNCTIONS_PER_STEP {
            let RoadPlace { arm, along_m } = self.place;
            let edge = &roads.edges()[arm.edge];
            let ahead = if arm.forward { edge.length_m() - along_m } else { along_m };
            if rest <= ahead {
                self.place.along_m += if arm.forward { rest } else { -rest };
                return;
            }
            rest -= ahead;
            let node = edge.nodes[usize::from(arm.forward)];
            self.enter(roads, node, Arm { edge: arm.edge, forward: !arm.forward });
        }
    }

    /// Leaves a node by a random arm other than `back`, by which it came; at a dead end by `back`.
    fn enter(&mut self, roads: &RoadGraph, node: usize, back: Arm) {
        let onward: Vec<Arm> = roads.arms(node).iter().copied().filter(|a| *a != back).collect();
        let arm = onward.choose(&mut self.rng).copied().unwrap_or(back);
        let along_m = if arm.forward { 0.0 } else { roads.edges()[arm.edge].length_m() };
        self.place = RoadPlace { arm, along_m };
    }

    fn wait(&mut self) {
        self.waited += 1;
        if self.waited >= self.patience {
            self.waited = 0;
            self.place.arm.forward = !self.place.arm.forward;
        }
    }
}

/// `from_rad` turned towards `to_rad` the short way by at most `most_rad`.
pub(crate) fn turned(from_rad: f64, to_rad: f64, most_rad: f64) -> f64 {
    let mut difference = (to_rad - from_rad).rem_euclid(TAU);
    if difference > PI {
        difference -= TAU;
    }
    let heading = from_rad + difference.clamp(-most_rad, most_rad);
    (heading + PI).rem_euclid(TAU) - PI
}

#[cfg(test)]
mod tests;
