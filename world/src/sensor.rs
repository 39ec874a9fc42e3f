//! What a UAV carries: a camera whose pixels are labelled, one with a detector, or one that segments roads.

use csat_proto::camera::{CameraModel, Pose, PoseEstimate};
use csat_proto::detector::DetectorModel;
use csat_proto::frame::Frame;
use csat_proto::ids::AgentId;
pub use csat_proto::model::RoadSensor;
use csat_proto::time::Step;
use nalgebra::Vector3;
use rand::RngExt;

use crate::camera::Renderer;
use crate::camera::noise::{NoisePurpose, Stream};
use crate::road_area::RoadArea;
use crate::scene::Scene;
use crate::target::TargetTruth;

mod misidentify;
mod roads;

use misidentify::misidentify;
pub use roads::mistakes;

/// The kind of a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SensorModel {
    /// A camera whose computer-vision system labels every pixel.
    Labels(CameraModel),
    /// A camera with a detector that reports one image point or nothing.
    Detector(CameraModel, DetectorModel),
    /// A camera that looks straight down and segments roads.
    Roads(CameraModel, RoadSensor),
}

impl SensorModel {
    /// Its camera.
    pub fn camera(&self) -> &CameraModel {
        match self {
            Self::Labels(camera) | Self::Detector(camera, _) | Self::Roads(camera, _) => camera,
        }
    }
}

/// What there is to be seen at step k.
#[derive(Debug, Clone, Copy)]
pub struct Sight<'a> {
    /// k.
    pub step: Step,
    /// The seed of the mission.
    pub seed: u64,
    /// All solids.
    pub scene: &'a Scene,
    /// All targets, by index.
    pub targets: &'a [TargetTruth],
    /// R, for cameras that segment roads; without it they see none.
    pub roads: Option<&'a RoadArea>,
}

/// A sensor of one UAV.
#[derive(Debug, Clone)]
pub enum Sensor {
    /// It labels pixels.
    Labels(Box<LabelCamera>),
    /// It detects targets.
    Detector(CameraModel, DetectorModel),
    /// It segments roads.
    Roads(CameraModel, RoadSensor),
}

/// A camera that labels pixels.
#[derive(Debug, Clone)]
pub struct LabelCamera {
    renderer: Renderer,
    has_misidentified: bool,
}

impl LabelCamera {
    fn frame(&mut self, sight: &Sight<'_>, stream: Stream, pose: &Pose) -> Frame {
        let Stream { seed, agent, step } = stream;
        let mut frame = self.renderer.frame(sight.scene, pose, step, seed, agent);
        let p = self.renderer.model().misidentify;
        self.has_misidentified |=
            misidentify(p, &mut frame.detections, sight.targets.len() as u16, stream);
        frame
    }
}

impl Sensor {
    /// A sensor of that kind.
    pub fn new(model: SensorModel) -> Self {
        match model {
            SensorModel::Labels(camera) => {
                let renderer = Renderer::new(camera);
                Self::Labels(Box::new(LabelCamera { renderer, has_misidentified: false }))
            }
            SensorModel::Detector(camera, detector) => Self::Detector(camera, detector),
            SensorModel::Roads(camera, roads) => Self::Roads(camera, roads),
        }
    }

    /// The frame that UAV `agent` gets: seen from its true `pose`, and said to be from the `reported` one.
    ///
    /// A function of its arguments alone: seed, agent and step select the random stream.
    pub fn frame(
        &mut self,
        sight: &Sight<'_>,
        agent: AgentId,
        pose: &Pose,
        reported: &PoseEstimate,
    ) -> Frame {
        let &Sight { step, seed, targets, roads, .. } = sight;
        let stream = Stream { seed, agent, step };
        let &PoseEstimate { pose: reported, error: pose_error } = reported;
        match self {
            Self::Labels(camera) => {
                Frame { pose: reported, pose_error, ..camera.frame(sight, stream, pose) }
            }
            Self::Detector(camera, detector) => {
                let sighting = sighting(camera, detector, pose, targets, stream);
                Frame { pose_error, ..Frame::of_detector(step, reported, sighting) }
            }
            Self::Roads(camera, model) => {
                let labels = roads::labels(camera, model, pose, roads, stream);
                Frame { labels, pose_error, ..Frame::of_detector(step, reported, None) }
            }
        }
    }
}

impl Sensor {
    /// Whether a frame so far has taken a target for another one.
    pub fn has_misidentified(&self) -> bool {
        matches!(self, Self::Labels(camera) if camera.has_misidentified)
    }
}

