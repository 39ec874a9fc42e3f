//! The visible parts of the contour edges.

use nalgebra::Vector3;

use super::CLEARANCE_M;
use super::lens::ImageEdge;
use super::outline::Outline;
use crate::plane::{between, cross, dot, minus};
use crate::scene::{Prism, Scene};

/// Lines that enclose a smaller angle (radians) are also split like parallel ones.
const PARALLEL: f64 = 1e-5;
/// How far beyond its ends an edge splits others, as a share of its length. Superfluous splits are
/// harmless, a missing one is not.
const OVERSHOOT: f64 = 1e-3;

/// Finds visible parts, in buffers that are reused.
#[derive(Debug, Clone, Default)]
pub(super) struct Visibility {
    splits: Vec<f64>,
    occluders: Vec<usize>,
    crossings: Vec<f64>,
}

impl Visibility {
    /// Calls `visible` with both image ends of every visible part of every contour edge.
    pub fn for_visible(
        &mut self,
        outline: &Outline,
        scene: &Scene,
        centre: &Vector3<f64>,
        mut visible: impl FnMut([f64; 2], [f64; 2]),
    ) {
        for edge in &outline.contours {
            self.split(edge, outline);
            let mut open: Option<f64> = None;
            for i in 1..self.splits.len() {
                let (from, to) = (self.splits[i - 1], self.splits[i]);
                if self.is_hidden(edge, 0.5 * (from + to), outline, scene, centre) {
                    if let Some(start) = open.take() {
                        visible(edge.image_at(start), edge.image_at(from));
                    }
                } else {
                    open.get_or_insert(from);
                }
            }
            if let Some(start) = open {
                visible(edge.image_at(start), edge.ends[1]);
            }
        }
    }

    /// Lists the prisms that may hide part of `edge`, and the parameters where its visibility may
    /// change.
    fn split(&mut self, edge: &ImageEdge, outline: &Outline) {
        self.splits.clear();
        self.occluders.clear();
        let farthest = edge.inv_z[0].min(edge.inv_z[1]);
        for (slot, prism) in outline.prisms.iter().enumerate() {
            // A prism entirely behind the farthest point of the edge hides no part of it.
            if prism.max_inv_z < farthest || !prism.bounds.overlaps(&edge.bounds) {
                continue;
            }
            self.occluders.push(slot);
            for other in &outline.contours[prism.contours.clone()] {
                if other.bounds.overlaps(&edge.bounds) {
                    add_splits(edge, other, &mut self.splits);
                }
            }
        }
        self.splits.retain(|s| *s > 0.0 && *s < 1.0);
        self.splits.extend([0.0, 1.0]);
        self.splits.sort_unstable_by(f64::total_cmp);
    }

    /// Whether the point at parameter `s` of `edge` is hidden.
    fn is_hidden(
        &mut self,
        edge: &ImageEdge,
        s: f64,
        outline: &Outline,
        scene: &Scene,
        centre: &Vector3<f64>,
    ) -> bool {
        let image = edge.image_at(s);
        let point = edge.world_at(s);
        let crossings = &mut self.crossings;
        self.occluders.iter().any(|slot| {
            let prism = &outline.prisms[*slot];
            prism.bounds.contains(image)
                && pierces(&scene.prisms[prism.index], centre, &point, crossings)
        })
    }
}

/// Appends the parameters on `edge` where its image crosses that of `other`.
fn add_splits(edge: &ImageEdge, other: &ImageEdge, splits: &mut Vec<f64>) {
    let d = minus(edge.ends[1], edge.ends[0]);
    let e = minus(other.ends[1], other.ends[0]);
    let offset = minus(other.ends[0], edge.ends[0]);
    let sine = cross(d, e);
    let t = cross(offset, d) / sine;
    if (-OVERSHOOT..=1.0 + OVERSHOOT).contains(&t) {
        splits.push(cross(offset, e) / sine);
    }
    let d2 = dot(d, d);
    if sine * sine <= PARALLEL * PARALLEL * d2 * dot(e, e) && d2 > 0.0 {
        splits.extend(other.ends.map(|end| dot(minus(end, edge.ends[0]), d) / d2));
    }
}

/// Whether the segment from `centre` (outside the prism) to `point` gets deeper than [`CLEARANCE_M`]
/// into the prism; `crossings` is scratch space.
pub(super) fn pierces(
    prism: &Prism,
    centre: &Vector3<f64>,
    point: &Vector3<f64>,
    crossings: &mut Vec<f64>,
) -> bool {
    let Some([from, to]) = below(prism.height_m, centre, point) else { return false };
    let start = [from.x, from.y];
    let d = [to.x - from.x, to.y - from.y];
    crossings.clear();
    crossings.push(0.0);
    for ring in &prism.rings {
        let Some(&last) = ring.last() else { continue };
        let mut a = minus(last, start);
        let mut side_a = cross(d, a);
        for &vertex in ring {
            let b = minus(vertex, start);
            let side_b = cross(d, b);
            if (side_a > 0.0) != (side_b > 0.0) {
                let e = minus(b, a);
                let t = cross(a, e) / cross(d, e);
                if t > 0.0 && t < 1.0 {
                    crossings.push(t);
                }
            }
            (a, side_a) = (b, side_b);
        }
    }
    crossings.push(1.0);
    crossings.sort_unstable_by(f64::total_cmp);
    crossings.windows(2).any(|pair| {
        let t = 0.5 * (pair[0] + pair[1]);
        let z = from.z + t * (to.z - from.z);
        z < prism.height_m - CLEARANCE_M
            && is_deep_inside(prism, [start[0] + t * d[0], start[1] + t * d[1]])
    })
}

/// The ends of the part of the segment from `centre` to `point` that is below a height, metres.
fn below(height_m: f64, centre: &Vector3<f64>, point: &Vector3<f64>) -> Option<[Vector3<f64>; 2]> {
    let crossing = || centre + (point - centre) * ((centre.z - height_m) / (centre.z - point.z));
    match (centre.z < height_m, point.z < height_m) {
        (true, true) => Some([*centre, *point]),
        (true, false) => Some([*centre, crossing()]),
        (false, true) => Some([crossing(), *point]),
        (false, false) => None,
    }
}

/// Whether a point is in the footprint and farther than [`CLEARANCE_M`] from its border.
fn is_deep_inside(prism: &Prism, point: [f64; 2]) -> bool {
    let mut inside = false;
    for ring in &prism.rings {
        let Some(&last) = ring.last() else { continue };
        let mut a = minus(last, point);
        for &vertex in ring {
            let b = minus(vertex, point);
            let e = minus(b, a);
            let near = between(a, b, (-dot(a, e) / dot(e, e)).clamp(0.0, 1.0));
            if dot(near, near) <= CLEARANCE_M * CLEARANCE_M {
                return false;
            }
            if (a[1] <= 0.0) != (b[1] <= 0.0) && (a[0] - a[1] * e[0] / e[1] > 0.0) {
                inside = !inside;
            }
            a = b;
        }
    }
    inside
}
