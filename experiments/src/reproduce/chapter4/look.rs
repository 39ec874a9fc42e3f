//! From a frame to the sets of its cars.

use csat_agent::region::{Inner, Outer};
use csat_agent::sense::exclusion::exclusion;
use csat_agent::sense::{Sensor, clear, outline};
use csat_proto::camera::CameraModel;
use csat_proto::frame::{Detection, Frame, Label};
use csat_proto::ids::AgentId;
use csat_proto::model::Ground;
use csat_proto::region::Region;
use csat_proto::time::Step;
use csat_world::camera::Renderer;
use rayon::prelude::*;

use super::scene::{self, CARS_M};
use super::settings::Setting;
use crate::set_membership::measures::equivalent_radius_m;
use crate::stats::{Stats, stats};

/// The least distances between cars that figure 4.19 may be about, metres; the text names 6 and 8.
pub const SEPARATIONS_M: [f64; 4] = [5.0, 6.0, 7.0, 8.0];

/// What one frame says of one car.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// φ^{eq,R}(X^{t,m}): of the measurement, metres.
    pub measured_radius_m: f64,
    /// φ^{eq,R}(X^t): of the measurement without the clear ground (4.46), metres.
    pub set_radius_m: f64,
    /// φ^c(X^t): from the barycentre of that set to the car (4.45), metres.
    pub error_m: f64,
    /// (4.49) of the exclusion (4.17) round X^{t,m}, by [`SEPARATIONS_M`], per cent: how much of the
    /// ground behind the car's pixels has no other car in it.
    pub covered_pct: [f64; SEPARATIONS_M.len()],
    /// The same of the exclusion round X^t, which is as sound.
    pub covered_by_set_pct: [f64; SEPARATIONS_M.len()],
}

/// Many looks at the five cars.
#[derive(Debug, Clone)]
pub struct Looks {
    /// Per car, what the looks that identify it say.
    pub cars: Vec<Vec<Seen>>,
}

impl Looks {
    /// A look for each seed of the depth noise.
    pub fn take(setting: &Setting, seeds: &[u64]) -> Self {
        let each: Vec<[Option<Seen>; CARS_M.len()]> = seeds
            .par_iter()
            .map_init(
                || Renderer::new(setting.config.camera),
                |renderer, &seed| look(setting, renderer, seed),
            )
            .collect();
        let cars = (0..CARS_M.len()).map(|car| each.iter().filter_map(|look| look[car]).collect());
        Self { cars: cars.collect() }
    }

    /// All values of a number of a car.
    pub fn values(&self, car: usize, value: impl Fn(&Seen) -> f64) -> Vec<f64> {
        self.cars[car].iter().map(value).collect()
    }

    /// Mean and spread of a number of a car; `None` when it was never identified.
    pub fn stats(&self, car: usize, value: impl Fn(&Seen) -> f64) -> Option<Stats> {
        stats(&self.values(car, value))
    }
}

fn look(setting: &Setting, renderer: &mut Renderer, seed: u64) -> [Option<Seen>; CARS_M.len()] {
    let Setting { config, heading_rad, pose_error, .. } = setting;
    let scene = scene::cars(&config.targets, *heading_rad);
    let frame = renderer.frame(&scene, &scene::pose(), Step(0), seed, AgentId(0));
    let frame = Frame { pose_error: *pose_error, ..frame };
    let measured = Sensor::new(config).measure(&frame);
    let mut cars = [None; CARS_M.len()];
    for (target, detection) in measured.targets.iter().zip(&frame.detections) {
        let car = usize::from(target.target.0);
        let set = target.location.minus([&measured.clear_ground]);
        let Some([x, y]) = set.region().barycentre() else { continue };
        let [car_x, car_y] = scene::location(car);
        let shadow = shadow(renderer.model(), &frame, detection, config.ground);
        let covered = |location: &Outer| {
            SEPARATIONS_M.map(|separation_m| {
                let vertices = config.estimator.disc_vertices;
                covered_pct(&shadow, &exclusion(location, separation_m, vertices))
            })
        };
        cars[car] = Some(Seen {
            measured_radius_m: equivalent_radius_m(target.location.region().area_m2()),
            set_radius_m: equivalent_radius_m(set.region().area_m2()),
            error_m: (x - car_x).hypot(y - car_y),
            covered_pct: covered(&target.location),
            covered_by_set_pct: covered(&set),
        });
    }
    cars
}

/// P^g(Y^t_j): the ground behind the Target pixels of a detection.
fn shadow(camera: &CameraModel, frame: &Frame, detection: &Detection, ground: Ground) -> Outer {
    let (columns, rows) = (camera.columns, camera.rows);
    let [box_columns, box_rows] = [detection.pixels.columns, detection.pixels.rows];
    let mut behind = vec![Label::Unknown; frame.labels.len()];
    for row in box_rows[0]..=box_rows[1].min(rows - 1) {
        for column in box_columns[0]..=box_columns[1].min(columns - 1) {
            let pixel = usize::from(row) * usize::from(columns) + usize::from(column);
            if frame.labels[pixel] == Label::Target {
                behind[pixel] = Label::Ground;
            }
        }
    }
    let outline = outline::ground_outline(&behind, columns.into(), rows.into());
    let ground = Region::rectangle(ground.size_m);
    Outer::containing(clear::clear_ground(&camera.at(&frame.pose), &outline, &ground).into_region())
}

/// (4.49).
fn covered_pct(shadow: &Outer, exclusion: &Inner) -> f64 {
    let left_m2 = shadow.minus([exclusion]).region().area_m2();
    100.0 * (1.0 - left_m2 / shadow.region().area_m2())
}
