//! How many searchers a network needs that see no more than a point each: a reference line for UAVs that clear roads.
//!
//! Searchers look for an evader of any speed on the edges of a graph. In *node searching* they are put on nodes and
//! taken away again, and an edge is cleared when both of its ends are guarded at once. In *edge searching* an edge is
//! cleared by one that slides along it, as UAVs fly along roads: one of them clears a street without junctions, and
//! bends do not count. Both numbers are vertex separations: that of the graph plus 1 (Kirousis, Papadimitriou 1986), and
//! that of the graph with two more nodes on each edge (Ellis, Sudborough, Turner 1994).
//!
//! | module | what it does |
//! |---|---|
//! | `tree` | the vertex separation of a tree |
//! | `order` | bounds of that of any graph |

mod order;
#[cfg(test)]
mod tests;
mod tree;

use std::collections::BTreeMap;

use crate::road::RoadGraph;

/// The number of searchers, exactly where both bounds are equal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bounds {
    /// Fewer do not do.
    pub at_least: usize,
    /// So many do.
    pub at_most: usize,
}

impl Bounds {
    fn exactly(number: usize) -> Self {
        Self { at_least: number, at_most: number }
    }

    /// Of two things of which each needs all: the greater of both.
    fn or(self, other: Self) -> Self {
        let at_least = self.at_least.max(other.at_least);
        Self { at_least, at_most: self.at_most.max(other.at_most) }
    }

    fn plus(self, more: usize) -> Self {
        Self { at_least: self.at_least + more, at_most: self.at_most + more }
    }
}

/// Nodes, by index, and edges between them: loops and several edges between two nodes are possible.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Network {
    nodes: usize,
    edges: Vec<[usize; 2]>,
}

impl Network {
    /// A network of edges between nodes below `nodes`.
    pub fn new(nodes: usize, edges: Vec<[usize; 2]>) -> Self {
        Self { nodes, edges }
    }

    /// Junctions and dead ends of roads, and the streets between them; `None` without roads.
    pub fn of_roads(roads: &RoadGraph) -> Option<Self> {
        let mut numbers: BTreeMap<usize, usize> = BTreeMap::new();
        let mut number = |node: usize| {
            let next = numbers.len();
            *numbers.entry(node).or_insert(next)
        };
        let edges: Vec<_> = roads.edges().iter().map(|edge| edge.nodes.map(&mut number)).collect();
        (!edges.is_empty()).then(|| Self::new(numbers.len(), edges))
    }

    /// The node search number.
    pub fn node_search(&self) -> Bounds {
        separation(&Graph::new(self)).plus(1)
    }

    /// The edge search number.
    pub fn edge_search(&self) -> Bounds {
        let least = Bounds::exactly(usize::from(self.nodes > 0));
        separation(&Graph::new(&self.expanded())).or(least)
    }

    /// The same with two more nodes on each edge.
    fn expanded(&self) -> Self {
        let parts = self.edges.iter().zip((self.nodes..).step_by(2));
        let parts = parts.flat_map(|(&[a, b], c)| [[a, c], [c, c + 1], [c + 1, b]]);
        Self::new(self.nodes + 2 * self.edges.len(), parts.collect())
    }
}

/// A graph without loops, with one edge at most between two nodes: the neighbours of each node, ascending.
#[derive(Debug, Clone)]
struct Graph(Vec<Vec<usize>>);

impl Graph {
    fn new(network: &Network) -> Self {
        let mut neighbours = vec![Vec::new(); network.nodes];
        for &[a, b] in network.edges.iter().filter(|[a, b]| a != b) {
            neighbours[a].push(b);
            neighbours[b].push(a);
        }
        neighbours.iter_mut().for_each(|of_node| {
            of_node.sort_unstable();
            of_node.dedup();
        });
        Self(neighbours)
    }

    fn count(&self) -> usize {
        self.0.len()
    }

    fn neighbours(&self, node: usize) -> &[usize] {
        &self.0[node]
    }

    fn edges(&self) -> usize {
        self.0.iter().map(Vec::len).sum::<usize>() / 2
    }

    /// Its connected parts.
    fn components(&self) -> Vec<Self> {
        let mut number = vec![None; self.count()];
        let mut parts = Vec::new();
        for start in 0..self.count() {
            if number[start].is_some() {
                continue;
            }
            let mut nodes = vec![start];
            number[start] = Some(0);
            let mut done = 0;
            while let Some(&node) = nodes.get(done) {
                done += 1;
                for &next in self.neighbours(node) {
                    if number[next].is_none() {
                        number[next] = Some(nodes.len());
                        nodes.push(next);
                    }
                }
            }
            let renumbered = |node: &usize| {
                let neighbours = self.neighbours(*node).iter();
                let mut neighbours: Vec<usize> = neighbours.filter_map(|n| number[*n]).collect();
                neighbours.sort_unstable();
                neighbours
            };
            parts.push(Self(nodes.iter().map(renumbered).collect()));
        }
        parts
    }
}

/// The vertex separation: of all orders of the nodes the least, and in an order the greatest, number of nodes so far
/// that have a neighbour later.
fn separation(graph: &Graph) -> Bounds {
    let of_part = |part: &Graph| match part.edges() + 1 == part.count() {
        true => Bounds::exactly(tree::separation(part)),
        false => order::separation(part),
    };
    graph.components().iter().map(of_part).fold(Bounds::exactly(0), Bounds::or)
}
