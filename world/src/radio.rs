//! Buildings as obstructions of radio: whether one stands between two antennas.

use csat_netem::propagation::Obstruction;
use nalgebra::Vector3;

use crate::camera::oracle::{Hit, Oracle};
use crate::obstacle::Obstacle;
use crate::scene::Scene;

/// Antennas that are lower are raised to this height, metres.
const LOWEST_M: f64 = 0.01;

/// The buildings of a town, for lines of sight. Cars are left out: they are too low and too small.
///
/// Rays are cast by parry, as in the oracle that checks the renderer.
pub struct Buildings {
    oracle: Oracle,
}

impl Buildings {
    /// The buildings of a map.
    pub fn new(obstacles: &[Obstacle]) -> Self {
        let prisms = (0u32..).zip(obstacles).map(|(index, obstacle)| obstacle.prism(index));
        Self { oracle: Oracle::new(&Scene { prisms: prisms.collect() }) }
    }
}

impl Obstruction for Buildings {
    fn blocked(&self, a: [f64; 3], b: [f64; 3]) -> bool {
        // Sorted ends give the same result in both directions, to the last bit.
        let ordered = a.iter().zip(&b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
        let [from, to] = match ordered {
            None => return false,
            Some(order) if order.is_lt() => [a, b],
            Some(_) => [b, a],
        };
        // A ray along the ground could pass between floor and wall.
        let raised = |[x, y, z]: [f64; 3]| Vector3::new(x, y, z.max(LOWEST_M));
        let (from, to) = (raised(from), raised(to));
        let distance_m = (to - from).norm();
        if !(distance_m > 0.0 && distance_m.is_finite()) {
            return false;
        }
        let hit = self.oracle.cast(from, to - from);
        hit.is_some_and(|(hit, at_m)| matches!(hit, Hit::Solid(_)) && at_m < distance_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geo::polygon;
    use proptest::prelude::*;

    /// A block of 10 m x 10 m, 12 m high, with a courtyard of 4 m x 4 m.
    fn block() -> Obstacle {
        Obstacle {
            footprint: polygon!(
                exterior: [(x: 0.0, y: 0.0), (x: 10.0, y: 0.0), (x: 10.0, y: 10.0), (x: 0.0, y: 10.0)],
                interiors: [[(x: 3.0, y: 3.0), (x: 3.0, y: 7.0), (x: 7.0, y: 7.0), (x: 7.0, y: 3.0)]],
            ),
            height_m: 12.0,
            name: "block".into(),
        }
    }

    #[test]
    fn a_building_stands_in_the_way_of_what_is_lower() {
        let buildings = Buildings::new(&[block()]);
        let both = |a, b| {
            assert_eq!(buildings.blocked(a, b), buildings.blocked(b, a));
            buildings.blocked(a, b)
        };
        assert!(both([-5.0, 5.1, 5.0], [15.0, 5.1, 5.0]), "through the block");
        assert!(!both([-5.0, 5.1, 12.5], [15.0, 5.1, 12.5]), "over it");
        assert!(!both([-5.0, 11.0, 5.0], [15.0, 11.0, 5.0]), "past it");
        assert!(!both([-5.0, 5.1, 5.0], [-1.0, 5.1, 5.0]), "before it");
        assert!(both([5.0, 5.1, 50.0], [1.5, 5.1, 1.0]), "down through the roof");
        assert!(!both([5.0, 5.1, 50.0], [5.0, 5.2, 1.0]), "down into the courtyard");
        assert!(both([-5.0, 5.1, 2.0], [5.0, 5.1, 2.0]), "from the street into the courtyard");
        assert!(both([-5.0, 5.1, 0.0], [15.0, 5.1, 0.0]), "through it, along the ground");
        assert!(!both([-5.0, 11.0, 0.0], [15.0, 11.0, 0.0]), "past it, along the ground");
        assert!(!both([5.0; 3], [5.0; 3]), "no way at all");
        assert!(!both([f64::NAN; 3], [5.0; 3]), "nowhere");
        assert!(!Buildings::new(&[]).blocked([0.0; 3], [9.0; 3]), "an empty town");
    }

    proptest! {
        /// Against samples along the line: a sample inside the walls is an obstruction, and every
        /// obstruction that is not tiny has a sample inside the walls.
        #[test]
        fn lines_agree_with_points_along_them(
            a in [-20.0..30.0, -20.0..30.0, 0.1..30.0f64],
            b in [-20.0..30.0, -20.0..30.0, 0.1..30.0f64],
        ) {
            let inside = |p: [f64; 3], margin: f64| {
                let within = |low: f64, high: f64| {
                    p[..2].iter().all(|c| (low - margin..high + margin).contains(c))
                };
                let hole = p[..2].iter().all(|c| (3.0 + margin..7.0 - margin).contains(c));
                within(0.0, 10.0) && !hole && p[2] < 12.0 + margin
            };
            // Antennas are not inside walls.
            prop_assume!(!inside(a, 0.0) && !inside(b, 0.0));
            let samples = (0..=4000).map(|i| {
                let t = f64::from(i) / 4000.0;
                std::array::from_fn(|axis| a[axis] + t * (b[axis] - a[axis]))
            });
            let samples: Vec<[f64; 3]> = samples.collect();
            let blocked = Buildings::new(&[block()]).blocked(a, b);
            prop_assert!(blocked || !samples.iter().any(|p| inside(*p, -1e-6)));
            prop_assert!(!blocked || samples.iter().any(|p| inside(*p, 0.02)));
        }
    }
}
