//! Footprints of generated buildings.

use geo::{AffineOps, AffineTransform, BoundingRect, LineString, Polygon, Rotate, coord};
use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;

use crate::plane::Bounds;

/// The largest angle between a building and the street, degrees.
const MAX_TURN_DEG: f64 = 20.0;
/// A building spans at least this share of its lot along either axis.
const MIN_FILL: f64 = 0.6;

const KINDS: [&str; 5] = ["box", "L", "U", "T", "courtyard"];

/// A building somewhere on the lot, and its kind.
pub(super) fn draw(lot: &Bounds, rng: &mut ChaCha8Rng) -> (Polygon<f64>, &'static str) {
    let kind = KINDS.choose(rng).copied().unwrap_or("box");
    let size = lot.size_m().map(|side| side * rng.random_range(MIN_FILL..=1.0));
    let wing = rng.random_range(0.3..0.4);
    let unit = match kind {
        "L" => ring(&[[0.0, 0.0], [1.0, 0.0], [1.0, wing], [wing, wing], [wing, 1.0], [0.0, 1.0]]),
        "U" => ring(&[
            [0.0, 0.0],
            [1.0, 0.0],
            [1.0, 1.0],
            [1.0 - wing, 1.0],
            [1.0 - wing, wing],
            [wing, wing],
            [wing, 1.0],
            [0.0, 1.0],
        ]),
        "T" => ring(&[
            [0.5 - wing / 2.0, 0.0],
            [0.5 + wing / 2.0, 0.0],
            [0.5 + wing / 2.0, 1.0 - wing],
            [1.0, 1.0 - wing],
            [1.0, 1.0],
            [0.0, 1.0],
            [0.0, 1.0 - wing],
            [0.5 - wing / 2.0, 1.0 - wing],
        ]),
        _ => ring(&SQUARE),
    };
    // Clockwise, because it is a hole.
    let (a, b) = (0.3, 0.7);
    let yard = ring(&[[a, a], [a, b], [b, b], [b, a]]);
    let holes = if kind == "courtyard" { vec![yard] } else { Vec::new() };
    // First a random number of quarter turns, so that concave sides face all directions.
    let quarter = 90.0 * f64::from(rng.random_range(0..4u8));
    let turn_deg =
        if rng.random_bool(0.5) { 0.0 } else { rng.random_range(-MAX_TURN_DEG..=MAX_TURN_DEG) };
    let middle = coord! { x: 0.5, y: 0.5 };
    let stretch = AffineTransform::scale(size[0], size[1], coord! { x: 0.0, y: 0.0 });
    let building = Polygon::new(unit, holes)
        .rotate_around_point(quarter, middle.into())
        .affine_transform(&stretch)
        .rotate_around_point(turn_deg, coord! { x: size[0] / 2.0, y: size[1] / 2.0 }.into());
    let [u, v] = [rng.random_range(0.0..=1.0), rng.random_range(0.0..=1.0)];
    (fitted(&building, lot, [u, v]), kind)
}

/// A box as large as the lot.
pub(super) fn filling(lot: &Bounds) -> Polygon<f64> {
    let ([x0, y0], [x1, y1]) = (lot.min, lot.max);
    Polygon::new(ring(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1]]), Vec::new())
}

const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

/// The footprint scaled by `scale` <= 1 about the middle of its bounding box, which stays inside.
pub(super) fn shrunk(footprint: &Polygon<f64>, scale: f64) -> Polygon<f64> {
    let Some(bounds) = footprint.bounding_rect() else { return footprint.clone() };
    footprint.affine_transform(&AffineTransform::scale(scale, scale, bounds.center()))
}

/// The building moved onto the lot, shrunk if it does not fit; `at` is its place within the room that
/// is left along either axis, 0..1.
fn fitted(building: &Polygon<f64>, lot: &Bounds, at: [f64; 2]) -> Polygon<f64> {
    let Some(bounds) = building.bounding_rect() else { return building.clone() };
    let size = lot.size_m();
    let scale = (size[0] / bounds.width()).min(size[1] / bounds.height()).min(1.0);
    let room = [size[0] - scale * bounds.width(), size[1] - scale * bounds.height()];
    let [x, y] = [0, 1].map(|i| lot.min[i] + at[i] * room[i].max(0.0));
    let origin = bounds.min();
    let moved = AffineTransform::translate(-origin.x, -origin.y)
        .scaled(scale, scale, coord! { x: 0.0, y: 0.0 })
        .translated(x, y);
    building.affine_transform(&moved)
}

fn ring(points: &[[f64; 2]]) -> LineString<f64> {
    points.iter().copied().collect()
}
