//! One frame to measured sets (docs/concepts/sensing.md, thesis §4.2-4.4, §4.6 and A.2).
//!
//! | module | from | to |
//! |---|---|---|
//! | [`outline`] | Ground pixels | their outline in the image |
//! | [`clear`] | the outline | clear ground C (4.6), inner |
//! | [`pyramid`] | a pixel and its depth | the points that may have lit it (A.2, A.3) |
//! | `target` | Target pixels of a detection | X^{t,m} (4.4), outer |
//! | [`exclusion`] | X^{t,m} \\ C | X̲^t (4.17), inner |
//! | `obstacle` | Obstacle pixels | S° (4.12), inner, and occupied cells (4.39) |
//! | `pixel_bounds` | Obstacle pixels | bounds on what they may add, in single precision |
//! | [`pose_box`] | the box of poses | what all of them show, or any (6.9), (6.19) |
//! | `hidden` | all labels | H^CVS (4.23), seen ground, empty cells (4.40) |

pub mod clear;
pub mod exclusion;
mod foot;
mod hidden;
mod hull;
mod obstacle;
pub mod outline;
mod pixel_bounds;
pub mod pose_box;
pub mod pyramid;
mod target;

use csat_proto::camera::{CameraModel, CameraView, PoseError};
use csat_proto::frame::{Frame, Label};
use csat_proto::ids::TargetId;
use csat_proto::oem::OemDelta;
use csat_proto::raster::{Grid, Raster};
use csat_proto::region::{Region, Ring};

use crate::config::AgentConfig;
use crate::mutant::{Mutant, is_on};
use crate::region::{Disc, Inner, Outer};
use pose_box::PoseBox;
use target::TargetPixels;

/// The label of the pixel that an image point (c, r), pixels, falls into; `None` outside the image.
fn label_at(view: &CameraView, frame: &Frame, [c, r]: [f64; 2]) -> Option<Label> {
    let (columns, rows) = (view.model().columns, view.model().rows);
    let inside = c >= 0.0 && r >= 0.0 && c < f64::from(columns) && r < f64::from(rows);
    inside.then(|| frame.labels[r as usize * usize::from(columns) + c as usize])
}

/// An identified target in one frame.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredTarget {
    /// j.
    pub target: TargetId,
    /// X^{t,m}_j: contains the location of j.
    pub location: Outer,
    /// X̲^t_j: contains no other target's location.
    pub exclusion: Inner,
}

/// What one frame proves.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// C: contains no target location.
    pub clear_ground: Inner,
    /// S°: contains no target location at any step. Without parts that were measured as well before.
    pub obstacle_margin: Inner,
    /// The identified targets, by increasing index.
    pub targets: Vec<MeasuredTarget>,
    /// H^CVS: ground hidden in this frame.
    pub hidden: Raster,
    /// Ground seen in this frame.
    pub seen: Raster,
    /// States to join into the OEM.
    pub oem: Vec<OemDelta>,
}

impl Measured {
    /// The measurement of a step without a frame; rasters are on `grid`.
    pub fn nothing(grid: Grid) -> Self {
        Self {
            clear_ground: Inner::default(),
            obstacle_margin: Inner::default(),
            targets: Vec::new(),
            hidden: Raster::empty(grid),
            seen: Raster::empty(grid),
            oem: Vec::new(),
        }
    }
}

/// Turns frames into measured sets. Its only state is where obstacle margins were measured before, so
/// that it does not measure them again.
#[derive(Debug, Clone)]
pub struct Sensor {
    config: AgentConfig,
    ground: Region,
    cylinder: Disc,
    margins: obstacle::MarginSensor,
}

impl Sensor {
    /// A sensor before its first frame.
    pub fn new(config: &AgentConfig) -> Self {
        let vertices = config.estimator.disc_vertices;
        Self {
            ground: Region::rectangle(config.ground.size_m),
            cylinder: Disc::circumscribed(config.targets.radius_m, vertices),
            margins: obstacle::MarginSensor::new(config),
            config: config.clone(),
        }
    }

