//! Views with one difficulty each.

use csat_proto::camera::{Assumption, CameraModel, Pose};
use csat_proto::frame::Label;
use csat_proto::ids::{AgentId, TargetId};
use csat_proto::time::Step;
use csat_world::camera::{Classified, Renderer};
use csat_world::scene::{Entity, Prism, Scene};
use std::f64::consts::{FRAC_PI_2, PI};

use crate::check_view as check;
use crate::scenes::{Town, placed, rectangle};

const SMALL: CameraModel = CameraModel {
    columns: 48,
    rows: 36,
    aperture_deg: 45.0,
    tilt_deg: 30.0,
    d_max_m: 300.0,
    depth_noise: [-0.01, 0.01],
    min_pixels: 10,
    box_error_px: 0,
    assumption: Assumption::EveryRay,
    misidentify: 0.0,
};
/// Looks straight down.
const NADIR: CameraModel = CameraModel { tilt_deg: 90.0, ..SMALL };

fn block(centre: [f64; 2], size: [f64; 2], height_m: f64) -> Scene {
    let mut town = Town::default();
    town.add(vec![placed(&rectangle(size[0], size[1]), centre, 0.0)], height_m);
    town.scene
}

/// Renders and checks against 9 x 9 rays per pixel and rays around all edges.
fn view(name: &str, scene: &Scene, model: CameraModel, pose: Pose) -> Classified {
    let count = check(name.to_owned(), scene, model, pose, 8);
    // Parts thinner than the spacing of samples, and reflex creases at d_max.
    assert!(count.unexplained <= 10, "{name}: {count:?}");
    Renderer::new(model).render(scene, &pose).clone()
}

fn count(seen: &Classified, label: Label) -> usize {
    seen.labels().iter().filter(|l| **l == label).count()
}

#[test]
fn empty_scene_is_ground_up_to_d_max() {
    let seen = view("empty", &Scene::default(), SMALL, Pose::level([0.0, 0.0, 52.0], 1.0));
    assert!(count(&seen, Label::Ground) > 1000);
    assert_eq!(count(&seen, Label::Obstacle) + count(&seen, Label::Target), 0);
    let high = view("too high", &Scene::default(), SMALL, Pose::level([0.0, 0.0, 301.0], 1.0));
    assert_eq!(count(&high, Label::Unknown), SMALL.pixels());
}

#[test]
fn sky_and_horizon_are_unknown() {
    for pitch_rad in [-0.3, -0.6, -1.0, PI] {
        for roll_rad in [0.0, 0.4, 2.0] {
            let pose = Pose { p_world: [0.0, 0.0, 20.0], yaw_rad: 0.3, pitch_rad, roll_rad };
            let far = CameraModel { d_max_m: 1e5, ..SMALL };
            view("horizon", &block([30.0, 9.0], [9.0, 9.0], 19.0), far, pose);
        }
    }
    let up = Pose { p_world: [0.0, 0.0, 20.0], pitch_rad: -2.0, ..Pose::default() };
    let seen = view("sky", &block([30.0, 9.0], [9.0, 9.0], 19.0), SMALL, up);
    assert_eq!(count(&seen, Label::Unknown), SMALL.pixels());
    assert_eq!(seen.rho_m(0), f64::INFINITY);
}

/// A case that samples at the corners and the centre do not detect.
#[test]
fn roof_corner_pokes_into_a_pixel_through_one_side() {
    let model = NADIR;
    let pose = Pose::level([0.0, 0.0, 50.0], 0.0);
    let view_ = model.at(&pose);
    let renderer = &mut Renderer::new(model);
    for poke_px in [0.3, 0.01, 1e-3, 2e-5] {
        // The tip of a wedge, 10 m high, at the middle of a side of pixel (row 20, column 30).
        let roof = |c: f64, r: f64| {
            let ray = view_.ray_world(c, r);
            let p = view_.centre_world() + ray * (-40.0 / ray.z);
            [p.x, p.y]
        };
        let tip = roof(30.0 + poke_px, 20.5);
        let mut ring = vec![tip, roof(24.0, 20.6), roof(24.0, 20.4)];
        let area = |r: &[[f64; 2]]| {
            (0..3).map(|i| r[i][0] * r[(i + 1) % 3][1] - r[i][1] * r[(i + 1) % 3][0]).sum::<f64>()
        };
        if area(&ring) < 0.0 {
            ring.reverse();
        }
        let entity = Entity::Obstacle(0);
        let scene = Scene { prisms: vec![Prism { entity, rings: vec![ring], height_m: 10.0 }] };
        view("poke", &scene, model, pose);
        let seen = renderer.render(&scene, &pose);
        assert_eq!(seen.labels()[20 * 48 + 30], Label::Unknown, "a poke of {poke_px} px");
        assert_eq!(seen.labels()[20 * 48 + 31], Label::Ground);
        assert_eq!(seen.entity(20 * 48 + 30), None, "the centre sees the ground");
    }
}

