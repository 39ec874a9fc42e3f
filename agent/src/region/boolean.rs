//! Boolean operations on rings, by `i_overlay`'s integer engine.

use csat_proto::region::{Region, Ring};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::{Overlay, ShapeType};
pub(crate) use i_overlay::core::overlay_rule::OverlayRule as RULE;
use i_overlay::core::solver::{Precision, Solver};

/// Applies `rule` to two collections of rings, each filled where its winding number is positive.
///
/// The rings of a collection may overlap and cross: counter-clockwise ones add, clockwise ones
/// subtract. The result is disjoint and oriented; its rings may touch themselves and each other in
/// points.
///
/// Rounding an intersection to the grid bends edges, which may then cross elsewhere. The engine
/// repeats until nothing crosses, snapping to edge ends within √2ⁱ units in round i
/// (`Precision::HIGH`): rounds are few, and the boundary moves by about one unit. A constant radius
/// (`Precision::ABSOLUTE`) is no more exact and practically never ends on bundles of nearly parallel
/// edges.
pub(crate) fn overlay<'a>(
    subject: impl IntoIterator<Item = &'a Ring>,
    clip: impl IntoIterator<Item = &'a Ring>,
    rule: RULE,
) -> Region {
    let solver = Solver::with_precision(Precision::HIGH);
    let mut overlay = Overlay::<i32>::new_custom(1024, Default::default(), solver);
    for ring in subject {
        overlay.add_contour(ring, ShapeType::Subject);
    }
    for ring in clip {
        overlay.add_contour(ring, ShapeType::Clip);
    }
    Region::from_shapes(overlay.overlay(rule, FillRule::Positive))
}
