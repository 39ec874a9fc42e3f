//! What a UAV's navigation system makes of its pose: reported poses have errors.
//!
//! The error of each of six axes is a normal number of mean 0 and standard deviation σ, independent of the
//! other axes and UAVs. Along track is the direction of the true yaw, across track is to its left.

use csat_proto::camera::Pose;
use csat_proto::ids::AgentId;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::random::{StreamPurpose, normal, stream};

/// No reported height is lower, metres: a camera is above the ground.
const MIN_HEIGHT_M: f64 = 1.0;

/// `[pose]`: how far reported poses are from the true ones (Tisdale et al. 2008, table I).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NavigationModel {
    /// Standard deviations: along track, across track and height, metres; yaw, pitch and roll, radians.
    pub sigma: [f64; 6],
    /// How errors change with time.
    pub noise: Noise,
    /// The time in which the correlation of Gauss-Markov errors falls to 1/e, seconds.
    pub time_constant_s: f64,
}

/// How errors change with time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Noise {
    /// Those of different steps are independent.
    #[default]
    White,
    /// First-order Gauss-Markov: e' = a e + σ √(1 − a²) n with a = exp(−T/τ) and n standard normal, stationary
    /// from step 0 on.
    GaussMarkov,
}

impl Default for NavigationModel {
    fn default() -> Self {
        Self {
            sigma: [10.5, 5.5, 5.5, 0.01, 0.05, 0.02],
            noise: Noise::White,
            time_constant_s: 20.0,
        }
    }
}

impl NavigationModel {
    /// a, the correlation of the errors of two steps `period_s` apart.
    pub fn correlation(&self, period_s: f64) -> f64 {
        match self.noise {
            Noise::White => 0.0,
            Noise::GaussMarkov => (-period_s / self.time_constant_s).exp(),
        }
    }
}

/// The navigation system of one UAV.
#[derive(Debug, Clone)]
pub(crate) struct Navigation {
    model: NavigationModel,
    /// a.
    correlation: f64,
    rng: ChaCha8Rng,
    /// In the order of [`NavigationModel::sigma`].
    error: [f64; 6],
}

impl Navigation {
    /// The system of a UAV at step 0.
    pub(crate) fn new(model: NavigationModel, period_s: f64, seed: u64, agent: AgentId) -> Self {
        let mut rng = stream(seed, StreamPurpose::Navigation(agent));
        let error = model.sigma.map(|sigma| sigma * normal(&mut rng));
        Self { model, correlation: model.correlation(period_s), rng, error }
    }

    /// Lets a period pass.
    pub(crate) fn advance(&mut self) {
        let a = self.correlation;
        let fresh = (1.0 - a * a).sqrt();
        for (error, sigma) in self.error.iter_mut().zip(self.model.sigma) {
            *error = a * *error + sigma * fresh * normal(&mut self.rng);
        }
    }

    /// What it reports for a true pose.
    pub(crate) fn reported(&self, pose: &Pose) -> Pose {
        let [along_m, across_m, up_m, yaw_rad, pitch_rad, roll_rad] = self.error;
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let [x, y, z] = pose.p_world;
        Pose {
            p_world: [
                x + along_m * cos - across_m * sin,
                y + along_m * sin + across_m * cos,
                (z + up_m).max(MIN_HEIGHT_M),
            ],
            yaw_rad: pose.yaw_rad + yaw_rad,
            pitch_rad: pose.pitch_rad + pitch_rad,
            roll_rad: pose.roll_rad + roll_rad,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f64 = 0.5;

    fn pose() -> Pose {
        Pose { p_world: [100.0, -50.0, 150.0], yaw_rad: 0.6, pitch_rad: -0.1, roll_rad: 0.2 }
    }

    /// The errors of the reported pose, along the axes of `sigma`.
    fn errors(navigation: &Navigation) -> [f64; 6] {
        let (pose, reported) = (pose(), navigation.reported(&pose()));
        let d: [f64; 3] = std::array::from_fn(|i| reported.p_world[i] - pose.p_world[i]);
        let (sin, cos) = pose.yaw_rad.sin_cos();
        [
            d[0] * cos + d[1] * sin,
            d[1] * cos - d[0] * sin,
            d[2],
            reported.yaw_rad - pose.yaw_rad,
            reported.pitch_rad - pose.pitch_rad,
            reported.roll_rad - pose.roll_rad,
        ]
    }

    /// Standard deviations, and correlations of steps `lag` apart, over many UAVs.
    fn statistics(noise: Noise, from: u32, lag: u32) -> ([f64; 6], [f64; 6]) {
        const UAVS: u16 = 4000;
        let model = NavigationModel { noise, ..NavigationModel::default() };
        let (mut square, mut product) = ([0.0; 6], [0.0; 6]);
        for id in 0..UAVS {
            let mut navigation = Navigation::new(model, PERIOD_S, 1, AgentId(id));
            (0..from).for_each(|_| navigation.advance());
            let first = errors(&navigation);
            (0..lag).for_each(|_| navigation.advance());
            let second = errors(&navigation);
            for i in 0..6 {
                square[i] += first[i] * first[i] / f64::from(UAVS);
                product[i] += first[i] * second[i] / f64::from(UAVS);
            }
        }
        let deviation = square.map(f64::sqrt);
        (deviation, std::array::from_fn(|i| product[i] / square[i]))
    }

    #[test]
    fn errors_have_their_deviations_from_the_first_step_on() {
        for noise in [Noise::White, Noise::GaussMarkov] {
            for from in [0, 1, 30] {
                let (deviations, _) = statistics(noise, from, 1);
                for (got, expected) in deviations.into_iter().zip(NavigationModel::default().sigma)
                {
                    // Four standard deviations of the estimate, 1/√8000 each.
                    assert!(
                        (got / expected - 1.0).abs() < 0.045,
                        "{noise:?} {from}: {deviations:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn gauss_markov_errors_last_and_white_ones_do_not() {
        for (noise, lag, expected) in [
            (Noise::White, 1, 0.0),
            (Noise::GaussMarkov, 1, (-0.5f64 / 20.0).exp()),
            (Noise::GaussMarkov, 40, (-1f64).exp()),
        ] {
            let (_, correlations) = statistics(noise, 2, lag);
            for got in correlations {
                assert!((got - expected).abs() < 0.065, "{noise:?} {lag}: {correlations:?}");
            }
        }
    }

    #[test]
    fn an_exact_system_reports_the_truth_and_no_height_is_below_the_ground() {
        let exact = NavigationModel { sigma: [0.0; 6], ..NavigationModel::default() };
        let navigation = Navigation::new(exact, PERIOD_S, 1, AgentId(0));
        assert_eq!(navigation.reported(&pose()), pose());
        let mut poor = NavigationModel::default();
        poor.sigma[2] = 1e4;
        let lowest = (0..20)
            .map(|id| Navigation::new(poor, PERIOD_S, 1, AgentId(id)).reported(&pose()).p_world[2]);
        assert_eq!(lowest.fold(f64::INFINITY, f64::min), 1.0);
    }

    #[test]
    fn a_table_of_a_scenario_reads() {
        let json = r#"{"noise": "gauss-markov", "sigma": [1, 2, 3, 0.1, 0.2, 0.3]}"#;
        let model: NavigationModel = serde_json::from_str(json).unwrap();
        assert_eq!((model.noise, model.sigma[1]), (Noise::GaussMarkov, 2.0));
        assert_eq!(model.time_constant_s, 20.0);
        assert!(serde_json::from_str::<NavigationModel>(r#"{"tau_s": 1}"#).is_err());
    }
}
