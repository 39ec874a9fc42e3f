//! Targets off the roads: on open ground, or anywhere in a town that is clear of walls. They stand, or they
//! walk at random.
//!
//! In each step of T seconds a walker's displacement is normal along each axis, independently, with
//! standard deviation σ√T, where σ is `targets.walk_m_sqrt_s`. A displacement that leads out of the region is
//! reflected at its border. One that comes too near to a wall or another target is not made. No bound holds
//! for its length, so the monitor does not hold walkers to v_max.

use std::f64::consts::TAU;

use csat_proto::ids::TargetId;
use csat_proto::model::{Driving, Ground, TargetsModel};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::{MAX_TURN_RATE_RAD_S, TargetTruth, has_room, separation_m, turned};
use crate::obstacle::Walls;
use crate::plane::{Point, between, distance_m};
use crate::random::{StreamPurpose, normal, stream};

/// Random places that are tried for a target.
const PLACEMENT_DRAWS: u32 = 10_000;
/// Distance between the places on a way that are checked, metres.
const WAY_STEP_M: f64 = 1.0;

/// Where targets may be off the roads.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OffRoad<'a> {
    /// The region, without the strip along its border that targets keep out of.
    pub(crate) ground: Ground,
    /// The buildings.
    pub(crate) walls: &'a Walls,
    /// How far a location stays from every wall, metres.
    pub(crate) clearance_m: f64,
}

impl OffRoad<'_> {
    fn is_open(&self, place: Point) -> bool {
        self.ground.contains(place)
            && self.walls.nearest_within(place, self.clearance_m.next_up()).is_none()
    }

    /// Whether all of the straight way between two places is open and `has_room`.
    pub(super) fn is_free(&self, from: Point, to: Point, has_room: impl Fn(Point) -> bool) -> bool {
        let pieces = (distance_m(from, to) / WAY_STEP_M).ceil().max(1.0) as u32;
        let way = (1..=pieces).map(|i| between(from, to, f64::from(i) / f64::from(pieces)));
        let mut way = way.chain([to]);
        way.all(|place| self.is_open(place) && has_room(place))
    }
}

/// Not all targets found room off the roads.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error(
    "targets.count: {placed} of {count} targets found room in {PLACEMENT_DRAWS} draws each of a place on \
     {} x {} m of ground, {separation_m} m apart and {clearance_m} m clear of walls: lower \
     targets.count or targets.target_distance_m",
    size_m[0], size_m[1]
)]
pub struct OffRoadError {
    /// Number of targets that found room.
    pub placed: u16,
    /// Number of targets.
    pub count: u16,
    /// East and north sides of the ground that they may be on, metres.
    pub size_m: [f64; 2],
    /// How far apart they have to be, metres.
    pub separation_m: f64,
    /// How far from walls they have to be, metres.
    pub clearance_m: f64,
}

/// All targets, off the roads. As in [`Traffic`](super::Traffic), they move one after the other, so the
/// separation always holds.
#[derive(Debug, Clone)]
pub(crate) struct Walkers {
    truths: Vec<TargetTruth>,
    /// One for each target; empty if they stand.
    walks: Vec<ChaCha8Rng>,
    walk_m_sqrt_s: f64,
    separation_m: f64,
}

impl Walkers {
    /// Puts `model.count` targets on the ground, each at a place that is uniform where there is room.
    ///
    /// # Errors
    /// When no place was found for some of them.
    pub(crate) fn place(
        ground: &OffRoad<'_>,
        model: &TargetsModel,
        seed: u64,
    ) -> Result<Self, OffRoadError> {
        let separation_m = separation_m(model);
        let mut truths = Vec::new();
        for id in (0..model.count).map(TargetId) {
            let mut rng = stream(seed, StreamPurpose::Place(id));
            let heading_rad = turned(0.0, rng.random_range(0.0..TAU), TAU);
            let place = (0..PLACEMENT_DRAWS)
                .map(|_| ground.ground.size_m.map(|side_m| (rng.random::<f64>() - 0.5) * side_m));
            let fits = |place: &Point| {
                ground.is_open(*place) && has_room(&truths, separation_m, None, *place)
            };
            let Some(location) = { place }.find(fits) else { continue };
            truths.push(TargetTruth { id, location, heading_rad, speed_m_s: 0.0 });
        }
        let (placed, count) = (truths.len() as u16, model.count);
        if placed < count {
            let (size_m, clearance_m) = (ground.ground.size_m, ground.clearance_m);
            return Err(OffRoadError { placed, count, size_m, separation_m, clearance_m });
        }
        let walker = |truth: &TargetTruth| stream(seed, StreamPurpose::Walk(truth.id));
        let walks = match model.driving {
            Driving::RandomWalk => truths.iter().map(walker).collect(),
            _ => Vec::new(),
        };
        Ok(Self { truths, walks, walk_m_sqrt_s: model.walk_m_sqrt_s, separation_m })
    }

