//! The parts of the prisms that a camera may see: faces that face it, contour edges, creases.

use std::ops::Range;

use csat_proto::region::is_inside;
use nalgebra::Vector3;

use super::MIN_CLEARANCE_M;
use super::depth::DepthBuffer;
use super::lens::{ImageBox, ImageEdge, Lens, Vertex};
use crate::plane::distance_to_segment_m;
use crate::scene::{Entity, Prism, Scene};

/// A face whose plane is this close to the camera is seen edge-on, metres.
const EDGE_ON_M: f64 = 1e-6;

/// A plane that is nearest at some pixel centres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Face {
    /// The entity of the face; `None` for the ground.
    pub entity: Option<Entity>,
    /// 1/z = g · (c, r, 1).
    pub plane: [f64; 3],
    /// Whether part of it may be beyond d_max. The ground is tested separately.
    pub far: bool,
}

/// A prism in view.
#[derive(Debug, Clone)]
pub(super) struct SeenPrism {
    /// Index in the scene.
    pub index: usize,
    /// Box around its image.
    pub bounds: ImageBox,
    /// Largest 1/z of its vertices, 1/m; infinite when it reaches behind the camera.
    pub max_inv_z: f64,
    /// Its contour edges in [`Outline::contours`].
    pub contours: Range<usize>,
    /// Whether part of it is beyond d_max.
    far: bool,
}

/// An edge between two faces that face the camera, one of them perhaps beyond d_max.
#[derive(Debug, Clone, Copy)]
pub(super) struct Crease {
    pub edge: ImageEdge,
    /// The numbers of both faces in [`Outline::faces`].
    pub faces: [u32; 2],
}

/// How a face is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Facing {
    Towards,
    Away,
    EdgeOn,
}

impl Facing {
    /// Of a face that the camera is this far in front of, metres.
    fn of(ahead_m: f64) -> Self {
        if ahead_m > EDGE_ON_M {
            Self::Towards
        } else if ahead_m < -EDGE_ON_M {
            Self::Away
        } else {
            Self::EdgeOn
        }
    }

    /// Whether an edge between two faces is contour: unless both face the camera, or both away.
    fn is_contour(self, other: Self) -> bool {
        self != other || self == Self::EdgeOn
    }
}

/// A vertical edge of a prism and the wall from it to the next one.
#[derive(Debug, Clone, Copy)]
struct Corner {
    base: Vertex,
    top: Vertex,
    next: usize,
    previous: usize,
    facing: Facing,
    /// Number of the wall's face; meaningless unless `facing` is `Towards`.
    face: u32,
}

/// Everything in view, in buffers that are reused.
#[derive(Debug, Clone, Default)]
pub(super) struct Outline {
    pub prisms: Vec<SeenPrism>,
    /// Face 0 is the ground.
    pub faces: Vec<Face>,
    pub contours: Vec<ImageEdge>,
    pub creases: Vec<Crease>,
    corners: Vec<Corner>,
    rings: Vec<Range<usize>>,
    ring: Vec<Vector3<f64>>,
    edges: Vec<[[f64; 2]; 2]>,
}

impl Outline {
    /// Finds the prisms in view and draws their faces; `false` when the camera touches one of them.
    pub fn build(&mut self, lens: &mut Lens, scene: &Scene, depth: &mut DepthBuffer) -> bool {
        self.prisms.clear();
        self.faces.clear();
        self.contours.clear();
        self.creases.clear();
        let mut clearance_m = lens.centre.z;
        for (index, prism) in scene.prisms.iter().enumerate() {
            if let Some(seen) = self.sight(lens, index, prism) {
                clearance_m = clearance_m.min(clearance_of(prism, &lens.centre));
                self.prisms.push(seen);
            }
        }
        if clearance_m < MIN_CLEARANCE_M {
            return false;
        }
        lens.set_clearance(clearance_m);
        let ground = lens.plane(&Vector3::z(), 0.0);
        self.faces.push(Face { entity: None, plane: ground, far: false });
        depth.clear(ground);
        for slot in 0..self.prisms.len() {
            self.trace(lens, slot, &scene.prisms[self.prisms[slot].index], depth);
        }
        true
    }

