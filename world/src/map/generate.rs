//! A seeded town: a grid of streets, and buildings of several kinds in the blocks between them.

use csat_proto::model::Ground;
use geo::{Area, MultiPolygon, Polygon};
use rand::RngExt;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::count::FeatureCount;
use super::report::{MapError, MapWarning};
use super::{Map, MapConfig, MapRules};
use crate::obstacle::Obstacle;
use crate::plane::{Bounds, Point};
use crate::random::{StreamPurpose, stream};

mod shapes;

/// Buildings keep at least this far from a street's centre line, metres.
const SETBACK_M: f64 = 6.0;
/// Added to the distance that cars need, metres.
const SETBACK_MARGIN_M: f64 = 0.5;
/// Buildings keep at least this far from the border of the region, metres.
const BORDER_M: f64 = 2.0;
/// Half the gap between neighbouring buildings, metres.
const HALF_GAP_M: f64 = 2.0;
/// Approximate side of a lot, metres.
const LOT_M: f64 = 28.0;
/// Smallest side of a lot worth building on, metres.
const MIN_LOT_M: f64 = 6.0;
/// Streets deviate from the regular grid by at most this share of their spacing.
const JITTER: f64 = 0.1;

/// The town of `seed`.
///
/// Streets run through the whole region. Buildings keep a distance from streets and from each other,
/// and cover exactly `built_share` of the region: kinds are drawn lot by lot, in random order, until
/// enough is covered, then all footprints shrink by a common factor.
///
/// # Errors
/// When the blocks have no room for that share.
pub fn generate(config: &MapConfig, rules: &MapRules, seed: u64) -> Result<Map, MapError> {
    let ground = Ground { size_m: config.size_m };
    let mut warnings = Vec::new();
    let heights = heights_m(config, rules, &mut warnings);
    let streets = {
        let mut rng = stream(seed, StreamPurpose::Streets);
        config.size_m.map(|size_m| street_lines(size_m, config.road_spacing_m, &mut rng))
    };
    let mut rng = stream(seed, StreamPurpose::Buildings);
    let setback_m = SETBACK_M.max(rules.road_clearance_m + SETBACK_MARGIN_M);
    let mut lots = lots(&ground, &streets, setback_m);
    lots.shuffle(&mut rng);
    let wanted_m2 = config.built_share * ground.area_m2();
    let mut plan = draw(&lots, wanted_m2, &mut rng);
    if total_m2(&plan) < wanted_m2 {
        // Buildings of several kinds do not cover enough: use blocks that fill their lots.
        plan = lots.iter().map(|lot| (shapes::filling(lot), "block")).collect();
    }
    let total_m2 = total_m2(&plan);
    if total_m2 < wanted_m2 {
        return Err(MapError::BuiltShare {
            got: config.built_share,
            max: total_m2 / ground.area_m2(),
            road_spacing_m: config.road_spacing_m,
        });
    }
    let scale = if total_m2 > 0.0 { (wanted_m2 / total_m2).sqrt() } else { 1.0 };
    let obstacles = plan
        .iter()
        .enumerate()
        .map(|(index, (footprint, kind))| Obstacle {
            footprint: shapes::shrunk(footprint, scale),
            height_m: rng.random_range(heights[0]..=heights[1]),
            name: format!("building {index} ({kind})"),
        })
        .collect();
    Ok(Map {
        ground,
        obstacles,
        roads: polylines(&ground, &streets),
        road_widths_m: Vec::new(),
        centre_deg: None,
        attribution: None,
        count: FeatureCount::default(),
        warnings,
    })
}

/// The range of heights, below the flights.
fn heights_m(config: &MapConfig, rules: &MapRules, warnings: &mut Vec<MapWarning>) -> [f64; 2] {
    let max_m = rules.height_limit_m();
    if config.max_height_m > max_m {
        warnings.push(MapWarning::MaxHeightLowered { got_m: config.max_height_m, max_m });
    }
    [config.min_height_m.min(max_m), config.max_height_m.min(max_m)]
}