/// Edges of the image of a block fall exactly on borders between pixels.
#[test]
fn edges_on_pixel_borders_make_both_sides_unknown() {
    let model = CameraModel { aperture_deg: 90.0, ..NADIR };
    let pose = Pose::level([0.0, 0.0, 34.0], 0.0);
    // f = 24 px: at 24 m below the camera one metre is one pixel.
    let seen = view("borders", &block([0.0, 0.0], [8.0, 12.0], 10.0), model, pose);
    assert_eq!(count(&seen, Label::Obstacle), 6 * 10);
    assert_eq!(count(&seen, Label::Unknown), 10 * 14 - 6 * 10);
}

#[test]
fn camera_above_a_roof_corner_and_in_wall_planes() {
    let scene = block([0.0, 0.0], [10.0, 14.0], 20.0);
    for (x, y) in [(5.0, 7.0), (5.0, -30.0), (-5.0, 0.0), (5.0 + 1e-9, -30.0), (5.0 - 1e-7, -30.0)]
    {
        for yaw_rad in [0.0, FRAC_PI_2, 0.3, PI] {
            for model in [SMALL, NADIR] {
                let pose = Pose::level([x, y, 30.0], yaw_rad);
                view(&format!("edge-on at {x}, {y}"), &scene, model, pose);
            }
        }
    }
}

#[test]
fn camera_just_above_a_roof() {
    let scene = block([0.0, 0.0], [10.0, 14.0], 20.0);
    for above in [0.002, 0.05, 0.5] {
        for x in [0.0, -5.01, 4.99] {
            let pose = Pose::level([x, 0.0, 20.0 + above], 0.0);
            view(&format!("{above} m above"), &scene, SMALL, pose);
            let seen = view(&format!("{above} m above, down"), &scene, NADIR, pose);
            if x == 0.0 {
                // The roof fills the view but for what 14 m do not reach.
                assert!(count(&seen, Label::Obstacle) == NADIR.pixels(), "{above}");
            }
        }
    }
}

#[test]
fn camera_in_a_prism_or_in_the_ground_is_blind() {
    let scene = block([30.0, 0.0], [10.0, 14.0], 20.0);
    for p_world in [
        [0.0, 0.0, 0.0],
        [0.0, 0.0, -3.0],
        [0.0, 0.0, f64::NAN],
        [30.0, 0.0, 19.0],
        [24.9995, 0.0, 19.0],
        [30.0, 0.0, 20.0],
        [30.0, 0.0, 20.0005],
        [f64::NAN, 0.0, 50.0],
    ] {
        let seen = Renderer::new(SMALL).render(&scene, &Pose::level(p_world, 0.0)).clone();
        assert_eq!(count(&seen, Label::Unknown), SMALL.pixels(), "at {p_world:?}");
        assert_eq!(seen.entity(0), None);
    }
}

/// A tower before the camera, as high as it, a little lower and higher, and much higher.
#[test]
fn camera_beside_a_tower() {
    for height_m in [19.0, 20.0 - 1e-4, 20.0 - 1e-7, 20.0, 20.0 + 1e-7, 20.0 + 1e-4, 21.0, 90.0] {
        let scene = block([30.0, 0.0], [10.0, 14.0], height_m);
        for (x, y) in [(0.0, 0.0), (24.0, 0.0), (24.998, 3.0), (0.0, 7.0), (25.0 - 1e-9, -20.0)] {
            let toward = f64::atan2(-y, 30.0 - x);
            for (yaw_rad, pitch_rad) in [(toward, 0.0), (toward + 0.4, -0.5), (PI, 0.0)] {
                let pose = Pose { pitch_rad, ..Pose::level([x, y, 20.0], yaw_rad) };
                let name = format!("{height_m} m high from {x}, {y}, pitch {pitch_rad}");
                let seen = view(&name, &scene, SMALL, pose);
                if (x, yaw_rad) == (24.0, toward) {
                    assert!(count(&seen, Label::Obstacle) > 1500, "{name}");
                }
            }
        }
    }
}

/// Over a lower roof, and over the front edge of one above the camera, to a tower that touches it.
#[test]
fn towers_that_touch_are_told_apart() {
    for heights in [[15.0, 90.0], [25.0, 90.0], [90.0, 25.0], [40.0, 40.0], [20.0, 40.0]] {
        let mut town = Town::default();
        for (height_m, x) in heights.into_iter().zip([30.0, 40.0]) {
            town.add(vec![placed(&rectangle(10.0, 14.0), [x, 0.0], 0.0)], height_m);
        }
        for (x, y) in [(0.0, 0.0), (20.0, -20.0), (35.0, -20.0), (60.0, 3.0)] {
            let yaw_rad = f64::atan2(-y, 35.0 - x);
            for pitch_rad in [0.0, -0.7] {
                let pose = Pose { pitch_rad, ..Pose::level([x, y, 20.0], yaw_rad) };
                view(&format!("{heights:?} from {x}, {y}"), &town.scene, SMALL, pose);
            }
        }
    }
}

