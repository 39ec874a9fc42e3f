//! Boolean operations cell by cell.
//!
//! The time of an operation grows faster than its edges: each edge is compared with those under the
//! sweep line. A set of a whole town has thousands of edges, and what is known of one street does not
//! depend on another street. So an operation on many edges is divided: a line cuts all rings in two,
//! and each half is resolved for itself, and divided again if it still has many edges.
//!
//! The lines are those of one quadtree, the same for all sets. A set that was resolved in cells
//! consists of a shape or more in each cell, which meet on the lines. At the next operation most rings
//! are in one cell already.
//!
//! # Cutting a ring
//!
//! What is beyond a line is moved onto it, at right angles (Sutherland and Hodgman). On the way no point on
//! this side of the line is passed, so its winding number stays as it is; the winding numbers beyond the
//! line become 0. Where an edge crosses a line, it is bent by half a unit at most. Each piece of an edge
//! is cut by at most one line of each of the 9 sizes in x and one in y, so it is bent by no more than 9
//! units in all. Where a corner lies within a few units of a line, the engine may snap the border of a
//! piece to it: a gap of that width may stay between two pieces until they grow next.

use std::borrow::Cow;

use csat_proto::region::{GridBox, GridPoint, Region, Ring, Shape};

use super::boolean::shallow_groups;
use super::{Memo, RULE, overlay};
use crate::identity::Identity;

/// An operation on more edges than this is divided.
const EDGES: usize = 512;
/// Half the side of the cell that contains the grid, units.
const HALF_GRID: i32 = 1 << 30;
/// Half the side of the smallest cell, units: 8 m.
const HALF_CELL: i32 = 1 << 21;

/// A closed path, borrowed until a line cuts it, and its box.
#[derive(Debug, Clone)]
pub(super) struct Path<'a> {
    points: Cow<'a, [GridPoint]>,
    extent: GridBox,
}

impl<'a> Path<'a> {
    /// A path through `points`; `None` where there are none.
    pub(super) fn new(points: impl Into<Cow<'a, [GridPoint]>>) -> Option<Self> {
        let points = points.into();
        let extent = GridBox::around(points.iter())?;
        Some(Self { points, extent })
    }
}

impl AsRef<[GridPoint]> for Path<'_> {
    fn as_ref(&self) -> &[GridPoint] {
        &self.points
    }
}

/// `set` without the union of `parts`, each as paths that are filled where their winding number is
/// positive.
pub(super) fn difference(
    set: Vec<Path<'_>>,
    parts: Vec<Vec<Path<'_>>>,
    memo: Option<&Memo>,
) -> Region {
    Operation { rule: RULE::Difference, set, parts }.result(memo)
}

/// The intersection of two sets of rings.
pub(super) fn intersection(a: &Region, b: &Region, memo: Option<&Memo>) -> Region {
    let [set, other] = [a, b].map(|set| paths(set.rings()));
    Operation { rule: RULE::Intersect, set, parts: vec![other] }.result(memo)
}

/// Paths along rings.
pub(super) fn paths<'a>(rings: impl IntoIterator<Item = &'a Ring>) -> Vec<Path<'a>> {
    rings.into_iter().filter_map(|ring| Path::new(&ring[..])).collect()
}

/// What is to be done with a set in a cell: every part is taken from it, or it is intersected with the
/// only one.
#[derive(Debug)]
struct Operation<'a> {
    rule: RULE,
    set: Vec<Path<'a>>,
    parts: Vec<Vec<Path<'a>>>,
}

impl Operation<'_> {
    fn result(self, memo: Option<&Memo>) -> Region {
        let mut shapes = Vec::new();
        self.resolve(Cell { centre: GridPoint::ZERO, half: [HALF_GRID; 2] }, memo, &mut shapes);
        Region::from_shapes(shapes)
    }

    fn resolve(mut self, cell: Cell, memo: Option<&Memo>, shapes: &mut Vec<Shape>) {
        let Some(extent) = extent(&self.set) else { return };
        for part in &mut self.parts {
            part.retain(|path| path.extent.meets(&extent));
        }
        self.parts.retain(|part| !part.is_empty());
        if self.rule == RULE::Intersect && self.parts.is_empty() {
            return;
        }
        match cell.line() {
            Some(line) if self.edges() > EDGES => {
                let [low, high] = self.halves(line);
                let [low_cell, high_cell] = cell.halves(line);
                low.resolve(low_cell, memo, shapes);
                high.resolve(high_cell, memo, shapes);
            }
            _ => match memo {
                Some(memo) => {
                    let known = memo.result(self.identity(), || self.at_once().into());
                    shapes.extend_from_slice(&known);
                }
                None => shapes.extend(self.at_once()),
            },
        }
    }

    fn edges(&self) -> usize {
        self.set.iter().chain(self.parts.iter().flatten()).map(|path| path.points.len()).sum()
    }

    fn identity(&self) -> Identity {
        let groups = std::iter::once(&self.set).chain(&self.parts);
        Identity::of_operation([self.rule as u64, 0], groups)
    }

    fn at_once(&self) -> Vec<Shape> {
        let boxes = self.parts.iter().filter_map(|part| Some((extent(part)?, part)));
        let mut layers = shallow_groups(boxes).into_iter().map(|layer| layer.into_iter().flatten());
        let first = layers.next().into_iter().flatten();
        let start = overlay(&self.set, first, self.rule);
        let result = layers.fold(start, |set, layer| overlay(set.rings(), layer, self.rule));
        result.into_shapes()
    }

    fn halves(self, line: Line) -> [Self; 2] {
        let [low, high] = line.cut(self.set);
        let cut = self.parts.into_iter().map(|part| line.cut(part).into());
        let (below, above): (Vec<_>, Vec<_>) = cut.unzip();
        let half = |set, parts| Self { rule: self.rule, set, parts };
        [half(low, below), half(high, above)]
    }
}