/// Coordinates of the streets that cross an axis of the region, ascending, metres.
fn street_lines(size_m: f64, spacing_m: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let count = (size_m / spacing_m).round().max(1.0);
    let pitch_m = size_m / count;
    (0..count as u32)
        .map(|i| {
            let jitter = rng.random_range(-JITTER..=JITTER);
            (f64::from(i) + 0.5 + jitter) * pitch_m - size_m / 2.0
        })
        .collect()
}

/// Streets as polylines: north-south ones first.
fn polylines(ground: &Ground, streets: &[Vec<f64>; 2]) -> Vec<Vec<Point>> {
    let [half_x, half_y] = ground.size_m.map(|s| s / 2.0);
    let north = streets[0].iter().map(|&x| vec![[x, -half_y], [x, half_y]]);
    let east = streets[1].iter().map(|&y| vec![[-half_x, y], [half_x, y]]);
    north.chain(east).collect()
}

/// The lots of all blocks, gaps already taken off.
fn lots(ground: &Ground, streets: &[Vec<f64>; 2], setback_m: f64) -> Vec<Bounds> {
    let axes: [Vec<[f64; 2]>; 2] = std::array::from_fn(|axis| {
        spans(ground.size_m[axis] / 2.0, &streets[axis], setback_m)
            .iter()
            .flat_map(|span| split(*span))
            .collect()
    });
    let mut lots = Vec::new();
    for &[x0, x1] in &axes[0] {
        for &[y0, y1] in &axes[1] {
            lots.push(Bounds { min: [x0, y0], max: [x1, y1] });
        }
    }
    lots
}

/// The free spans between the streets along one axis.
fn spans(half_m: f64, lines: &[f64], setback_m: f64) -> Vec<[f64; 2]> {
    let starts = std::iter::once(-half_m + BORDER_M).chain(lines.iter().map(|x| x + setback_m));
    let ends = lines.iter().map(|x| x - setback_m).chain(std::iter::once(half_m - BORDER_M));
    starts.zip(ends).map(|(a, b)| [a, b]).filter(|[a, b]| b - a >= MIN_LOT_M).collect()
}

/// A span cut into lots of about [`LOT_M`] with gaps between them.
fn split([start, end]: [f64; 2]) -> Vec<[f64; 2]> {
    let count = ((end - start) / LOT_M).round().max(1.0);
    let pitch = (end - start) / count;
    (0..count as u32)
        .map(|i| {
            let from = start + f64::from(i) * pitch;
            let first = if i == 0 { 0.0 } else { HALF_GAP_M };
            let last = if f64::from(i) + 1.5 > count { 0.0 } else { HALF_GAP_M };
            [from + first, from + pitch - last]
        })
        .collect()
}

/// Buildings on the lots in their order until they cover `wanted_m2`.
fn draw(
    lots: &[Bounds],
    wanted_m2: f64,
    rng: &mut ChaCha8Rng,
) -> Vec<(Polygon<f64>, &'static str)> {
    let mut plan = Vec::new();
    let mut total_m2 = 0.0;
    for lot in lots {
        if total_m2 >= wanted_m2 {
            break;
        }
        let (footprint, kind) = shapes::draw(lot, rng);
        total_m2 += footprint.unsigned_area();
        plan.push((footprint, kind));
    }
    plan
}