    /// What `frame` proves. Obstacle pixels prove something only if the agent
    /// [uses them](AgentConfig::uses_obstacle_pixels).
    pub fn measure(&mut self, frame: &Frame) -> Measured {
        let view = self.config.camera.at(&frame.pose);
        let poses = PoseBox::new(&view, &frame.pose, &self.pose_error(frame));
        let (mut hidden, mut seen) =
            hidden::hidden_and_seen(&view, frame, self.config.raster_grid());
        let outline = self.outline(frame);
        let mut clear_ground = clear::clear_ground(&view, &outline, &self.ground);
        if !poses.is_exact() {
            let swept = clear::swept(&poses, &view, &outline);
            clear_ground = match &swept {
                Some(_) if is_on(Mutant::ClearFromSomePose) => clear_ground,
                Some(swept) => clear_ground.without(&swept.all),
                None => Inner::default(),
            };
            let silhouettes = swept.iter().flat_map(|swept| swept.silhouettes());
            hidden.union_with(&hidden::behind(silhouettes, &seen));
            seen.intersect_with(&hidden::cells_in(&clear_ground, *seen.grid()));
            hidden.subtract(&seen);
        }
        let clear_ground = clear_ground.limited(self.max_vertices());
        let mut measured = Measured {
            targets: self.targets(&view, &poses, frame, &clear_ground),
            clear_ground,
            obstacle_margin: Inner::default(),
            hidden,
            seen,
            oem: Vec::new(),
        };
        if self.config.uses_obstacle_pixels() {
            let oem_grid = self.config.oem_grid();
            let found = self.margins.measure(&view, &poses, frame, &self.ground);
            measured.obstacle_margin = found.margin.limited(self.max_vertices());
            measured.oem = found.occupied;
            measured.oem.extend(match poses.is_exact() {
                true => hidden::empty_cells(&view, frame, oem_grid),
                false => hidden::empty_cells_in(&measured.clear_ground, oem_grid),
            });
        }
        measured
    }

    /// The limit of vertices. It applies to the sets as they are sent, so that receivers apply the
    /// same sets as the sender.
    fn max_vertices(&self) -> usize {
        self.config.estimator.max_vertices as usize
    }

    /// The half-widths of the box of the frame's pose.
    fn pose_error(&self, frame: &Frame) -> PoseError {
        let mut error = frame.pose_error;
        if is_on(Mutant::BoxNotGrownBetweenFixes) {
            let fix = self.config.pose_error.p_world;
            for (half, fix) in error.p_world.iter_mut().zip(fix) {
                *half = half.min(fix);
            }
        }
        if is_on(Mutant::NominalPoseUsed) { PoseError::NONE } else { error }
    }

    /// The simplified outline of the Ground pixels.
    fn outline(&self, frame: &Frame) -> Vec<Ring> {
        let CameraModel { columns, rows, .. } = self.config.camera;
        let outline = outline::ground_outline(&frame.labels, columns.into(), rows.into());
        outline::simplified_inward(&outline, self.config.estimator.outline_tolerance_px)
    }

    fn targets(
        &self,
        view: &CameraView,
        poses: &PoseBox,
        frame: &Frame,
        clear_ground: &Inner,
    ) -> Vec<MeasuredTarget> {
        let knowledge = &self.config.targets;
        let vertices = self.config.estimator.disc_vertices;
        let measure = |detection: &csat_proto::frame::Detection| {
            let pixels = TargetPixels::new(view, frame, detection.pixels);
            let location = target::location(&pixels, poses, &self.cylinder, &self.ground)
                .simplified(self.config.estimator.simplify_m)
                .limited(self.max_vertices(), &self.ground);
            // X^t, which is little more than the car and its shadow.
            let closer = location.minus([clear_ground]);
            let exclusion = exclusion::exclusion(&closer, knowledge.target_distance_m, vertices);
            MeasuredTarget { target: detection.target, location, exclusion }
        };
        frame.detections.iter().map(measure).collect()
    }
}
