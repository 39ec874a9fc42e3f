//! The limit of vertices only grows outer approximations and only shrinks inner ones.

use csat_agent::region::{Inner, Outer};
use csat_proto::region::{Region, Ring, grid_point};
use rand::RngExt;

use crate::oracle::{excess_m2, perimeter_m};
use crate::shapes::{Rng, any_region, cases, region_at, solid};

fn bounds() -> Region {
    Region::rectangle([900.0, 700.0])
}

/// Dozens of sets, some of which overlap: islands, holes and notches.
fn crowd(rng: &mut Rng) -> Region {
    let rings: Vec<Ring> = (0..rng.random_range(5..60))
        .flat_map(|_| {
            let at = [rng.random_range(-400.0..400.0), rng.random_range(-300.0..300.0)];
            let scale_m = rng.random_range(1.0..40.0);
            region_at(rng, at, scale_m).into_shapes().into_iter().flatten()
        })
        .collect();
    Outer::containing(solid(&rings)).intersection(&Outer::containing(bounds())).into_region()
}

#[test]
fn a_limited_outer_set_contains_the_set_and_keeps_to_its_bounds() {
    cases("a_limited_outer_set_contains_the_set_and_keeps_to_its_bounds", 300, |rng| {
        let region = crowd(rng);
        let vertices = rng.random_range(4..200);
        let limited = Outer::containing(region.clone()).limited(vertices, &bounds()).into_region();
        assert!(limited.vertex_count() <= vertices, "{} of {vertices}", limited.vertex_count());
        let lost_m2 = excess_m2(&region, &limited);
        assert!(lost_m2 <= 1e-5 * perimeter_m(&region) + 1e-9, "{lost_m2} m² lost");
        let outside_m2 = excess_m2(&limited, &bounds());
        assert!(outside_m2 <= 1e-5 * perimeter_m(&limited), "{outside_m2} m² outside");
    });
}

#[test]
fn a_limited_inner_set_is_contained_in_the_set() {
    cases("a_limited_inner_set_is_contained_in_the_set", 300, |rng| {
        let region = crowd(rng);
        let vertices = rng.random_range(4..200);
        let limited = Inner::within(region.clone()).limited(vertices).into_region();
        assert!(limited.vertex_count() <= vertices, "{} of {vertices}", limited.vertex_count());
        let gained_m2 = excess_m2(&limited, &region);
        assert!(gained_m2 <= 1e-5 * perimeter_m(&limited) + 1e-9, "{gained_m2} m² gained");
    });
}

#[test]
fn what_has_few_vertices_stays_as_it_is() {
    cases("what_has_few_vertices_stays_as_it_is", 200, |rng| {
        let region = any_region(rng);
        let vertices = region.vertex_count();
        assert_eq!(
            Outer::containing(region.clone()).limited(vertices, &bounds()).region(),
            &region
        );
        assert_eq!(Inner::within(region.clone()).limited(vertices).region(), &region);
    });
}

/// Details are dropped first: a town with a finely notched border and a yard keeps its yard.
#[test]
fn little_is_lost_where_little_has_to_be() {
    let notched: Ring = (0..400)
        .map(|i| {
            let angle = f64::from(i) * std::f64::consts::TAU / 400.0;
            let radius_m = if i % 2 == 0 { 200.0 } else { 199.8 };
            grid_point([radius_m * angle.cos(), radius_m * angle.sin()])
        })
        .collect();
    let yard: Ring =
        [[-40.0, -40.0], [-40.0, 40.0], [40.0, 40.0], [40.0, -40.0]].map(grid_point).to_vec();
    let region = Region::from_shapes(vec![vec![notched, yard]]);
    let outer = Outer::containing(region.clone()).limited(120, &bounds()).into_region();
    let inner = Inner::within(region.clone()).limited(120).into_region();
    assert!(outer.vertex_count() <= 120 && inner.vertex_count() <= 120);
    let area_m2 = region.area_m2();
    assert!((area_m2..1.02 * area_m2).contains(&outer.area_m2()), "{}", outer.area_m2());
    assert!((0.98 * area_m2..area_m2).contains(&inner.area_m2()), "{}", inner.area_m2());
}
