//! Checks whether the rings of a received set cross each other.

use csat_proto::region::{GridBox, GridPoint, Region, Ring};

use crate::region::turn;

/// What is wrong with the rings of a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RingFault {
    /// Two edges cross.
    Crossing,
    /// So many edges lie close together that the check would take too long.
    TooDense,
}

/// The most pairs and strips that are checked per edge, on average. Valid sets take a few.
const LOOKS_PER_EDGE: usize = 100;

struct Edge {
    a: GridPoint,
    b: GridPoint,
    extent: GridBox,
}

/// Checks that no two edges cross in a point inside both. Rings may touch, as those of resolved sets
/// do.
///
/// It sweeps from west to east and keeps the edges at the sweep line in strips from south to north,
/// so that only edges that are near each other are compared.
///
/// # Errors
/// When two edges cross, or the check would take too long.
pub fn check(region: &Region) -> Result<(), RingFault> {
    let mut edges: Vec<Edge> = region.rings().flat_map(edges_of).collect();
    edges.sort_unstable_by_key(|edge| edge.extent.min.x);
    let Some(bounds) = GridBox::around(edges.iter().flat_map(|edge| [&edge.a, &edge.b])) else {
        return Ok(());
    };
    let count = edges.len().isqrt().max(1);
    let height = (i64::from(bounds.max.y) - i64::from(bounds.min.y)) / count as i64 + 1;
    let strip = |y: i32| ((i64::from(y) - i64::from(bounds.min.y)) / height) as usize;
    let mut strips: Vec<Vec<&Edge>> = vec![Vec::new(); count];
    let mut left = LOOKS_PER_EDGE.saturating_mul(edges.len());
    for edge in &edges {
        for open in &mut strips[strip(edge.extent.min.y)..=strip(edge.extent.max.y)] {
            open.retain(|other| other.extent.max.x >= edge.extent.min.x);
            left = left.checked_sub(open.len() + 1).ok_or(RingFault::TooDense)?;
            if open.iter().any(|other| other.extent.meets(&edge.extent) && cross(other, edge)) {
                return Err(RingFault::Crossing);
            }
            open.push(edge);
        }
    }
    Ok(())
}

fn edges_of(ring: &Ring) -> impl Iterator<Item = Edge> {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).filter(|(a, b)| a != b).map(|(&a, &b)| {
        let min = GridPoint::new(a.x.min(b.x), a.y.min(b.y));
        let max = GridPoint::new(a.x.max(b.x), a.y.max(b.y));
        Edge { a, b, extent: GridBox { min, max } }
    })
}

fn cross(e: &Edge, f: &Edge) -> bool {
    let side = |edge: &Edge, p| turn(edge.a, edge.b, p).signum();
    let apart = |edge: &Edge, p, q| side(edge, p) * side(edge, q) < 0;
    apart(e, f.a, f.b) && apart(f, e.a, e.b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::region::grid_point;

    fn region(rings: &[&[[f64; 2]]]) -> Region {
        let ring = |points: &&[[f64; 2]]| points.iter().map(|&p| grid_point(p)).collect();
        Region::from_shapes(vec![rings.iter().map(ring).collect()])
    }

    #[test]
    fn crossings_are_found_and_touching_is_not_one() {
        let bow_tie = region(&[&[[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]]]);
        assert_eq!(check(&bow_tie), Err(RingFault::Crossing));
        let square: &[[f64; 2]] = &[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        let inside: &[[f64; 2]] = &[[1.0, 1.0], [1.0, 2.0], [2.0, 1.0]];
        let touching: &[[f64; 2]] = &[[0.0, 0.0], [1.0, 2.0], [2.0, 1.0]];
        let sticking_out: &[[f64; 2]] = &[[1.0, 1.0], [1.0, 2.0], [5.0, 1.0]];
        assert_eq!(check(&region(&[square, inside])), Ok(()));
        assert_eq!(check(&region(&[square, touching])), Ok(()));
        assert_eq!(check(&region(&[square, sticking_out])), Err(RingFault::Crossing));
        assert_eq!(check(&Region::EMPTY), Ok(()));
    }

    /// Against a comparison of all pairs, on rings of all sizes: the sweep finds every crossing.
    #[test]
    fn a_crossing_is_found_wherever_it_is() {
        let mut state = 1u64;
        let mut random = |n: i64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as i64 % n
        };
        let mut found = [0, 0];
        for round in 0..3000 {
            let rings: Vec<Ring> = (0..1 + round % 6)
                .map(|_| {
                    let size = 1 + random(60);
                    let at = [random(100), random(100)];
                    let mut p = |axis: usize| (at[axis] + random(size)) as i32;
                    (0..3).map(|_| GridPoint::new(p(0), p(1))).collect()
                })
                .collect();
            let edges: Vec<Edge> = rings.iter().flat_map(edges_of).collect();
            let crosses = |e: &Edge| edges.iter().any(|f| cross(e, f));
            let expected = edges.iter().any(crosses);
            found[usize::from(expected)] += 1;
            let got = check(&Region::from_shapes(vec![rings]));
            assert_eq!(got, if expected { Err(RingFault::Crossing) } else { Ok(()) });
        }
        assert!(found.iter().all(|&n| n > 300), "{found:?}");
    }

    #[test]
    fn a_bundle_of_edges_is_given_up_on() {
        let zigzag = (0..20_000).map(|i| [f64::from(i % 2) * 100.0, f64::from(i) * 25e-5]);
        let around = [[200.0, 5.0], [200.0, -5.0], [-1.0, -5.0]];
        let ring: Vec<[f64; 2]> = zigzag.chain(around).collect();
        assert_eq!(check(&region(&[&ring])), Err(RingFault::TooDense));
    }
}
