//! Thesis §6.6 and A.4: what one frame says of five cars, of buildings and of the ground when the pose of the UAV is
//! only known to a box.
//!
//! The scene is that of chapter 4. The reported pose is the true one, as there; only the box differs.
//!
//! | module | what it does |
//! |---|---|
//! | [`settings`] | the boxes |
//! | [`interval`] | interval arithmetic |
//! | [`sivia`] | set inversion by interval analysis |
//! | [`camera`] | the same for the footprint of a camera |
//! | [`figures`], [`tables`] | ours beside theirs |

pub mod camera;
pub mod figures;
pub mod interval;
pub mod settings;
pub mod sivia;
pub mod tables;

use csat_agent::config::AgentConfig;
use csat_agent::region::Outer;
use csat_agent::sense::{Measured, Sensor};
use csat_mission::mission::Mission;
use csat_mission::timing::Stopwatch;
use csat_proto::camera::PoseError;
use csat_proto::frame::{Frame, Label};
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::model::Ground;
use csat_proto::region::Region;
use csat_proto::time::Step;
use csat_world::camera::Renderer;

use super::chapter4::look::Looks;
use super::chapter4::scene;
use super::chapter4::settings::Setting;
use super::table::{Table, banner_of};
use crate::report::page;
use crate::scenario::Scenario;
use crate::set_membership::SetMembership;
use camera::Footprint;
use settings::{POSITION_M, RADII_M, Uncertainty, uncertainties};
use sivia::{Algorithm, Paving, ring};

/// The side of the least box of Thick SIVIA, metres (§6.6.1).
const LEAST_M: f64 = 2.0;
/// The part of the ground that it paves: south-west corner and side, metres.
pub const PAVED_M: ([f64; 2], f64) = ([0.0, -160.0], 320.0);

/// Everything that was seen.
pub struct Chapter6 {
    /// How many looks were taken of each setting.
    pub seeds: usize,
    /// The exact pose, then u1 to u4.
    pub seen: Vec<Seen>,
    /// The footprint under u2, by Thick SIVIA (figure 6.3).
    pub paving: Paving,
    /// S° by error of the position ([`POSITION_M`]) and r_s^to ([`RADII_M`]).
    pub margins: Vec<Vec<Region>>,
    /// (A.21): SIVIA with p = 0 and with p in a box, Thick SIVIA for X^∃ and for X^∀ with p in that box.
    pub rings: [Paving; 4],
}

/// What is seen within a box of poses.
pub struct Seen {
    /// The box.
    pub uncertainty: Uncertainty,
    /// The part of the footprint that is in the image from all poses.
    pub footprint: Region,
    /// What the looks say of the cars.
    pub looks: Looks,
    /// X^{t,m} of each car, in the first look.
    pub measured: Vec<Region>,
    /// X^t, the part of it outside the clear ground.
    pub sets: Vec<Region>,
    /// C of the first look.
    pub clear_ground: Region,
    /// What the sensing of a frame took, seconds, the least of the looks that are timed.
    pub frame_s: f64,
    /// The same of the set of the nearest car alone.
    pub target_s: f64,
}

impl Chapter6 {
    /// Looks once per seed with the camera, the cars and the estimator of `scenario`.
    pub fn look(scenario: &Scenario, seeds: &[u64]) -> Self {
        let mission = SetMembership::new(scenario);
        let config = mission.agent(AgentId(0), Incarnation(0)).config().clone();
        let seen: Vec<Seen> =
            uncertainties().into_iter().map(|u| Seen::take(&config, u, seeds)).collect();
        let footprint = Footprint::new(&config.camera, &scene::pose(), &seen[2].uncertainty.error);
        let margins = POSITION_M
            .map(|half_m| RADII_M.map(|radius_m| margin(&config, half_m, radius_m)).to_vec());
        Self {
            seeds: seeds.len(),
            seen,
            paving: footprint.pave(PAVED_M.0, PAVED_M.1, LEAST_M),
            margins: margins.to_vec(),
            rings: [
                ring(0.0, Algorithm::Sivia),
                ring(0.5, Algorithm::Sivia),
                ring(0.5, Algorithm::ThickOuter),
                ring(0.5, Algorithm::ThickInner),
            ],
        }
    }

    /// (6.64), per cent of the footprint from the exact pose.
    pub fn footprint_pct(&self, one: &Seen) -> f64 {
        100.0 * one.footprint.area_m2() / self.seen[0].footprint.area_m2()
    }

    /// The tables.
    pub fn tables(&self) -> Vec<Table> {
        tables::tables(self)
    }

