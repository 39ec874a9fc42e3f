//! An independent ray caster: slow and simple. It shares only the camera with the renderer.
//!
//! Every prism becomes triangles (walls, roof and floor), all in one parry mesh; floors close the
//! solids, so a ray that passes between two triangles by rounding still ends in the same entity.

use csat_proto::camera::CameraView;
use csat_proto::frame::Label;
use nalgebra::Vector3;
use parry3d_f64::math::Vector;
use parry3d_f64::query::{Ray, RayCast};
use parry3d_f64::shape::TriMesh;

use crate::scene::{Entity, Prism, Scene};

/// The thing that a ray meets first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Hit {
    /// The plane z = 0.
    Ground,
    /// A prism.
    Solid(Entity),
}

impl Hit {
    /// The label of a pixel all of whose rays meet this.
    pub fn label(self) -> Label {
        match self {
            Self::Ground => Label::Ground,
            Self::Solid(Entity::Obstacle(_)) => Label::Obstacle,
            Self::Solid(Entity::Target(_)) => Label::Target,
        }
    }
}

/// Casts rays at a scene.
pub struct Oracle {
    /// `None` when the scene is empty.
    mesh: Option<TriMesh>,
    /// The entity of each triangle.
    entities: Vec<Entity>,
}

impl Oracle {
    /// An oracle for `scene`.
    pub fn new(scene: &Scene) -> Self {
        let mut soup = Soup::default();
        for prism in &scene.prisms {
            soup.add_prism(prism);
        }
        Self { mesh: TriMesh::new(soup.vertices, soup.triangles).ok(), entities: soup.entities }
    }

    /// What the ray from `origin` (above ground, `world`, metres) along `direction` (of any length)
    /// meets first, and its distance in metres; `None` for the sky.
    pub fn cast(&self, origin: Vector3<f64>, direction: Vector3<f64>) -> Option<(Hit, f64)> {
        let direction = direction.normalize();
        let ground_m = (direction.z < 0.0).then(|| -origin.z / direction.z);
        let reach = ground_m.unwrap_or(f64::MAX);
        let vector = |v: Vector3<f64>| Vector::new(v.x, v.y, v.z);
        let ray = Ray::new(vector(origin), vector(direction));
        // Floors lie in the plane of the ground; with a little more reach the ray meets them first.
        let solid = self.mesh.as_ref().and_then(|mesh| {
            mesh.cast_local_ray_and_get_normal(&ray, reach * (1.0 + 1e-12), false)
        });
        match solid {
            Some(hit) => {
                let entity = self.entities.get(hit.subshape as usize)?;
                Some((Hit::Solid(*entity), hit.time_of_impact))
            }
            None => ground_m.map(|distance| (Hit::Ground, distance)),
        }
    }

    /// What image point (c, r) shows, and its distance in metres.
    pub fn cast_image(&self, view: &CameraView, c: f64, r: f64) -> Option<(Hit, f64)> {
        self.cast(view.centre_world(), view.ray_world(c, r))
    }

    /// The thing that `n` x `n` rays through a pixel meet, corners and borders included (`n` >= 2);
    /// `None` unless all meet the same thing within d_max.
    pub fn classify_pixel(
        &self,
        view: &CameraView,
        column: usize,
        row: usize,
        n: usize,
    ) -> Option<Hit> {
        let d_max_m = view.model().d_max_m;
        let part = |i: usize| i as f64 / (n.max(2) - 1) as f64;
        let mut common = None;
        for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
            let (c, r) = (column as f64 + part(j), row as f64 + part(i));
            let (hit, distance_m) = self.cast_image(view, c, r)?;
            if distance_m > d_max_m || *common.get_or_insert(hit) != hit {
                return None;
            }
        }
        common
    }
}

#[derive(Default)]
struct Soup {
    vertices: Vec<Vector>,
    triangles: Vec<[u32; 3]>,
    entities: Vec<Entity>,
}

impl Soup {
    fn add_prism(&mut self, prism: &Prism) {
        let top = prism.height_m;
        for ring in &prism.rings {
            for (i, &a) in ring.iter().enumerate() {
                let b = ring[(i + 1) % ring.len()];
                self.add_quad(prism.entity, [(a, 0.0), (b, 0.0), (b, top), (a, top)]);
            }
        }
        for z in [0.0, top] {
            for trapezoid in trapezoids(&prism.rings) {
                self.add_quad(prism.entity, trapezoid.map(|p| (p, z)));
            }
        }
    }

    fn add_quad(&mut self, entity: Entity, corners: [([f64; 2], f64); 4]) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(corners.map(|([x, y], z)| Vector::new(x, y, z)));
        self.triangles.push([first, first + 1, first + 2]);
        self.triangles.push([first, first + 2, first + 3]);
        self.entities.extend([entity; 2]);
    }
}

/// Cuts a polygon with holes at the northing of every vertex.
fn trapezoids(rings: &[Vec<[f64; 2]>]) -> Vec<[[f64; 2]; 4]> {
    let mut cuts: Vec<f64> = rings.iter().flatten().map(|p| p[1]).collect();
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let edges: Vec<[[f64; 2]; 2]> = rings
        .iter()
        .flat_map(|ring| (0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]]))
        .map(|[a, b]| if a[1] <= b[1] { [a, b] } else { [b, a] })
        .collect();
    let mut pieces = Vec::new();
    for slab in cuts.windows(2) {
        let at = |[a, b]: [[f64; 2]; 2], y: f64| {
            let t = ((y - a[1]) / (b[1] - a[1])).clamp(0.0, 1.0);
            a[0] + t * (b[0] - a[0])
        };
        let middle = 0.5 * (slab[0] + slab[1]);
        let mut across: Vec<_> = edges
            .iter()
            .filter(|[a, b]| a[1] <= slab[0] && b[1] >= slab[1] && a[1] < b[1])
            .copied()
            .collect();
        across.sort_by(|e, f| at(*e, middle).total_cmp(&at(*f, middle)));
        for pair in across.chunks_exact(2) {
            let [left, right] = [pair[0], pair[1]];
            pieces.push([
                [at(left, slab[0]), slab[0]],
                [at(right, slab[0]), slab[0]],
                [at(right, slab[1]), slab[1]],
                [at(left, slab[1]), slab[1]],
            ]);
        }
    }
    pieces
}
