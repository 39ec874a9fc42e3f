//! The camera at a pose, and the projection of edges and planes.

use csat_proto::camera::CameraView;
use nalgebra::Vector3;

/// An axis-aligned box in the image, pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct ImageBox {
    pub min: [f64; 2],
    pub max: [f64; 2],
}

impl ImageBox {
    pub const EMPTY: Self = Self { min: [f64::INFINITY; 2], max: [f64::NEG_INFINITY; 2] };
    pub const EVERYWHERE: Self = Self { min: [f64::NEG_INFINITY; 2], max: [f64::INFINITY; 2] };
    /// Boxes this close count as overlapping, pixels.
    const MARGIN_PX: f64 = 1e-3;

    pub fn add(&mut self, point: [f64; 2]) {
        self.min = [self.min[0].min(point[0]), self.min[1].min(point[1])];
        self.max = [self.max[0].max(point[0]), self.max[1].max(point[1])];
    }

    pub fn overlaps(&self, other: &Self) -> bool {
        (0..2).all(|axis| {
            self.min[axis] <= other.max[axis] + Self::MARGIN_PX
                && other.min[axis] <= self.max[axis] + Self::MARGIN_PX
        })
    }

    pub fn contains(&self, point: [f64; 2]) -> bool {
        self.overlaps(&Self { min: point, max: point })
    }
}

/// A vertex in both frames, metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vertex {
    pub world: Vector3<f64>,
    pub camera: Vector3<f64>,
}

impl Vertex {
    /// The point at parameter `u` of the segment to `other`.
    pub fn towards(&self, other: &Self, u: f64) -> Self {
        Self {
            world: self.world + (other.world - self.world) * u,
            camera: self.camera + (other.camera - self.camera) * u,
        }
    }
}

/// The visible range of a straight edge: clipped to just outside the image.
#[derive(Debug, Clone, Copy)]
pub(super) struct ImageEdge {
    /// Both ends in the image, pixels.
    pub ends: [[f64; 2]; 2],
    /// 1/z of both ends, z along the optical axis, 1/m. Affine along the edge's image.
    pub inv_z: [f64; 2],
    /// Both ends in `world`, metres.
    pub world: [Vector3<f64>; 2],
    /// The box around `ends`.
    pub bounds: ImageBox,
}

impl ImageEdge {
    /// The image point at parameter `s` of the image segment.
    pub fn image_at(&self, s: f64) -> [f64; 2] {
        lerp(self.ends[0], self.ends[1], s)
    }

    /// The `world` point whose image is `image_at(s)`.
    pub fn world_at(&self, s: f64) -> Vector3<f64> {
        let inv_z = self.inv_z[0] + s * (self.inv_z[1] - self.inv_z[0]);
        let u = (s * self.inv_z[1] / inv_z).clamp(0.0, 1.0);
        self.world[0] + (self.world[1] - self.world[0]) * u
    }
}

/// A camera at a pose.
#[derive(Debug, Clone)]
pub(super) struct Lens {
    pub view: CameraView,
    /// Optical centre in `world`, metres.
    pub centre: Vector3<f64>,
    /// Points with a smaller z in the camera frame are cut away, metres. Nothing visible is nearer.
    pub near_m: f64,
    columns: f64,
    rows: f64,
    focal_px: f64,
}

impl Lens {
    /// How far outside the image edges are cut, pixels.
    const RIM_PX: f64 = 1.0;

    pub fn new(view: CameraView) -> Self {
        let model = *view.model();
        Self {
            centre: view.centre_world(),
            near_m: 0.0,
            columns: f64::from(model.columns),
            rows: f64::from(model.rows),
            focal_px: model.focal_px(),
            view,
        }
    }

    /// Sets `near_m` for a camera that is `clearance_m` above or beside every prism in view: a point in
    /// view is at least that far away, and at most |ray| times its z.
    pub fn set_clearance(&mut self, clearance_m: f64) {
        let longest = self.ray_norm_squared(-Self::RIM_PX, -Self::RIM_PX).sqrt();
        self.near_m = 0.5 * clearance_m / longest;
    }

    /// |ray|² of image point (c, r), the ray's component along the optical axis being 1.
    pub fn ray_norm_squared(&self, c: f64, r: f64) -> f64 {
        let x = (self.columns / 2.0 - c) / self.focal_px;
        let y = (self.rows / 2.0 - r) / self.focal_px;
        1.0 + x * x + y * y
    }

    pub fn vertex(&self, x: f64, y: f64, z: f64) -> Vertex {
        let world = Vector3::new(x, y, z);
        Vertex { world, camera: self.view.to_camera(&world) }
    }

