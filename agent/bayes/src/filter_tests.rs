use csat_proto::camera::Pose;
use csat_proto::ids::{AgentId, ChannelId, Incarnation, RunId};
use csat_proto::model::FleetModel;

use super::*;
use crate::config::{BeliefConfig, BeliefKind, ExchangeConfig, GuidanceConfig};
use crate::factor::ReportedPose;
use crate::likelihood::tests::{SIGMA, sensor};

/// The first agent of two over a square kilometre.
pub(crate) fn config(kind: BeliefKind, walk_m: f64) -> AgentConfig {
    let Sensor { camera, detector, ground, .. } = sensor();
    AgentConfig {
        run: RunId(7),
        seed: 1,
        id: AgentId(0),
        incarnation: Incarnation(0),
        period_s: 0.25,
        ground,
        fleet: FleetModel { count: 2, speed_m_s: 20.0, altitude_m: 90.0, ..FleetModel::default() },
        stations: 0,
        camera,
        detector,
        pose_sigma: SIGMA,
        walk_m,
        belief: BeliefConfig { kind, lag_s: 2.0, ..BeliefConfig::default() },
        exchange: ExchangeConfig::default(),
        guidance: GuidanceConfig::default(),
        channel: ChannelId(0),
    }
}

/// The factor of a step of an aircraft that flies east past a target at (0, 0), which it sees while it is near.
fn factor(source: u16, step: u32) -> Factor {
    let x = 5.0 * f64::from(step) - 100.0;
    let pose = Pose { pitch_rad: -0.07, ..Pose::level([x, 8.0 * f64::from(source), 90.0], 0.0) };
    let z = sensor().camera.at(&pose).project(&nalgebra::Vector3::zeros()).unwrap();
    let is_inside = (0.0..640.0).contains(&z[0]) && (0.0..480.0).contains(&z[1]);
    Factor {
        id: FactorId { source: AgentId(source), incarnation: Incarnation(0), number: step },
        step: Step(step),
        pose: ReportedPose::from(&pose),
        sighting: is_inside.then(|| z.map(|z| z as f32)),
    }
}

fn flown(kind: BeliefKind, walk_m: f64, late: impl Fn(u32) -> u32) -> Filter {
    let mut filter = Filter::new(&config(kind, walk_m));
    for step in 0..40 {
        filter.advance(Step(step));
        let mut news = vec![factor(0, step)];
        // The other one's factors arrive late.
        news.extend((0..=step).filter(|of| of + late(*of) == step).map(|of| factor(1, of)));
        filter.apply(news);
    }
    filter
}

/// A fixed lag: what is late by less makes the same belief as what is in time; what is later is left out.
#[test]
fn late_factors_of_a_moving_target_are_put_where_they_belong() {
    for kind in [BeliefKind::Grid, BeliefKind::Adaptive, BeliefKind::Particles] {
        let in_time = flown(kind, 0.5, |_| 0);
        let late = flown(kind, 0.5, |of| if of > 30 { 0 } else { of % 7 });
        assert_eq!(late.left_out(), 0);
        let (a, b) = (in_time.belief().gaussian(), late.belief().gaussian());
        assert!(
            (a.mean[0] - b.mean[0]).hypot(a.mean[1] - b.mean[1]) < 1e-6,
            "{kind:?} {a:?} {b:?}"
        );
        assert!((a.sigma_m() - b.sigma_m()).abs() < 1e-6, "{kind:?} {a:?} {b:?}");
        assert!(a.mean[0].hypot(a.mean[1]) < 12.0, "{kind:?} {a:?}");
        let too_late = flown(kind, 0.5, |of| if of < 10 { 12 } else { 0 });
        assert_eq!(too_late.left_out(), 10, "{kind:?}");
    }
}

#[test]
fn for_a_target_that_stands_no_factor_is_too_late() {
    for kind in [BeliefKind::Grid, BeliefKind::Adaptive] {
        let in_time = flown(kind, 0.0, |_| 0);
        let late = flown(kind, 0.0, |of| 39 - of);
        let (a, b) = (in_time.belief().gaussian(), late.belief().gaussian());
        assert!(
            (a.mean[0] - b.mean[0]).hypot(a.mean[1] - b.mean[1]) < 1e-6,
            "{kind:?} {a:?} {b:?}"
        );
        assert_eq!(late.left_out(), 0);
        assert!((in_time.cumulative_detection() - late.cumulative_detection()).abs() < 1e-9);
    }
    let p = flown(BeliefKind::Grid, 0.0, |_| 0).cumulative_detection();
    // 200 m and the ends, 80 m wide, of a square kilometre.
    assert!((0.015..0.035).contains(&p), "{p}");
}

/// Equal news make equal bits, whoever holds them.
#[test]
fn equal_news_make_equal_bits() {
    let mut filters = [0, 1].map(|_| Filter::new(&config(BeliefKind::Grid, 0.0)));
    for step in 0..30 {
        for (index, filter) in filters.iter_mut().enumerate() {
            filter.advance(Step(step));
            let mut news = vec![factor(0, step), factor(1, step)];
            news.rotate_left(index);
            filter.apply(news);
        }
    }
    let [a, b] = filters;
    for x in [[0.0, 0.0], [30.0, -10.0], [-55.0, 70.0]] {
        assert_eq!(a.belief().at(x), b.belief().at(x));
    }
}