fn total_m2(plan: &[(Polygon<f64>, &'static str)]) -> f64 {
    MultiPolygon(plan.iter().map(|(p, _)| p.clone()).collect()).unsigned_area()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::obstacle::Walls;
    use crate::plane::distance_to_segment_m;
    use geo::{BooleanOps, Distance, Euclidean, Validation};
    use proptest::prelude::*;

    const RULES: MapRules = MapRules { lowest_altitude_m: 52.0, road_clearance_m: 2.55 };

    fn city(size_m: [f64; 2], built_share: f64, seed: u64) -> Map {
        let config = MapConfig { size_m, built_share, ..MapConfig::default() };
        generate(&config, &RULES, seed).unwrap()
    }

    #[test]
    fn towns_of_all_sizes_and_shares_are_exact_and_apart() {
        for (size_m, share) in [
            ([60.0, 60.0], 0.05),
            ([500.0, 500.0], 0.0),
            ([500.0, 500.0], 0.05),
            ([500.0, 500.0], 0.3),
            ([200.0, 700.0], 0.3),
            ([2000.0, 2000.0], 0.05),
        ] {
            for seed in 0..3 {
                let map = city(size_m, share, seed);
                assert!((map.built_share() - share).abs() < 1e-9, "{}", map.built_share());
                sound(&map);
            }
        }
    }

    fn sound(map: &Map) {
        let walls = Walls::new(&map.obstacles);
        let edges = |o: &Obstacle| o.rings().flatten().collect::<Vec<_>>();
        for (i, a) in map.obstacles.iter().enumerate() {
            assert_eq!(a.footprint.validation_errors(), []);
            assert!((6.0..=45.0).contains(&a.height_m));
            for p in edges(a) {
                assert!(map.ground.contains(p));
                for road in &map.roads {
                    assert!(distance_to_segment_m(p, road[0], road[1]) >= SETBACK_M - 1e-9);
                }
            }
            for b in map.obstacles[..i].iter().filter(|_| map.obstacles.len() < 200) {
                assert!(Euclidean.distance(&a.footprint, &b.footprint) >= 2.0 * HALF_GAP_M - 1e-9);
                assert!(a.footprint.intersection(&b.footprint).0.is_empty());
            }
        }
        for road in &map.roads {
            for i in 0..=1000 {
                let p = crate::plane::between(road[0], road[1], f64::from(i) / 1000.0);
                assert_eq!(walls.nearest_within(p, SETBACK_M - 1e-9), None);
            }
        }
    }

    #[test]
    fn the_paper_s_town_is_varied() {
        let map = city([500.0, 500.0], 0.05, 1);
        assert!((20..150).contains(&map.obstacles.len()), "{}", map.obstacles.len());
        for kind in ["box", "L", "U", "T", "courtyard"] {
            let suffix = format!("({kind})");
            assert!(map.obstacles.iter().any(|o| o.name.ends_with(&suffix)), "no {kind}");
        }
        assert!(map.obstacles.iter().any(|o| !o.footprint.interiors().is_empty()));
        let heights: Vec<f64> = map.obstacles.iter().map(|o| o.height_m).collect();
        assert!(heights.iter().any(|h| *h > 35.0) && heights.iter().any(|h| *h < 15.0));
    }

    #[test]
    fn the_seed_is_the_town() {
        let size = [300.0, 300.0];
        assert_eq!(city(size, 0.1, 4), city(size, 0.1, 4));
        assert_ne!(city(size, 0.1, 4).obstacles, city(size, 0.1, 5).obstacles);
        assert_ne!(city(size, 0.1, 4).roads, city(size, 0.1, 5).roads);
    }

    #[test]
    fn too_much_is_refused_with_what_would_do() {
        let config = MapConfig { built_share: 0.9, ..MapConfig::default() };
        let error = generate(&config, &RULES, 1).unwrap_err();
        let MapError::BuiltShare { got, max, .. } = error else { panic!("{error}") };
        assert!(got == 0.9 && max > 0.3 && max < 0.9, "{max}");
        let config = MapConfig { built_share: max * 0.999, ..config };
        sound(&generate(&config, &RULES, 1).unwrap());
    }

    #[test]
    fn tops_stay_below_the_flights() {
        let rules = MapRules { lowest_altitude_m: 20.0, ..RULES };
        let map = generate(&MapConfig::default(), &rules, 1).unwrap();
        assert!(map.obstacles.iter().all(|o| o.height_m <= 18.0));
        let expected = MapWarning::MaxHeightLowered { got_m: 45.0, max_m: 18.0 };
        assert_eq!(map.warnings, [expected]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]
        #[test]
        fn any_town_is_sound(
            width in 60.0..600.0f64, depth in 60.0..600.0f64, share in 0.0..0.3f64, seed: u64,
        ) {
            let map = city([width, depth], share, seed);
            prop_assert!((map.built_share() - share).abs() < 1e-9);
            sound(&map);
        }
    }
}
