//! Boolean operations on rings, by `i_overlay`'s integer engine.

use std::cell::Cell;

use csat_proto::region::{GridBox, GridPoint, Region, Ring};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::{Overlay, ShapeType};
pub(crate) use i_overlay::core::overlay_rule::OverlayRule as RULE;
use i_overlay::core::solver::{Precision, Solver, Strategy};

use crate::work::note_edges;

/// In round i of resolving crossings the engine snaps them to edge ends within 2^(2i) units.
///
/// Rounding a crossing to the grid bends edges by up to a unit, which may make them cross elsewhere,
/// and the engine starts another round. A crossing caused by bending has an edge end about a unit
/// from the other edge, so snapping to it bends edges by no more than that, for every radius. A
/// growing radius ends the rounds on edges that nearly coincide, as those of the same set on two
/// agents do. With a constant radius (`Precision::ABSOLUTE`), subtracting a star from a copy of
/// itself with vertices moved by a unit has taken minutes.
const PRECISION: Precision = Precision { start: 0, progression: 4 };

/// Up to this many edges the engine keeps those under the sweep line in a list; beyond it may use a
/// tree.
///
/// The default of the engine is 2000 edges, its documentation recommends 10 000. With the list, grown
/// sets of 2000 to 7000 edges take a third less time. The result is the same.
const LIST_UP_TO: usize = 10_000;

/// How the engine resolves that many edges.
pub fn solver(edges: usize) -> Solver {
    let strategy = if edges <= LIST_UP_TO { Strategy::List } else { Strategy::Auto };
    Solver::with_strategy_and_precision(strategy, PRECISION)
}

thread_local! {
    /// The engine of this thread's last operation, for its memory: most operations have a few dozen edges, and
    /// allocating takes a large part of their time.
    static ENGINE: Cell<Option<Overlay<i32>>> = const { Cell::new(None) };
}

/// Applies `rule` to two collections of rings, each filled where its winding number is positive.
///
/// The rings of a collection may overlap and cross: counter-clockwise ones add, clockwise ones
/// subtract. The shapes of the result are disjoint and oriented; their rings may touch themselves and
/// each other in points. Its boundary is within about one grid unit of the exact one, and narrower
/// parts or gaps may be lost or filled.
pub(crate) fn overlay<S, C>(
    subject: impl IntoIterator<Item = S>,
    clip: impl IntoIterator<Item = C>,
    rule: RULE,
) -> Region
where
    S: AsRef<[GridPoint]>,
    C: AsRef<[GridPoint]>,
{
    let mut overlay = ENGINE.take().unwrap_or_else(|| Overlay::new(1024));
    overlay.clear();
    let mut edges = 0;
    let mut add = |ring: &[GridPoint], side| {
        overlay.add_contour(ring, side);
        edges += ring.len();
    };
    subject.into_iter().for_each(|ring| add(ring.as_ref(), ShapeType::Subject));
    clip.into_iter().for_each(|ring| add(ring.as_ref(), ShapeType::Clip));
    note_edges(edges);
    overlay.solver = solver(edges);
    let shapes = overlay.overlay(rule, FillRule::Positive);
    ENGINE.set(Some(overlay));
    Region::from_shapes(shapes)
}

/// What rings fill.
pub(crate) fn filled(rings: &[Ring]) -> Region {
    overlay(rings, [] as [&Ring; 0], RULE::Subject)
}

/// Groups of parts, each with its box, of which no three overlap, to be applied one group after the
/// other.
///
/// Where many edges nearly coincide, as those of copies of one set do, the work of the engine
/// explodes: subtracting ten copies with vertices moved by a unit from a star takes 0.1 s in one
/// operation, and 0.1 ms one by one.
pub(super) fn shallow_groups<T>(parts: impl IntoIterator<Item = (GridBox, T)>) -> Vec<Vec<T>> {
    let mut groups: Vec<Vec<(GridBox, T)>> = Vec::new();
    for (bounds, part) in parts {
        let has_room = |group: &&mut Vec<(GridBox, T)>| {
            group.iter().filter(|(other, _)| other.meets(&bounds)).count() < 2
        };
        match groups.iter_mut().find(has_room) {
            Some(group) => group.push((bounds, part)),
            None => groups.push(vec![(bounds, part)]),
        }
    }
    groups.into_iter().map(|group| group.into_iter().map(|(_, part)| part).collect()).collect()
}

/// Each part with all items and parts that its box meets, directly or through others; items are disjoint up
/// to rounding, so one item does not bring another. Takes those items out of `items`.
pub(super) fn touched<T>(items: &mut Vec<(GridBox, T)>, parts: Vec<(GridBox, T)>) -> Vec<Vec<T>> {
    let mut left = parts;
    let mut clusters = Vec::new();
    while let Some(part) = left.pop() {
        let (mut parts, mut taken) = (vec![part], Vec::new());
        let mut next = 0;
        while let Some((extent, _)) = parts.get(next) {
            let extent = *extent;
            let mut reached = vec![extent];
            let met = items.extract_if(.., |(item, _)| extent.meets(item));
            taken.extend(met.inspect(|(item, _)| reached.push(*item)));
            let meets = |part: &GridBox| reached.iter().any(|extent| extent.meets(part));
            parts.extend(left.extract_if(.., |(part, _)| meets(part)));
            next += 1;
        }
        clusters.push(taken.into_iter().chain(parts).map(|(_, item)| item).collect());
    }
    clusters
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes on a line: what meets a part comes along, what meets only that stays.
    #[test]
    fn parts_bring_what_they_meet_and_each_other() {
        let boxed = |name: &'static str, from: i32, to: i32| {
            let corners = [GridPoint::new(from, 0), GridPoint::new(to, 1)];
            (GridBox::around(&corners).unwrap(), name)
        };
        let mut items = vec![
            boxed("west", 0, 10),
            boxed("beside", 8, 20),
            boxed("east", 100, 110),
            boxed("far", 200, 210),
        ];
        let parts = vec![
            boxed("p", -5, 3),
            boxed("q", 105, 120),
            boxed("r", 118, 130),
            boxed("s", 90, 101),
        ];
        let mut clusters = touched(&mut items, parts);
        clusters.iter_mut().for_each(|cluster| cluster.sort_unstable());
        clusters.sort_unstable();
        assert_eq!(clusters, [vec!["east", "q", "r", "s"], vec!["p", "west"]]);
        let left: Vec<_> = items.into_iter().map(|(_, name)| name).collect();
        assert_eq!(left, ["beside", "far"]);
    }
}
