//! Roads.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Roads in a square region around the origin. The start line is where x is least and y is `start_m`.
#[derive(Debug, Clone, PartialEq)]
pub struct Town {
    /// Half of the side of the region, metres.
    pub half_m: f64,
    /// The middle lines of roads, metres.
    pub roads: Vec<[[f64; 2]; 2]>,
    /// Half of the width of roads, metres.
    pub half_width_m: f64,
    pub start_m: f64,
}

impl Town {
    pub fn new(half_m: f64, roads: &[[[f64; 2]; 2]]) -> Self {
        Self { half_m, roads: roads.to_vec(), half_width_m: 3.0, start_m: 0.0 }
    }

    /// A dead end.
    pub fn straight() -> Self {
        Self::new(250.0, &[[[-250.0, 0.0], [150.0, 0.0]]])
    }

    pub fn tee() -> Self {
        let bar = [[0.0, -180.0], [0.0, 180.0]];
        Self::new(250.0, &[[[-250.0, 0.0], [0.0, 0.0]], bar])
    }

    pub fn cross() -> Self {
        let bar = [[0.0, -180.0], [0.0, 180.0]];
        Self::new(250.0, &[[[-250.0, 0.0], [200.0, 0.0]], bar])
    }

    pub fn ring() -> Self {
        let [a, b, c, d] = [[-80.0, -110.0], [120.0, -110.0], [120.0, 110.0], [-80.0, 110.0]];
        Self::new(250.0, &[[[-250.0, 0.0], [-80.0, 0.0]], [a, b], [b, c], [c, d], [d, a]])
    }

    /// Two parallel roads, and streets from one to the other.
    pub fn ladder(apart_m: f64, streets: &[f64]) -> Self {
        let mut roads = vec![[[-250.0, 0.0], [200.0, 0.0]], [[-200.0, apart_m], [200.0, apart_m]]];
        roads.extend(streets.iter().map(|x| [[*x, 0.0], [*x, apart_m]]));
        Self::new(250.0, &roads)
    }

    /// Acute angles.
    pub fn fork() -> Self {
        let middle = [-60.0, 0.0];
        Self::new(
            250.0,
            &[
                [[-250.0, 0.0], middle],
                [middle, [200.0, 60.0]],
                [middle, [200.0, -30.0]],
                [middle, [120.0, 220.0]],
            ],
        )
    }

    /// Two parallel roads with a street between them; the rear of the second one turns off to the north.
    pub fn rear() -> Self {
        let corner = [-130.0, 35.0];
        Self::new(
            250.0,
            &[
                [[-250.0, 0.0], [200.0, 0.0]],
                [corner, [200.0, 35.0]],
                [corner, [-130.0, 230.0]],
                [[0.0, 0.0], [0.0, 35.0]],
            ],
        )
    }

    /// Two roads that part, and come near to each other again without touching.
    pub fn hooks() -> Self {
        let mut roads = vec![[[-150.0, 0.0], [-60.0, 0.0]]];
        for side in [-1.0, 1.0] {
            let at = |x: f64, y: f64| [x, side * y];
            let corners = [
                at(-60.0, 0.0),
                at(-60.0, 100.0),
                at(20.0, 100.0),
                at(20.0, 20.0),
                at(140.0, 20.0),
            ];
            roads.extend(corners.windows(2).map(|pair| [pair[0], pair[1]]));
        }
        Self::new(150.0, &roads)
    }

    /// A grid with jitter and missing pieces, about 500 m wide.
    pub fn desert(seed: u64, spacing_m: f64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let half_m = 250.0;
        let count = (2.0 * half_m / spacing_m).floor() as usize;
        let first = -spacing_m * (count as f64 - 1.0) / 2.0;
        let mut jitter = |at: f64| at + random.random_range(-0.15..0.15) * spacing_m;
        let nodes: Vec<Vec<[f64; 2]>> = (0..count)
            .map(|row| {
                (0..count)
                    .map(|column| {
                        let at = |index: usize| first + index as f64 * spacing_m;
                        [jitter(at(column)), jitter(at(row))]
                    })
                    .collect()
            })
            .collect();
        let start = nodes[count / 2][0];
        let mut roads = vec![[[-half_m, start[1]], start]];
        for row in 0..count {
            for column in 0..count {
                let from = nodes[row][column];
                if column + 1 < count && random.random_bool(0.75) {
                    roads.push([from, nodes[row][column + 1]]);
                }
                if row + 1 < count && random.random_bool(0.75) {
                    roads.push([from, nodes[row + 1][column]]);
                }
                if random.random_bool(0.15) {
                    let by = spacing_m * 0.4;
                    let turn = [[by, by * 0.5], [-by, by * 0.6], [by * 0.4, -by], [-by, -by]];
                    let [x, y] = turn[random.random_range(0..4)];
                    roads.push([from, [from[0] + x, from[1] + y]]);
                }
                if row == 0 && random.random_bool(0.3) {
                    roads.push([from, [from[0], -half_m]]);
                }
                if column + 1 == count && random.random_bool(0.3) {
                    roads.push([from, [half_m, from[1]]]);
                }
            }
        }
        Self { start_m: start[1], ..Self::new(half_m, &roads) }
    }

    /// Whether a point is on a road, metres.
    pub fn is_road(&self, point: [f64; 2]) -> bool {
        self.roads.iter().any(|[a, b]| distance(point, *a, *b) <= self.half_width_m)
    }
}

fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let to = [p[0] - a[0], p[1] - a[1]];
    let share = (to[0] * along[0] + to[1] * along[1]) / (along[0].powi(2) + along[1].powi(2));
    let share = share.clamp(0.0, 1.0);
    (to[0] - share * along[0]).hypot(to[1] - share * along[1])
}
