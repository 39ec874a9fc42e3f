//! Labels and depths of all pixels; see the [module documentation](super) for why they are exact.

use csat_proto::camera::{Assumption, CameraModel, Pose};
use csat_proto::frame::{Frame, Label};
use csat_proto::ids::AgentId;
use csat_proto::time::Step;

use super::depth::DepthBuffer;
use super::hidden::Visibility;
use super::lens::Lens;
use super::outline::{Face, Outline};
use super::reach::{RowReach, pixel_within};
use super::{cover, detect, noise};
use crate::scene::{Entity, Scene};

/// The label and the distance of each pixel, without noise. Row-major, as in [`Frame`].
#[derive(Debug, Clone)]
pub struct Classified {
    labels: Vec<Label>,
    depth: DepthBuffer,
    faces: Vec<Face>,
    /// |ray| through each centre, the component along the optical axis being 1.
    ray_norm: Vec<f64>,
}

impl Classified {
    /// One label per pixel, under the camera's assumption.
    pub fn labels(&self) -> &[Label] {
        &self.labels
    }

    /// The entity that the ray through the centre of a pixel meets first, at any distance; `None` for
    /// ground and sky. Where [`Self::labels`] is Obstacle or Target under Assumption 4, every ray of
    /// the pixel meets it.
    pub fn entity(&self, pixel: usize) -> Option<Entity> {
        self.faces[self.depth.face[pixel] as usize].entity
    }

    /// ρ, the distance along the ray through the centre of a pixel, metres; infinite for sky.
    ///
    /// Exact where `labels` is not Unknown; elsewhere, prisms entirely beyond d_max may be left out.
    pub fn rho_m(&self, pixel: usize) -> f64 {
        self.ray_norm[pixel] / self.depth.inv_z[pixel]
    }

    /// ρ of a row of pixels from `start` on.
    pub(super) fn rho_from(&self, start: usize) -> impl Iterator<Item = f64> {
        self.ray_norm[start..].iter().zip(&self.depth.inv_z[start..]).map(|(norm, inv)| norm / inv)
    }
}

/// Renders frames of one camera. Its buffers are reused; no result depends on an earlier one.
#[derive(Debug, Clone)]
pub struct Renderer {
    model: CameraModel,
    seen: Classified,
    outline: Outline,
    visibility: Visibility,
    /// The label of each face, for pixels that no contour and no d_max makes Unknown.
    plain: Vec<Label>,
    /// Whether a visible contour touches the pixel.
    contour: Vec<bool>,
    /// Whether a crease touches the pixel and a face at it may leave d_max there.
    far_crease: Vec<bool>,
}

impl Renderer {
    /// A renderer for `model`.
    pub fn new(model: CameraModel) -> Self {
        let (columns, rows) = (usize::from(model.columns), usize::from(model.rows));
        let lens = Lens::new(model.at(&Pose::default()));
        let norm = |pixel: usize| {
            let (c, r) = ((pixel % columns) as f64 + 0.5, (pixel / columns) as f64 + 0.5);
            lens.ray_norm_squared(c, r).sqrt()
        };
        let seen = Classified {
            labels: vec![Label::Unknown; model.pixels()],
            depth: DepthBuffer::new(columns, rows),
            faces: vec![Face { entity: None, plane: [0.0; 3], far: false }],
            ray_norm: (0..model.pixels()).map(norm).collect(),
        };
        Self {
            model,
            seen,
            outline: Outline::default(),
            visibility: Visibility::default(),
            plain: Vec::new(),
            contour: vec![false; model.pixels()],
            far_crease: vec![false; model.pixels()],
        }
    }

    /// The camera.
    pub fn model(&self) -> &CameraModel {
        &self.model
    }

    /// Classifies every pixel of the view of `scene` from `pose`.
    ///
    /// The camera must be above the ground and above or beside every prism in view by
    /// [`super::MIN_CLEARANCE_M`], and the pose finite; otherwise every pixel is Unknown, which is
    /// sound.
    pub fn render(&mut self, scene: &Scene, pose: &Pose) -> &Classified {
        let mut lens = Lens::new(self.model.at(pose));
        if self.model.pixels() == 0 {
            return &self.seen;
        }
        if !is_finite(pose) || !self.outline.build(&mut lens, scene, &mut self.seen.depth) {
            self.blind();
            return &self.seen;
        }
        std::mem::swap(&mut self.seen.faces, &mut self.outline.faces);
        self.mark_contours(&lens, scene);
        self.mark_far_creases(&lens);
        self.label(&lens);
        &self.seen
    }

