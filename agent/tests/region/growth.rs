//! Repeated prediction keeps sets small and tight.

use std::f64::consts::{PI, TAU};

use csat_agent::region::{Disc, Inner, Outer};
use csat_proto::region::{Region, Ring, grid_point};
use rand::{RngExt, SeedableRng};

use crate::dilate::everywhere;
use crate::shapes::{Rng, solid};

#[test]
fn a_square_stays_a_small_polygon() {
    for (vertices, count, area) in [(8, 8, 1.025), (16, 32, 1.0065)] {
        let disc = Disc::circumscribed(0.5, vertices);
        let mut set = Outer::containing(Region::rectangle([40.0, 40.0]));
        for _ in 0..100 {
            set = set.dilated(&disc, &everywhere());
        }
        let exact = 40.0 * 40.0 + 4.0 * 40.0 * 50.0 + PI * 50.0 * 50.0;
        let ratio = set.region().area_m2() / exact;
        println!("n = {vertices}: {} vertices, area ratio {ratio}", set.region().vertex_count());
        assert!(set.region().vertex_count() <= count);
        assert!((1.0..area).contains(&ratio));
    }
}

/// X̄ of a region of interest during a search: predict, remove a seen part, simplify.
#[test]
fn a_ragged_set_stays_bounded() {
    let bounds = Region::rectangle([500.0, 500.0]);
    for vertices in [8, 16] {
        let mut rng = Rng::seed_from_u64(u64::from(vertices));
        let disc = Disc::circumscribed(0.5, vertices);
        let mut set = Outer::containing(bounds.clone());
        let (mut most, mut sum) = (0, 0);
        for _ in 0..600 {
            let cut = Inner::within(solid(&[random_quad(&mut rng)]));
            set = set.dilated(&disc, &bounds).minus([&cut]).simplified(0.05);
            most = most.max(set.region().vertex_count());
            sum += set.region().vertex_count();
        }
        println!("n = {vertices}: at most {most} vertices, {} on average", sum / 600);
        assert!(most < 2000);
    }
}

pub fn random_quad(rng: &mut Rng) -> Ring {
    let at: [f64; 2] = [rng.random_range(-250.0..250.0), rng.random_range(-250.0..250.0)];
    let turn: f64 = rng.random_range(0.0..TAU);
    let corner = |k: u32| {
        let radius = rng.random_range(10.0..60.0);
        let angle = turn + TAU / 4.0 * (f64::from(k) + rng.random_range(-0.4..0.4));
        grid_point([at[0] + radius * angle.cos(), at[1] + radius * angle.sin()])
    };
    (0..4).map(corner).collect()
}