/// The camera may be in a courtyard, below its roofs.
#[test]
fn camera_in_a_courtyard() {
    let mut town = Town::default();
    let mut court = rectangle(20.0, 16.0);
    court.reverse();
    town.add(vec![rectangle(40.0, 30.0), court], 60.0);
    town.add_car([6.0, 2.0], 0.4);
    for (yaw_rad, tilt_deg) in [(0.0, 30.0), (0.5, 60.0), (2.0, 10.0), (4.0, -20.0)] {
        let model = CameraModel { tilt_deg, ..SMALL };
        let pose = Pose::level([-6.0, 1.0, 12.0], yaw_rad);
        let seen = view(&format!("courtyard, {yaw_rad}"), &town.scene, model, pose);
        let known = SMALL.pixels() - count(&seen, Label::Unknown);
        assert!(count(&seen, Label::Obstacle) > 50 && known > 800, "{yaw_rad}");
    }
}

#[test]
fn camera_without_pixels_does_not_panic() {
    let scene = block([30.0, 0.0], [10.0, 14.0], 20.0);
    for (columns, rows) in [(0, 0), (0, 3), (3, 0), (1, 1)] {
        let model = CameraModel { columns, rows, ..SMALL };
        let pose = Pose::level([0.0, 0.0, 40.0], 0.0);
        let frame = Renderer::new(model).frame(&scene, &pose, Step(0), 1, AgentId(0));
        assert_eq!(frame.labels.len(), model.pixels());
        assert_eq!(frame.depth.len(), model.pixels());
    }
}

#[test]
fn obstacle_cut_by_the_image_border() {
    for yaw_rad in [0.3, 0.39, 0.4, -0.35, 0.5] {
        for x in [15.0, 40.0, 92.0] {
            let pose = Pose { roll_rad: 0.05, ..Pose::level([0.0, 0.0, 30.0], yaw_rad) };
            view("cut", &block([x, 0.0], [12.0, 9.0], 25.0), SMALL, pose);
        }
    }
}

#[test]
fn touching_buildings_of_equal_height_are_told_apart() {
    let mut town = Town::default();
    town.add(vec![placed(&rectangle(10.0, 20.0), [-5.0, 0.0], 0.0)], 10.0);
    town.add(vec![placed(&rectangle(10.0, 20.0), [5.0, 0.0], 0.0)], 10.0);
    for x in [-3.0, -1e-8, 0.0, 1e-3] {
        let seen = view("touching", &town.scene, NADIR, Pose::level([x, 0.0, 30.0], 0.0));
        for first in [0, 1] {
            let own = |p: &usize| {
                seen.labels()[*p] == Label::Obstacle
                    && seen.entity(*p) == Some(Entity::Obstacle(first))
            };
            assert!((0..NADIR.pixels()).filter(own).count() > 100);
        }
    }
}

#[test]
fn building_fills_a_court_and_a_notch() {
    let mut town = Town::default();
    let court = vec![[-4.0, -3.0], [-4.0, 3.0], [4.0, 3.0], [4.0, -3.0]];
    town.add(vec![rectangle(20.0, 16.0), court], 12.0);
    town.add(vec![rectangle(8.0, 6.0)], 18.0);
    town.add(vec![placed(&rectangle(4.0, 16.0), [12.0, 0.0], 0.0)], 5.0);
    for yaw_rad in [0.0, 0.7, PI] {
        let back = [-45.0 * f64::cos(yaw_rad), -45.0 * f64::sin(yaw_rad), 40.0];
        view("court", &town.scene, SMALL, Pose::level(back, yaw_rad));
    }
}

#[test]
fn slivers_and_specks_smaller_than_a_pixel() {
    let mut town = Town::default();
    town.add(vec![placed(&rectangle(0.01, 9.0), [70.0, 3.0], 0.3)], 8.0);
    town.add(vec![placed(&rectangle(0.02, 0.02), [90.0, -9.0], 0.3)], 0.02);
    town.add(vec![placed(&rectangle(60.0, 0.001), [120.0, 9.0], 0.1)], 0.5);
    town.add_car([110.0, -20.0], 0.5);
    for k in 0..20 {
        let pose = Pose::level([0.0, 0.0, 52.0], 0.01 * f64::from(k) - 0.1);
        view("slivers", &town.scene, SMALL, pose);
    }
}

