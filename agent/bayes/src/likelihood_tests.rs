use super::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Table II.
pub(crate) const SIGMA: [f64; 6] = [10.5, 5.5, 5.5, 0.01, 0.05, 0.02];

pub(crate) fn sensor() -> Sensor {
    Sensor {
        camera: CameraModel {
            columns: 640,
            rows: 480,
            aperture_deg: 49.3,
            tilt_deg: 90.0,
            ..CameraModel::default()
        },
        detector: DetectorModel::default(),
        sigma: SIGMA,
        ground: Ground { size_m: [1000.0, 1000.0] },
    }
}

fn turning() -> Pose {
    Pose { p_world: [40.0, -25.0, 90.0], yaw_rad: 0.7, pitch_rad: -0.17, roll_rad: 0.26 }
}

/// A pose with errors e along track, across track, of the height, of yaw, pitch and roll.
fn with_errors(pose: &Pose, e: [f64; 6]) -> Pose {
    let (sin, cos) = pose.yaw_rad.sin_cos();
    let [x, y, z] = pose.p_world;
    Pose {
        p_world: [x + e[0] * cos - e[1] * sin, y + e[0] * sin + e[1] * cos, z + e[2]],
        yaw_rad: pose.yaw_rad + e[3],
        pitch_rad: pose.pitch_rad + e[4],
        roll_rad: pose.roll_rad + e[5],
    }
}

/// A standard normal number: the sum of twelve uniform ones would do, too; Box-Muller is exact.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let [u, v] = [rng.random_range(f64::MIN_POSITIVE..1.0), rng.random_range(0.0..1.0)];
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

fn errors(rng: &mut ChaCha8Rng) -> [f64; 6] {
    SIGMA.map(|sigma| sigma * normal(rng))
}

/// Σ(x) from the derivatives agrees with differences of the projection.
#[test]
fn derivatives_are_those_of_the_projection() {
    let sensor = sensor();
    for pose in [turning(), Pose::level([40.0, -25.0, 90.0], 2.0)] {
        for x in [[40.0, -25.0], [70.0, -5.0], [20.0, 30.0]] {
            let image = Optics::new(&sensor, &pose).see(x).unwrap();
            let mut numerical = [0.0; 3];
            for (index, sigma) in SIGMA.into_iter().enumerate() {
                let project = |step: f64| {
                    let mut e = [0.0; 6];
                    e[index] = step;
                    let view = sensor.camera.at(&with_errors(&pose, e));
                    view.project(&Vector3::new(x[0], x[1], 0.0)).unwrap()
                };
                let h = 1e-5;
                let (after, before) = (project(h), project(-h));
                let [c, r] = [0, 1].map(|i| sigma * (after[i] - before[i]) / (2.0 * h));
                numerical = [numerical[0] + c * c, numerical[1] + c * r, numerical[2] + r * r];
            }
            for (got, expected) in image.covariance.into_iter().zip(numerical) {
                assert!((got - expected).abs() < 1e-5 * numerical[0], "{got} {expected}");
            }
            let [c, r] = sensor.camera.at(&pose).project(&Vector3::new(x[0], x[1], 0.0)).unwrap();
            assert!((image.mean[0] - c).hypot(image.mean[1] - r) < 1e-9);
        }
    }
}

/// p(D, V | x) against 20 000 drawn poses, inside, at an edge and outside.
#[test]
fn detection_is_as_probable_as_drawn_poses_have_it() {
    let sensor = sensor();
    let [columns, rows] = [f64::from(sensor.camera.columns), f64::from(sensor.camera.rows)];
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for pose in [Pose::level([0.0, 0.0, 90.0], 0.3), turning()] {
        let centre = sensor.camera.at(&pose).ground_point(columns / 2.0, rows / 2.0).unwrap();
        let likelihood = Likelihood::of_frame(&sensor, &pose, None);
        for offset in [[0.0, 0.0], [25.0, 5.0], [35.0, -20.0], [-30.0, 45.0], [70.0, 0.0]] {
            let x = [centre[0] + offset[0], centre[1] + offset[1]];
            let mut sum = 0.0;
            let draws = 20_000;
            for _ in 0..draws {
                let view = sensor.camera.at(&with_errors(&pose, errors(&mut rng)));
                let [c, r] = view.project(&Vector3::new(x[0], x[1], 0.0)).unwrap();
                if (0.0..columns).contains(&c) && (0.0..rows).contains(&r) {
                    sum += sensor.detector.p_detected(view.resolution_px_m2(c, r));
                }
            }
            let (got, expected) = (likelihood.p_detection(x), sum / f64::from(draws));
            assert!((got - expected).abs() < 0.025, "{offset:?}: {got}, drawn {expected}");
        }
    }
}

