//! Clear ground.

use csat_proto::camera::CameraView;
use csat_proto::region::{GridPoint, Region, Ring, grid_point};

use super::outline::UNITS_PER_PX;
use crate::region::Inner;

/// C = P^g(Y^g) ∩ X_g (4.6): the ground seen through Ground pixels, inner.
///
/// The image-to-ground map is a homography, and homographies map straight edges to straight edges:
/// mapping the corners of the pixels' outline is exact, whatever the number of pixels. `outline`
/// holds rings in 1/256 pixels with the ground on the left, filled by positive winding; no target location
/// is in the result by Assumption 7 (Proposition 14).
pub fn clear_ground(view: &CameraView, outline: &[Ring], ground: &Region) -> Inner {
    let pixels = |units: i32| f64::from(units) / f64::from(UNITS_PER_PX);
    let on_ground = |p: &GridPoint| view.ground_point(pixels(p.x), pixels(p.y)).map(grid_point);
    // Every corner of a Ground pixel sees the ground; a frame that claims otherwise proves nothing.
    let mapped: Option<Vec<Ring>> =
        outline.iter().map(|ring| ring.iter().rev().map(on_ground).collect()).collect();
    // From (column, row) to (east, north) the orientation flips: columns grow to the left of the
    // flight direction, rows along it. Hence the reversal above.
    mapped.map_or_else(Inner::default, |rings| Inner::from_rings(&rings, ground))
}
