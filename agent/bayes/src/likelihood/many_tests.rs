use super::*;
use crate::likelihood::tests::sensor;
use crate::likelihood::{Sensor, phi};
use csat_proto::camera::{CameraModel, Pose};

/// The ratio that a point is weighed by.
fn ratio(weigher: &Weigher, [x, y]: [f64; 2]) -> f32 {
    let mut weights = [1.0];
    weigher.weigh(&[x as f32], &[y as f32], &mut weights);
    weights[0]
}

/// Single and double precision agree, for cameras that look down and ahead.
#[test]
fn many_points_have_the_ratios_of_each() {
    let down = sensor();
    let ahead = Sensor {
        camera: CameraModel { tilt_deg: 40.0, ..down.camera },
        sigma: [3.0, 2.0, 4.0, 0.02, 0.01, 0.03],
        ..down.clone()
    };
    let mut worst = [0.0f64; 2];
    for (sensor, pitch_rad) in [(&down, -0.17), (&down, 0.05), (&ahead, 0.02)] {
        for p_world in [[40.0, -25.0, 90.0], [-440.0, 460.0, 60.0]] {
            let pose = Pose { p_world, yaw_rad: 0.7, pitch_rad, roll_rad: 0.2 };
            for sighting in [None, Some([320.0, 240.0]), Some([3.0, 470.0])] {
                let likelihood = Likelihood::of_frame(sensor, &pose, sighting);
                let weigher = Weigher::new(&likelihood).unwrap();
                let bounds = likelihood.bounds().unwrap();
                for i in 0..100 * 100 {
                    let p = [i % 100, i / 100].map(|i| f64::from(i as f32 * 10.0 - 495.0));
                    let got = f64::from(ratio(&weigher, p));
                    if bounds.contains(p) {
                        let expected = likelihood.ratio_within(p);
                        let kind = usize::from(sighting.is_some());
                        worst[kind] = worst[kind].max((got / expected - 1.0).abs());
                    } else {
                        assert_eq!(got, 1.0);
                    }
                }
            }
        }
    }
    assert!(worst[0] < 2e-5 && worst[1] < 5e-5, "{worst:?}");
}

/// A point has the same ratio alone, in a block, and by instructions that every processor has, to the last bit.
#[test]
fn a_block_has_the_ratios_of_its_points() {
    let pose = Pose { p_world: [0.0, 0.0, 90.0], yaw_rad: 0.3, pitch_rad: 0.1, roll_rad: -0.1 };
    for sighting in [None, Some([300.0, 200.0])] {
        let weigher = Weigher::new(&Likelihood::of_frame(&sensor(), &pose, sighting)).unwrap();
        let x: [f32; BLOCK] = std::array::from_fn(|i| 7.0 * i as f32 - 110.0);
        let y = x.map(|x| 0.3 * x - 5.0);
        let mut weights = [2.0; BLOCK];
        weigher.weigh(&x, &y, &mut weights);
        let mut plain = [2.0; BLOCK];
        weigher.weigh_block(&x, &y, &mut plain);
        assert_eq!(weights, plain);
        let alone = |i: usize| 2.0 * ratio(&weigher, [x[i].into(), y[i].into()]);
        assert_eq!(weights, std::array::from_fn(alone));
    }
}

/// Other agents may say that a frame was taken from there.
#[test]
fn ratios_are_positive_from_anywhere() {
    let sensor = sensor();
    for height in [1e-45, f64::from(f32::MIN_POSITIVE), 0.5, 2.0, 9999.0, 1e30] {
        for (x, pitch_rad) in [(40.0, 0.0), (40.0, 0.3), (1e5, 0.3), (-3e38, -1.57)] {
            let pose = Pose { p_world: [x, -25.0, height], pitch_rad, yaw_rad: 0.7, roll_rad: 0.2 };
            for sighting in [None, Some([0.0, 0.0]), Some([320.0, 240.0])] {
                let likelihood = Likelihood::of_frame(&sensor, &pose, sighting);
                let Some(weigher) = Weigher::new(&likelihood) else { continue };
                for p in [[40.0, -25.0], [48.0, -25.0], [20.0, 30.0], [400.0, 300.0]] {
                    let ratio = ratio(&weigher, p);
                    assert!(ratio > 0.0 && ratio <= 2.0 * MOST, "{height} {x} {p:?}: {ratio}");
                }
            }
        }
    }
}

#[test]
fn powers_and_odds_are_as_exact_as_is_said() {
    for i in -126_000..=126_000 {
        let x = i as f32 * 1e-3;
        let error = f64::from(exp2(x)) / f64::from(x).exp2() - 1.0;
        assert!(error.abs() < 3e-6, "{x}: {error}");
    }
    for i in -8000..=8000 {
        let t = i as f32 * 1e-3;
        let error = 1.0 / (1.0 + f64::from(odds_against(t))) - phi(t.into());
        assert!(error.abs() < 1e-6, "{t}: {error}");
    }
}

/// What (8) multiplies by is what is left of p(D, V | x), whatever the frame showed.
#[test]
fn survival_is_what_is_not_detected() {
    let pose = Pose { p_world: [10.0, 5.0, 90.0], yaw_rad: 0.3, pitch_rad: 0.1, roll_rad: -0.1 };
    let mut least = 1.0f64;
    for sighting in [None, Some([300.0, 200.0])] {
        let likelihood = Likelihood::of_frame(&sensor(), &pose, sighting);
        let weigher = Weigher::of_survival(&likelihood).unwrap();
        for i in 0..60 * 60 {
            let p = [i % 60, i / 60].map(|i| f64::from(i as f32 * 5.0 - 147.5));
            let (got, expected) = (f64::from(ratio(&weigher, p)), 1.0 - likelihood.p_detection(p));
            assert!((got - expected).abs() < 1e-5, "{p:?}: {got} {expected}");
            least = least.min(got);
        }
    }
    assert!(least < 0.9, "{least}");
}
