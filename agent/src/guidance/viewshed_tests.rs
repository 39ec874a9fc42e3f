//! Viewsheds against the point by point test of the exact shadows.

use csat_proto::model::Ground;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::shadow::hides_point;
use super::super::shadow::tests::{occupy, random_oem};
use super::*;

const GROUND: Ground = Ground { size_m: [500.0, 420.0] };

/// The boxes that a skyline makes of a map.
fn boxes(skyline: &Skyline, grid: &Grid) -> Oem {
    let mut oem = Oem::unexplored(*grid);
    for (cell, &storeys) in (0..).zip(&skyline.rows).filter(|&(_, &storeys)| storeys > 0) {
        let height_dm = u16::from(storeys) * STOREY_DM;
        oem.join(OemDelta { cell, state: OemCell::Occupied { height_dm } });
    }
    oem
}

fn sees(viewshed: &mut Viewshed, [column, row]: [i32; 2]) -> bool {
    viewshed.seen(row as u32, column as usize / 64, 1 << (column % 64)) != 0
}

#[test]
fn what_is_hidden_is_what_points_say() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let grid = Grid::covering(&GROUND, 4.0);
    let (mut hidden, mut false_hidden, mut false_seen) = (0, 0, 0);
    for _ in 0..10 {
        let oem = random_oem(&mut rng, 45.0);
        let mut viewshed = Viewshed::new(grid, 300.0);
        assert!(viewshed.load(&oem) && !viewshed.load(&oem), "news are told once");
        let boxes = boxes(&viewshed.skyline, &grid);
        let eye = [rng.random_range(-30..155), rng.random_range(-30..135)];
        let [x, y] = [0, 1].map(|i| grid.origin()[i] + (f64::from(eye[i]) + 0.5) * grid.cell_m);
        let z_m = rng.random_range(30.0..70.0);
        viewshed.look_from(eye, z_m);
        for (column, row) in (0..125).flat_map(|c| (0..105).map(move |r| (c, r))) {
            let p = grid.centre(column as u32, row as u32);
            if (p[0] - x).hypot(p[1] - y) > 300.0 {
                continue;
            }
            let expected = hides_point(&boxes, [x, y, z_m], p);
            let found = !sees(&mut viewshed, [column, row]);
            hidden += u32::from(expected);
            false_hidden += u32::from(found && !expected);
            false_seen += u32::from(expected && !found);
        }
    }
    // Corners that a line of sight only cuts are missed, and far away a ray stands for two cells side by
    // side.
    assert!(hidden > 10_000, "{hidden}");
    assert!(false_hidden * 100 < 2 * hidden, "{false_hidden} of {hidden}");
    assert!(false_seen * 100 < 7 * hidden, "{false_seen} of {hidden}");
}

#[test]
fn a_shadow_ends_where_the_line_of_sight_over_the_roof_meets_the_ground() {
    let ground = Ground { size_m: [404.0; 2] };
    let grid = Grid::covering(&ground, 4.0);
    let mut oem = Oem::unexplored(grid);
    // Half a cell more on both sides are two cells, the farther one ending 20.5 cells away.
    occupy(&mut oem, 70, 50, 26.0);
    occupy(&mut oem, 50, 30, 52.0);
    let mut viewshed = Viewshed::new(grid, 300.0);
    viewshed.load(&oem);
    viewshed.look_from([50, 50], 52.0);
    // A roof half as high as the eye: twice as far.
    let hidden: Vec<i32> = (50..101).filter(|&c| !sees(&mut viewshed, [c, 50])).collect();
    assert_eq!(hidden, (69..91).collect::<Vec<_>>());
    let hidden: Vec<i32> = (0..50).filter(|&r| !sees(&mut viewshed, [50, r])).collect();
    assert_eq!(hidden, (0..31).collect::<Vec<_>>(), "as high as the eye");
    assert!((0..101).all(|r| (0..50).all(|c| c > 45 && r < 35 || sees(&mut viewshed, [c, r]))));
}

/// The same from outside the map, where rays enter it somewhere on their way.
#[test]
fn eyes_may_be_outside_the_map() {
    let ground = Ground { size_m: [200.0; 2] };
    let grid = Grid::covering(&ground, 4.0);
    let mut oem = Oem::unexplored(grid);
    (20..30).for_each(|i| occupy(&mut oem, i, 10, 60.0));
    (20..30).for_each(|i| occupy(&mut oem, 10, i, 60.0));
    let mut viewshed = Viewshed::new(grid, 300.0);
    viewshed.load(&oem);
    for (eye, behind) in
        [([25, -20], [25, 12]), ([25, 60], [25, 8]), ([-20, 25], [12, 25]), ([60, 25], [8, 25])]
    {
        viewshed.look_from(eye, 52.0);
        assert!(!sees(&mut viewshed, behind) && sees(&mut viewshed, [40, 40]), "{eye:?}");
    }
    viewshed.look_from([500, 500], 52.0);
    assert_eq!(inside(500, -1, 50, 76), 76..76);
}
