//! The q-relaxed intersection, against the sets that each point is in, and sets that miss each other.

use csat_agent::region::Outer;
use csat_proto::region::{Region, metres};
use rand::RngExt;

use crate::oracle::{around, boundary_distance_m};
use crate::shapes::{Rng, cases, region_at};

/// Several regions that mostly overlap, some of them equal.
fn any_sets(rng: &mut Rng) -> Vec<Region> {
    let at = |rng: &mut Rng| [0; 2].map(|_| rng.random_range(-10.0..10.0));
    let mut sets: Vec<Region> = Vec::new();
    for _ in 0..rng.random_range(2..7) {
        let twin = sets.first().cloned().filter(|_| rng.random_bool(0.2));
        let (at, scale) = (at(rng), rng.random_range(5.0..40.0));
        sets.push(twin.unwrap_or_else(|| region_at(rng, at, scale)));
    }
    sets
}

#[test]
fn a_point_is_kept_if_all_sets_but_q_contain_it() {
    cases("a_point_is_kept_if_all_sets_but_q_contain_it", 800, |rng| {
        let mut sets: Vec<Outer> = any_sets(rng).into_iter().map(Outer::containing).collect();
        // What contains all is left out of the operation.
        if rng.random_bool(0.3) {
            sets.push(Outer::containing(Region::rectangle([300.0, 300.0])));
        }
        let within = sets.swap_remove(0);
        let claims: Vec<&Outer> = sets.iter().collect();
        for q in 0..=claims.len() {
            let kept = within.clone().in_all_but(q, &claims);
            let all = claims.iter().copied().chain([&within]);
            let points = all.clone().flat_map(|set| around(rng, set.region(), 20));
            for p in points.collect::<Vec<_>>() {
                if all.clone().any(|set| boundary_distance_m(set.region(), p) < 1e-3) {
                    continue;
                }
                let missed = claims.iter().filter(|set| !set.region().contains(p)).count();
                let expected = within.region().contains(p) && missed <= q;
                assert_eq!(kept.region().contains(p), expected, "q = {q}, {p:?}");
            }
        }
    });
}

#[test]
fn sets_miss_each_other_if_a_gap_is_between_them() {
    let bounds = Region::rectangle([400.0, 400.0]);
    let (mut missed, mut met) = (0, 0);
    let square = |x: f64| {
        let ring = [[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]];
        let ring = ring.iter().map(|&p| csat_proto::region::grid_point(p)).collect();
        Outer::containing(Region::from_shapes(vec![vec![ring]]))
    };
    for (x, misses) in [(0.5, false), (0.999, false), (1.0, false), (1.000_5, false), (1.01, true)]
    {
        assert_eq!(square(0.0).misses(&square(x), &bounds), misses, "{x}");
        assert_eq!(square(x).misses(&square(0.0), &bounds), misses, "{x}");
    }
    let nothing = Outer::default();
    assert!(nothing.misses(&square(0.0), &bounds) && square(0.0).misses(&nothing, &bounds));
    for seed in 0..600u64 {
        let mut rng = <Rng as rand::SeedableRng>::seed_from_u64(seed);
        let mut at = || [0; 2].map(|_| rng.random_range(-40.0..40.0));
        let places = [at(), at()];
        let [a, b] = places.map(|at| Outer::containing(region_at(&mut rng, at, 20.0)));
        let misses = a.misses(&b, &bounds);
        *(if misses { &mut missed } else { &mut met }) += 1;
        let gap_m = |from: &Outer, to: &Outer| {
            let corners = from.region().rings().flatten();
            corners.map(|p| to.region().distance_m(metres(*p))).fold(f64::INFINITY, f64::min)
        };
        let gap_m = gap_m(&a, &b).min(gap_m(&b, &a));
        assert!(!(misses && gap_m == 0.0), "seed {seed}");
        assert!(!misses || a.intersection(&b).is_empty(), "seed {seed}");
    }
    assert!(missed > 50 && met > 50, "{missed} {met}");
}
