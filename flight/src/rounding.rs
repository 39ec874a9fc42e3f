//! Sets and outlines on the decimal grid that they are shown on: rounded, and valid polygons again.
//!
//! Rounding corners to a grid may make rings touch or cross themselves and each other. Here they are
//! resolved on that very grid, in integers, to polygons that are valid in the sense of OGC Simple
//! Features (ISO 19125-1): rings are simple, holes lie within, polygons touch in points at most.
//!
//! What contains a set is moved outward before it is rounded, what is contained in one inward, by
//! [`MARGIN_M`]: so the polygons that are shown keep the promise of the set that they show.

use csat_agent::region::{Disc, Inner, Outer, solver};
use csat_proto::model::Ground;
use csat_proto::region::{GridPoint, Region, metres, twice_signed_area};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::{IntOverlayOptions, Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::core::solver::Solver;

use csat_mission::picture::Ring;
use csat_mission::picture::Shapes;

/// Lengths are shown to the millimetre.
pub const PER_METRE: f64 = 1e3;

/// How far a set is moved before it is rounded, metres. Rounding moves a border by 0.71 mm at most, and
/// resolving crossings bends it by about as much.
pub const MARGIN_M: f64 = 0.003;

/// The polygon that stands for the disc of [`MARGIN_M`] has as few corners as can be: each may add a
/// corner at each corner of the set.
const CORNERS: u16 = 4;

/// A set that contains what it stands for, within the ground: to the millimetre, and it contains that
/// still.
pub fn outer(set: &Region, ground: &Ground) -> Shapes {
    // What lies on the border of the ground must not be rounded inward.
    let whole = |size_m: f64| 2.0 * (size_m / 2.0 * PER_METRE).ceil() / PER_METRE;
    let bounds = Region::rectangle(ground.size_m.map(whole));
    let grown = Outer::containing(set.clone()).dilated(&margin(), &bounds);
    shapes(grown.region())
}

/// A set that is contained in what it stands for: to the millimetre, and it is contained in that still.
pub fn inner(set: &Region) -> Shapes {
    shapes(Inner::within(set.clone()).eroded(&margin()).region())
}

/// A set to the nearest millimetre.
pub fn shapes(set: &Region) -> Shapes {
    let point = |p: &GridPoint| rounded(metres(*p), PER_METRE);
    resolved(set.rings().map(|ring| ring.iter().map(point).collect()), PER_METRE)
}

/// Polygons, each an outer ring and its holes, whichever way they go, to the nearest multiple of
/// 1/`per_unit`. What is thinner than that may be gone.
pub fn polygons(shapes: &[Vec<Ring>], per_unit: f64) -> Shapes {
    let turned = shapes.iter().flat_map(|shape| {
        shape.iter().enumerate().map(|(index, ring)| {
            let mut ring: Vec<GridPoint> = ring.iter().map(|p| rounded(*p, per_unit)).collect();
            if (twice_signed_area(&ring) > 0) != (index == 0) {
                ring.reverse();
            }
            ring
        })
    });
    resolved(turned, per_unit)
}

fn margin() -> Disc {
    Disc::circumscribed(MARGIN_M, CORNERS)
}

fn rounded(p: [f64; 2], per_unit: f64) -> GridPoint {
    let [x, y] = p.map(|value| (value * per_unit).round() as i32);
    GridPoint::new(x, y)
}

/// What rings on the grid of 1/`per_unit` enclose, counter-clockwise ones adding and clockwise ones
/// subtracting.
fn resolved(rings: impl Iterator<Item = Vec<GridPoint>>, per_unit: f64) -> Shapes {
    // Where a corner of one ring lies on a side of another, both have it: as decimal fractions, a corner
    // on a side would be on either side of it.
    let options = IntOverlayOptions { preserve_output_collinear: true, ..IntOverlayOptions::ogc() };
    let mut overlay = Overlay::<i32>::new_custom(1024, options, Solver::AUTO);
    let mut edges = 0;
    for ring in rings {
        overlay.add_contour(&ring, ShapeType::Subject);
        edges += ring.len();
    }
    overlay.solver = solver(edges);
    let shapes = overlay.overlay(OverlayRule::Subject, FillRule::Positive);
    let point = |p: &GridPoint| [p.x, p.y].map(|value| f64::from(value) / per_unit);
    let ring = |ring: &Vec<GridPoint>| ring.iter().map(point).collect();
    shapes.iter().map(|shape| shape.iter().map(ring).collect()).collect()
}

#[cfg(test)]
#[path = "rounding_tests.rs"]
mod tests;