/// Σ over the region of both outcomes' likelihoods is what it has to be.
#[test]
fn likelihoods_are_probabilities() {
    let sensor = sensor();
    let pose = turning();
    let p_false = sensor.detector.p_false;
    let none = Likelihood::of_frame(&sensor, &pose, None);
    for x in [[40.0, -25.0], [60.0, -60.0], [300.0, 300.0]] {
        let p_none = none.ln_ratio(x).exp() * (1.0 - p_false);
        assert!((p_none - (1.0 - p_false - none.p_detection(x))).abs() < 1e-5, "{x:?}");
    }
    // ∫ p(D, z | x) dz = p(D | x), as far as the image holds the normal density.
    let x = sensor.camera.at(&pose).ground_point(320.0, 240.0).unwrap();
    let [columns, rows] = [640.0, 480.0];
    let mut sum = 0.0;
    let step = 8.0;
    for i in 0..(columns / step) as u32 {
        for j in 0..(rows / step) as u32 {
            let z = [(f64::from(i) + 0.5) * step, (f64::from(j) + 0.5) * step];
            let seen = Likelihood::of_frame(&sensor, &pose, Some(z));
            sum += seen.ln_ratio(x).exp() * p_false / (columns * rows) * step * step;
        }
    }
    let expected = none.p_detection(x) + p_false;
    assert!((sum / expected - 1.0).abs() < 0.02, "{sum} {expected}");
}

/// Other agents may say that a frame was taken from there.
#[test]
fn likelihoods_are_finite_from_any_height() {
    let sensor = sensor();
    for height in [1e-45, f64::from(f32::MIN_POSITIVE), 0.5, 9999.0] {
        for pitch_rad in [0.0, 0.3, -1.57] {
            let pose = Pose { p_world: [40.0, -25.0, height], pitch_rad, ..turning() };
            for sighting in [None, Some([0.0, 0.0]), Some([320.0, 240.0])] {
                let frame = Likelihood::of_frame(&sensor, &pose, sighting);
                for x in [[40.0, -25.0], [48.0, -25.0], [20.0, 30.0], [400.0, 300.0]] {
                    let (p, ln) = (frame.p_detection(x), frame.ln_ratio(x));
                    assert!(
                        (0.0..=1.0).contains(&p) && ln.is_finite(),
                        "{height} {pitch_rad} {x:?}: {p} {ln}"
                    );
                }
            }
        }
    }
}

#[test]
fn outside_its_bounds_a_likelihood_is_its_constant() {
    let sensor = sensor();
    for sighting in [None, Some([320.0, 240.0]), Some([3.0, 470.0])] {
        let likelihood = Likelihood::of_frame(&sensor, &turning(), sighting);
        let bounds = likelihood.bounds().unwrap();
        for i in 0..=20 {
            let share = f64::from(i) / 20.0;
            let along =
                |axis: usize| bounds.min[axis] + share * (bounds.max[axis] - bounds.min[axis]);
            for x in
                [[along(0), bounds.min[1]], [along(0), bounds.max[1]], [bounds.min[0], along(1)]]
            {
                assert!(likelihood.ln_within(x).abs() < 2e-3, "{sighting:?} {x:?}");
            }
        }
        assert_eq!(likelihood.ln_ratio([bounds.max[0] + 1.0, 0.0]), 0.0);
    }
    let away = Pose::level([5000.0, 0.0, 90.0], 0.0);
    assert_eq!(Likelihood::of_frame(&sensor, &away, None).bounds(), None);
}

/// Table II, by the derivatives of (10): the paper's printed values to the digit before the last one.
#[test]
fn table_two() {
    let sensor = sensor();
    let pose = Pose { p_world: [0.0, 0.0, 90.0], yaw_rad: 0.0, pitch_rad: 0.17, roll_rad: 0.26 };
    let centre = |pose: &Pose| sensor.camera.at(pose).ground_point(320.0, 240.0).unwrap();
    let published = [10.5, 5.5, 1.77, 0.29, 4.65, 1.96];
    for (index, (sigma, published)) in SIGMA.into_iter().zip(published).enumerate() {
        let at = |step: f64| {
            let mut e = [0.0; 6];
            e[index] = step;
            centre(&with_errors(&pose, e))
        };
        let h = 1e-6;
        let (a, b) = (at(h), at(-h));
        let moved = sigma * (a[0] - b[0]).hypot(a[1] - b[1]) / (2.0 * h);
        assert!((moved - published).abs() < 0.06, "{index}: {moved}, published {published}");
    }
}