#[test]
fn car_at_a_corner_behind_a_building() {
    let mut town = Town::default();
    town.add(vec![placed(&rectangle(10.0, 10.0), [60.0, 0.0], 0.0)], 8.0);
    town.add_car([67.0, 5.0], FRAC_PI_2);
    for k in 0..20 {
        let pose = Pose::level([0.0, f64::from(k) - 10.0, 30.0], 0.0);
        view("corner", &town.scene, CameraModel { aperture_deg: 20.0, ..SMALL }, pose);
    }
}

/// Walls, roofs, convex and reflex creases at the sphere of radius d_max.
#[test]
fn faces_at_d_max() {
    let mut town = Town::default();
    let l = [[-6.0, -6.0], [6.0, -6.0], [6.0, 6.0], [2.0, 6.0], [2.0, -2.0], [-6.0, -2.0]];
    town.add(vec![placed(&l, [70.0, 0.0], 0.2)], 9.0);
    town.add_car([66.0, 5.0], 0.4);
    for k in 0..60 {
        let model = CameraModel { d_max_m: 62.0 + 0.5 * f64::from(k), aperture_deg: 15.0, ..SMALL };
        let pose = Pose::level([0.0, 0.0, 40.0], 0.003 * f64::from(k) - 0.09);
        view(&format!("d_max {k}"), &town.scene, model, pose);
    }
}

#[test]
fn closed_rings_and_repeated_points_change_nothing() {
    let clean = block([60.0, 0.0], [10.0, 14.0], 20.0);
    let mut messy = clean.clone();
    let ring = &mut messy.prisms[0].rings[0];
    ring.insert(2, ring[2]);
    ring.insert(2, ring[2]);
    ring.push(ring[0]);
    let pose = Pose::level([0.0, 0.0, 40.0], 0.1);
    let (a, b) = (&mut Renderer::new(SMALL), &mut Renderer::new(SMALL));
    assert_eq!(a.render(&clean, &pose).labels(), b.render(&messy, &pose).labels());
    // A prism without points must not cause a panic.
    messy.prisms[0].rings = vec![vec![], vec![[1.0, 1.0]]];
    b.render(&messy, &pose);
}

/// Straight angles, as clipping a map leaves them: a vertical edge between two coplanar walls.
#[test]
fn straight_angles_in_a_wall() {
    let mut scene = block([60.0, 0.0], [10.0, 14.0], 20.0);
    let ring = &mut scene.prisms[0].rings[0];
    ring.insert(1, [60.0, -7.0]);
    ring.push([55.0, 1.0]);
    for (x, y) in [(0.0, 0.0), (0.0, -7.0), (55.0, -40.0)] {
        let yaw_rad = f64::atan2(-y, 60.0 - x);
        let seen = view("straight", &scene, SMALL, Pose::level([x, y, 40.0], yaw_rad));
        assert!(count(&seen, Label::Obstacle) > 10);
    }
}

/// Assumptions 5 and 6: solids by the centre ray, ground as under Assumption 4.
#[test]
fn centre_ray_assumptions_label_solids_at_silhouettes() {
    let mut town = Town::default();
    town.add(vec![placed(&rectangle(10.0, 10.0), [60.0, 0.0], 0.1)], 8.0);
    town.add_car([70.0, 6.0], 0.3);
    let pose = Pose { roll_rad: 0.02, ..Pose::level([0.0, 0.0, 40.0], 0.01) };
    for d_max_m in [300.0, 82.0] {
        let exact = CameraModel { d_max_m, ..SMALL };
        let strict = Renderer::new(exact).render(&town.scene, &pose).clone();
        for assumption in [Assumption::SomeRay, Assumption::CentreRay] {
            let model = CameraModel { assumption, ..exact };
            let loose = Renderer::new(model).render(&town.scene, &pose).clone();
            let oracle = csat_world::camera::oracle::Oracle::new(&town.scene);
            let view = model.at(&pose);
            for pixel in 0..model.pixels() {
                let (c, r) = ((pixel % 48) as f64 + 0.5, (pixel / 48) as f64 + 0.5);
                let met = oracle.cast_image(&view, c, r).filter(|(_, d)| *d <= d_max_m);
                let expected = match met.map(|(hit, _)| hit.label()) {
                    Some(label @ (Label::Obstacle | Label::Target)) => label,
                    _ => strict.labels()[pixel],
                };
                assert_eq!(loose.labels()[pixel], expected, "pixel {pixel}, {assumption:?}");
            }
            assert!(count(&loose, Label::Target) > count(&strict, Label::Target));
            assert_eq!(loose.entity(0), None);
        }
    }
    assert_eq!(town.scene.prisms[1].entity, Entity::Target(TargetId(0)));
}