    /// What the CVS of `agent` reports at `step`: [`Self::render`] with depth noise (3.33),
    /// quantisation and detections (3.53).
    ///
    /// A function of its arguments alone: `seed`, `agent` and `step` select the random stream.
    pub fn frame(
        &mut self,
        scene: &Scene,
        pose: &Pose,
        step: Step,
        seed: u64,
        agent: AgentId,
    ) -> Frame {
        self.render(scene, pose);
        let mut labels = self.seen.labels.clone();
        let stream = noise::Stream { seed, agent, step };
        let depth = noise::measure(&self.model, &self.seen, stream, &mut labels);
        let target_of = |pixel: usize| match self.seen.entity(pixel) {
            Some(Entity::Target(target)) => Some(target),
            _ => None,
        };
        let detections = detect::detections(&self.model, &labels, target_of, stream);
        Frame { labels, depth, detections, ..Frame::of_detector(step, *pose, None) }
    }

    /// Makes every pixel Unknown.
    fn blind(&mut self) {
        self.seen.labels.fill(Label::Unknown);
        self.seen.faces.clear();
        self.seen.faces.push(Face { entity: None, plane: [0.0; 3], far: false });
        self.seen.depth.clear([0.0; 3]);
    }

    fn mark_contours(&mut self, lens: &Lens, scene: &Scene) {
        let (columns, rows) = (usize::from(self.model.columns), usize::from(self.model.rows));
        self.contour.fill(false);
        let contour = &mut self.contour;
        self.visibility.for_visible(&self.outline, scene, &lens.centre, |a, b| {
            cover::for_touched(columns, rows, a, b, |row, first, last| {
                contour[row * columns + first..=row * columns + last].fill(true);
            });
        });
    }

    fn mark_far_creases(&mut self, lens: &Lens) {
        let (columns, rows) = (usize::from(self.model.columns), usize::from(self.model.rows));
        self.far_crease.fill(false);
        for crease in &self.outline.creases {
            let [a, b] = crease.edge.ends;
            let planes = crease.faces.map(|face| self.seen.faces[face as usize].plane);
            cover::for_touched(columns, rows, a, b, |row, first, last| {
                for column in first..=last {
                    let within = |plane| pixel_within(lens, plane, self.model.d_max_m, column, row);
                    self.far_crease[row * columns + column] |= !planes.into_iter().all(within);
                }
            });
        }
    }

    fn label(&mut self, lens: &Lens) {
        let columns = usize::from(self.model.columns);
        let every_ray = self.model.assumption == Assumption::EveryRay;
        self.plain.clear();
        self.plain.extend(self.seen.faces.iter().map(|face| match face.entity {
            None => Label::Ground,
            Some(Entity::Obstacle(_)) => Label::Obstacle,
            Some(Entity::Target(_)) => Label::Target,
        }));
        let any_far = self.seen.faces.iter().any(|face| face.far);
        let mut ground = RowReach::new(lens, self.seen.faces[0].plane, self.model.d_max_m, columns);
        for row in 0..usize::from(self.model.rows) {
            let reached = ground.next_row(lens, row);
            let line = row * columns..(row + 1) * columns;
            let faces = &self.seen.depth.face[line.clone()];
            let labels = &mut self.seen.labels[line.clone()];
            for ((label, face), contour) in labels.iter_mut().zip(faces).zip(&self.contour[line]) {
                let plain = self.plain[*face as usize];
                let blocked = *contour && (every_ray || plain == Label::Ground);
                *label = if blocked { Label::Unknown } else { plain };
            }
            for column in (0..reached.start.min(columns)).chain(reached.end..columns) {
                if faces[column] == 0 {
                    labels[column] = Label::Unknown;
                }
            }
            if any_far {
                self.limit(lens, row, every_ray);
            }
        }
    }

    /// Applies d_max to the obstacles and targets of a row.
    fn limit(&mut self, lens: &Lens, row: usize, every_ray: bool) {
        let columns = usize::from(self.model.columns);
        let d_max_m = self.model.d_max_m;
        let seen = &mut self.seen;
        for column in 0..columns {
            let pixel = row * columns + column;
            let face = &seen.faces[seen.depth.face[pixel] as usize];
            if !face.far || seen.labels[pixel] == Label::Unknown {
                continue;
            }
            let good = if every_ray {
                !self.far_crease[pixel] && pixel_within(lens, face.plane, d_max_m, column, row)
            } else {
                seen.ray_norm[pixel] <= d_max_m * seen.depth.inv_z[pixel]
            };
            if !good {
                seen.labels[pixel] = Label::Unknown;
            }
        }
    }
}

fn is_finite(pose: &Pose) -> bool {
    let angles = [pose.yaw_rad, pose.pitch_rad, pose.roll_rad];
    pose.p_world.iter().chain(&angles).all(|x| x.is_finite())
}
