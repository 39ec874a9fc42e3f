//! Buildings and polygons as triangles.

use csat_mission::picture::Ring;

/// A corner of a triangle: east, north, up, metres.
pub type Corner = [f64; 3];

/// The walls and the roof of a building: three corners for each triangle. `rings` are its outline
/// and its holes, whichever way they go, without repetition of the first point.
pub fn building(rings: &[Ring], height_m: f64) -> Vec<Corner> {
    let mut corners = Vec::new();
    for [a, b] in sides(rings) {
        let [low_a, low_b] = [a, b].map(|p| [p[0], p[1], 0.0]);
        let [high_a, high_b] = [a, b].map(|p| [p[0], p[1], height_m]);
        corners.extend([low_a, low_b, high_b, low_a, high_b, high_a]);
    }
    corners.extend(flat(rings, height_m));
    corners
}

/// A polygon at a height: three corners for each triangle.
pub fn flat(rings: &[Ring], height_m: f64) -> impl Iterator<Item = Corner> + use<> {
    roof(rings).into_iter().map(move |[x, y]| [x, y, height_m])
}

/// A polygon as triangles, by strips between the latitudes of its corners: within one of them,
/// sides do not end or cross, and whatever lies between an odd side and the next is inside.
fn roof(rings: &[Ring]) -> Vec<[f64; 2]> {
    let mut levels: Vec<f64> = rings.iter().flatten().map(|p| p[1]).collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    let mut corners = Vec::new();
    for strip in levels.windows(2) {
        let (south, north) = (strip[0], strip[1]);
        let mut crossing: Vec<[f64; 2]> = sides(rings)
            .filter(|[a, b]| a[1].min(b[1]) <= south && a[1].max(b[1]) >= north && a[1] != b[1])
            .map(|side| [south, north].map(|y| east_of(side, y)))
            .collect();
        crossing.sort_by(|a, b| (a[0] + a[1]).total_cmp(&(b[0] + b[1])));
        for pair in crossing.chunks_exact(2) {
            let ([west_s, west_n], [east_s, east_n]) = (pair[0], pair[1]);
            let (sw, se) = ([west_s, south], [east_s, south]);
            let (ne, nw) = ([east_n, north], [west_n, north]);
            if se != sw {
                corners.extend([sw, se, ne]);
            }
            if ne != nw {
                corners.extend([sw, ne, nw]);
            }
        }
    }
    corners
}

/// Where a side is at a latitude.
fn east_of([a, b]: [[f64; 2]; 2], y: f64) -> f64 {
    a[0] + (b[0] - a[0]) * ((y - a[1]) / (b[1] - a[1]))
}

/// From each corner to the next.
fn sides(rings: &[Ring]) -> impl Iterator<Item = [[f64; 2]; 2]> {
    rings.iter().flat_map(|ring| {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(a, b)| [*a, *b])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{Request, load};

    fn area_m2(corners: &[[f64; 2]]) -> f64 {
        let triangles = corners.chunks_exact(3);
        triangles
            .map(|t| {
                let [u, v] = [1, 2].map(|i| [t[i][0] - t[0][0], t[i][1] - t[0][1]]);
                (u[0] * v[1] - u[1] * v[0]).abs() / 2.0
            })
            .sum()
    }

    #[test]
    fn a_courtyard_stays_open() {
        let square = |r: f64| vec![[-r, -r], [r, -r], [r, r], [-r, r]];
        let rings = [square(10.0), square(4.0)];
        assert!((area_m2(&roof(&rings)) - (400.0 - 64.0)).abs() < 1e-9);
        // Eight walls of two triangles, and four strips of the roof of two.
        assert_eq!(building(&rings, 5.0).len(), 3 * (8 * 2 + 4 * 2));
    }

    #[test]
    fn roofs_cover_what_their_buildings_do() {
        for scenario in ["city", "helsinki-05"] {
            let request = Request { scenario: Some(scenario), ..Request::default() };
            for obstacle in load(request).unwrap().world.obstacles() {
                let rings: Vec<Ring> = obstacle.rings().collect();
                let (got, expected) = (area_m2(&roof(&rings)), obstacle.area_m2());
                assert!((got - expected).abs() < 1e-6 * expected.max(1.0), "{}", obstacle.name);
            }
        }
    }
}
