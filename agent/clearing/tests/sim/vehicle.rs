//! A multirotor with a camera that looks down, and its odometry. All errors are drawn within their bounds; half of
//! the time they are at them.

use csat_clearing::bitmap::Bitmap;
use csat_proto::camera::Pose;
use csat_proto::frame::{Frame, Label};
use csat_proto::time::Step;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::truth::{IMAGE_M, PIXEL_M, Truth};
use super::{PERIOD_S, Setup};

pub struct Vehicle {
    pub place_m: [f64; 2],
    start_m: [f64; 2],
    /// What the odometry drifts per metre.
    drift: [f64; 2],
    path_m: f64,
    jitter_m: f64,
    motion_error_m: f64,
    speed_m_s: f64,
    random: ChaCha8Rng,
}

/// An error of at most this size.
pub fn error(random: &mut ChaCha8Rng, bound: f64) -> f64 {
    let share: f64 = random.random_range(-1.0..=1.0);
    bound * if random.random_bool(0.5) { share.signum() } else { share }
}

impl Vehicle {
    pub fn new(setup: &Setup, id: u16) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(setup.seed);
        random.set_stream(u64::from(id) + 1);
        let start_m = [-setup.town.half_m - 4.0 * f64::from(id), setup.town.start_m];
        let angle: f64 = random.random_range(0.0..std::f64::consts::TAU);
        let share = setup.odometry.drift_share;
        Self {
            place_m: start_m,
            start_m,
            drift: [share * angle.cos(), share * angle.sin()],
            path_m: 0.0,
            jitter_m: setup.odometry.jitter_m,
            motion_error_m: setup.motion_error_m,
            speed_m_s: 5.0,
            random,
        }
    }

    pub fn displace(&mut self, by_m: [f64; 2]) {
        let most = self.speed_m_s * PERIOD_S;
        assert!(by_m[0].hypot(by_m[1]) <= most + 1e-9, "{by_m:?}");
        let flown = by_m.map(|metres| metres + error(&mut self.random, self.motion_error_m));
        self.path_m += flown[0].hypot(flown[1]);
        self.place_m.iter_mut().zip(flown).for_each(|(place, by)| *place += by);
    }

    pub fn frame(&mut self, step: Step, truth: &Truth) -> Frame {
        let odometry = [0, 1].map(|axis| {
            let jitter = error(&mut self.random, self.jitter_m / 2.0);
            self.place_m[axis] - self.start_m[axis] + self.drift[axis] * self.path_m + jitter
        });
        let pose = Pose::level([odometry[0], odometry[1], 70.0], std::f64::consts::FRAC_PI_2);
        let labels = self.labels(truth);
        let (depth, detections) = Default::default();
        Frame { labels, depth, detections, ..Frame::of_detector(step, pose, None) }
    }

    fn labels(&mut self, truth: &Truth) -> Vec<Label> {
        let [x, y] = self.place_m;
        let middle = |index: u16| (f64::from(index) + 0.5) * PIXEL_M - IMAGE_M / 2.0;
        let columns: Vec<Option<u16>> = (0..256).map(|c| truth.index(x + middle(c))).collect();
        let mut road = Bitmap::new(256, 256);
        for row in 0..256 {
            let index = truth.index(y - middle(row));
            for (column, cell) in columns.iter().enumerate() {
                if truth.is_road(index, *cell) {
                    road.set(row, column as u16);
                }
            }
        }
        let noisy = self.segment(&road);
        let mut labels = vec![Label::Ground; 256 * 256];
        for [row, column] in noisy.pixels() {
            labels[usize::from(row) * 256 + usize::from(column)] = Label::Road;
        }
        labels
    }

    /// Gaps that the bound of one pixel allows, ragged edges and speckle.
    fn segment(&mut self, road: &Bitmap) -> Bitmap {
        let kept = random_mask(&mut self.random);
        let is_ragged = self.random.random_bool(0.5);
        let kept = if is_ragged { kept.or(&road.eroded(1)) } else { kept };
        let labelled = road.clone().and(&kept);
        let missing = road.clone().and_not(&labelled.dilated(1));
        let mut noisy = labelled.or(&missing);
        for _ in 0..12 {
            noisy.set(self.random.random_range(0..256), self.random.random_range(0..256));
        }
        noisy
    }
}

fn random_mask(random: &mut ChaCha8Rng) -> Bitmap {
    let mut bytes = vec![0; 256 * 32];
    random.fill_bytes(&mut bytes);
    Bitmap::from_bytes(256, 256, &bytes).unwrap()
}
