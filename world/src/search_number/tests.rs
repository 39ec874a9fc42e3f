//! Numbers that are known, and small graphs of which all orders and all moves of searchers can be tried.

use std::collections::BTreeSet;

use proptest::prelude::*;

use super::*;

fn network(nodes: usize, edges: &[[usize; 2]]) -> Network {
    Network::new(nodes, edges.to_vec())
}

fn path(nodes: usize) -> Network {
    Network::new(nodes, (1..nodes).map(|i| [i - 1, i]).collect())
}

fn ring(nodes: usize) -> Network {
    Network::new(nodes, (0..nodes).map(|i| [i, (i + 1) % nodes]).collect())
}

fn star(arms: usize) -> Network {
    Network::new(arms + 1, (1..=arms).map(|i| [0, i]).collect())
}

/// Each node but those of the last row has `children` of them; a single node has a height of 0.
fn full_tree(children: usize, height: u32) -> Network {
    let nodes = (0..=height).map(|row| children.pow(row)).sum();
    Network::new(nodes, (1..nodes).map(|i| [(i - 1) / children, i]).collect())
}

fn complete(nodes: usize) -> Network {
    let pairs = (0..nodes).flat_map(|a| (a + 1..nodes).map(move |b| [a, b]));
    Network::new(nodes, pairs.collect())
}

fn grid(columns: usize, rows: usize) -> Network {
    let east = (0..columns * rows).filter(|i| i % columns + 1 < columns).map(|i| [i, i + 1]);
    let north = (0..columns * (rows - 1)).map(|i| [i, i + columns]);
    Network::new(columns * rows, east.chain(north).collect())
}

fn exact(network: &Network) -> [usize; 2] {
    [network.node_search(), network.edge_search()].map(|bounds| {
        assert_eq!(bounds.at_least, bounds.at_most, "{network:?}");
        bounds.at_least
    })
}

#[test]
fn numbers_of_trees_are_those_that_are_known() {
    assert_eq!(exact(&path(1)), [1, 1]);
    for nodes in [2, 3, 30] {
        assert_eq!(exact(&path(nodes)), [2, 1], "{nodes}");
    }
    for arms in [3, 4, 9] {
        assert_eq!(exact(&star(arms)), [2, 2], "{arms}");
    }
    // A full binary tree of height h has a pathwidth of ⌈h / 2⌉, a full ternary one of h.
    for height in 1..=9 {
        let binary = full_tree(2, height).node_search();
        assert_eq!(binary, Bounds::exactly(height.div_ceil(2) as usize + 1), "{height}");
    }
    for height in 1..=6 {
        let ternary = full_tree(3, height).node_search();
        assert_eq!(ternary, Bounds::exactly(height as usize + 1), "{height}");
    }
    assert_eq!(exact(&network(7, &[[0, 1], [1, 2], [0, 3], [3, 4], [0, 5], [5, 6]])), [3, 2]);
}

#[test]
fn numbers_of_other_graphs_are_those_that_are_known() {
    for nodes in [3, 4, 20] {
        assert_eq!(exact(&ring(nodes)), [3, 2], "{nodes}");
    }
    for nodes in 4..=6 {
        assert_eq!(exact(&complete(nodes)), [nodes, nodes], "{nodes}");
    }
    // A grid of n columns and as many rows or more has a pathwidth of n.
    for (columns, rows) in [(2, 2), (2, 9), (3, 3), (3, 7), (4, 4)] {
        let bounds = grid(columns, rows).node_search();
        assert_eq!(bounds, Bounds::exactly(columns + 1), "{columns} x {rows}");
    }
}

#[test]
fn loops_repeats_and_parts_are_possible() {
    // A ring street without junctions, and one at the end of a street.
    assert_eq!(exact(&network(1, &[[0, 0]])), [1, 2]);
    assert_eq!(exact(&network(2, &[[0, 1], [1, 1]])), [2, 2]);
    // Two streets between the same junctions.
    assert_eq!(exact(&network(2, &[[0, 1], [0, 1]])), [2, 2]);
    // The greater of both parts counts.
    assert_eq!(exact(&network(6, &[[0, 1], [1, 2], [3, 4], [4, 5], [5, 3]])), [3, 2]);
    assert_eq!(network(0, &[]).edge_search(), Bounds::exactly(0));
}

#[test]
fn a_large_network_has_bounds() {
    let bounds = grid(30, 40).edge_search();
    assert!(bounds.at_least >= 3 && bounds.at_most <= 60, "{bounds:?}");
}

#[test]
fn streets_are_the_edges_of_a_network() {
    use crate::map::{Map, MapConfig, MapKind, MapRules, load};
    use crate::road_area::{CELL_M, RoadArea};
    use crate::start_line::StartLine;
    use csat_proto::model::Ground;

    let ground = Ground { size_m: [200.0, 200.0] };
    let roads = vec![
        vec![[-120.0, 0.0], [0.0, 0.0], [20.0, 50.0]],
        vec![[0.0, 0.0], [0.0, -60.0]],
        // Apart from the others.
        vec![[50.0, -80.0], [90.0, -80.0], [70.0, -60.0], [50.0, -80.0]],
    ];
    let map = Map { roads, ..Map::open(ground) };
    let area = RoadArea::new(&map, CELL_M);
    let connected = area.component(&StartLine::choose(&area, None).unwrap());
    let tee = Network::of_roads(&RoadGraph::within(&map, &connected)).unwrap();
    assert_eq!((tee.nodes, tee.edges.len()), (4, 3));
    assert_eq!(exact(&tee), [2, 2]);
    let all = Network::of_roads(&RoadGraph::within(&map, &area)).unwrap();
    assert_eq!((all.nodes, all.edges.len()), (5, 4));
    assert!(Network::of_roads(&RoadGraph::within(&Map::open(ground), &area)).is_none());
    for seed in 1..=10 {
        let config = MapConfig { kind: MapKind::Desert, ..MapConfig::default() };
        let rules = MapRules { lowest_altitude_m: 70.0, road_clearance_m: 2.5 };
        let map = load(&config, &rules, seed).unwrap();
        let area = RoadArea::new(&map, CELL_M);
        let network = Network::of_roads(&RoadGraph::within(&map, &area)).unwrap();
        let bounds = network.edge_search();
        assert!((2..=bounds.at_most).contains(&bounds.at_least) && bounds.at_most <= 6);
    }
}