    /// Whether any of a prism is in the view cone and within d_max.
    fn sight(&mut self, lens: &Lens, index: usize, prism: &Prism) -> Option<SeenPrism> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in prism.rings.first()? {
            for axis in 0..2 {
                low[axis] = low[axis].min(p[axis]);
                high[axis] = high[axis].max(p[axis]);
            }
        }
        let centre = lens.centre;
        let d_max_m = lens.view.model().d_max_m;
        let gap = |axis: usize| (low[axis] - centre[axis]).max(centre[axis] - high[axis]).max(0.0);
        let reach = |axis: usize| (centre[axis] - low[axis]).max(high[axis] - centre[axis]);
        let drop = (centre.z - prism.height_m).max(0.0);
        if Vector3::new(gap(0), gap(1), drop).norm() > d_max_m {
            return None;
        }
        let rise = centre.z.max(prism.height_m - centre.z);
        let far = Vector3::new(reach(0), reach(1), rise).norm() > d_max_m * (1.0 - 1e-9);
        // The outer ring bounds the holes.
        let mut outside = u8::MAX;
        for p in prism.rings.first()? {
            outside &= lens.outcode(&lens.vertex(p[0], p[1], 0.0).camera);
            outside &= lens.outcode(&lens.vertex(p[0], p[1], prism.height_m).camera);
            if outside == 0 {
                break;
            }
        }
        (outside == 0).then_some(SeenPrism {
            index,
            bounds: ImageBox::EMPTY,
            max_inv_z: 0.0,
            contours: 0..0,
            far,
        })
    }

    /// Draws the faces of a prism in view and collects its contour edges and creases.
    fn trace(&mut self, lens: &Lens, slot: usize, prism: &Prism, depth: &mut DepthBuffer) {
        self.walk_rings(lens, prism);
        let mut seen = self.prisms[slot].clone();
        for corner in &self.corners {
            for vertex in [&corner.base, &corner.top] {
                if vertex.camera.z < lens.near_m {
                    seen.bounds = ImageBox::EVERYWHERE;
                    seen.max_inv_z = f64::INFINITY;
                } else {
                    seen.bounds.add(lens.view.project_camera(&vertex.camera));
                    seen.max_inv_z = seen.max_inv_z.max(1.0 / vertex.camera.z);
                }
            }
        }
        let roof_facing = Facing::of(lens.centre.z - prism.height_m);
        let roof =
            (roof_facing == Facing::Towards).then(|| self.draw_roof(lens, prism, seen.far, depth));
        for i in 0..self.corners.len() {
            if self.corners[i].facing == Facing::Towards {
                self.corners[i].face = self.draw_wall(lens, prism.entity, i, seen.far, depth);
            }
        }
        let first = self.contours.len();
        self.collect_contours(lens, roof_facing);
        seen.contours = first..self.contours.len();
        if seen.far {
            self.collect_creases(lens, roof);
        }
        self.prisms[slot] = seen;
    }

    /// Lists the corners of all rings, repeated points left out.
    fn walk_rings(&mut self, lens: &Lens, prism: &Prism) {
        self.corners.clear();
        self.rings.clear();
        for ring in &prism.rings {
            let start = self.corners.len();
            let mut last = ring.last();
            for p in ring {
                if last != Some(p) {
                    let base = lens.vertex(p[0], p[1], 0.0);
                    let top = lens.vertex(p[0], p[1], prism.height_m);
                    let (next, previous) = (self.corners.len() + 1, self.corners.len().max(1) - 1);
                    let facing = Facing::EdgeOn;
                    self.corners.push(Corner { base, top, next, previous, facing, face: 0 });
                }
                last = Some(p);
            }
            let end = self.corners.len();
            if end > start {
                self.corners[end - 1].next = start;
                self.corners[start].previous = end - 1;
                self.rings.push(start..end);
            }
        }
        for i in 0..self.corners.len() {
            let (a, b) =
                (self.corners[i].base.world, self.corners[self.corners[i].next].base.world);
            // Distance of the camera in front of the wall; the solid is on the left of a -> b.
            let normal = Vector3::new(b.y - a.y, a.x - b.x, 0.0).normalize();
            let ahead_m = normal.dot(&(lens.centre - a));
            self.corners[i].facing = Facing::of(ahead_m);
        }
    }

    fn draw_roof(&mut self, lens: &Lens, prism: &Prism, far: bool, depth: &mut DepthBuffer) -> u32 {
        self.edges.clear();
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for corners in &self.rings {
            self.ring.clear();
            self.ring.extend(self.corners[corners.clone()].iter().map(|c| c.top.camera));
            widen(&mut range, &self.ring, lens.near_m);
            lens.ring_image(&self.ring, &mut self.edges);
        }
        let plane = lens.plane(&Vector3::z(), prism.height_m);
        self.draw(Face { entity: Some(prism.entity), plane, far }, range, depth)
    }

    fn draw_wall(
        &mut self,
        lens: &Lens,
        entity: Entity,
        corner: usize,
        far: bool,
        depth: &mut DepthBuffer,
    ) -> u32 {
        let a = self.corners[corner];
        let b = self.corners[a.next];
        self.ring.clear();
        self.ring.extend([a.base, b.base, b.top, a.top].map(|v| v.camera));
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        widen(&mut range, &self.ring, lens.near_m);
        self.edges.clear();
        lens.ring_image(&self.ring, &mut self.edges);
        let along = b.base.world - a.base.world;
        let normal = Vector3::new(along.y, -along.x, 0.0).normalize();
        let plane = lens.plane(&normal, normal.dot(&a.base.world));
        self.draw(Face { entity: Some(entity), plane, far }, range, depth)
    }

    /// Draws the polygon in `edges` and returns its face number.
    fn draw(&mut self, face: Face, range: [f64; 2], depth: &mut DepthBuffer) -> u32 {
        let number = self.faces.len() as u32;
        depth.fill(&self.edges, face.plane, range, number);
        self.faces.push(face);
        number
    }

    fn collect_contours(&mut self, lens: &Lens, roof: Facing) {
        for corner in &self.corners {
            let next = &self.corners[corner.next];
            let before = self.corners[corner.previous].facing;
            // The floor always faces away.
            if corner.facing.is_contour(Facing::Away) {
                self.contours.extend(lens.edge(&corner.base, &next.base));
            }
            if corner.facing.is_contour(roof) {
                self.contours.extend(lens.edge(&corner.top, &next.top));
            }
            if corner.facing.is_contour(before) {
                self.contours.extend(lens.edge(&corner.base, &corner.top));
            }
        }
    }

    /// `roof` is the face of the roof, if it faces the camera.
    fn collect_creases(&mut self, lens: &Lens, roof: Option<u32>) {
        for corner in self.corners.iter().filter(|corner| corner.facing == Facing::Towards) {
            let next = &self.corners[corner.next];
            let before = &self.corners[corner.previous];
            if let Some(roof) = roof {
                let edge = lens.edge(&corner.top, &next.top);
                self.creases.extend(edge.map(|edge| Crease { edge, faces: [roof, corner.face] }));
            }
            if before.facing == Facing::Towards {
                let upright = lens.edge(&corner.base, &corner.top);
                let faces = [before.face, corner.face];
                self.creases.extend(upright.map(|edge| Crease { edge, faces }));
            }
        }
    }
}

/// A lower bound on the distance of the camera from a prism, metres: above the roof, or beside the
/// walls of a higher prism. 0 inside.
fn clearance_of(prism: &Prism, centre: &Vector3<f64>) -> f64 {
    let above_m = centre.z - prism.height_m;
    if above_m >= MIN_CLEARANCE_M {
        return above_m;
    }
    let p = [centre.x, centre.y];
    let edges = prism.rings.iter().flat_map(|ring| {
        let ends = ring.iter().zip(ring.iter().cycle().skip(1));
        ends.map(|(&a, &b)| [a, b])
    });
    let edges: Vec<[[f64; 2]; 2]> = edges.collect();
    if is_inside(&edges, p) {
        return 0.0;
    }
    edges.iter().map(|&[a, b]| distance_to_segment_m(p, a, b)).fold(f64::INFINITY, f64::min)
}

/// Widens a range of 1/z by the vertices of a ring in the camera frame.
fn widen(range: &mut [f64; 2], ring: &[Vector3<f64>], near_m: f64) {
    for camera in ring {
        let inv_z = 1.0 / camera.z.max(near_m);
        *range = [range[0].min(inv_z), range[1].max(inv_z)];
    }
}
