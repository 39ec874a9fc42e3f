use csat_proto::model::Ground;
use proptest::prelude::*;

use super::*;
use crate::map::Map;
use crate::road_area::CELL_M;

const GROUND: Ground = Ground { size_m: [40.0, 30.0] };

fn area(roads: Vec<Vec<[f64; 2]>>) -> RoadArea {
    let road_widths_m = vec![2.0; roads.len()];
    RoadArea::new(&Map { roads, road_widths_m, ..Map::open(GROUND) }, CELL_M)
}

/// The definition, cell by cell, with all components found anew.
struct Plain<'a> {
    roads: &'a RoadArea,
    contaminated: Vec<u32>,
}

impl Plain<'_> {
    fn step(&mut self, images: &[Square]) -> Vec<u32> {
        let roads = self.roads;
        let is_covered = |cell: u32| {
            let (middle, half_m) = (roads.middle(cell), roads.cell_m() / 2.0);
            images.iter().any(|image| {
                let free_m = image.side_m / 2.0 - half_m;
                (0..2).all(|axis| (middle[axis] - image.middle[axis]).abs() <= free_m)
            })
        };
        let before = self.contaminated.clone();
        self.contaminated.retain(|cell| !is_covered(*cell));
        let free: Vec<u32> = roads.cells().filter(|cell| !is_covered(*cell)).collect();
        let mut component: Vec<u32> = (0..free.len() as u32).collect();
        let index = |cell: u32| free.binary_search(&cell).ok();
        // The lowest index of a component spreads until nothing changes.
        let mut is_changed = true;
        while is_changed {
            is_changed = false;
            for (i, cell) in free.iter().enumerate() {
                let around = neighbours(roads.place(*cell), [roads.columns(), roads.rows()]);
                let around = around.filter_map(|[column, row]| index(roads.number(column, row)));
                for j in around {
                    let least = component[i].min(component[j]);
                    is_changed |= component[i] != least;
                    component[i] = least;
                }
            }
        }
        let bad: Vec<u32> = self
            .contaminated
            .iter()
            .filter_map(|cell| index(*cell))
            .map(|i| component[i])
            .collect();
        self.contaminated =
            (0..free.len()).filter(|i| bad.contains(&component[*i])).map(|i| free[i]).collect();
        self.contaminated.iter().filter(|cell| !before.contains(cell)).copied().collect()
    }
}

fn point() -> impl Strategy<Value = [f64; 2]> {
    [-22.0..22.0f64, -17.0..17.0f64]
}

/// An image over time: where it begins, its side, and its jumps; in some odd steps it is absent.
type Image = ([f64; 2], f64, Vec<(bool, [f64; 2])>);

const STEPS: usize = 12;

fn image() -> impl Strategy<Value = Image> {
    let jumps = prop::collection::vec((any::<bool>(), [-2.0..2.0f64, -2.0..2.0f64]), STEPS);
    (point(), 4.0..25.0f64, jumps)
}

/// Where an image is in a step.
fn square((middle, side_m, jumps): &Image, step: usize) -> Option<Square> {
    let (is_there, jump) = jumps[step];
    let middle = [middle[0] + 0.7 * step as f64 + jump[0], middle[1] + jump[1]];
    (is_there || step.is_multiple_of(2)).then_some(Square { middle, side_m: *side_m })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]
    #[test]
    fn it_agrees_with_the_definition(
        roads in prop::collection::vec(prop::collection::vec(point(), 2..4), 1..5),
        images in prop::collection::vec(image(), 1..5),
    ) {
        let roads = area(roads);
        let mut quick = Contamination::new(&roads);
        let mut plain = Plain { roads: &roads, contaminated: roads.cells().collect() };
        for step in 0..STEPS {
            let images: Vec<Square> = images.iter().filter_map(|i| square(i, step)).collect();
            let expected = plain.step(&images);
            prop_assert_eq!(quick.step(&images).recontaminated, expected);
            prop_assert_eq!(quick.cells().collect::<Vec<_>>(), plain.contaminated.clone());
        }
    }
}

/// An image that pushes the contamination along a street, and one that guards its end.
#[test]
fn a_street_is_cleared_by_going_along_it_and_lost_when_the_guard_leaves() {
    let roads = area(vec![vec![[-30.0, 0.0], [30.0, 0.0]]]);
    let mut c = Contamination::new(&roads);
    let start = c.contaminated_m2();
    assert_eq!((start, c.contaminated_m2_in(&roads)), (roads.area_m2(), 40.0 * 2.0));
    let at = |x: f64| Square { middle: [x, 0.0], side_m: 8.0 };
    for step in 0..=20 {
        let spread = c.step(&[at(-20.0 + 0.4 * f64::from(step))]);
        assert_eq!(spread, Spread::default(), "{step}");
    }
    // The image is from -16 to -8.
    let cell = |x: f64| roads.cell_at([x, 0.2]).unwrap();
    let is = |c: &Contamination, x: f64| c.is_contaminated(cell(x));
    assert_eq!((is(&c, -18.0), is(&c, -12.0), is(&c, -7.8)), (false, false, true));
    assert_eq!(c.contaminated_m2(), 28.0 * 2.0);
    // A second image takes over ahead, and the first one leaves.
    assert_eq!(c.step(&[at(-8.0), at(-12.0)]), Spread::default());
    assert_eq!(c.step(&[at(-8.0)]), Spread::default());
    assert!(!is(&c, -18.0));
    // It jumps ahead: what is behind it becomes contaminated.
    let spread = c.step(&[at(1.0)]);
    assert!(spread.recontaminated.contains(&cell(-18.0)));
    assert_eq!(c.contaminated_m2(), 32.0 * 2.0);
    assert_eq!(c.step(&[]).recontaminated.len(), 8 * 2 * 4);
    assert_eq!(c.contaminated_m2(), start);
}

#[test]
fn a_cell_that_is_only_partly_in_an_image_stays_contaminated() {
    let roads = area(vec![vec![[-30.0, 0.0], [30.0, 0.0]]]);
    let mut c = Contamination::new(&roads);
    c.step(&[Square { middle: [0.25, 0.0], side_m: 10.0 }]);
    assert_eq!(c.contaminated_m2(), (40.0 - 9.5) * 2.0);
}

#[test]
fn the_square_of_an_image() {
    let camera =
        CameraModel { columns: 256, rows: 256, aperture_deg: 80.0, ..CameraModel::default() };
    let image = Square::of_image(&camera, &Pose::level([3.0, 4.0, 70.0], 0.0));
    assert_eq!(image.middle, [3.0, 4.0]);
    assert!((image.side_m - 117.474).abs() < 1e-3, "{image:?}");
}
