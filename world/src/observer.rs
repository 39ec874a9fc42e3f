//! The bounded observer of a UAV's pose (thesis §6.1): a box that contains the true pose.
//!
//! The position over the ground is dead-reckoned (6.2): a step moves the box by the measured displacement and widens
//! it by a share of the path. A position fix of bounded error corrects it (6.3): the box becomes its intersection
//! with the box about the fix. Where fixes are denied the box only grows. Height and attitude are measured at every
//! step, with errors of constant bounds.
//!
//! The errors themselves change slowly, as those of satellite navigation do: along each axis the error runs from one
//! uniform number within its bounds to the next in the time constant.

use std::sync::Arc;

use csat_proto::camera::{Pose, PoseError, PoseEstimate};
use csat_proto::ids::AgentId;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::random::{StreamPurpose, stream};

/// Added to half-widths that are computed from others, metres and radians: more than the rounding of a mission.
const ROUNDING: f64 = 1e-9;

/// `[pose]` of the set-membership mission: how well a UAV knows its pose.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ObserverModel {
    /// Bounds of the errors of what is measured: x, y, z, metres; roll, pitch, yaw, degrees.
    pub error: [f64; 6],
    /// The time in which an error runs from one uniform number within its bounds to the next, seconds.
    pub time_constant_s: f64,
    /// Seconds between position fixes; 0 for one at every step. The first is at step 0.
    pub fix_period_s: f64,
    /// Bound of the error of dead reckoning along either axis, metres per metre flown.
    pub drift: f64,
    /// `[[pose.denied]]`: where and when there are no fixes.
    pub denied: Vec<Denied>,
}

/// A rectangle of ground over which UAVs get no position fixes for some time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Denied {
    /// Its south-west corner, `world`, metres.
    pub min_m: [f64; 2],
    /// Its north-east corner.
    pub max_m: [f64; 2],
    /// From when on, seconds of simulated time.
    #[serde(default)]
    pub from_s: f64,
    /// Until when; for ever if it is not said.
    #[serde(default = "for_ever")]
    pub until_s: f64,
}

fn for_ever() -> f64 {
    f64::INFINITY
}

impl Default for ObserverModel {
    fn default() -> Self {
        Self {
            error: [0.0; 6],
            time_constant_s: 30.0,
            fix_period_s: 0.0,
            drift: 0.02,
            denied: Vec::new(),
        }
    }
}

impl ObserverModel {
    /// The bounds of the errors, as half-widths.
    pub fn half_widths(&self) -> PoseError {
        let [x, y, z, roll, pitch, yaw] = self.error;
        PoseError {
            p_world: [x, y, z],
            yaw_rad: yaw.to_radians(),
            pitch_rad: pitch.to_radians(),
            roll_rad: roll.to_radians(),
        }
    }

    /// Whether every reported pose is exact.
    pub fn is_exact(&self) -> bool {
        let has_gaps = self.fix_period_s > 0.0 || !self.denied.is_empty();
        self.error == [0.0; 6] && !(has_gaps && self.drift > 0.0)
    }

    /// Whether a UAV gets no fix at a place and time.
    fn denies(&self, p: [f64; 2], t_s: f64) -> bool {
        self.denied.iter().any(|zone| {
            (zone.from_s..zone.until_s).contains(&t_s)
                && (0..2).all(|axis| (zone.min_m[axis]..=zone.max_m[axis]).contains(&p[axis]))
        })
    }

    /// Whether the clock of fixes strikes at step `k`.
    fn is_due(&self, k: u32, period_s: f64) -> bool {
        // Early by far less than a step: multiples of a period are not exact.
        let strikes = |k: f64| ((k * period_s + 1e-6) / self.fix_period_s).floor();
        k == 0 || self.fix_period_s <= 0.0 || strikes(f64::from(k)) > strikes(f64::from(k) - 1.0)
    }
}

/// An error within [-1, 1] that runs from one uniform number to the next.
#[derive(Debug, Clone)]
struct Wandering {
    from: f64,
    to: f64,
}

impl Wandering {
    fn new(rng: &mut ChaCha8Rng) -> Self {
        Self { from: rng.random_range(-1.0..=1.0), to: rng.random_range(-1.0..=1.0) }
    }

    fn turn(&mut self, rng: &mut ChaCha8Rng) {
        self.from = std::mem::replace(&mut self.to, rng.random_range(-1.0..=1.0));
    }

    fn at(&self, share: f64) -> f64 {
        self.from + (self.to - self.from) * share
    }
}

