//! Polylines cut into segments that meet only at their ends.

use csat_proto::model::Ground;

use crate::plane::{
    Bounds, Point, between, crossing, distance_m, distance_to_segment_m, dot, interval_in_box,
    minus,
};

/// Ends this near to another road join it, metres. Roads that share a node in OpenStreetMap have
/// equal ends; this corrects inexact drawing.
const SNAP_M: f64 = 0.2;

/// A piece of centre line.
pub(super) type Segment = [Point; 2];

/// The segments of `polylines` inside the region less `inset_m`, cut at every crossing and wherever
/// an end comes within [`SNAP_M`], ends that near made equal.
pub(super) fn noded(ground: &Ground, polylines: &[Vec<Point>], inset_m: f64) -> Vec<Segment> {
    let segments = clipped(ground, polylines, inset_m);
    let cuts = cuts(&segments);
    let mut nodes = Nodes::default();
    let mut pieces = Vec::new();
    for (&[a, b], mut along) in segments.iter().zip(cuts) {
        along.sort_by(f64::total_cmp);
        let mut from = nodes.snap(a);
        for t in along {
            let to = nodes.snap(if t == 1.0 { b } else { between(a, b, t) });
            if from != to {
                pieces.push([from, to]);
            }
            from = to;
        }
    }
    pieces
}

/// The parts of all segments inside the region, in order.
fn clipped(ground: &Ground, polylines: &[Vec<Point>], inset_m: f64) -> Vec<Segment> {
    let half = ground.size_m.map(|s| s / 2.0 - inset_m);
    let mut segments = Vec::new();
    if half.iter().any(|x| *x <= 0.0) {
        return segments;
    }
    for line in polylines {
        for pair in line.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let Some([lo, hi]) = interval_in_box(a, minus(b, a), half.map(|x| -x), half) else {
                continue;
            };
            let (lo, hi) = (lo.max(0.0), hi.min(1.0));
            let at = |t: f64| if t == 1.0 { b } else { between(a, b, t) };
            if lo < hi {
                segments.push([at(lo), at(hi)]);
            }
        }
    }
    segments
}

/// Per segment the parameters at which to cut it; each list contains 1.
fn cuts(segments: &[Segment]) -> Vec<Vec<f64>> {
    let mut cuts = vec![vec![1.0]; segments.len()];
    let boxes: Vec<Option<Bounds>> =
        segments.iter().map(|s| Bounds::around(*s).map(|b| b.grown(SNAP_M))).collect();
    // A sweep from west to east avoids the comparison of all pairs.
    let west = |i: usize| boxes[i].map_or(f64::INFINITY, |b| b.min[0]);
    let mut order: Vec<usize> = (0..segments.len()).collect();
    order.sort_by(|&i, &j| west(i).total_cmp(&west(j)));
    for (position, &i) in order.iter().enumerate() {
        let Some(own) = boxes[i] else { continue };
        for &j in order[position + 1..].iter().take_while(|&&j| west(j) <= own.max[0]) {
            if !boxes[j].is_some_and(|b| b.meets(&own)) {
                continue;
            }
            if let Some([s, t]) = crossing(segments[i], segments[j]) {
                cuts[i].push(s);
                cuts[j].push(t);
            }
            for (one, other) in [(i, j), (j, i)] {
                let near = segments[other].iter().filter_map(|&p| foot(segments[one], p));
                cuts[one].extend(near);
            }
        }
    }
    cuts
}

/// The parameter of the point of a segment that is nearest to `p`, if it is near enough to join.
fn foot([a, b]: Segment, p: Point) -> Option<f64> {
    if distance_to_segment_m(p, a, b) > SNAP_M {
        return None;
    }
    let d = minus(b, a);
    Some((dot(minus(p, a), d) / dot(d, d)).clamp(0.0, 1.0))
}

/// Points that others snap to, sorted into cells of [`SNAP_M`].
#[derive(Default)]
struct Nodes {
    cells: std::collections::BTreeMap<(i64, i64), Vec<Point>>,
}

impl Nodes {
    /// The first node within [`SNAP_M`] of `p`, nearest first; `p` becomes one if there is none.
    fn snap(&mut self, p: Point) -> Point {
        let [x, y] = p.map(|v| (v / SNAP_M).floor() as i64);
        let mut nearest: Option<(f64, Point)> = None;
        for cell in (x - 1..=x + 1).flat_map(|i| (y - 1..=y + 1).map(move |j| (i, j))) {
            for &node in self.cells.get(&cell).into_iter().flatten() {
                let distance = distance_m(p, node);
                if distance <= SNAP_M && nearest.is_none_or(|(d, _)| distance < d) {
                    nearest = Some((distance, node));
                }
            }
        }
        nearest.map_or_else(
            || {
                self.cells.entry((x, y)).or_default().push(p);
                p
            },
            |(_, node)| node,
        )
    }
}
