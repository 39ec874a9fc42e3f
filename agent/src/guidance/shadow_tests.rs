//! Shadows against the definition: hulls of projected boxes.

use csat_proto::camera::{CameraModel, Pose, PoseError};
use csat_proto::model::Ground;
use csat_proto::oem::OemDelta;
use csat_proto::raster::Raster;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::footprint::Footprint;
use super::*;
use crate::sense::pose_box::PoseBox;

fn grid(cell_m: f64) -> Grid {
    Grid::covering(&Ground { size_m: [500.0; 2] }, cell_m)
}

pub(in super::super) fn occupy(oem: &mut Oem, column: u32, row: u32, height_m: f64) {
    let cell = oem.grid().index(column, row) as u32;
    let height_dm = (height_m * 10.0).round() as u16;
    oem.join(OemDelta { cell, state: OemCell::Occupied { height_dm } });
}

/// A few buildings of several cells each.
pub(in super::super) fn random_oem(rng: &mut ChaCha8Rng, tallest_m: f64) -> Oem {
    let mut oem = Oem::unexplored(grid(5.0));
    for _ in 0..25 {
        let (column, row) = (rng.random_range(0..95), rng.random_range(0..95));
        let (width, depth) = (rng.random_range(1..6), rng.random_range(1..6));
        let height = rng.random_range(2.0..tallest_m);
        for c in column..(column + width).min(100) {
            (row..(row + depth).min(100)).for_each(|r| occupy(&mut oem, c, r, height));
        }
    }
    oem
}

fn hides(caster: &ShadowCaster, column: u32, row: u32) -> bool {
    caster.hidden_bits(row, column as usize / 64, 1 << (column % 64)) != 0
}

/// Convex hull, counter-clockwise (Andrew).
fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut ring: Vec<[f64; 2]> = Vec::new();
    for pass in 0..2 {
        let start = ring.len();
        for &p in &points {
            while ring.len() >= start + 2 {
                let (a, b) = (ring[ring.len() - 2], ring[ring.len() - 1]);
                if cross([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]) > 0.0 {
                    break;
                }
                ring.pop();
            }
            ring.push(p);
        }
        ring.pop();
        if pass == 0 {
            points.reverse();
        }
    }
    ring
}

/// (4.42) by its definition: per box the convex hull of the points where the lines through the
/// optical centre and the eight vertices meet the ground.
fn hulls(oem: &Oem, eye: [f64; 3]) -> Vec<Vec<[f64; 2]>> {
    let (grid, mut all) = (oem.grid(), Vec::new());
    for (row, column) in (0..grid.rows).flat_map(|r| (0..grid.columns).map(move |c| (r, c))) {
        let Some(height) = oem.height_m(column, row) else { continue };
        let [x, y] = grid.centre(column, row);
        let mut points = Vec::new();
        for (dx, dy) in [(-2.5, -2.5), (2.5, -2.5), (2.5, 2.5), (-2.5, 2.5)] {
            for h in [0.0, height] {
                let scale = eye[2] / (eye[2] - h);
                let project = |from: f64, to: f64| from + scale * (to - from);
                points.push([project(eye[0], x + dx), project(eye[1], y + dy)]);
            }
        }
        all.push(hull(points));
    }
    all
}

fn in_ring(ring: &[[f64; 2]], p: [f64; 2]) -> bool {
    (0..ring.len()).all(|i| {
        let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
        cross([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]) >= 0.0
    })
}

/// Whether all cells about (column, row) are equal to it, so that it is more than a cell from a border.
fn is_interior(set: &Raster, column: u32, row: u32) -> bool {
    let around = |v: u32, max: u32| v.saturating_sub(1)..(v + 2).min(max);
    around(row, set.grid().rows)
        .all(|r| around(column, set.grid().columns).all(|c| set.get(c, r) == set.get(column, row)))
}