/// The observer of one UAV's pose.
#[derive(Debug, Clone)]
pub(crate) struct Observer {
    model: Arc<ObserverModel>,
    period_s: f64,
    step: u32,
    rng: ChaCha8Rng,
    /// In the order of [`ObserverModel::error`], as shares of the bounds.
    errors: [Wandering; 6],
    /// How far the errors are on their way, 0..1.
    share: f64,
    /// The true position at this step, metres.
    position: [f64; 2],
    /// Least and greatest coordinate along either axis that the position may have, metres.
    span: [[f64; 2]; 2],
}

impl Observer {
    /// The observer of a UAV at `pose`, in truth, at step 0.
    pub(crate) fn new(
        model: Arc<ObserverModel>,
        period_s: f64,
        pose: &Pose,
        seed: u64,
        agent: AgentId,
    ) -> Self {
        let mut rng = stream(seed, StreamPurpose::Observer(agent));
        let errors = std::array::from_fn(|_| Wandering::new(&mut rng));
        let share = rng.random_range(0.0..1.0);
        let position = [pose.p_world[0], pose.p_world[1]];
        let span = [[f64::NEG_INFINITY, f64::INFINITY]; 2];
        let mut observer = Self { model, period_s, step: 0, rng, errors, share, position, span };
        observer.correct();
        observer
    }

    /// Lets a period pass, after which the UAV is at `pose`, in truth.
    pub(crate) fn advance(&mut self, pose: &Pose) {
        self.step += 1;
        self.share += self.period_s / self.model.time_constant_s;
        while self.share >= 1.0 {
            self.share -= 1.0;
            self.errors.iter_mut().for_each(|error| error.turn(&mut self.rng));
        }
        self.predict([pose.p_world[0], pose.p_world[1]]);
        let t_s = f64::from(self.step) * self.period_s;
        if self.model.is_due(self.step, self.period_s) && !self.model.denies(self.position, t_s) {
            self.correct();
        }
    }

    /// (6.2): the box moves by the measured displacement and widens by the bound of its error.
    fn predict(&mut self, position: [f64; 2]) {
        let d: [f64; 2] = std::array::from_fn(|axis| position[axis] - self.position[axis]);
        let bound_m = self.model.drift * d[0].hypot(d[1]);
        for (moved_m, [low, high]) in d.into_iter().zip(&mut self.span) {
            let measured_m = moved_m + bound_m * self.rng.random_range(-1.0..=1.0);
            *low += measured_m - bound_m - ROUNDING;
            *high += measured_m + bound_m + ROUNDING;
        }
        self.position = position;
    }

    /// (6.3): the intersection with the box about a fix.
    fn correct(&mut self) {
        for axis in 0..2 {
            let bound_m = self.model.error[axis];
            let fix_m = self.position[axis] + bound_m * self.errors[axis].at(self.share);
            let [low, high] = &mut self.span[axis];
            *low = low.max(fix_m - bound_m - ROUNDING);
            *high = high.min(fix_m + bound_m + ROUNDING);
        }
    }