    /// The page with these tables; `again` is the command that makes it again.
    pub fn html(&self, tables: &[Table], again: &str) -> String {
        let about = page::definitions(&[
            (
                "scene",
                "UAV at (0, 0, 50) m, yaw 0; cars at x = 60, 90, 120, 150 and 180 m, crosswise"
                    .to_owned(),
            ),
            ("looks", format!("{} per box, which differ in the depth noise", self.seeds)),
            ("again", format!("<code>{}</code>", crate::report::shapes::escaped(again))),
        ]);
        let banner = banner_of(tables);
        let tables: String = tables.iter().map(Table::html).collect();
        page::document(
            "Thesis chapter 6, ours beside theirs",
            &(banner + &about + &tables + &figures::all(self)),
        )
    }
}

impl Seen {
    fn take(config: &AgentConfig, uncertainty: Uncertainty, seeds: &[u64]) -> Self {
        let setting = Setting {
            name: uncertainty.name.clone(),
            config: config.clone(),
            heading_rad: std::f64::consts::FRAC_PI_2,
            pose_error: uncertainty.error,
        };
        let looks = Looks::take(&setting, seeds);
        let frame = frame_of_cars(&setting, seeds.first().copied().unwrap_or(1));
        let measured = Sensor::new(config).measure(&frame);
        let nearest = Frame { detections: frame.detections[..1].to_vec(), ..frame.clone() };
        let footprint = all_ground(config, &uncertainty.error);
        Self {
            looks,
            sets: sets(&measured),
            frame_s: least_s(config, &frame),
            target_s: least_s(config, &only_targets(&nearest)),
            measured: measured.targets.into_iter().map(|t| t.location.into_region()).collect(),
            clear_ground: measured.clear_ground.into_region(),
            footprint: footprint.clear_ground.into_region(),
            uncertainty,
        }
    }
}

fn frame_of_cars(setting: &Setting, seed: u64) -> Frame {
    let cars = scene::cars(&setting.config.targets, setting.heading_rad);
    let mut renderer = Renderer::new(setting.config.camera);
    let frame = renderer.frame(&cars, &scene::pose(), Step(0), seed, AgentId(0));
    Frame { pose_error: setting.pose_error, ..frame }
}

fn sets(measured: &Measured) -> Vec<Region> {
    let closer = |location: &Outer| location.minus([&measured.clear_ground]).into_region();
    measured.targets.iter().map(|target| closer(&target.location)).collect()
}

/// What a frame in which all is ground proves, without regard to d_max and on ground without end (§6.6.1).
fn all_ground(config: &AgentConfig, error: &PoseError) -> Measured {
    let mut config = AgentConfig { ground: Ground { size_m: [2000.0; 2] }, ..config.clone() };
    config.estimator.raster_cell_m = 10.0;
    let pixels = config.camera.pixels();
    let frame = Frame::of_detector(Step(0), scene::pose(), None);
    let (labels, depth) = (vec![Label::Ground; pixels], vec![0; pixels]);
    Sensor::new(&config).measure(&Frame { labels, depth, pose_error: *error, ..frame })
}

/// The frame without what takes the time of other sets.
fn only_targets(frame: &Frame) -> Frame {
    let label = |label: &Label| if *label == Label::Target { *label } else { Label::Unknown };
    Frame { labels: frame.labels.iter().map(label).collect(), ..frame.clone() }
}

/// How often a frame is sensed to find out what it takes.
const TIMED: usize = 5;

fn least_s(config: &AgentConfig, frame: &Frame) -> f64 {
    let once = |_| {
        let mut sensor = Sensor::new(config);
        let watch = Stopwatch::start();
        std::hint::black_box(sensor.measure(frame));
        watch.elapsed_s()
    };
    (0..TIMED).map(once).fold(f64::INFINITY, f64::min)
}

/// S° of a look at buildings, with u1 but for the errors of x and y.
fn margin(config: &AgentConfig, half_m: f64, radius_m: f64) -> Region {
    let mut config = config.clone();
    config.targets.obstacle_distance_m = radius_m;
    let mut error = settings::half_widths([0.1; 6]);
    (error.p_world[0], error.p_world[1]) = (half_m, half_m);
    let mut renderer = Renderer::new(config.camera);
    let frame = renderer.frame(&scene::buildings(), &scene::pose(), Step(0), 1, AgentId(0));
    let frame = Frame { pose_error: error, ..frame };
    Sensor::new(&config).measure(&frame).obstacle_margin.into_region()
}
