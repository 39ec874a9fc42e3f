//! The vertex separation of a tree, by the labels of Ellis, Sudborough and Turner (*The vertex separation and search
//! number of a graph*, Information and Computation 113, 1994).
//!
//! A tree has a vertex separation of at most k ≥ 1 if and only if no node has three branches of at least k. So of a
//! tree with a root it is enough to know its separation k, and whether a node, itself of separation k, has two children
//! of separation k (it is *critical*: nothing more of k may join it from above); and then the same of the rest of the
//! tree without the branch of that node.

use super::Graph;

/// What there is to know of a tree with a root.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Label {
    /// The separation of the tree, of the tree without the branch of its critical node, and so on: descending.
    values: Vec<usize>,
    /// Whether the root is critical for the last one; else no node is.
    ends_at_root: bool,
}

impl Label {
    /// Of a tree of this separation without a critical node.
    fn open(value: usize) -> Self {
        Self { values: vec![value], ends_at_root: false }
    }

    fn value(&self) -> usize {
        self.values[0]
    }

    fn is_critical(&self) -> bool {
        self.values.len() > 1 || self.ends_at_root
    }

    /// Of the tree without the branch of its critical node; `None` if nothing is left.
    fn without_critical(mut self) -> Option<Self> {
        self.values.remove(0);
        (!self.values.is_empty()).then_some(self)
    }
}

/// The vertex separation of a tree.
pub(super) fn separation(tree: &Graph) -> usize {
    let (order, parents) = spanning(tree, 0, false);
    let mut children: Vec<Vec<Label>> = vec![Vec::new(); tree.count()];
    let mut separation = 0;
    for &node in order.iter().rev() {
        let label = joined(std::mem::take(&mut children[node]));
        match parents[node] {
            Some(parent) => children[parent].push(label),
            None => separation = label.value(),
        }
    }
    separation
}

/// The label of a node with children of these labels.
fn joined(mut children: Vec<Label>) -> Label {
    let Some(k) = children.iter().map(Label::value).max() else { return Label::open(0) };
    if k == 0 {
        return Label::open(1);
    }
    let is_highest = |label: &Label| label.value() == k;
    let count = children.iter().filter(|label| is_highest(label)).count();
    let critical = children.iter().position(|label| is_highest(label) && label.is_critical());
    match (count, critical) {
        (1, None) => Label::open(k),
        (2, None) => Label { values: vec![k], ends_at_root: true },
        (1, Some(index)) => {
            let rest = children.swap_remove(index).without_critical();
            children.extend(rest);
            let mut above = joined(children);
            // From above, the critical node has a third branch of k.
            if above.value() >= k {
                return Label::open(k + 1);
            }
            above.values.insert(0, k);
            above
        }
        _ => Label::open(k + 1),
    }
}

/// The nodes of a spanning tree in an order in which parents come first, and the parents; `is_deep` goes as far as
/// possible before it turns back.
pub(super) fn spanning(
    graph: &Graph,
    root: usize,
    is_deep: bool,
) -> (Vec<usize>, Vec<Option<usize>>) {
    let mut parents = vec![None; graph.count()];
    let mut is_found = vec![false; graph.count()];
    let mut order = Vec::with_capacity(graph.count());
    let mut waiting = std::collections::VecDeque::from([(root, None)]);
    while let Some((node, parent)) = if is_deep { waiting.pop_back() } else { waiting.pop_front() }
    {
        if std::mem::replace(&mut is_found[node], true) {
            continue;
        }
        parents[node] = parent;
        order.push(node);
        let next = graph.neighbours(node).iter().filter(|next| !is_found[**next]);
        waiting.extend(next.map(|next| (*next, Some(node))));
    }
    (order, parents)
}

/// A spanning tree.
pub(super) fn of_graph(graph: &Graph, root: usize, is_deep: bool) -> Graph {
    let (_, parents) = spanning(graph, root, is_deep);
    let mut tree = Graph(vec![Vec::new(); graph.count()]);
    for (node, parent) in parents.iter().enumerate() {
        if let Some(parent) = *parent {
            tree.0[node].push(parent);
            tree.0[parent].push(node);
        }
    }
    tree
}
