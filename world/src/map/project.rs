//! Longitude and latitude to the local tangent plane.
//!
//! # References
//! RFC 7946 §4 (WGS 84); the plane is East-North of the topocentric frame of EPSG method 9837.

/// Semi-major axis of WGS 84, metres.
const A_M: f64 = 6_378_137.0;
/// First eccentricity squared of WGS 84.
const E2: f64 = 6.694_379_990_141_316e-3;

/// The greatest distance from the centre that is projected, degrees; far away the projection is not
/// injective.
const MAX_OFFSET_DEG: f64 = 1.0;

/// The plane that touches the ellipsoid at a centre: x east, y north, metres.
#[derive(Debug, Clone, Copy)]
pub struct TangentPlane {
    centre_deg: [f64; 2],
    centre_ecef: [f64; 3],
}

impl TangentPlane {
    /// The plane about `[longitude, latitude]` in degrees.
    pub fn new(centre_deg: [f64; 2]) -> Self {
        Self { centre_deg, centre_ecef: ecef(centre_deg) }
    }

    /// The centre, `[longitude, latitude]` in degrees.
    pub fn centre_deg(&self) -> [f64; 2] {
        self.centre_deg
    }

    /// `[longitude, latitude]` in degrees to `[east, north]` in metres; `None` far from the centre.
    pub fn project(&self, lon_lat_deg: [f64; 2]) -> Option<[f64; 2]> {
        let lat_offset = (lon_lat_deg[1] - self.centre_deg[1]).abs();
        let lon_offset = (lon_lat_deg[0] - self.centre_deg[0]).abs();
        // Across the antimeridian 359.9° is 0.1°; a degree of longitude shortens with latitude.
        let lon_offset = lon_offset.min(360.0 - lon_offset) * self.centre_deg[1].to_radians().cos();
        if lat_offset > MAX_OFFSET_DEG || lon_offset > MAX_OFFSET_DEG {
            return None;
        }
        let p = ecef(lon_lat_deg);
        let d: [f64; 3] = std::array::from_fn(|i| p[i] - self.centre_ecef[i]);
        let [(sin_lon, cos_lon), (sin_lat, cos_lat)] =
            self.centre_deg.map(|degrees| degrees.to_radians().sin_cos());
        let east = -sin_lon * d[0] + cos_lon * d[1];
        let north = -sin_lat * (cos_lon * d[0] + sin_lon * d[1]) + cos_lat * d[2];
        Some([east, north])
    }

    /// `[east, north]` in metres to the `[longitude, latitude]` in degrees of the point of the
    /// ellipsoid above or below it: the inverse of [`Self::project`], to 1 µm within 10 km.
    pub fn unproject(&self, p_world: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.centre_deg[1].to_radians().sin_cos();
        let w2 = 1.0 - E2 * sin * sin;
        let (prime_vertical_m, meridian_m) = (A_M / w2.sqrt(), A_M * (1.0 - E2) / (w2 * w2.sqrt()));
        let mut lon_lat_deg = self.centre_deg;
        // Each iteration reduces the error by the ratio of distance to radius, 10⁻³ at 10 km.
        for _ in 0..6 {
            let Some(got) = self.project(lon_lat_deg) else { break };
            let rest: [f64; 2] = std::array::from_fn(|i| p_world[i] - got[i]);
            if rest[0].hypot(rest[1]) < 1e-7 {
                break;
            }
            lon_lat_deg[0] += (rest[0] / (prime_vertical_m * cos)).to_degrees();
            lon_lat_deg[1] += (rest[1] / meridian_m).to_degrees();
        }
        // Across the antimeridian 181° is -179°.
        lon_lat_deg[0] = (lon_lat_deg[0] + 180.0).rem_euclid(360.0) - 180.0;
        lon_lat_deg
    }
}

/// Earth-centred, Earth-fixed coordinates of a point of the ellipsoid, metres.
fn ecef(lon_lat_deg: [f64; 2]) -> [f64; 3] {
    let [(sin_lon, cos_lon), (sin_lat, cos_lat)] =
        lon_lat_deg.map(|degrees| degrees.to_radians().sin_cos());
    let n = A_M / (1.0 - E2 * sin_lat * sin_lat).sqrt();
    [n * cos_lat * cos_lon, n * cos_lat * sin_lon, n * (1.0 - E2) * sin_lat]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_lengths_of_a_degree() {
        // At 60° N one degree of latitude is 111 412 m and of longitude 55 800 m (NGA tables).
        let plane = TangentPlane::new([24.94, 60.0]);
        let [x, y] = plane.project([24.94 + 0.01, 60.0]).unwrap();
        assert!((x - 558.00).abs() < 0.05 && y.abs() < 0.1, "{x} {y}");
        let [x, y] = plane.project([24.94, 60.0 + 0.01]).unwrap();
        assert!(x.abs() < 1e-6 && (y - 1114.12).abs() < 0.05, "{x} {y}");
    }

    #[test]
    fn the_way_back_is_exact() {
        for centre_deg in [[24.94, 60.17], [0.0, 0.0], [179.999, -33.0], [-70.0, 80.0]] {
            let plane = TangentPlane::new(centre_deg);
            for p_world in [[0.0, 0.0], [250.0, -250.0], [-4000.0, 4000.0], [7000.0, 7000.0]] {
                let [x, y] = plane.project(plane.unproject(p_world)).unwrap();
                let off_m = (x - p_world[0]).hypot(y - p_world[1]);
                assert!(off_m < 1e-6, "{centre_deg:?} {p_world:?}: {off_m} m");
            }
        }
    }

    #[test]
    fn the_antimeridian_is_no_border_and_the_far_side_is_far() {
        let plane = TangentPlane::new([179.999, 10.0]);
        let [x, _] = plane.project([-179.999, 10.0]).unwrap();
        assert!((x - 219.3).abs() < 0.5, "{x}");
        assert_eq!(plane.project([0.0, 10.0]), None);
        assert_eq!(plane.project([179.999, -10.0]), None);
    }
}
