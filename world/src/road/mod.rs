//! Where cars can drive: the road graph, clear of walls.

use csat_proto::model::Ground;

mod build;
mod noding;

use crate::map::Map;
use crate::obstacle::Walls;
use crate::plane::{Point, between, distance_m, minus};
use crate::road_area::RoadArea;

/// Which parts of roads are usable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RoadRules {
    /// Roads end this far inside the border of the region, metres.
    pub(crate) inset_m: f64,
    /// The least distance of usable roads to every wall, metres.
    pub(crate) clearance_m: f64,
    /// Connected pieces of road shorter than this are left out, metres.
    pub(crate) min_network_m: f64,
}

/// A part of a road between two nodes without a junction on it.
#[derive(Debug, Clone, PartialEq)]
pub struct RoadEdge {
    /// The nodes at its ends; equal for a loop.
    pub nodes: [usize; 2],
    /// The centre line, `world`, metres; at least two points.
    pub line: Vec<[f64; 2]>,
    /// Arc length at each point of `line`, metres.
    along_m: Vec<f64>,
}

impl RoadEdge {
    fn new(nodes: [usize; 2], line: Vec<Point>) -> Self {
        let mut along_m = Vec::with_capacity(line.len());
        let mut total = 0.0;
        for (i, &p) in line.iter().enumerate() {
            total += if i > 0 { distance_m(line[i - 1], p) } else { 0.0 };
            along_m.push(total);
        }
        Self { nodes, line, along_m }
    }

    /// Length, metres.
    pub fn length_m(&self) -> f64 {
        self.along_m.last().copied().unwrap_or(0.0)
    }

    /// The point at arc length `along_m` (clamped to the edge) and the direction of the line there,
    /// radians from east.
    pub(crate) fn at(&self, along_m: f64) -> ([f64; 2], f64) {
        let last = self.line.len() - 2;
        let segment = self.along_m.partition_point(|&s| s <= along_m).saturating_sub(1).min(last);
        let (a, b) = (self.line[segment], self.line[segment + 1]);
        let (from, to) = (self.along_m[segment], self.along_m[segment + 1]);
        let t = if to > from { ((along_m - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        let d = minus(b, a);
        (between(a, b, t), d[1].atan2(d[0]))
    }
}

/// One end of an edge at a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Arm {
    /// The edge.
    pub(crate) edge: usize,
    /// True at the beginning of the edge.
    pub(crate) forward: bool,
}

/// The usable roads of a town. Every point of every edge keeps its distance to all walls.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RoadGraph {
    nodes: Vec<Point>,
    edges: Vec<RoadEdge>,
    arms: Vec<Vec<Arm>>,
}

impl RoadGraph {
    /// The usable part of `polylines` (centre lines, `world`, metres): clipped to the region, joined
    /// where they meet or cross, cut where they are too close to a wall. Equal arguments give equal
    /// graphs.
    pub(crate) fn build(
        ground: &Ground,
        polylines: &[Vec<[f64; 2]>],
        walls: &Walls,
        rules: &RoadRules,
    ) -> Self {
        let segments = noding::noded(ground, polylines, rules.inset_m);
        build::graph(&segments, walls, rules)
    }

    /// The centre lines of a map's roads within a part of its road area. Walls do not count. Roads that touch at their
    /// sides, while their centre lines do not meet, do not meet here.
    pub fn within(map: &Map, area: &RoadArea) -> Self {
        let rules = RoadRules { inset_m: 0.0, clearance_m: 0.0, min_network_m: 0.0 };
        let Self { nodes, mut edges, .. } =
            Self::build(&map.ground, &map.roads, &Walls::new(&[]), &rules);
        edges.retain(|edge| area.is_road(edge.at(edge.length_m() / 2.0).0));
        Self::new(nodes, edges)
    }

