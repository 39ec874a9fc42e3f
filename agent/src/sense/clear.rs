//! Clear ground C (4.6).

use csat_proto::camera::CameraView;
use csat_proto::region::{GridPoint, MAX_COORDINATE_M, Region, Ring, grid_point};

use super::exclusion::HalfPlane;
use super::outline::UNITS_PER_PX;
use super::pose_box::PoseBox;
use crate::region::Inner;

/// C = P^g(Y^g) ∩ X_g (4.6): the ground seen through Ground pixels, inner.
///
/// The image-to-ground map is a homography, and homographies map straight edges to straight edges:
/// mapping the corners of the pixels' outline is exact for any number of pixels. `outline` holds
/// rings in 1/256 pixels with the ground on the left, filled by positive winding; no target location
/// is in the result by Assumption 7 (Proposition 14).
pub fn clear_ground(view: &CameraView, outline: &[Ring], ground: &Region) -> Inner {
    let pixels = |units: i32| f64::from(units) / f64::from(UNITS_PER_PX);
    let on_ground = |p: &GridPoint| view.ground_point(pixels(p.x), pixels(p.y));
    // The ray through every corner of a Ground pixel meets the ground; a frame in which one does not is
    // invalid and proves nothing.
    let mapped: Option<Vec<Ring>> = outline
        .iter()
        .map(|ring| Some(rounded(ring.iter().rev().map(on_ground).collect::<Option<_>>()?)))
        .collect();
    // From (column, row) to (east, north) the orientation flips: columns grow to the left of the
    // flight direction, rows along it. Hence the reversal above.
    mapped.map_or_else(Inner::default, |rings| Inner::from_rings(&rings, ground))
}

/// Where the outline of the Ground pixels may run on the ground.
#[derive(Debug, Clone)]
pub(super) struct Swept {
    /// What each edge of the outline sweeps, as convex rings.
    pub(super) all: Vec<Ring>,
    /// Whether the edge is a border of the image.
    is_border: Vec<bool>,
}

impl Swept {
    /// What the edges sweep beyond which something hides the ground, if only for some poses.
    pub(super) fn silhouettes(&self) -> impl Iterator<Item = &Ring> {
        self.all.iter().zip(&self.is_border).filter(|(_, is_border)| !**is_border).map(|(r, _)| r)
    }
}

/// What the edges of `outline` sweep on the ground from all poses of the box: outside of it, the ground is clear
/// from all of them or from none. `None` if a Ground pixel may show what is above the horizon.
pub(super) fn swept(poses: &PoseBox, view: &CameraView, outline: &[Ring]) -> Option<Swept> {
    let size = [view.model().columns, view.model().rows];
    // An outline is one unit inside of its pixels.
    let is_at_end =
        |units: i32, axis: usize| units <= 1 || units >= i32::from(size[axis]) * UNITS_PER_PX - 1;
    let is_border = |a: &GridPoint, b: &GridPoint| {
        (a.x == b.x && is_at_end(a.x, 0)) || (a.y == b.y && is_at_end(a.y, 1))
    };
    let borders = |ring: &Ring| -> Vec<bool> {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(a, b)| is_border(a, b)).collect()
    };
    let pixels = |p: &GridPoint| [p.x, p.y].map(|units| f64::from(units) / f64::from(UNITS_PER_PX));
    let image: Vec<Vec<[f64; 2]>> =
        outline.iter().map(|ring| ring.iter().map(pixels).collect()).collect();
    let all = poses.swept_outline(&image)?;
    Some(Swept { all, is_border: outline.iter().flat_map(borders).collect() })
}

/// A ring (`world`, metres) rounded to the grid. Parts beyond the grid are cut off, because moving
/// their corners would change the directions of edges.
fn rounded(ring: Vec<[f64; 2]>) -> Ring {
    let is_beyond = |p: &[f64; 2]| p.iter().any(|x| x.abs() > MAX_COORDINATE_M);
    let ring = if ring.iter().any(is_beyond) {
        let normals = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
        let sides = normals.map(|normal| HalfPlane { normal, offset: MAX_COORDINATE_M });
        sides.iter().fold(ring, |ring, side| side.clip(&ring))
    } else {
        ring
    };
    ring.into_iter().map(grid_point).collect()
}

#[cfg(test)]
mod tests {
    use csat_proto::camera::{CameraModel, Pose};

    use super::*;

    /// A camera that looks to the north-east over 20 km of ground through all of its lowest pixels.
    #[test]
    fn what_is_seen_beyond_the_grid_bends_no_edge() {
        let pose = Pose::level([-300.0, -300.0, 60.0], 0.6);
        let model = CameraModel { aperture_deg: 70.0, d_max_m: 2e4, ..CameraModel::default() };
        let view = model.at(&pose);
        let ground = Region::rectangle([2000.0; 2]);
        // The rows whose ground is nearer than 15 km.
        let mut rows = (1..=model.rows).rev();
        let is_near =
            |row: &u16| view.ground_point(240.0, f64::from(*row)).is_some_and(|p| p[0] < 15e3);
        let last = i32::from(rows.find(is_near).expect("ground")) * UNITS_PER_PX;
        let right = i32::from(model.columns) * UNITS_PER_PX;
        let corners = [(0, 0), (right, 0), (right, last), (0, last)];
        let outline = vec![corners.map(|(x, y)| GridPoint::new(x, y)).to_vec()];
        let clear = clear_ground(&view, &outline, &ground);
        let (mut inside, mut outside) = (0, 0);
        for (i, j) in (-99..=99).flat_map(|i| (-99..=99).map(move |j| (i, j))) {
            let p = [f64::from(i) * 10.0, f64::from(j) * 10.0];
            let image = view.project(&nalgebra::Vector3::new(p[0], p[1], 0.0));
            let is_seen = image.is_some_and(|[c, r]| {
                (0.0..=480.0).contains(&c) && (0.0..=f64::from(last / UNITS_PER_PX)).contains(&r)
            });
            assert_eq!(clear.region().contains(p), is_seen, "{p:?}");
            *(if is_seen { &mut inside } else { &mut outside }) += 1;
        }
        assert!(inside > 5000 && outside > 5000, "{inside} {outside}");
    }
}