    /// What the UAV knows of its pose, which is `pose` in truth.
    pub(crate) fn estimate(&self, pose: &Pose) -> PoseEstimate {
        let bounds = self.model.half_widths();
        let error = |axis: usize| self.errors[axis].at(self.share);
        let middle = self.span.map(|[low, high]| 0.5 * (low + high));
        let half = self.span.map(|[low, high]| 0.5 * (high - low) + ROUNDING);
        let measured = |value: f64, bound: f64, axis: usize| value + bound * error(axis);
        // An axis that is measured exactly stays exact.
        let wide = |bound: f64| if bound > 0.0 { bound + ROUNDING } else { 0.0 };
        PoseEstimate {
            pose: Pose {
                p_world: [middle[0], middle[1], measured(pose.p_world[2], bounds.p_world[2], 2)],
                roll_rad: measured(pose.roll_rad, bounds.roll_rad, 3),
                pitch_rad: measured(pose.pitch_rad, bounds.pitch_rad, 4),
                yaw_rad: measured(pose.yaw_rad, bounds.yaw_rad, 5),
            },
            error: PoseError {
                p_world: [half[0], half[1], wide(bounds.p_world[2])],
                roll_rad: wide(bounds.roll_rad),
                pitch_rad: wide(bounds.pitch_rad),
                yaw_rad: wide(bounds.yaw_rad),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.5;

    fn model() -> ObserverModel {
        ObserverModel { error: [5.0, 3.0, 0.2, 0.1, 0.2, 1.0], ..ObserverModel::default() }
    }

    /// A UAV on a curve, its true pose at step k.
    fn pose(k: u32) -> Pose {
        let angle = f64::from(k) * 0.02;
        let p_world = [120.0 * angle.sin(), -120.0 * angle.cos(), 52.0];
        Pose { p_world, yaw_rad: angle, pitch_rad: 0.01, roll_rad: -0.02 }
    }

    fn estimates(model: &ObserverModel, agent: u16, steps: u32) -> Vec<(Pose, PoseEstimate)> {
        let model = Arc::new(model.clone());
        let mut observer = Observer::new(model, PERIOD_S, &pose(0), 7, AgentId(agent));
        let mut all = vec![(pose(0), observer.estimate(&pose(0)))];
        for k in 1..=steps {
            observer.advance(&pose(k));
            all.push((pose(k), observer.estimate(&pose(k))));
        }
        all
    }

    fn components(pose: &Pose) -> [f64; 6] {
        let [x, y, z] = pose.p_world;
        [x, y, z, pose.yaw_rad, pose.pitch_rad, pose.roll_rad]
    }

    #[test]
    fn the_box_always_contains_the_true_pose() {
        let zone = Denied { min_m: [0.0; 2], max_m: [200.0; 2], from_s: 10.0, until_s: 200.0 };
        for fix_period_s in [0.0, 0.7, 20.0] {
            for denied in [Vec::new(), vec![zone]] {
                let model = ObserverModel { fix_period_s, denied, ..model() };
                for (truth, known) in (0..5).flat_map(|id| estimates(&model, id, 600)) {
                    let (truth, reported) = (components(&truth), components(&known.pose));
                    let half = known.error.half_widths();
                    for axis in 0..6 {
                        let error = (truth[axis] - reported[axis]).abs();
                        assert!(error <= half[axis], "{axis}: {error} of {half:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn errors_use_their_bounds_and_differ_between_uavs() {
        let worst = (0..20)
            .flat_map(|id| estimates(&model(), id, 600))
            .fold(0.0, |worst, (t, k)| f64::max(worst, (t.yaw_rad - k.pose.yaw_rad).abs()));
        assert!((0.9..=1.0).contains(&worst.to_degrees()), "{worst}");
        assert_ne!(estimates(&model(), 0, 3), estimates(&model(), 1, 3));
    }

    #[test]
    fn without_fixes_the_box_grows_with_the_path_and_a_fix_ends_that() {
        let half_m = |fix_period_s: f64| -> Vec<f64> {
            let model = ObserverModel { fix_period_s, ..model() };
            estimates(&model, 0, 80).iter().map(|(_, known)| known.error.p_world[0]).collect()
        };
        let (rare, always) = (half_m(20.0), half_m(0.0));
        // 2.4 m per step at 2 %: 1.9 m wider after 39 steps.
        assert!((rare[39] - rare[0] - 0.02 * 2.4 * 39.0).abs() < 1e-3, "{}", rare[39] - rare[0]);
        assert!(rare[40] <= 5.0 + 1e-6 && rare[39] > 6.8, "{rare:?}");
        assert!(always.iter().all(|half| *half <= 5.0 + 1e-6));
    }

    #[test]
    fn no_fix_comes_from_a_denied_zone_while_it_is_denied() {
        let zone = Denied { min_m: [-200.0; 2], max_m: [200.0; 2], from_s: 10.0, until_s: 20.0 };
        let half_m = |denied: Vec<Denied>| -> Vec<f64> {
            let model = ObserverModel { denied, ..model() };
            estimates(&model, 0, 60).iter().map(|(_, known)| known.error.p_world[0]).collect()
        };
        let (free, jammed) = (half_m(Vec::new()), half_m(vec![zone]));
        assert_eq!(free[..20], jammed[..20]);
        assert!(jammed[39] > jammed[19] + 0.9 && jammed[40] < 5.1, "{jammed:?}");
        let elsewhere = Denied { min_m: [300.0; 2], max_m: [400.0; 2], ..zone };
        assert_eq!(free, half_m(vec![elsewhere]));
    }

    #[test]
    fn what_is_measured_exactly_stays_exact() {
        let mut model = ObserverModel::default();
        assert!(model.is_exact());
        model.error[0] = 2.0;
        assert!(!model.is_exact());
        let (truth, known) = estimates(&model, 0, 50)[50];
        assert_eq!((truth.yaw_rad, truth.p_world[2]), (known.pose.yaw_rad, known.pose.p_world[2]));
        let half = known.error.half_widths();
        assert!(half[0] > 0.1 && half[1] < 1e-6 && half[2..] == [0.0; 4], "{half:?}");
        let gaps = ObserverModel { fix_period_s: 5.0, ..ObserverModel::default() };
        assert!(!gaps.is_exact() && ObserverModel { drift: 0.0, ..gaps }.is_exact());
    }
}
