//! From segments to a graph: parts too near to walls are cut out, the rest is joined into edges between
//! junctions.

use std::collections::{BTreeMap, BTreeSet};

use csat_proto::region::is_inside;

use super::noding::Segment;
use super::{RoadEdge, RoadGraph, RoadRules};
use crate::obstacle::Walls;
use crate::plane::{Point, between, distance_m, interval_near_segment};

/// Shorter pieces after a cut are dropped, metres.
const MIN_PIECE_M: f64 = 0.01;

/// The graph of the usable parts of `segments`, which meet only at equal ends.
pub(super) fn graph(segments: &[Segment], walls: &Walls, rules: &RoadRules) -> RoadGraph {
    let mut links = RoadLinks::default();
    for &segment in segments {
        for [lo, hi] in clear_intervals(segment, walls, rules.clearance_m) {
            let [a, b] = segment;
            // Ends that are not cut stay bit-equal to those of other segments.
            let from = if lo == 0.0 { a } else { between(a, b, lo) };
            let to = if hi == 1.0 { b } else { between(a, b, hi) };
            if distance_m(from, to) > MIN_PIECE_M {
                links.add(from, to);
            }
        }
    }
    let edges = links.chains();
    keep_long_networks(&links.nodes, edges, rules.min_network_m)
}

/// The parameters of the parts of a segment that keep their distance to all walls.
fn clear_intervals([a, b]: Segment, walls: &Walls, clearance_m: f64) -> Vec<[f64; 2]> {
    let mut blocked: Vec<[f64; 2]> = Vec::new();
    let near: Vec<_> = walls.near_segment([a, b], clearance_m).map(|(_, edges)| edges).collect();
    for edges in &near {
        blocked.extend(edges.iter().filter_map(|w| interval_near_segment([a, b], *w, clearance_m)));
    }
    blocked.sort_by(|x, y| x[0].total_cmp(&y[0]));
    blocked.push([1.0, 1.0]);
    let (mut clear, mut from) = (Vec::new(), 0.0);
    for [lo, hi] in blocked {
        if lo > from {
            clear.push([from, lo]);
        }
        from = hi.max(from);
    }
    // A part far from all walls may be inside a building: wholly or not at all.
    let inside = |[lo, hi]: [f64; 2]| {
        let middle = between(a, b, (lo + hi) / 2.0);
        near.iter().any(|edges| is_inside(*edges, middle))
    };
    clear.retain(|interval| !inside(*interval));
    clear
}

/// Straight links between nodes, without repeats.
#[derive(Default)]
struct RoadLinks {
    nodes: Vec<Point>,
    index: BTreeMap<[u64; 2], usize>,
    links: BTreeSet<[usize; 2]>,
    neighbours: Vec<Vec<usize>>,
}

impl RoadLinks {
    fn node(&mut self, p: Point) -> usize {
        // + 0.0 turns −0 into 0: equal points have equal bits.
        let next = self.nodes.len();
        let node = *self.index.entry(p.map(|x| (x + 0.0).to_bits())).or_insert(next);
        if node == next {
            self.nodes.push(p);
            self.neighbours.push(Vec::new());
        }
        node
    }

    fn add(&mut self, a: Point, b: Point) {
        let (a, b) = (self.node(a), self.node(b));
        if self.links.insert([a.min(b), a.max(b)]) {
            self.neighbours[a].push(b);
            self.neighbours[b].push(a);
        }
    }

    /// Chains of links between junctions and dead ends (and whole rings), as lists of nodes.
    fn chains(&self) -> Vec<Vec<usize>> {
        let mut left = self.links.clone();
        let mut chains = Vec::new();
        let bend = |node: usize| self.neighbours[node].len() == 2;
        let starts = (0..self.nodes.len()).filter(|&n| !bend(n));
        // Rings without a junction start at their first node; they come last.
        for start in starts.chain(0..self.nodes.len()) {
            for &next in &self.neighbours[start] {
                let mut chain = vec![start];
                let (mut from, mut to) = (start, next);
                while left.remove(&[from.min(to), from.max(to)]) {
                    chain.push(to);
                    if to == start || !bend(to) {
                        break;
                    }
                    let onward = self.neighbours[to].iter().copied().find(|&n| n != from);
                    (from, to) = (to, onward.unwrap_or(from));
                }
                if chain.len() > 1 {
                    chains.push(chain);
                }
            }
        }
        chains
    }
}

/// The graph of the chains, without connected pieces shorter than `min_network_m`.
fn keep_long_networks(points: &[Point], chains: Vec<Vec<usize>>, min_network_m: f64) -> RoadGraph {
    let mut network_of: Vec<usize> = (0..points.len()).collect();
    for chain in &chains {
        let (a, b) = (network_of[chain[0]], network_of[chain[chain.len() - 1]]);
        let (keep, drop) = (a.min(b), a.max(b));
        network_of.iter_mut().filter(|n| **n == drop).for_each(|n| *n = keep);
    }
    let lines = chains.iter().map(|chain| {
        let line: Vec<Point> = chain.iter().map(|&n| points[n]).collect();
        (chain[0], chain[chain.len() - 1], line)
    });
    let mut lengths = vec![0.0; points.len()];
    let lines: Vec<_> = lines.collect();
    for (from, _, line) in &lines {
        lengths[network_of[*from]] += line.windows(2).map(|w| distance_m(w[0], w[1])).sum::<f64>();
    }
    let (mut nodes, mut edges) = (Vec::new(), Vec::new());
    let mut renumbered: BTreeMap<usize, usize> = BTreeMap::new();
    for (from, to, line) in lines {
        if lengths[network_of[from]] < min_network_m {
            continue;
        }
        let ends = [from, to].map(|node| {
            *renumbered.entry(node).or_insert_with(|| {
                nodes.push(points[node]);
                nodes.len() - 1
            })
        });
        edges.push(RoadEdge::new(ends, line));
    }
    RoadGraph::new(nodes, edges)
}