/// The box around paths.
fn extent(paths: &[Path<'_>]) -> Option<GridBox> {
    paths.iter().map(|path| path.extent).reduce(|a, b| a.around_both(&b))
}

/// A square of the quadtree, or a half of one.
#[derive(Debug, Clone, Copy)]
struct Cell {
    centre: GridPoint,
    /// Half the sides, units.
    half: [i32; 2],
}

impl Cell {
    /// The line that divides it; `None` for the smallest cells.
    fn line(&self) -> Option<Line> {
        let [x, y] = self.half;
        match x.max(y) <= HALF_CELL {
            true => None,
            false if x >= y => Some(Line { axis: Axis::X, at: self.centre.x }),
            false => Some(Line { axis: Axis::Y, at: self.centre.y }),
        }
    }

    fn halves(&self, line: Line) -> [Self; 2] {
        [-1, 1].map(|side| {
            let mut cell = *self;
            match line.axis {
                Axis::X => {
                    cell.half[0] /= 2;
                    cell.centre.x += side * cell.half[0];
                }
                Axis::Y => {
                    cell.half[1] /= 2;
                    cell.centre.y += side * cell.half[1];
                }
            }
            cell
        })
    }
}

#[derive(Debug, Clone, Copy)]
enum Axis {
    X,
    Y,
}

/// The points whose coordinate along `axis` is `at`.
#[derive(Debug, Clone, Copy)]
struct Line {
    axis: Axis,
    at: i32,
}

impl Line {
    /// The paths below and above the line.
    fn cut<'a>(&self, paths: Vec<Path<'a>>) -> [Vec<Path<'a>>; 2] {
        let [mut below, mut above] = [Vec::new(), Vec::new()];
        for path in paths {
            if self.coordinate(path.extent.max) <= self.at {
                below.push(path);
            } else if self.coordinate(path.extent.min) >= self.at {
                above.push(path);
            } else {
                let [low, high] = self.cut_path(&path.points);
                below.extend(Path::new(low));
                above.extend(Path::new(high));
            }
        }
        [below, above]
    }

    fn cut_path(&self, path: &[GridPoint]) -> [Vec<GridPoint>; 2] {
        let [mut below, mut above] = [Vec::new(), Vec::new()];
        let mut before = path[path.len() - 1];
        for &p in path {
            let (from, to) = (self.coordinate(before), self.coordinate(p));
            if (from < self.at) != (to < self.at) && from != self.at && to != self.at {
                let crossing = self.crossing(before, p);
                self.extend(&mut below, crossing);
                self.extend(&mut above, crossing);
            }
            if to <= self.at {
                self.extend(&mut below, p);
            }
            if to >= self.at {
                self.extend(&mut above, p);
            }
            before = p;
        }
        [below, above]
    }

    /// Appends a point, in place of the last one if the path has come to that along the line.
    fn extend(&self, path: &mut Vec<GridPoint>, p: GridPoint) {
        if let [.., a, b] = path[..]
            && [a, b, p].iter().all(|&p| self.coordinate(p) == self.at)
        {
            path.pop();
        }
        path.push(p);
    }

    /// Where the edge between two points on different sides crosses the line, the same for both directions.
    fn crossing(&self, p: GridPoint, q: GridPoint) -> GridPoint {
        let (p, q) = if self.coordinate(p) < self.coordinate(q) { (p, q) } else { (q, p) };
        let wide = i64::from;
        let along = |p: GridPoint, q: GridPoint| {
            let (run, rise) = (wide(q.x) - wide(p.x), wide(q.y) - wide(p.y));
            wide(p.y) + divided((wide(self.at) - wide(p.x)) as i128 * rise as i128, run)
        };
        let flipped = |p: GridPoint| GridPoint::new(p.y, p.x);
        match self.axis {
            Axis::X => GridPoint::new(self.at, along(p, q) as i32),
            Axis::Y => GridPoint::new(along(flipped(p), flipped(q)) as i32, self.at),
        }
    }

    fn coordinate(&self, p: GridPoint) -> i32 {
        match self.axis {
            Axis::X => p.x,
            Axis::Y => p.y,
        }
    }
}

/// The integer nearest to a quotient; `by` is positive.
fn divided(number: i128, by: i64) -> i64 {
    let by = i128::from(by);
    (2 * number + by).div_euclid(2 * by) as i64
}
