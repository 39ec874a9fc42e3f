//! Planar sets: polygons with holes on an integer grid.
//!
//! Every set of the estimator has its vertices on one grid of 2^-18 m (3.8 µm), so that Boolean
//! operations, messages and digests are the same bits on every machine. The grid spans ±4096 m.

use i_overlay::i_float::int::point::IntPoint;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Grid units per metre.
pub const UNITS_PER_M: f64 = 262_144.0;

/// The largest coordinate of a valid region, in metres.
pub const MAX_COORDINATE_M: f64 = 4095.0;

/// A point on the grid, in units of 1/[`UNITS_PER_M`] metres, `world`.
pub type GridPoint = IntPoint<i32>;

/// A closed ring; the last point is not repeated. Outer rings run counter-clockwise, holes clockwise.
pub type Ring = Vec<GridPoint>;

/// An outer ring followed by its holes.
pub type Shape = Vec<Ring>;

/// The grid point nearest to a point in metres.
pub fn grid_point(p: [f64; 2]) -> GridPoint {
    GridPoint::new(to_units(p[0]), to_units(p[1]))
}

/// Metres to the nearest grid coordinate.
pub fn to_units(metres: f64) -> i32 {
    (metres.clamp(-MAX_COORDINATE_M, MAX_COORDINATE_M) * UNITS_PER_M).round() as i32
}

/// A grid point in metres.
pub fn metres(p: GridPoint) -> [f64; 2] {
    [f64::from(p.x) / UNITS_PER_M, f64::from(p.y) / UNITS_PER_M]
}

/// Twice the signed area of a ring, in square units; positive when counter-clockwise.
pub fn twice_signed_area(ring: &[GridPoint]) -> i128 {
    let Some(&last) = ring.last() else { return 0 };
    let mut previous = last;
    let mut sum = 0i128;
    for &p in ring {
        sum += i128::from(previous.x) * i128::from(p.y) - i128::from(p.x) * i128::from(previous.y);
        previous = p;
    }
    sum
}

/// An axis-aligned box on the grid, bounds inclusive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GridBox {
    /// Least corner.
    pub min: GridPoint,
    /// Greatest corner.
    pub max: GridPoint,
}

impl GridBox {
    /// The smallest box around `points`; `None` when there are none.
    pub fn around<'a>(points: impl IntoIterator<Item = &'a GridPoint>) -> Option<Self> {
        let mut points = points.into_iter();
        let first = *points.next()?;
        let start = Self { min: first, max: first };
        Some(points.fold(start, |b, p| Self {
            min: GridPoint::new(b.min.x.min(p.x), b.min.y.min(p.y)),
            max: GridPoint::new(b.max.x.max(p.x), b.max.y.max(p.y)),
        }))
    }

    /// Whether two boxes share a point.
    pub fn meets(&self, other: &Self) -> bool {
        self.min.x <= other.max.x
            && other.min.x <= self.max.x
            && self.min.y <= other.max.y
            && other.min.y <= self.max.y
    }

    /// The smallest box around two boxes.
    pub fn around_both(&self, other: &Self) -> Self {
        Self {
            min: GridPoint::new(self.min.x.min(other.min.x), self.min.y.min(other.min.y)),
            max: GridPoint::new(self.max.x.max(other.max.x), self.max.y.max(other.max.y)),
        }
    }

    /// Whether the box contains a point.
    pub fn contains(&self, p: GridPoint) -> bool {
        (self.min.x..=self.max.x).contains(&p.x) && (self.min.y..=self.max.y).contains(&p.y)
    }
}

/// Whether edges that enclose something enclose a point, by the even-odd rule. On an edge either answer
/// is possible.
pub fn is_inside<E>(edges: impl IntoIterator<Item = E>, p: [f64; 2]) -> bool
where
    E: std::borrow::Borrow<[[f64; 2]; 2]>,
{
    edges.into_iter().fold(false, |is_inside, edge| {
        let [a, b] = edge.borrow();
        let crosses = (a[1] > p[1]) != (b[1] > p[1])
            && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
        is_inside != crosses
    })
}

/// A planar set: disjoint shapes in `world`. The types of `csat-agent` say whether it is an outer or an
/// inner approximation.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Region {
    shapes: Vec<Shape>,
}

impl Region {
    /// ∅.
    pub const EMPTY: Region = Region { shapes: Vec::new() };

    /// A region from shapes that are already simple, disjoint and oriented.
    pub fn from_shapes(shapes: Vec<Shape>) -> Self {
        Self { shapes }
    }

    /// The axis-aligned rectangle of `size_m`, centred on the origin.
    pub fn rectangle(size_m: [f64; 2]) -> Self {
        let (x, y) = (to_units(size_m[0] / 2.0), to_units(size_m[1] / 2.0));
        let ring = [(-x, -y), (x, -y), (x, y), (-x, y)];
        Self { shapes: vec![vec![ring.iter().map(|&(x, y)| GridPoint::new(x, y)).collect()]] }
    }

    /// The shapes.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    /// The shapes, by value.
    pub fn into_shapes(self) -> Vec<Shape> {
        self.shapes
    }

    /// Every ring, outer ones and holes.
    pub fn rings(&self) -> impl Iterator<Item = &Ring> {
        self.shapes.iter().flatten()
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.rings().map(Vec::len).sum()
    }

