//! Extreme valid input does not cause a panic, and the results keep the guarantee.

use csat_agent::region::{Disc, Inner, Outer};
use csat_proto::region::{MAX_COORDINATE_M, Region, grid_point};

use crate::shapes::solid;

/// A square that touches the corner of the grid.
fn far_square() -> Region {
    let (near, far) = (MAX_COORDINATE_M - 10.0, MAX_COORDINATE_M);
    let ring = [[near, near], [far, near], [far, far], [near, far]];
    solid(&[ring.iter().map(|&p| grid_point(p)).collect()])
}

#[test]
fn dilation_past_the_grid_fills_the_bounds() {
    let bounds = Region::rectangle([500.0, 500.0]);
    let outer = Outer::containing(far_square());
    assert!(outer.dilated(&Disc::circumscribed(0.5, 16), &bounds).is_empty());
    for radius_m in [1.5, 4000.0, 1e9, f64::INFINITY, f64::NAN] {
        let disc = Disc::circumscribed(radius_m, 16);
        assert_eq!(outer.dilated(&disc, &bounds).into_region(), bounds);
        assert!(Outer::default().dilated(&disc, &bounds).is_empty());
    }
}

#[test]
fn erosion_past_the_grid_leaves_nothing() {
    let inner = Inner::within(far_square());
    assert!(!inner.eroded(&Disc::circumscribed(0.5, 16)).is_empty());
    for radius_m in [1.5, 4000.0, 1e9, f64::INFINITY, f64::NAN] {
        assert!(inner.eroded(&Disc::circumscribed(radius_m, 16)).is_empty());
    }
}

#[test]
fn a_negative_radius_is_none() {
    assert_eq!(Disc::circumscribed(-3.0, 16), Disc::circumscribed(0.0, 16));
}

#[test]
fn repeated_points_change_nothing() {
    let square = Region::rectangle([10.0, 10.0]);
    let twice = |p| [p, p];
    let ring = square.shapes()[0][0].iter().copied().flat_map(twice).collect();
    let disc = Disc::circumscribed(0.5, 16);
    let bounds = Region::rectangle([500.0, 500.0]);
    assert_eq!(
        Outer::containing(Region::from_shapes(vec![vec![ring]])).dilated(&disc, &bounds),
        Outer::containing(square).dilated(&disc, &bounds),
    );
}