    /// The plane `normal · X = offset` (`world`) as g with 1/z = g · (c, r, 1).
    pub fn plane(&self, normal: &Vector3<f64>, offset: f64) -> [f64; 3] {
        let g = self.view.ray_matrix().tr_mul(normal) / (offset - normal.dot(&self.centre));
        [g.x, g.y, g.z]
    }

    /// The sides of the view cone that a point is outside of, a bit each. Points that share a bit
    /// span no visible set.
    pub fn outcode(&self, camera: &Vector3<f64>) -> u8 {
        let x = self.focal_px * camera.x;
        let y = self.focal_px * camera.y;
        let half_c = (self.columns / 2.0 + Self::RIM_PX) * camera.z;
        let half_r = (self.rows / 2.0 + Self::RIM_PX) * camera.z;
        u8::from(x > half_c)
            | u8::from(x < -half_c) << 1
            | u8::from(y > half_r) << 2
            | u8::from(y < -half_r) << 3
            | u8::from(camera.z <= 0.0) << 4
    }

    /// The part of the edge from `a` to `b` that is in front of the camera and near the image.
    pub fn edge(&self, a: &Vertex, b: &Vertex) -> Option<ImageEdge> {
        let (da, db) = (a.camera.z - self.near_m, b.camera.z - self.near_m);
        if da <= 0.0 && db <= 0.0 {
            return None;
        }
        let a_near = if da < 0.0 { a.towards(b, da / (da - db)) } else { *a };
        let b_near = if db < 0.0 { b.towards(a, db / (db - da)) } else { *b };
        let whole = ImageEdge {
            ends: [
                self.view.project_camera(&a_near.camera),
                self.view.project_camera(&b_near.camera),
            ],
            inv_z: [1.0 / a_near.camera.z, 1.0 / b_near.camera.z],
            world: [a_near.world, b_near.world],
            bounds: ImageBox::EMPTY,
        };
        let [from, to] = self.clip(whole.ends)?;
        let mut edge = whole;
        for (end, s) in [from, to].into_iter().enumerate() {
            if s > 0.0 && s < 1.0 {
                edge.ends[end] = whole.image_at(s);
                edge.inv_z[end] = whole.inv_z[0] + s * (whole.inv_z[1] - whole.inv_z[0]);
                edge.world[end] = whole.world_at(s);
            }
            edge.bounds.add(edge.ends[end]);
        }
        Some(edge)
    }

    /// The range of parameters of a segment inside the image and its rim (Liang-Barsky).
    fn clip(&self, [a, b]: [[f64; 2]; 2]) -> Option<[f64; 2]> {
        let (mut from, mut to) = (0.0f64, 1.0f64);
        for (axis, size) in [self.columns, self.rows].into_iter().enumerate() {
            let d = b[axis] - a[axis];
            let low = -Self::RIM_PX - a[axis];
            let high = size + Self::RIM_PX - a[axis];
            if d == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (first, last) = if d > 0.0 { (low / d, high / d) } else { (high / d, low / d) };
            from = from.max(first);
            to = to.min(last);
        }
        (from <= to).then_some([from, to])
    }

    /// Cuts a closed ring (camera frame) at `near_m` (Sutherland-Hodgman) and appends the edges of
    /// its image. Neighbouring faces get bit-equal edges: each cut goes from the kept end.
    pub fn ring_image(&self, ring: &[Vector3<f64>], edges: &mut Vec<[[f64; 2]; 2]>) {
        let mut first = None;
        let mut last: Option<[f64; 2]> = None;
        let mut emit = |camera: &Vector3<f64>| {
            let point = self.view.project_camera(camera);
            if let Some(previous) = last {
                edges.push([previous, point]);
            } else {
                first = Some(point);
            }
            last = Some(point);
        };
        for (i, a) in ring.iter().enumerate() {
            let b = &ring[(i + 1) % ring.len()];
            let (da, db) = (a.z - self.near_m, b.z - self.near_m);
            if da >= 0.0 {
                emit(a);
                if db < 0.0 {
                    emit(&(a + (b - a) * (da / (da - db))));
                }
            } else if db >= 0.0 {
                emit(&(b + (a - b) * (db / (db - da))));
            }
        }
        if let (Some(first), Some(last)) = (first, last) {
            edges.push([last, first]);
        }
    }
}

/// a + s (b - a).
pub(super) fn lerp(a: [f64; 2], b: [f64; 2], s: f64) -> [f64; 2] {
    [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])]
}