    fn new(nodes: Vec<Point>, edges: Vec<RoadEdge>) -> Self {
        let mut arms = vec![Vec::new(); nodes.len()];
        for (index, edge) in edges.iter().enumerate() {
            arms[edge.nodes[0]].push(Arm { edge: index, forward: true });
            arms[edge.nodes[1]].push(Arm { edge: index, forward: false });
        }
        Self { nodes, edges, arms }
    }

    /// Junctions and dead ends, `world`, metres.
    #[cfg(test)]
    pub(crate) fn nodes(&self) -> &[[f64; 2]] {
        &self.nodes
    }

    /// The edges between them.
    pub fn edges(&self) -> &[RoadEdge] {
        &self.edges
    }

    /// The arms of a node, by increasing edge.
    pub(crate) fn arms(&self, node: usize) -> &[Arm] {
        self.arms.get(node).map_or(&[], Vec::as_slice)
    }

    /// Length of all edges, metres.
    pub fn length_m(&self) -> f64 {
        self.edges.iter().map(RoadEdge::length_m).sum()
    }

    /// The edge and the arc length on it at `along_m` of the total length, as if all edges were
    /// laid end to end; `None` beyond it.
    pub(crate) fn locate(&self, along_m: f64) -> Option<(usize, f64)> {
        let mut rest = along_m;
        for (index, edge) in self.edges.iter().enumerate() {
            if rest <= edge.length_m() {
                return Some((index, rest));
            }
            rest -= edge.length_m();
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::obstacle::Obstacle;
    use geo::polygon;
    use proptest::prelude::*;

    const GROUND: Ground = Ground { size_m: [200.0, 200.0] };
    const RULES: RoadRules = RoadRules { inset_m: 3.0, clearance_m: 2.55, min_network_m: 20.0 };

    fn wall(x: f64, y: f64, side: f64) -> Obstacle {
        Obstacle {
            footprint: polygon![
                (x: x, y: y), (x: x + side, y: y), (x: x + side, y: y + side), (x: x, y: y + side)
            ],
            height_m: 9.0,
            name: String::new(),
        }
    }

    fn build(lines: &[&[Point]], walls: &[Obstacle]) -> RoadGraph {
        let lines: Vec<Vec<Point>> = lines.iter().map(|l| l.to_vec()).collect();
        RoadGraph::build(&GROUND, &lines, &Walls::new(walls), &RULES)
    }

    fn degrees(graph: &RoadGraph) -> Vec<usize> {
        let mut degrees: Vec<usize> =
            (0..graph.nodes().len()).map(|n| graph.arms(n).len()).collect();
        degrees.sort_unstable();
        degrees
    }

    #[test]
    fn a_crossing_becomes_a_junction_and_the_ends_stay_inside() {
        let graph = build(&[&[[-500.0, 0.0], [500.0, 0.0]], &[[10.0, -500.0], [10.0, 500.0]]], &[]);
        assert_eq!(degrees(&graph), [1, 1, 1, 1, 4]);
        assert!((graph.length_m() - 4.0 * 97.0).abs() < 1e-9);
        assert!(graph.nodes().iter().any(|n| distance_m(*n, [10.0, 0.0]) < 1e-9));
    }

    #[test]
    fn shared_and_nearly_shared_ends_join() {
        let graph = build(
            &[
                &[[0.0, 0.0], [50.0, 0.0]],
                &[[50.0, 0.0], [90.0, 30.0]],
                // Ends 5 cm from the middle of the first road, and 5 cm before its end.
                &[[25.0, 0.05], [25.0, 40.0]],
                &[[50.0, -0.05], [50.0, -40.0]],
            ],
            &[],
        );
        assert_eq!(degrees(&graph), [1, 1, 1, 1, 3, 3]);
    }

    #[test]
    fn a_wall_cuts_the_road_and_a_road_through_a_building_goes() {
        let road: &[Point] = &[[-80.0, 0.0], [80.0, 0.0]];
        let graph = build(&[road], &[wall(0.0, 2.0, 10.0)]);
        assert_eq!(degrees(&graph), [1, 1, 1, 1]);
        // The clearance disc about the corner (0, 2) meets y = 0 at ∓√(2.55² − 2²).
        let reach = (2.55f64 * 2.55 - 4.0).sqrt();
        assert!((graph.length_m() - (160.0 - 10.0 - 2.0 * reach)).abs() < 1e-9);
        // All of the inside is forbidden, at any distance from its walls.
        let graph = build(&[road], &[wall(-40.0, -40.0, 80.0)]);
        assert!((graph.length_m() - 2.0 * (80.0 - 42.55)).abs() < 1e-9);
        assert_eq!(
            build(&[&[[-30.0, 0.0], [30.0, 5.0]]], &[wall(-40.0, -40.0, 80.0)]),
            RoadGraph::default()
        );
    }

    #[test]
    fn short_networks_are_left_out_and_repeats_count_once() {
        let short: &[Point] = &[[0.0, 0.0], [19.0, 0.0]];
        assert_eq!(build(&[short], &[]).edges().len(), 0);
        let long: &[Point] = &[[0.0, 50.0], [60.0, 50.0]];
        let graph = build(&[short, long, long], &[]);
        assert_eq!(graph.length_m(), 60.0);
        assert_eq!(graph.edges().len(), 1);
    }

    #[test]
    fn bends_are_no_junctions_and_rings_are_loops() {
        let bend: &[Point] = &[[0.0, 0.0], [40.0, 0.0], [40.0, 40.0], [80.0, 40.0]];
        let graph = build(&[bend], &[]);
        assert_eq!(graph.edges().len(), 1);
        assert_eq!(graph.edges()[0].line.len(), 4);
        let ring: &[Point] = &[[0.0, 0.0], [40.0, 0.0], [40.0, 40.0], [0.0, 0.0]];
        let graph = build(&[ring], &[]);
        assert_eq!((graph.nodes().len(), graph.edges().len()), (1, 1));
        assert_eq!(graph.arms(0).len(), 2);
        assert!((graph.length_m() - (80.0 + 3200f64.sqrt())).abs() < 1e-9);
    }

    #[test]
    fn points_along_an_edge() {
        let edge = RoadEdge::new([0, 1], vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]]);
        assert_eq!(edge.at(-1.0), ([0.0, 0.0], 0.0));
        assert_eq!(edge.at(1.0), ([1.0, 0.0], 0.0));
        assert_eq!(edge.at(6.0), ([4.0, 2.0], std::f64::consts::FRAC_PI_2));
        assert_eq!(edge.at(9.0).0, [4.0, 4.0]);
    }

    fn point() -> impl Strategy<Value = Point> {
        [-120.0..120.0f64, -120.0..120.0f64]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn every_point_of_any_graph_is_clear_and_inside(
            lines in prop::collection::vec(prop::collection::vec(point(), 2..6), 1..8),
            walls in prop::collection::vec((point(), 1.0..40.0f64), 0..12),
        ) {
            let walls: Vec<Obstacle> = walls.iter().map(|(p, s)| wall(p[0], p[1], *s)).collect();
            let walls = Walls::new(&walls);
            let graph = RoadGraph::build(&GROUND, &lines, &walls, &RULES);
            for edge in graph.edges() {
                let steps = (edge.length_m() / 0.1).ceil();
                for i in 0..=steps as u32 {
                    let (p, _) = edge.at(f64::from(i) / steps * edge.length_m());
                    prop_assert!(p.iter().all(|x| x.abs() <= 97.2), "{:?}", p);
                    prop_assert_eq!(walls.nearest_within(p, RULES.clearance_m - 1e-6), None);
                }
                for (end, node) in [(0, edge.nodes[0]), (edge.line.len() - 1, edge.nodes[1])] {
                    prop_assert_eq!(edge.line[end], graph.nodes()[node]);
                }
            }
        }
    }
}