/// The image point (c, r), pixels, that a detector reports from a true pose.
///
/// A target is visible if the image point of its location on the ground is in the image; nothing hides it,
/// and d_max does not limit it. A visible target is detected with the probability `p_detected` of the
/// resolution at its image point, independently of others, and the sighting is the exact image point of the
/// first one detected, by index. If none is detected, there is with probability `p_false` a false alarm at a
/// uniform image point. One uniform number decides: the events take disjoint parts of [0, 1).
fn sighting(
    camera: &CameraModel,
    detector: &DetectorModel,
    pose: &Pose,
    targets: &[TargetTruth],
    stream: Stream,
) -> Option<[f64; 2]> {
    let mut rng = stream.rng(NoisePurpose::Sighting);
    let u: f64 = rng.random();
    let view = camera.at(pose);
    let size = [f64::from(camera.columns), f64::from(camera.rows)];
    let mut decided = 0.0;
    for target in targets {
        let [x, y] = target.location;
        let point = view.project(&Vector3::new(x, y, 0.0));
        let is_inside = |p: &[f64; 2]| (0..2).all(|axis| (0.0..=size[axis]).contains(&p[axis]));
        let Some([c, r]) = point.filter(is_inside) else { continue };
        decided += (1.0 - decided) * detector.p_detected(view.resolution_px_m2(c, r));
        if u < decided {
            return Some([c, r]);
        }
    }
    let is_false = u < decided + detector.p_false;
    is_false.then(|| size.map(|side| side * rng.random::<f64>()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::ids::TargetId;

    const CAMERA: CameraModel = CameraModel {
        columns: 320,
        rows: 240,
        aperture_deg: 40.0,
        tilt_deg: 90.0,
        d_max_m: 1000.0,
        depth_noise: [0.0, 0.0],
        min_pixels: 1,
        box_error_px: 0,
        assumption: csat_proto::camera::Assumption::EveryRay,
        misidentify: 0.0,
    };

    fn at(id: u16, location: [f64; 2]) -> TargetTruth {
        TargetTruth { id: TargetId(id), location, heading_rad: 0.0, speed_m_s: 0.0 }
    }

    fn pose() -> Pose {
        Pose { p_world: [10.0, 20.0, 60.0], yaw_rad: 0.3, pitch_rad: -0.05, roll_rad: 0.1 }
    }

    fn sightings(
        detector: DetectorModel,
        targets: &[TargetTruth],
        frames: u32,
    ) -> Vec<Option<[f64; 2]>> {
        let mut sensor = Sensor::new(SensorModel::Detector(CAMERA, detector));
        let scene = Scene::default();
        let mut frame = |step| {
            let sight = Sight { step: Step(step), seed: 3, scene: &scene, targets, roads: None };
            let reported = Pose { yaw_rad: 0.4, ..pose() };
            let frame = sensor.frame(&sight, AgentId(1), &pose(), &reported.into());
            assert_eq!((frame.pose, frame.labels.len()), (reported, 0));
            frame.sighting
        };
        (0..frames).map(&mut frame).collect()
    }

    /// Whether `share` of `n` trials is a fair estimate of p: four standard deviations.
    fn is_near(count: usize, n: u32, p: f64) -> bool {
        let n = f64::from(n);
        (count as f64 / n - p).abs() < 4.0 * (p * (1.0 - p) / n).sqrt()
    }

    #[test]
    fn detections_and_false_alarms_come_at_their_rates() {
        const FRAMES: u32 = 20_000;
        let (p_detection, p_false) = (0.8, 0.05);
        let detector = DetectorModel { p_detection, p_false, ..DetectorModel::default() };
        let target = at(0, [12.0, 24.0]);
        let view = CAMERA.at(&pose());
        let [c, r] = view.project(&Vector3::new(12.0, 24.0, 0.0)).unwrap();
        let p = detector.p_detected(view.resolution_px_m2(c, r));
        assert!(p > 0.5 && p + p_false < 0.95, "the test needs misses: {p}");
        let seen = sightings(detector, &[target], FRAMES);
        let exact = seen.iter().flatten().filter(|point| **point == [c, r]).count();
        assert!(is_near(exact, FRAMES, p), "{exact} of {FRAMES}, {p}");
        let others: Vec<_> = seen.iter().flatten().filter(|point| **point != [c, r]).collect();
        assert!(is_near(others.len(), FRAMES, 0.05), "{}", others.len());
        let left = others.iter().filter(|point| point[0] < 80.0).count();
        assert!(is_near(left, others.len() as u32, 0.25), "{left} of {}", others.len());
        assert!(others.iter().all(|point| point[0] < 320.0 && point[1] < 240.0));
    }

    #[test]
    fn what_is_outside_the_image_is_not_detected() {
        let detector = DetectorModel { p_detection: 1.0, p_false: 0.0, ..DetectorModel::default() };
        let [outside, inside] = [at(0, [500.0, 0.0]), at(1, [10.0, 20.0])];
        assert!(sightings(detector, &[outside], 10).iter().all(Option::is_none));
        assert!(sightings(detector, &[inside], 10).iter().all(Option::is_some));
        let both = sightings(detector, &[outside, inside], 1);
        assert_eq!(both, sightings(detector, &[inside], 1));
        let two = sightings(detector, &[at(0, [12.0, 24.0]), inside], 1);
        assert_ne!(both, two, "the first one by index");
    }

    #[test]
    fn a_labelled_frame_is_seen_from_the_true_pose_and_has_the_reported_one() {
        let scene = Scene { prisms: vec![at(0, [10.0, 20.0]).prism([4.6, 1.8, 1.5])] };
        let sight = Sight { step: Step(2), seed: 3, scene: &scene, targets: &[], roads: None };
        let mut sensor = Sensor::new(SensorModel::Labels(CAMERA));
        let reported = Pose { yaw_rad: 1.4, ..pose() };
        let frame = sensor.frame(&sight, AgentId(0), &pose(), &reported.into());
        let expected = Renderer::new(CAMERA).frame(&scene, &pose(), Step(2), 3, AgentId(0));
        assert_eq!(frame, Frame { pose: reported, ..expected });
        assert!(frame.labels.contains(&csat_proto::frame::Label::Target));
    }
}
