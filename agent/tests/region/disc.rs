//! `Disc::circumscribed` contains its disc, tightly.

use csat_agent::region::{Disc, NUMERIC_MARGIN_M};
use csat_proto::region::UNITS_PER_M;

use crate::oracle::cross;

#[test]
fn every_disc_is_convex_and_circumscribed() {
    for vertices in [0u16, 3, 4, 5, 8, 16, 33, 64, 1000] {
        for radius_m in [0.0, 1e-6, 1e-3, 0.3, 0.5, 7.3, 60.0, 500.0] {
            let disc = Disc::circumscribed(radius_m, vertices);
            let corners = disc.corners();
            let wanted = (radius_m + NUMERIC_MARGIN_M) * UNITS_PER_M;
            for (i, &a) in corners.iter().enumerate() {
                let b = corners[(i + 1) % corners.len()];
                let c = corners[(i + 2) % corners.len()];
                assert!(cross(a, b, c) > 0, "not convex: r = {radius_m}, n = {vertices}");
                let (dx, dy) = (f64::from(b.x - a.x), f64::from(b.y - a.y));
                let apothem = (f64::from(a.x) * dy - f64::from(a.y) * dx) / dx.hypot(dy);
                assert!(apothem >= wanted, "{apothem} < {wanted}: n = {vertices}");
                if vertices >= 8 {
                    assert!(f64::from(a.x).hypot(f64::from(a.y)) < wanted * 1.09 + 6.0);
                }
            }
        }
    }
}
