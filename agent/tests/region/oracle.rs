//! Slow and independent implementations to compare with.

use std::f64::consts::TAU;

use csat_proto::region::{GridPoint, Region, Ring, Shape, UNITS_PER_M, metres, twice_signed_area};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::{Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use rand::RngExt;

use crate::shapes::{Rng, solid};

/// The most by which rounding may move a boundary, metres.
pub const ROUNDING_M: f64 = 1e-5;

/// An overlay of two regions with the library's own settings.
pub fn overlay(a: &Region, b: &Region, rule: OverlayRule) -> Region {
    let mut overlay = Overlay::<i32>::new(256);
    a.rings().for_each(|ring| overlay.add_contour(ring, ShapeType::Subject));
    b.rings().for_each(|ring| overlay.add_contour(ring, ShapeType::Clip));
    Region::from_shapes(overlay.overlay(rule, FillRule::NonZero))
}

/// The area of a \ b.
pub fn excess_m2(a: &Region, b: &Region) -> f64 {
    overlay(a, b, OverlayRule::Difference).area_m2()
}

/// Asserts that a and b differ by no more than their boundaries' rounding.
pub fn assert_same(a: &Region, b: &Region) {
    let allowed = ROUNDING_M * (perimeter_m(a) + perimeter_m(b)) + 1e-9;
    let (extra, missing) = (excess_m2(a, b), excess_m2(b, a));
    assert!(extra <= allowed, "{extra} m² too much, allowed {allowed}");
    assert!(missing <= allowed, "{missing} m² missing, allowed {allowed}");
}

/// The length of the boundary.
pub fn perimeter_m(region: &Region) -> f64 {
    edges(region).map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1])).sum()
}

/// The edges, in metres.
pub fn edges(region: &Region) -> impl Iterator<Item = [[f64; 2]; 2]> {
    region.rings().flat_map(|ring| {
        (0..ring.len()).map(|i| [metres(ring[i]), metres(ring[(i + 1) % ring.len()])])
    })
}