    /// Whether the set is empty.
    pub fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }

    /// φ: the area, in square metres.
    pub fn area_m2(&self) -> f64 {
        let twice: i128 = self.rings().map(|ring| twice_signed_area(ring)).sum();
        twice as f64 / 2.0 / (UNITS_PER_M * UNITS_PER_M)
    }

    /// c: the barycentre, in metres; `None` for a set without area.
    pub fn barycentre(&self) -> Option<[f64; 2]> {
        let (mut area, mut x, mut y) = (0.0, 0.0, 0.0);
        for ring in self.rings() {
            for (i, &p) in ring.iter().enumerate() {
                let (a, b) = (metres(p), metres(ring[(i + 1) % ring.len()]));
                let cross = a[0] * b[1] - b[0] * a[1];
                area += cross;
                x += (a[0] + b[0]) * cross;
                y += (a[1] + b[1]) * cross;
            }
        }
        (area > 0.0).then(|| [x / (3.0 * area), y / (3.0 * area)])
    }

    /// The bounding box; `None` for ∅.
    pub fn bounds(&self) -> Option<GridBox> {
        GridBox::around(self.shapes.iter().filter_map(|s| s.first()).flatten())
    }

    /// Whether a point (metres) lies in the set. On the boundary either answer is possible; use
    /// [`Self::distance_m`] where that matters.
    pub fn contains(&self, p: [f64; 2]) -> bool {
        let edges = self.rings().flat_map(|ring| {
            let starts = ring.last().into_iter().chain(ring);
            starts.zip(ring).map(|(&a, &b)| [metres(a), metres(b)])
        });
        is_inside(edges, p)
    }

    /// Distance in metres from a point to the set: 0 inside, infinite for ∅.
    pub fn distance_m(&self, p: [f64; 2]) -> f64 {
        if self.contains(p) {
            return 0.0;
        }
        let mut nearest = f64::INFINITY;
        for ring in self.rings() {
            let mut a = metres(*ring.last().expect("rings are never empty"));
            for &q in ring {
                let b = metres(q);
                nearest = nearest.min(distance_to_segment_squared(p, a, b));
                a = b;
            }
        }
        nearest.sqrt()
    }
}

fn distance_to_segment_squared(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length = dx * dx + dy * dy;
    let along = if length > 0.0 {
        (((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let (x, y) = (p[0] - a[0] - along * dx, p[1] - a[1] - along * dy);
    x * x + y * y
}

/// On the wire a region is its rings, each point as the difference from the point before, so that
/// nearby points take few bytes.
impl Serialize for Region {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut previous = GridPoint::ZERO;
        let mut deltas = |ring: &Ring| -> Vec<(i64, i64)> {
            ring.iter()
                .map(|&p| {
                    let d = (
                        i64::from(p.x) - i64::from(previous.x),
                        i64::from(p.y) - i64::from(previous.y),
                    );
                    previous = p;
                    d
                })
                .collect()
        };
        let wire: Vec<Vec<Vec<(i64, i64)>>> =
            self.shapes.iter().map(|s| s.iter().map(&mut deltas).collect()).collect();
        wire.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Region {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        use serde::de::Error;
        let wire = Vec::<Vec<Vec<(i64, i64)>>>::deserialize(deserializer)?;
        let limit = u64::from(to_units(MAX_COORDINATE_M).unsigned_abs());
        let (mut x, mut y) = (0i64, 0i64);
        let mut shapes = Vec::with_capacity(wire.len());
        for wire_shape in wire {
            let mut shape = Vec::with_capacity(wire_shape.len());
            for wire_ring in wire_shape {
                let mut ring = Vec::with_capacity(wire_ring.len());
                for (dx, dy) in wire_ring {
                    (x, y) = (x.saturating_add(dx), y.saturating_add(dy));
                    if x.unsigned_abs() > limit || y.unsigned_abs() > limit {
                        return Err(D::Error::custom("region vertex outside the grid"));
                    }
                    ring.push(GridPoint::new(x as i32, y as i32));
                }
                if ring.len() < 3 {
                    return Err(D::Error::custom("region ring with fewer than 3 vertices"));
                }
                shape.push(ring);
            }
            if shape.is_empty() {
                return Err(D::Error::custom("region shape without a ring"));
            }
            shapes.push(shape);
        }
        Ok(Self { shapes })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(points: &[(f64, f64)]) -> Ring {
        points.iter().map(|&(x, y)| grid_point([x, y])).collect()
    }

    fn frame_with_hole() -> Region {
        Region::from_shapes(vec![vec![
            ring(&[(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)]),
            ring(&[(1.0, 1.0), (1.0, 3.0), (3.0, 3.0), (3.0, 1.0)]),
        ]])
    }

    #[test]
    fn measures_of_a_square_with_a_hole() {
        let region = frame_with_hole();
        assert_eq!(region.area_m2(), 12.0);
        assert_eq!(region.barycentre(), Some([2.0, 2.0]));
        assert!(region.contains([0.5, 0.5]) && !region.contains([2.0, 2.0]));
        assert_eq!(region.distance_m([2.0, 2.0]), 1.0);
        assert_eq!(region.distance_m([7.0, 8.0]), 5.0);
        assert_eq!(Region::EMPTY.distance_m([0.0, 0.0]), f64::INFINITY);
    }

    #[test]
    fn the_wire_keeps_every_vertex() {
        let region = frame_with_hole();
        let bytes = postcard::to_stdvec(&region).unwrap();
        assert_eq!(postcard::from_bytes::<Region>(&bytes).unwrap(), region);
    }

    #[test]
    fn degenerate_rings_and_far_points_are_refused() {
        let two_points = vec![vec![vec![(0i64, 0i64), (1, 1)]]];
        let far = vec![vec![vec![(0i64, 0i64), (1 << 40, 1), (0, 5)]]];
        // The only number without an absolute value.
        let farthest = vec![vec![vec![(i64::MIN, 0i64), (0, 1), (0, 5)]]];
        for wire in [two_points, far, farthest, vec![vec![]]] {
            let bytes = postcard::to_stdvec(&wire).unwrap();
            assert!(postcard::from_bytes::<Region>(&bytes).is_err(), "{wire:?}");
        }
    }
}
