//! The points of space that may have lit a pixel.

use csat_proto::camera::{Assumption, CameraView};
use nalgebra::Vector3;

use super::pose_box::Extent;

/// The ground projections (`world`, metres) of the vertices of the truncated pyramid that contains
/// every point consistent with pixel (`row`, `column`) and the distance interval `depth_m`
/// (A.2, A.3): the near face at the least distance, the far one pushed out by 1/cos θ so that the
/// plane through its corners lies behind the sphere of the greatest distance.
///
/// Under Assumption 6 the pyramid is a segment of the centre ray (A.1.2).
pub fn ground_corners(
    view: &CameraView,
    column: u16,
    row: u16,
    depth_m: [f64; 2],
) -> Vec<[f64; 2]> {
    corners(view, column, row, depth_m).map(|p| [p.x, p.y]).collect()
}

/// How far the corners of the same pyramid are from the camera, at most.
pub(super) fn extent(view: &CameraView, column: u16, row: u16, depth_m: [f64; 2]) -> Extent {
    let centre = view.centre_world();
    corners(view, column, row, depth_m).fold(Extent::default(), |extent, p| Extent {
        reach_m: extent.reach_m.max((p - centre).norm()),
        drop_m: extent.drop_m.max((p.z - centre.z).abs()),
    })
}

/// The greatest height of the same pyramid above the ground, metres.
pub fn top_m(view: &CameraView, column: u16, row: u16, depth_m: [f64; 2]) -> f64 {
    corners(view, column, row, depth_m).map(|p| p.z).fold(f64::NEG_INFINITY, f64::max)
}

fn corners(
    view: &CameraView,
    column: u16,
    row: u16,
    [near_m, far_m]: [f64; 2],
) -> impl Iterator<Item = Vector3<f64>> {
    let (c, r) = (f64::from(column), f64::from(row));
    let origin = view.centre_world();
    let centre = view.ray_world(c + 0.5, r + 0.5).normalize();
    let half_width = match view.model().assumption {
        Assumption::EveryRay | Assumption::SomeRay => 0.5,
        Assumption::CentreRay => 0.0,
    };
    let offsets = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let used = if half_width > 0.0 { 4 } else { 1 };
    offsets.into_iter().take(used).flat_map(move |(dc, dr)| {
        let ray = view.ray_world(c + 0.5 + dc * half_width, r + 0.5 + dr * half_width).normalize();
        [origin + ray * near_m, origin + ray * (far_m / ray.dot(&centre))]
    })
}
