//! Bounds of the vertex separation of a connected graph with loops.
//!
//! From below: a part of a graph needs no more than the whole, so each spanning tree gives a bound. From above: each
//! order of the nodes gives one. In between, all orders are tried, without those that cannot be better, as long as that
//! takes little.

use std::collections::BTreeSet;

use super::{Bounds, Graph, tree};

/// From how many nodes spanning trees and orders begin.
const STARTS: usize = 16;
/// How many nodes are looked at to prove or refute one number, at most.
const EFFORT: usize = 4_000_000;

/// Bounds of the vertex separation.
pub(super) fn separation(graph: &Graph) -> Bounds {
    let starts = starts(graph);
    let few = || starts.iter().copied().take(STARTS);
    let trees = few().flat_map(|root| [false, true].map(|is_deep| (root, is_deep)));
    let of_tree = |(root, is_deep)| tree::separation(&tree::of_graph(graph, root, is_deep));
    // A loop alone has a separation of 2.
    let mut at_least = trees.map(of_tree).fold(2, usize::max);
    let at_most = few().map(|start| in_order(graph, start)).min().unwrap_or(graph.count());
    while at_least < at_most {
        match has_order(graph, &starts, at_least) {
            Some(true) => return Bounds::exactly(at_least),
            Some(false) => at_least += 1,
            None => {
                return Bounds { at_least, at_most: refined(graph, &starts, at_least, at_most) };
            }
        }
    }
    Bounds::exactly(at_most)
}

/// The least separation above `at_least` of which an order is found.
fn refined(graph: &Graph, starts: &[usize], at_least: usize, at_most: usize) -> usize {
    let found = |k: &usize| has_order(graph, starts, *k) == Some(true);
    (at_least + 1..at_most).find(found).unwrap_or(at_most)
}

/// Where the nodes of an order may begin anew, away from those before: at nodes with three neighbours or more. A node
/// with fewer may as well wait until a neighbour is there, or come right after it.
fn starts(graph: &Graph) -> Vec<usize> {
    let all = 0..graph.count();
    let junctions: Vec<usize> =
        all.clone().filter(|node| graph.neighbours(*node).len() > 2).collect();
    if junctions.is_empty() { all.collect() } else { junctions }
}

/// The nodes of an order so far.
#[derive(Debug, Clone)]
struct Prefix {
    is_placed: Vec<bool>,
    /// By node: how many neighbours are not placed.
    later: Vec<usize>,
    /// Placed nodes with neighbours that are not.
    border: Vec<usize>,
    count: usize,
}

impl Prefix {
    fn new(graph: &Graph) -> Self {
        let later = (0..graph.count()).map(|node| graph.neighbours(node).len()).collect();
        Self { is_placed: vec![false; graph.count()], later, border: Vec::new(), count: 0 }
    }

    fn place(&mut self, graph: &Graph, node: usize) {
        self.is_placed[node] = true;
        self.count += 1;
        for &next in graph.neighbours(node) {
            self.later[next] -= 1;
        }
        self.border.push(node);
        self.border.retain(|node| self.later[*node] > 0);
    }

    /// Whether the border does not grow with a node.
    fn is_free(&self, graph: &Graph, node: usize) -> bool {
        let leaves = |next: &usize| self.is_placed[*next] && self.later[*next] == 1;
        self.later[node] == 0 || graph.neighbours(node).iter().any(leaves)
    }

    /// The nodes beside the border that are not placed, those beside nodes that have the fewest first.
    fn beside(&self, graph: &Graph) -> Vec<usize> {
        let mut border = self.border.clone();
        border.sort_unstable_by_key(|node| (self.later[*node], *node));
        let beside = border.iter().flat_map(|node| graph.neighbours(*node));
        let mut is_new = BTreeSet::new();
        beside.copied().filter(|node| !self.is_placed[*node] && is_new.insert(*node)).collect()
    }

    /// Places all nodes with which the border does not grow: that is never a mistake, as the size of the border is a
    /// submodular function.
    fn close(&mut self, graph: &Graph) {
        while let Some(node) =
            self.beside(graph).into_iter().find(|node| self.is_free(graph, *node))
        {
            self.place(graph, node);
        }
    }
}

/// The greatest border of an order that always completes what is nearest to being complete.
fn in_order(graph: &Graph, start: usize) -> usize {
    let mut prefix = Prefix::new(graph);
    let mut next = Some(start);
    let mut greatest = 0;
    while let Some(node) = next {
        prefix.place(graph, node);
        greatest = greatest.max(prefix.border.len());
        prefix.close(graph);
        next = prefix.beside(graph).first().copied();
    }
    greatest
}

/// Whether an order has no border greater than `k`; `None` if that takes too long to find out.
fn has_order(graph: &Graph, starts: &[usize], k: usize) -> Option<bool> {
    let mut seen: BTreeSet<Vec<bool>> = BTreeSet::new();
    let mut waiting = vec![Prefix::new(graph)];
    let mut effort = 0;
    while let Some(prefix) = waiting.pop() {
        let beside = prefix.beside(graph);
        let anew = starts.iter().copied().filter(|node| !prefix.is_placed[*node]);
        let next: BTreeSet<usize> = beside.into_iter().chain(anew).collect();
        for node in next {
            effort += graph.count();
            if effort > EFFORT {
                return None;
            }
            let mut longer = prefix.clone();
            longer.place(graph, node);
            if longer.border.len() > k {
                continue;
            }
            longer.close(graph);
            if longer.count == graph.count() {
                return Some(true);
            }
            // A border of k nodes that does not shrink cannot go on.
            if longer.border.len() < k && seen.insert(longer.is_placed.clone()) {
                waiting.push(longer);
            }
        }
    }
    Some(false)
}