#[test]
fn shadows_are_the_union_of_the_hulls_of_the_boxes() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let (grid, mut caster) = (grid(2.0), ShadowCaster::new(&grid(2.0), 300.0));
    let (mut footprint_cells, mut border_differences) = (0, 0);
    for _ in 0..30 {
        let oem = random_oem(&mut rng, 45.0);
        let eye = [rng.random_range(-260.0..260.0), rng.random_range(-260.0..260.0), 52.0];
        let pose = Pose::level(eye, rng.random_range(-4.0..4.0));
        let footprint = exact(&pose, &grid);
        caster.cast(&OccupiedCells::of(&oem), eye, footprint.corners());
        let mut expected = Raster::empty(grid);
        for ring in hulls(&oem, eye) {
            expected.fill_rings(&[ring]);
        }
        for (column, row) in footprint.raster(grid).iter() {
            footprint_cells += 1;
            if hides(&caster, column, row) != expected.get(column, row) {
                border_differences += 1;
                let interior = is_interior(&expected, column, row);
                assert!(!interior, "cell {column} {row} from {pose:?} is not at a border");
            }
        }
    }
    assert!(footprint_cells > 50_000, "the footprints fell on the map");
    assert!(
        border_differences * 100 < footprint_cells,
        "{border_differences} of {footprint_cells}"
    );
}

/// The point test needs no grid, so it is exact, for any point of the region.
#[test]
fn single_points_agree_with_the_hulls() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut hidden_points = 0;
    for _ in 0..10 {
        let oem = random_oem(&mut rng, 45.0);
        let eye = [rng.random_range(-260.0..260.0), rng.random_range(-260.0..260.0), 52.0];
        let hulls = hulls(&oem, eye);
        for _ in 0..500 {
            let p = [rng.random_range(-250.0..250.0), rng.random_range(-250.0..250.0)];
            let expected = hulls.iter().any(|ring| in_ring(ring, p));
            assert_eq!(hides_point(&oem, eye, p), expected, "{p:?} from {eye:?}");
            hidden_points += u32::from(expected);
        }
    }
    assert!((200..4800).contains(&hidden_points), "{hidden_points}");
}

/// A box as high as the camera or higher hides all that lies behind it.
#[test]
fn what_reaches_the_camera_hides_to_the_horizon() {
    let mut oem = Oem::unexplored(grid(5.0));
    occupy(&mut oem, 60, 50, 60.0); // x 50..55, y 0..5
    let (grid, eye) = (grid(2.0), [0.0, 0.0, 52.0]);
    let footprint = exact(&Pose::level(eye, 0.0), &grid);
    let mut caster = ShadowCaster::new(&grid, 300.0);
    caster.cast(&OccupiedCells::of(&oem), eye, footprint.corners());
    for x in [51.0, 61.0, 151.0, 229.0] {
        let (column, row) = grid.cell_of([x, 1.0]).unwrap();
        assert!(hides(&caster, column, row), "{x}");
        assert!(hides_point(&oem, eye, [x, 1.0]), "{x}");
        let (column, row) = grid.cell_of([x, -3.0]).unwrap();
        assert!(!hides(&caster, column, row), "{x}");
        assert!(!hides_point(&oem, eye, [x, -3.0]), "{x}");
    }
    let (column, row) = grid.cell_of([49.0, 1.0]).unwrap();
    assert!(!hides(&caster, column, row), "in front");
}

/// For a camera that looks straight down, shadows lie all around the nadir.
#[test]
fn looking_down_there_is_no_fan() {
    let square = [[-10.0, -10.0], [10.0, -10.0], [10.0, 10.0], [-10.0, 10.0]];
    assert!(Fan::around([1.0, 2.0], &square).is_none());
    let fan = Fan::around([-30.0, 0.0], &square).unwrap();
    assert!(
        fan.meets([5.0, 0.0], 0.0) && !fan.meets([-5.0, 0.0], 1.0) && !fan.meets([0.0, 5.0], 1.0)
    );
    assert!(fan.meets([-1.0, 0.0], 2.0), "a cell at the nadir may cast into the fan");
}

/// The footprint from a pose that is known exactly.
fn exact(pose: &Pose, grid: &Grid) -> Footprint {
    let view = CameraModel::default().at(pose);
    Footprint::of(&view, &PoseBox::new(&view, pose, &PoseError::NONE), grid)
}
