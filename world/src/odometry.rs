//! Odometry: reported poses in a frame of the agent's own, with a bounded error that grows with the path.

use std::f64::consts::TAU;

use csat_proto::camera::Pose;
use csat_proto::ids::AgentId;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

pub use csat_proto::model::OdometryModel;

use crate::plane::{Point, distance_m, minus};
use crate::random::{StreamPurpose, stream};

/// The odometry of one UAV.
///
/// The position that it reports errs by s d + n: s is the path flown since the start, d a vector that the UAV keeps,
/// no longer than `drift_share`, and n is drawn anew for each frame, within ± `jitter_m` / 2 along either axis.
/// Therefore the displacement between two frames errs by at most `jitter_m` plus `drift_share` of the path between
/// them, along either axis.
#[derive(Debug, Clone)]
pub(crate) struct Odometry {
    model: OdometryModel,
    /// d.
    drift: Point,
    /// The true position at the start, metres.
    origin: Point,
    /// The true position now, metres.
    position: Point,
    /// s, metres.
    path_m: f64,
    /// n, metres.
    jitter_m: Point,
    rng: ChaCha8Rng,
}

impl Odometry {
    /// The odometry of a UAV at its start.
    pub(crate) fn new(model: OdometryModel, pose: &Pose, seed: u64, agent: AgentId) -> Self {
        let mut rng = stream(seed, StreamPurpose::Odometry(agent));
        let (sin, cos) = rng.random_range(0.0..TAU).sin_cos();
        let rate = model.drift_share * rng.random_range(0.0..=1.0);
        let origin = ground_point(pose);
        let jitter_m = jitter_m(&model, &mut rng);
        let drift = [rate * cos, rate * sin];
        Self { model, drift, origin, position: origin, path_m: 0.0, jitter_m, rng }
    }

    /// Lets a period pass, after which the UAV is at this true pose. Its path is at least as long as straight on.
    pub(crate) fn advance(&mut self, pose: &Pose) {
        let position = ground_point(pose);
        self.path_m += distance_m(position, self.position);
        self.position = position;
        self.jitter_m = jitter_m(&self.model, &mut self.rng);
    }

    /// What it reports for the true pose: the height and the attitude are true.
    pub(crate) fn reported(&self, pose: &Pose) -> Pose {
        let [east_m, north_m] = minus(self.position, self.origin);
        let error = [0, 1].map(|axis| self.path_m * self.drift[axis] + self.jitter_m[axis]);
        Pose { p_world: [east_m + error[0], north_m + error[1], pose.p_world[2]], ..*pose }
    }
}

fn ground_point(pose: &Pose) -> Point {
    [pose.p_world[0], pose.p_world[1]]
}

/// n of a frame.
fn jitter_m(model: &OdometryModel, rng: &mut ChaCha8Rng) -> Point {
    [(); 2].map(|()| model.jitter_m / 2.0 * rng.random_range(-1.0..=1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn pose([x, y]: Point) -> Pose {
        Pose::level([x, y, 70.0], 0.3)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn displacements_between_any_two_frames_are_within_the_bound(
            model in (0.0..0.5f64, 0.0..0.2f64)
                .prop_map(|(jitter_m, drift_share)| OdometryModel { jitter_m, drift_share }),
            moves in prop::collection::vec([-2.0..2.0f64, -2.0..2.0f64], 1..40),
            seed: u64,
        ) {
            let mut position = [40.0, -30.0];
            let mut odometry = Odometry::new(model, &pose(position), seed, AgentId(3));
            // The error of the reported position and the path, by frame.
            let mut frames = Vec::new();
            let mut path_m = 0.0;
            for step in moves.iter().map(Some).chain([None]) {
                let reported = odometry.reported(&pose(position));
                prop_assert_eq!((reported.p_world[2], reported.yaw_rad), (70.0, 0.3));
                let origin = [40.0, -30.0];
                let got = [reported.p_world[0], reported.p_world[1]];
                frames.push((minus(got, minus(position, origin)), path_m));
                if let Some(by) = step {
                    position = [position[0] + by[0], position[1] + by[1]];
                    path_m += by[0].hypot(by[1]);
                    odometry.advance(&pose(position));
                }
            }
            for (i, (late, late_m)) in frames.iter().enumerate() {
                for (early, early_m) in &frames[..i] {
                    let bound = model.jitter_m + model.drift_share * (late_m - early_m);
                    for error in minus(*late, *early) {
                        prop_assert!(error.abs() <= bound + 1e-9, "{} > {}", error, bound);
                    }
                }
            }
        }
    }

    #[test]
    fn the_drift_lasts_and_differs_by_agent() {
        let model = OdometryModel { jitter_m: 0.0, drift_share: 0.1 };
        let drift = |id| {
            let mut odometry = Odometry::new(model, &pose([5.0, 5.0]), 1, AgentId(id));
            assert_eq!(odometry.reported(&pose([5.0, 5.0])).p_world, [0.0, 0.0, 70.0]);
            let far = pose([105.0, 5.0]);
            odometry.advance(&far);
            let first = odometry.reported(&far).p_world;
            odometry.advance(&pose([5.0, 5.0]));
            let second = odometry.reported(&pose([5.0, 5.0])).p_world;
            let once = [first[0] - 100.0, first[1]];
            assert!((0..2).all(|axis| (second[axis] - 2.0 * once[axis]).abs() < 1e-9));
            once
        };
        assert_ne!(drift(0), drift(1));
        let length = |id| drift(id)[0].hypot(drift(id)[1]);
        let longest = (0..40).map(length).fold(0.0, f64::max);
        assert!((8.0..=10.0).contains(&longest), "{longest}");
    }

    #[test]
    fn the_jitter_is_drawn_for_each_frame() {
        let model = OdometryModel { jitter_m: 0.1, drift_share: 0.0 };
        let mut odometry = Odometry::new(model, &pose([0.0; 2]), 1, AgentId(0));
        let mut seen: Vec<[f64; 2]> = Vec::new();
        for _ in 0..100 {
            let [x, y, _] = odometry.reported(&pose([0.0; 2])).p_world;
            seen.push([x, y]);
            odometry.advance(&pose([0.0; 2]));
        }
        assert!(seen.windows(2).all(|pair| pair[0] != pair[1]));
        let widest = seen.iter().flatten().map(|x| x.abs()).fold(0.0, f64::max);
        assert!((0.045..=0.05).contains(&widest), "{widest}");
    }
}
