//! Viewsheds against the exact test of shadows, point by point.

use csat_proto::model::Ground;
use csat_proto::oem::{OemCell, OemDelta};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::super::shadow::hides_point;
use super::super::shadow::tests::{occupy, random_oem};
use super::*;

const GROUND: Ground = Ground { size_m: [500.0, 420.0] };

/// The boxes of a height map.
fn boxes(height_map: &HeightMap) -> Oem {
    let grid = *height_map.grid();
    let mut oem = Oem::unexplored(grid);
    for (column, row) in (0..grid.columns).flat_map(|c| (0..grid.rows).map(move |r| (c, r))) {
        let storeys = height_map.storeys([column as i32, row as i32]);
        if storeys > 0 {
            let height_dm = (f64::from(storeys) * STOREY_M * 10.0) as u16;
            let state = OemCell::Occupied { height_dm };
            oem.join(OemDelta { cell: grid.index(column, row) as u32, state });
        }
    }
    oem
}

/// The complete viewshed of `eye`.
fn all_around(caster: &mut RayCaster, eye: [i32; 2], z_m: f64) -> Viewshed {
    let mut viewshed = caster.viewshed(eye, z_m, 300.0);
    let cells = -caster.reach..=caster.reach;
    let cells = cells.clone().flat_map(|x| cells.clone().map(move |y| [x, y]));
    let rays = caster.rays_of(cells);
    assert_eq!(rays.iter().map(|word| word.count_ones()).sum::<u32>(), 4 * caster.reach as u32);
    caster.cast(&mut viewshed, &rays);
    viewshed
}

fn sees(viewshed: &Viewshed, [column, row]: [i32; 2]) -> bool {
    viewshed.seen(row, column / 64, 1 << (column % 64)) != 0
}

#[test]
fn what_is_hidden_is_what_points_say() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let grid = Grid::covering(&GROUND, 4.0);
    let (mut hidden, mut false_hidden, mut false_seen) = (0, 0, 0);
    for _ in 0..20 {
        let oem = random_oem(&mut rng, 45.0);
        let mut caster = RayCaster::new(grid, 300.0);
        assert!(caster.load(&oem) && !caster.load(&oem), "news are told once");
        let boxes = boxes(&caster.height_map);
        let eye = [rng.random_range(-75..200), rng.random_range(-75..180)];
        let [x, y] = [0, 1].map(|i| grid.origin()[i] + (f64::from(eye[i]) + 0.5) * grid.cell_m);
        let z_m = rng.random_range(30.0..70.0);
        let viewshed = all_around(&mut caster, eye, z_m);
        for (column, row) in (0..125).flat_map(|c| (0..105).map(move |r| (c, r))) {
            let p = grid.centre(column as u32, row as u32);
            if (p[0] - x).hypot(p[1] - y) > 300.0 {
                continue;
            }
            let expected = hides_point(&boxes, [x, y, z_m], p);
            let found = !sees(&viewshed, [column, row]);
            hidden += u32::from(expected);
            false_hidden += u32::from(found && !expected);
            false_seen += u32::from(expected && !found);
        }
    }
    // Rays miss corners that a line of sight only cuts, and far away a ray serves two cells side by
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
    let mut caster = RayCaster::new(grid, 300.0);
    caster.load(&oem);
    let viewshed = all_around(&mut caster, [50, 50], 52.0);
    // A roof half as high as the eye: its shadow ends at twice the distance.
    let hidden: Vec<i32> = (50..101).filter(|&c| !sees(&viewshed, [c, 50])).collect();
    assert_eq!(hidden, (69..91).collect::<Vec<_>>());
    let hidden: Vec<i32> = (0..50).filter(|&r| !sees(&viewshed, [50, r])).collect();
    assert_eq!(hidden, (0..31).collect::<Vec<_>>(), "as high as the eye");
    assert!((0..101).all(|r| (0..50).all(|c| c > 45 && r < 35 || sees(&viewshed, [c, r]))));
}

/// The same from outside the map, where rays enter the map on their way.
#[test]
fn eyes_may_be_outside_the_map() {
    let ground = Ground { size_m: [200.0; 2] };
    let grid = Grid::covering(&ground, 4.0);
    let mut oem = Oem::unexplored(grid);
    (20..30).for_each(|i| occupy(&mut oem, i, 10, 60.0));
    (20..30).for_each(|i| occupy(&mut oem, 10, i, 60.0));
    let mut caster = RayCaster::new(grid, 300.0);
    caster.load(&oem);
    for (eye, behind) in
        [([25, -20], [25, 12]), ([25, 60], [25, 8]), ([-20, 25], [12, 25]), ([60, 25], [8, 25])]
    {
        let viewshed = all_around(&mut caster, eye, 52.0);
        assert!(!sees(&viewshed, behind) && sees(&viewshed, [40, 40]), "{eye:?}");
    }
    all_around(&mut caster, [500, -500], 52.0);
    assert_eq!(inside(500, -1, 50, 76), 76..76);
}

/// Earlier queries have no effect.
#[test]
fn cells_take_one_ray_each() {
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    let mut caster = RayCaster::new(Grid::covering(&GROUND, 4.0), 300.0);
    caster.load(&random_oem(&mut rng, 45.0));
    let eye = [60, 50];
    let whole = all_around(&mut caster, eye, 52.0);
    let (mut known, mut hidden) = (caster.viewshed(eye, 52.0, 300.0), 0);
    for _ in 0..500 {
        let cell = [rng.random_range(0..125), rng.random_range(0..105)];
        let rays = caster.rays_of([[cell[0] - eye[0], cell[1] - eye[1]]].into_iter());
        caster.cast(&mut known, &rays);
        assert_eq!(sees(&known, cell), sees(&whole, cell), "{cell:?}");
        hidden += u32::from(!sees(&known, cell));
    }
    assert!((50..450).contains(&hidden), "{hidden}");
}