/// The vertex separation, from all subsets of the nodes.
fn by_subsets(graph: &Graph) -> usize {
    let count = graph.count();
    let border = |set: usize| {
        let is_open = |node: &usize| graph.neighbours(*node).iter().any(|n| set >> n & 1 == 0);
        (0..count).filter(|node| set >> node & 1 == 1).filter(is_open).count()
    };
    let mut least = vec![0; 1 << count];
    for set in 1..1 << count {
        let nodes = (0..count).filter(|node| set >> node & 1 == 1);
        let before = nodes.map(|node| least[set & !(1 << node)]).min().unwrap_or(0);
        least[set] = before.max(border(set));
    }
    least[(1 << count) - 1]
}

/// Whether so many searchers clear all edges, from all their moves: to be put on a node, to be taken away, to slide
/// along an edge. Edges become contaminated again over nodes without a searcher.
fn clears(network: &Network, searchers: usize) -> bool {
    type State = (Vec<Option<usize>>, Vec<bool>);
    let settle = |(mut places, mut is_clear): State| -> State {
        places.sort_unstable();
        loop {
            let is_free = |node: &usize| !places.contains(&Some(*node));
            let spreads = |a: usize, b: usize| {
                let mut common =
                    network.edges[a].iter().filter(|node| network.edges[b].contains(node));
                !is_clear[a] && is_clear[b] && common.any(is_free)
            };
            let count = network.edges.len();
            let lost = (0..count).find(|b| (0..count).any(|a| spreads(a, *b)));
            let Some(lost) = lost else { return (places, is_clear) };
            is_clear[lost] = false;
        }
    };
    let start = (vec![None; searchers], vec![false; network.edges.len()]);
    let mut seen = BTreeSet::from([start.clone()]);
    let mut waiting = vec![start];
    while let Some((places, is_clear)) = waiting.pop() {
        if is_clear.iter().all(|is_clear| *is_clear) {
            return true;
        }
        let mut next = Vec::new();
        for searcher in 0..searchers {
            let mut put = |place: Option<usize>, edge: Option<usize>| {
                let (mut places, mut is_clear) = (places.clone(), is_clear.clone());
                places[searcher] = place;
                edge.into_iter().for_each(|edge| is_clear[edge] = true);
                next.push(settle((places, is_clear)));
            };
            match places[searcher] {
                None => (0..network.nodes).for_each(|node| put(Some(node), None)),
                Some(node) => {
                    put(None, None);
                    for (edge, [a, b]) in network.edges.iter().enumerate() {
                        for (from, to) in [(a, b), (b, a)] {
                            if *from == node {
                                put(Some(*to), Some(edge));
                            }
                        }
                    }
                }
            }
        }
        waiting.extend(next.into_iter().filter(|state| seen.insert(state.clone())));
    }
    false
}

/// Searchers that slide along a loop would have to guard both of its ends: here there are none.
fn without_loops(network: Network) -> Network {
    let edges = network.edges.iter().map(|&[a, b]| [a, if a == b { (a + 1) % 5 } else { b }]);
    Network::new(network.nodes, edges.collect())
}

fn random_network(nodes: usize, edges: usize) -> impl Strategy<Value = Network> {
    let edges = prop::collection::vec([0..nodes, 0..nodes], 0..=edges);
    edges.prop_map(move |edges| Network::new(nodes, edges))
}

fn random_tree(nodes: usize) -> impl Strategy<Value = Network> {
    let parents: Vec<_> = (1..nodes).map(|node| 0..node).collect();
    parents.prop_map(|parents| {
        Network::new(parents.len() + 1, parents.into_iter().zip(1..).map(|(p, n)| [p, n]).collect())
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn trees_have_the_separation_of_all_subsets(tree in (2usize..12).prop_flat_map(random_tree)) {
        let expected = by_subsets(&Graph::new(&tree)) + 1;
        prop_assert_eq!(tree.node_search(), Bounds::exactly(expected));
    }

    #[test]
    fn graphs_have_the_separation_of_all_subsets(network in random_network(9, 16)) {
        let expected = by_subsets(&Graph::new(&network)) + 1;
        prop_assert_eq!(network.node_search(), Bounds::exactly(expected));
    }

    #[test]
    fn a_tree_of_a_graph_needs_no_more(network in random_network(16, 24), root in 0usize..16) {
        for part in Graph::new(&network).components() {
            let tree = tree::of_graph(&part, root % part.count(), root % 2 == 0);
            prop_assert!(tree::separation(&tree) <= separation(&part).at_most);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn so_many_searchers_clear_the_edges_and_no_fewer(
        network in random_network(5, 6).prop_map(without_loops),
    ) {
        let is_used = |node: usize| network.edges.iter().any(|edge| edge.contains(&node));
        prop_assume!((0..5).any(is_used));
        let bounds = network.edge_search();
        prop_assert_eq!(bounds.at_least, bounds.at_most);
        prop_assert!(clears(&network, bounds.at_least), "{} do not do", bounds.at_least);
        prop_assert!(!clears(&network, bounds.at_least - 1), "fewer do");
    }
}
