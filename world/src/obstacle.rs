//! Obstacles: Z-convex solids (3.1) that stand on the ground, and exact distances to them.

use csat_proto::region::is_inside;
use geo::{Area, Polygon};

use crate::plane::{Bounds, Point, distance_to_segment_m};
use crate::scene::{Entity, Prism};

/// A footprint extruded from the ground to a flat top (3.1). Obstacles of one map may touch but do
/// not overlap by more than rounding (a few µm).
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacle {
    /// A simple polygon: outer ring counter-clockwise, holes clockwise; `world`, metres.
    pub footprint: Polygon<f64>,
    /// Height of the top, metres.
    pub height_m: f64,
    /// Its name: the ids of the features that it was made from, or its generated type.
    pub name: String,
}

impl Obstacle {
    /// The rings, outer one first, without the closing repetition; `world`, metres.
    pub fn rings(&self) -> impl Iterator<Item = Vec<[f64; 2]>> {
        std::iter::once(self.footprint.exterior()).chain(self.footprint.interiors()).map(|ring| {
            let points = ring.0.split_last().map_or(&[][..], |(_, open)| open);
            points.iter().map(|c| [c.x, c.y]).collect()
        })
    }

    /// Area of the footprint, m².
    pub fn area_m2(&self) -> f64 {
        self.footprint.unsigned_area()
    }

    /// The solid that cameras see. `index` is its position in the list of the map.
    pub fn prism(&self, index: u32) -> Prism {
        Prism {
            entity: Entity::Obstacle(index),
            rings: self.rings().collect(),
            height_m: self.height_m,
        }
    }
}

/// The footprints of a map's obstacles, prepared for exact distance queries.
#[derive(Debug, Clone, Default)]
pub struct Walls {
    footprints: Vec<FootprintEdges>,
}

#[derive(Debug, Clone)]
struct FootprintEdges {
    height_m: f64,
    bounds: Bounds,
    edges: Vec<[Point; 2]>,
}

impl Walls {
    /// The walls of `obstacles`, in the same order.
    pub fn new(obstacles: &[Obstacle]) -> Self {
        Self { footprints: obstacles.iter().map(FootprintEdges::new).collect() }
    }

    /// The obstacle nearest to `p_world` among those nearer than `reach_m`, and its distance: 0 in
    /// and on a footprint, else to the nearest wall (a courtyard is not part of its building).
    pub fn nearest_within(&self, p_world: [f64; 2], reach_m: f64) -> Option<(usize, f64)> {
        self.nearest_above(f64::NEG_INFINITY, p_world, reach_m)
    }

    /// The nearest one among obstacles that are higher than `height_m`.
    pub fn nearest_above(
        &self,
        height_m: f64,
        p_world: [f64; 2],
        reach_m: f64,
    ) -> Option<(usize, f64)> {
        let mut nearest = None;
        let mut reach = reach_m;
        let high = |(_, footprint): &(usize, &FootprintEdges)| footprint.height_m > height_m;
        for (index, footprint) in self.footprints.iter().enumerate().filter(high) {
            // The box is only a filter; it is slightly wider, so that rounding cannot hide a wall.
            if footprint.bounds.grown(reach * (1.0 + 1e-9)).contains(p_world) {
                let distance = footprint.distance_m(p_world);
                if distance < reach {
                    (nearest, reach) = (Some((index, distance)), distance);
                }
            }
        }
        nearest
    }

    /// The index and the walls of every obstacle whose bounding box is within `reach_m` of the
    /// bounding box of the segment.
    pub(crate) fn near_segment(
        &self,
        [a, b]: [Point; 2],
        reach_m: f64,
    ) -> impl Iterator<Item = (usize, &[[Point; 2]])> {
        let bounds = Bounds::around([a, b]).map(|b| b.grown(reach_m));
        self.footprints
            .iter()
            .enumerate()
            .filter(move |(_, f)| bounds.is_some_and(|b| b.meets(&f.bounds)))
            .map(|(index, f)| (index, f.edges.as_slice()))
    }
}

impl FootprintEdges {
    fn new(obstacle: &Obstacle) -> Self {
        let mut edges = Vec::new();
        for ring in obstacle.rings() {
            edges.extend((0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()]]));
        }
        let nowhere = Bounds { min: [f64::INFINITY; 2], max: [f64::NEG_INFINITY; 2] };
        let bounds = Bounds::around(edges.iter().map(|e| e[0])).unwrap_or(nowhere);
        Self { height_m: obstacle.height_m, bounds, edges }
    }

    fn distance_m(&self, p: Point) -> f64 {
        if is_inside(&self.edges, p) {
            return 0.0;
        }
        self.edges
            .iter()
            .map(|&[a, b]| distance_to_segment_m(p, a, b))
            .fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geo::{Distance, Euclidean, polygon};
    use proptest::prelude::*;

    fn courtyard() -> Obstacle {
        Obstacle {
            footprint: polygon!(
                exterior: [
                    (x: 0.0, y: 0.0), (x: 10.0, y: 0.0), (x: 14.0, y: 8.0), (x: 0.0, y: 10.0)
                ],
                interiors: [[(x: 3.0, y: 3.0), (x: 3.0, y: 7.0), (x: 7.0, y: 7.0), (x: 7.0, y: 3.0)]],
            ),
            height_m: 12.0,
            name: "yard".into(),
        }
    }

    #[test]
    fn a_prism_has_open_rings_outer_first() {
        let prism = courtyard().prism(3);
        assert_eq!(prism.entity, Entity::Obstacle(3));
        assert_eq!(prism.rings.len(), 2);
        assert_eq!(prism.rings[0].len(), 4);
        assert_eq!(prism.rings[1][0], [3.0, 3.0]);
        assert_eq!(prism.height_m, 12.0);
    }

    #[test]
    fn a_courtyard_is_free_and_its_building_is_not() {
        let walls = Walls::new(&[courtyard()]);
        assert_eq!(walls.nearest_within([1.0, 1.0], 5.0), Some((0, 0.0)));
        assert_eq!(walls.nearest_within([5.0, 5.0], 5.0), Some((0, 2.0)));
        assert_eq!(walls.nearest_within([5.0, 5.0], 1.9), None);
        assert_eq!(walls.nearest_within([-3.0, 5.0], 5.0), Some((0, 3.0)));
        assert_eq!(walls.nearest_within([-3.0, 5.0], 3.0), None);
    }

    proptest! {
        #[test]
        fn distances_agree_with_geo(x in -20.0..30.0f64, y in -20.0..30.0f64) {
            let obstacle = courtyard();
            let expected = Euclidean.distance(&geo::Point::new(x, y), &obstacle.footprint);
            let (index, got) = Walls::new(&[obstacle]).nearest_within([x, y], 1e3).unwrap();
            prop_assert_eq!(index, 0);
            prop_assert!((got - expected).abs() < 1e-9, "{} {}", got, expected);
        }
    }
}
