//! Sets of many edges are resolved in cells, which changes nothing but the edges between the cells.

use std::sync::Arc;

use csat_agent::region::{Disc, Grown, Inner, Memo, Outer, Reach};
use csat_proto::region::{Region, twice_signed_area};
use csat_proto::time::Step;
use i_overlay::core::overlay_rule::OverlayRule;
use rand::RngExt;

use crate::oracle::{ROUNDING_M, assert_same, excess_m2, overlay, perimeter_m};
use crate::shapes::{Rng, cases, region_at, solid, star};

const SIDE_M: [f64; 2] = [900.0, 700.0];

/// Sets of any shape within the bounds.
fn parts(rng: &mut Rng, count: usize, size_m: std::ops::Range<f64>) -> Vec<Inner> {
    let part = |rng: &mut Rng| {
        let at = SIDE_M.map(|side| rng.random_range(-0.5..0.5) * side);
        let size_m = rng.random_range(size_m.clone());
        Inner::within(region_at(rng, at, size_m))
    };
    (0..count).map(|_| part(rng)).collect()
}

/// What is between the buildings of a town.
fn streets(rng: &mut Rng) -> Region {
    let building = |rng: &mut Rng| {
        let at = SIDE_M.map(|side| rng.random_range(-0.5..0.5) * side);
        let size_m = rng.random_range(1.0..25.0);
        star(rng, at, size_m)
    };
    let buildings: Vec<_> = (0..rng.random_range(20..120)).map(|_| building(rng)).collect();
    overlay(&Region::rectangle(SIDE_M), &solid(&buildings), OverlayRule::Difference)
}

fn plain_difference(set: &Region, parts: &[Inner]) -> Region {
    parts
        .iter()
        .fold(set.clone(), |left, part| overlay(&left, part.region(), OverlayRule::Difference))
}

/// No two shapes have more than a border in common.
fn assert_disjoint(set: &Region) {
    let rings: Vec<_> = set.rings().cloned().collect();
    let sum: i128 = rings.iter().map(|ring| twice_signed_area(ring)).sum();
    let united: i128 = solid(&rings).rings().map(|ring| twice_signed_area(ring)).sum();
    // Rounding where borders cross lines.
    let allowed = 1 << 34;
    assert!((sum - united).abs() < allowed, "{sum} and {united}");
}

#[test]
fn a_town_is_resolved_in_cells_to_the_same_set() {
    cases("a_town_is_resolved_in_cells_to_the_same_set", 150, |rng| {
        let bounds = Region::rectangle(SIDE_M);
        let disc = Disc::circumscribed(rng.random_range(0.1..5.0), 16);
        let town = Outer::containing(streets(rng));
        let count = rng.random_range(0..40);
        let parts = parts(rng, count, 5.0..90.0);
        let grown = Grown::new(&town, 0.0, &Reach::at_once(disc.clone()), &bounds, &Arc::default());
        let expected = plain_difference(town.dilated(&disc, &bounds).region(), &parts);
        let in_cells = grown.minus(&parts);
        assert_same(in_cells.region(), &expected);
        assert_disjoint(in_cells.region());
    });
}

/// What was divided once is divided again at every step, along the same lines. A strip that rounding
/// loses or leaves grows at every step, so the set is held between those of parts a millimetre larger
/// and smaller.
#[test]
fn steps_in_cells_do_not_add_up_to_a_difference() {
    cases("steps_in_cells_do_not_add_up_to_a_difference", 4, |rng| {
        let bounds = Region::rectangle(SIDE_M);
        let disc = Disc::circumscribed(0.5, 16);
        let step = |set: Region, parts: &[Inner]| {
            let grown = Outer::containing(set).dilated(&disc, &bounds);
            plain_difference(grown.region(), parts)
        };
        let buildings = parts(rng, 60, 1.0..25.0);
        let mut in_cells = Outer::containing(bounds.clone());
        let (mut least, mut most) = (bounds.clone(), bounds.clone());
        // What is looked up is what would be computed: the memo has seen the steps before.
        let memo = Arc::<Memo>::default();
        for step_number in 0..10 {
            memo.begin(Step(step_number));
            let mut cut = parts(rng, 4, 20.0..90.0);
            cut.extend(buildings.iter().cloned());
            let grown = Grown::new(&in_cells, 0.0, &Reach::at_once(disc.clone()), &bounds, &memo);
            let reach = Reach::at_once(disc.clone());
            let grown_again = Grown::new(&in_cells, 0.0, &reach, &bounds, &Arc::default());
            in_cells = grown.minus(&cut);
            assert_eq!(grown_again.minus(&cut), in_cells, "what was looked up");
            least = step(least, &cut.iter().map(|part| larger(part, &bounds)).collect::<Vec<_>>());
            most = step(most, &cut.iter().map(smaller).collect::<Vec<_>>());
        }
        let [divided, whole] = [in_cells.region(), &least].map(|set| set.shapes().len());
        assert!(divided > whole + 8, "nothing was divided: {divided} and {whole} shapes");
        let allowed_m2 = ROUNDING_M * perimeter_m(in_cells.region());
        let (beyond, short) =
            (excess_m2(in_cells.region(), &most), excess_m2(&least, in_cells.region()));
        assert!(beyond < allowed_m2 && short < allowed_m2, "{beyond} and {short} m²");
        assert_disjoint(in_cells.region());
    });
}

fn larger(part: &Inner, bounds: &Region) -> Inner {
    let set = Outer::containing(part.region().clone());
    Inner::within(set.dilated(&Disc::circumscribed(1e-3, 8), bounds).into_region())
}

fn smaller(part: &Inner) -> Inner {
    part.eroded(&Disc::circumscribed(1e-3, 8))
}