/// Distance to the boundary, metres.
pub fn boundary_distance_m(region: &Region, p: [f64; 2]) -> f64 {
    let distance = |[a, b]: [[f64; 2]; 2]| {
        let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
        let length = (dx * dx + dy * dy).max(f64::MIN_POSITIVE);
        let t = (((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / length).clamp(0.0, 1.0);
        (p[0] - a[0] - t * dx).hypot(p[1] - a[1] - t * dy)
    };
    edges(region).map(distance).fold(f64::INFINITY, f64::min)
}

/// P ⊕ Q: P and, for each of its edges, the convex hull of Q placed at both ends.
pub fn minkowski_sum(region: &Region, corners: &[GridPoint]) -> Region {
    let mut pieces: Vec<Ring> = Vec::new();
    for ring in region.rings() {
        for (i, &a) in ring.iter().enumerate() {
            let b = ring[(i + 1) % ring.len()];
            pieces.push(hull(corners.iter().flat_map(|&q| [a + q, b + q]).collect()));
        }
    }
    overlay(region, &solid(&pieces), OverlayRule::Union)
}

/// P ⊖ Q: P without the Minkowski sum of its complement, taken in a box about P.
pub fn minkowski_difference(region: &Region, corners: &[GridPoint]) -> Region {
    let Some(bounds) = region.bounds() else { return Region::EMPTY };
    let m = (UNITS_PER_M * 0.01) as i32;
    let (west, south) = (bounds.min.x - m, bounds.min.y - m);
    let (east, north) = (bounds.max.x + m, bounds.max.y + m);
    let frame = [(west, south), (east, south), (east, north), (west, north)];
    let frame = solid(&[frame.iter().map(|&(x, y)| GridPoint::new(x, y)).collect()]);
    let complement = overlay(&frame, region, OverlayRule::Difference);
    overlay(region, &minkowski_sum(&complement, corners), OverlayRule::Difference)
}

/// Andrew's monotone chain.
fn hull(mut points: Vec<GridPoint>) -> Ring {
    points.sort_unstable_by_key(|p| (p.x, p.y));
    points.dedup();
    let mut ring = Ring::new();
    for turn in 0..2 {
        let floor = ring.len() + 1;
        for &p in &points {
            while ring.len() > floor && cross(ring[ring.len() - 2], ring[ring.len() - 1], p) <= 0 {
                ring.pop();
            }
            ring.push(p);
        }
        ring.pop();
        if turn == 0 {
            points.reverse();
        }
    }
    ring
}

/// Twice the signed area of the triangle (a, b, c), in square units.
pub fn cross(a: GridPoint, b: GridPoint, c: GridPoint) -> i128 {
    let d = |p: GridPoint, q: GridPoint| {
        (i128::from(q.x) - i128::from(p.x), i128::from(q.y) - i128::from(p.y))
    };
    let ((ux, uy), (wx, wy)) = (d(a, b), d(b, c));
    ux * wy - uy * wx
}

/// Points of the set: vertices, points on edges, points inside. At most some hundred.
pub fn samples(rng: &mut Rng, region: &Region) -> Vec<[f64; 2]> {
    let mut points = Vec::new();
    for [a, b] in edges(region) {
        points.push(a);
        let t = rng.random_range(0.0..1.0);
        points.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
    }
    points.extend(around(rng, region, 60).into_iter().filter(|&p| region.contains(p)));
    points
}

/// Points in and about the bounding box and near the vertices.
pub fn around(rng: &mut Rng, region: &Region, count: usize) -> Vec<[f64; 2]> {
    let Some(bounds) = region.bounds() else { return Vec::new() };
    let (min, max) = (metres(bounds.min), metres(bounds.max));
    let size = (max[0] - min[0]).max(max[1] - min[1]);
    let vertices: Vec<[f64; 2]> = edges(region).map(|[a, _]| a).collect();
    let anywhere = |rng: &mut Rng| {
        let mut pick = |low: f64, high: f64| low + rng.random_range(-0.1..1.1) * (high - low);
        [pick(min[0], max[0]), pick(min[1], max[1])]
    };
    let near_vertex = |rng: &mut Rng| {
        let v = vertices[rng.random_range(0..vertices.len())];
        let reach = size * 10f64.powf(rng.random_range(-4.0..-1.0));
        let angle: f64 = rng.random_range(0.0..TAU);
        [v[0] + reach * angle.cos(), v[1] + reach * angle.sin()]
    };
    (0..count).map(|i| if i % 2 == 0 { anywhere(rng) } else { near_vertex(rng) }).collect()
}

/// 0 and points of the circle of `radius_m`.
pub fn disc_offsets(rng: &mut Rng, radius_m: f64, count: u32) -> Vec<[f64; 2]> {
    let start: f64 = rng.random_range(0.0..TAU);
    let offset = |k: u32| {
        let angle = start + TAU * f64::from(k) / f64::from(count);
        [radius_m * angle.cos(), radius_m * angle.sin()]
    };
    std::iter::once([0.0, 0.0]).chain((0..count).map(offset)).collect()
}

/// The region without splinters that rounding may leave: holes and shapes one or two grid units wide.
/// A later erosion would enlarge such holes, a later dilation such shapes.
pub fn without_splinters(region: Region) -> Region {
    let splinter = |ring: &Ring| {
        let (area_m2, length_m) = (twice_signed_area(ring), perimeter_of_ring_m(ring));
        area_m2.unsigned_abs() as f64 / 2.0 / UNITS_PER_M <= 2.0 * length_m + 10.0 / UNITS_PER_M
    };
    let kept = |mut shape: Shape| {
        shape.retain(|ring| !splinter(ring) || twice_signed_area(ring) > 0);
        (!splinter(&shape[0])).then_some(shape)
    };
    Region::from_shapes(region.into_shapes().into_iter().filter_map(kept).collect())
}

fn perimeter_of_ring_m(ring: &Ring) -> f64 {
    perimeter_m(&Region::from_shapes(vec![vec![ring.clone()]]))
}