    /// Lets one period of `period_s` seconds pass.
    pub(crate) fn advance(&mut self, ground: &OffRoad<'_>, period_s: f64) {
        let sigma_m = self.walk_m_sqrt_s * period_s.sqrt();
        for (index, walk) in self.walks.iter_mut().enumerate() {
            let [dx, dy] = [(); 2].map(|()| sigma_m * normal(walk));
            let from = self.truths[index].location;
            let [half_x, half_y] = ground.ground.size_m.map(|side_m| side_m / 2.0);
            let to = [reflected(from[0] + dx, half_x), reflected(from[1] + dy, half_y)];
            let has_room = |place| has_room(&self.truths, self.separation_m, Some(index), place);
            if from != to && ground.is_free(from, to, has_room) {
                let truth = &mut self.truths[index];
                let course_rad = (to[1] - from[1]).atan2(to[0] - from[0]);
                let most_rad = MAX_TURN_RATE_RAD_S * period_s;
                truth.heading_rad = turned(truth.heading_rad, course_rad, most_rad);
                truth.location = to;
            }
        }
    }

    /// What is true of every target, by index.
    pub(crate) fn truths(&self) -> &[TargetTruth] {
        &self.truths
    }
}

/// A coordinate folded into [-half, half], as often as it takes.
fn reflected(x: f64, half: f64) -> f64 {
    let unfolded = (x + half).rem_euclid(4.0 * half);
    let folded = if unfolded > 2.0 * half { 4.0 * half - unfolded } else { unfolded };
    (folded - half).clamp(-half, half)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn model(count: u16, driving: Driving) -> TargetsModel {
        TargetsModel { count, driving, ..TargetsModel::default() }
    }

    fn open(walls: &Walls, side_m: f64) -> OffRoad<'_> {
        OffRoad { ground: Ground { size_m: [side_m; 2] }, walls, clearance_m: 2.55 }
    }

    #[test]
    fn a_border_reflects() {
        for (x, expected) in [(3.0, 3.0), (12.0, 8.0), (-12.0, -8.0), (35.0, -5.0), (50.0, 10.0)] {
            assert!((reflected(x, 10.0) - expected).abs() < 1e-12, "{x}");
        }
    }

    #[test]
    fn places_are_uniform() {
        let walls = Walls::default();
        let mut quarters = [0; 4];
        let mut sum = [0.0; 2];
        for seed in 0..4000 {
            let walkers = Walkers::place(&open(&walls, 100.0), &model(1, Driving::Static), seed);
            let [x, y] = walkers.unwrap().truths()[0].location;
            assert!(x.abs() <= 50.0 && y.abs() <= 50.0);
            quarters[usize::from(x > 0.0) + 2 * usize::from(y > 0.0)] += 1;
            sum = [sum[0] + x * x, sum[1] + y * y];
        }
        assert!(quarters.iter().all(|n| (900..1100).contains(n)), "{quarters:?}");
        // The variance of a uniform number of width 100; four standard deviations of its estimate.
        for square in sum {
            assert!((square / 4000.0 - 10_000.0 / 12.0).abs() < 48.0, "{square}");
        }
    }

    #[test]
    fn the_variance_of_a_walk_grows_with_time_and_not_with_the_number_of_steps() {
        let walls = Walls::default();
        for (period_s, steps) in [(0.25, 40), (1.0, 10)] {
            let mut sum = [0.0; 2];
            for seed in 0..2000 {
                let ground = open(&walls, 4000.0);
                let mut walkers =
                    Walkers::place(&ground, &model(1, Driving::RandomWalk), seed).unwrap();
                let from = walkers.truths()[0].location;
                (0..steps).for_each(|_| walkers.advance(&ground, period_s));
                let to = walkers.truths()[0].location;
                (0..2).for_each(|axis| sum[axis] += (to[axis] - from[axis]).powi(2));
            }
            // σ² t = 40 m²; four standard deviations of its estimate, √(2/2000) each.
            for square in sum {
                assert!((square / 2000.0 - 40.0).abs() < 5.1, "{period_s} s: {square}");
            }
        }
    }

    #[test]
    fn who_stands_stands_and_who_has_no_room_is_an_error() {
        let walls = Walls::default();
        let ground = open(&walls, 100.0);
        let mut walkers = Walkers::place(&ground, &model(4, Driving::Static), 1).unwrap();
        let before = walkers.truths().to_vec();
        walkers.advance(&ground, 1.0);
        assert_eq!(walkers.truths(), before);
        let error = Walkers::place(&open(&walls, 20.0), &model(50, Driving::Static), 1);
        let text = error.unwrap_err().to_string();
        assert!(text.contains("of 50 targets found room"), "{text}");
        assert!(text.contains("20 x 20 m of ground, 8.05 m apart"), "{text}");
        let nowhere = Walkers::place(&open(&walls, -1.0), &model(1, Driving::Static), 1);
        assert_eq!(nowhere.unwrap_err().placed, 0);
    }
}
