//! The road area R: the ground that roads cover, as a raster.
//!
//! A cell belongs to R if its middle is within half the road's width of a centre line. The raster ends at the
//! border of the region, and so do the roads. Row 0 is the southernmost, column 0 the westernmost; cells are
//! numbered row by row. Two cells are connected if they share a side or a corner.

use csat_proto::model::Ground;

use crate::bits::{Bits, ones};
use crate::map::Map;
use crate::plane::{Bounds, Point, interval_near_segment};
use crate::start_line::StartLine;

/// The side of a cell, metres.
pub const CELL_M: f64 = 0.5;

/// A set of cells of the ground: R, or a part of it.
#[derive(Debug, Clone, PartialEq)]
pub struct RoadArea {
    ground: Ground,
    cell_m: f64,
    pub(crate) bits: Bits,
}

impl RoadArea {
    /// R of a map. The raster has the cells of side `cell_m` (above 0) whose middles are in the region.
    pub fn new(map: &Map, cell_m: f64) -> Self {
        let ground = map.ground;
        let [columns, rows] = ground.size_m.map(|size_m| (size_m / cell_m + 0.5).floor() as usize);
        let mut area = Self { ground, cell_m, bits: Bits::empty(columns, rows) };
        for (index, road) in map.roads.iter().enumerate() {
            for ends in road.windows(2) {
                area.pave([ends[0], ends[1]], map.road_width_m(index) / 2.0);
            }
        }
        area
    }

    /// Adds the cells within `radius_m` of a segment.
    fn pave(&mut self, [a, b]: [Point; 2], radius_m: f64) {
        let Some(bounds) = Bounds::around([a, b]).map(|bounds| bounds.grown(radius_m)) else {
            return;
        };
        let [columns, rows] = [self.columns(), self.rows()];
        let last = self.middle_of(columns.saturating_sub(1), 0)[0];
        let first = self.middle_of(0, 0)[0];
        let inside = |y: f64| bounds.min[1] <= y && y <= bounds.max[1];
        for row in self.rows_between(bounds.min[1], bounds.max[1], rows) {
            let y = self.middle_of(0, row)[1];
            // The middles of a row are points of a line, and those near a segment follow each other.
            let line = [[first - self.cell_m, y], [last + self.cell_m, y]];
            let near = interval_near_segment(line, [a, b], radius_m).filter(|_| inside(y));
            let Some([from, to]) = near else { continue };
            let cells = (columns + 1) as f64;
            let span = [(from * cells).ceil().max(1.0), (to * cells).floor().min(columns as f64)];
            let [from, to] = span.map(|index| index as usize);
            self.bits.set_span(row, [from - 1, to.max(from - 1)], true);
        }
    }

    /// The rows whose middles may be between two northings.
    fn rows_between(&self, south: f64, north: f64, rows: usize) -> std::ops::Range<usize> {
        let row = |y: f64| ((y + self.ground.size_m[1] / 2.0) / self.cell_m).floor();
        row(south).max(0.0) as usize..((row(north) + 1.0).max(0.0) as usize).min(rows)
    }

    /// The side of a cell, metres.
    pub fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// The region of interest.
    pub fn ground(&self) -> Ground {
        self.ground
    }

    /// Number of columns of the raster.
    pub fn columns(&self) -> usize {
        self.bits.columns()
    }

    /// Number of rows of the raster.
    pub fn rows(&self) -> usize {
        self.bits.rows()
    }

    /// Whether no cell belongs to it.
    pub fn is_empty(&self) -> bool {
        self.bits.count() == 0
    }

    /// Its area, m².
    pub fn area_m2(&self) -> f64 {
        self.bits.count() as f64 * self.cell_m * self.cell_m
    }

    /// The area that it has in common with another set of the same raster, m².
    pub fn common_m2(&self, other: &Self) -> f64 {
        self.bits.count_common(&other.bits) as f64 * self.cell_m * self.cell_m
    }

    /// Whether a cell belongs to it; no cell beyond the raster does.
    pub fn contains(&self, cell: u32) -> bool {
        let [column, row] = self.place(cell);
        row < self.rows() && self.bits.contains(column, row)
    }

    /// Whether a point, `world`, metres, is in a cell that belongs to it.
    pub fn is_road(&self, point: [f64; 2]) -> bool {
        self.cell_at(point).is_some_and(|cell| self.contains(cell))
    }

    /// The cells that belong to it, ascending.
    pub fn cells(&self) -> impl Iterator<Item = u32> + '_ {
        self.bits.cells().map(|[column, row]| self.number(column, row))
    }

    /// The cell at a point, `world`, metres; `None` outside the region. Where the sides of the region are no
    /// multiples of the cell, points within half a cell of its northern and eastern border are in the last one.
    pub fn cell_at(&self, point: [f64; 2]) -> Option<u32> {
        let column = self.index_at(0, point[0])?;
        Some(self.number(column, self.index_at(1, point[1])?))
    }

    /// The column (axis 0) or row (axis 1) at a coordinate; `None` outside the region.
    pub(crate) fn index_at(&self, axis: usize, x: f64) -> Option<usize> {
        let size_m = self.ground.size_m[axis];
        let along_m = x + size_m / 2.0;
        let last = [self.columns(), self.rows()][axis].checked_sub(1)?;
        let is_inside = (0.0..=size_m).contains(&along_m);
        is_inside.then(|| ((along_m / self.cell_m) as usize).min(last))
    }

    /// The middle of a cell, `world`, metres.
    pub fn middle(&self, cell: u32) -> [f64; 2] {
        let [column, row] = self.place(cell);
        self.middle_of(column, row)
    }

    fn middle_of(&self, column: usize, row: usize) -> Point {
        let [east_m, north_m] = self.ground.size_m;
        let along_m = |index: usize| (index as f64 + 0.5) * self.cell_m;
        [along_m(column) - east_m / 2.0, along_m(row) - north_m / 2.0]
    }

    /// The number of a cell.
    pub(crate) fn number(&self, column: usize, row: usize) -> u32 {
        (row * self.columns() + column) as u32
    }

    /// Column and row of a cell.
    pub(crate) fn place(&self, cell: u32) -> [usize; 2] {
        let columns = self.columns().max(1);
        [cell as usize % columns, cell as usize / columns]
    }

    /// Makes a cell road, or no road.
    pub fn set(&mut self, cell: u32, is_road: bool) {
        let [column, row] = self.place(cell);
        self.bits.set_span(row, [column, column + 1], is_road);
    }

    /// The cells of road in a rectangle and those on its edge, by number; its south-west and north-east corners are
    /// in metres of `world`.
    pub fn cells_in(&self, corners: [[f64; 2]; 2]) -> impl Iterator<Item = u32> + '_ {
        let index = |axis: usize, x: f64| {
            ((x + self.ground.size_m[axis] / 2.0) / self.cell_m).floor().max(0.0) as usize
        };
        let [columns, rows] = [(0, self.columns()), (1, self.rows())].map(|(axis, count)| {
            let [from, to] = corners.map(|corner| index(axis, corner[axis]));
            from.min(count)..(to + 1).min(count)
        });
        rows.flat_map(move |row| {
            let words = columns.start / 64..columns.end.div_ceil(64).max(columns.start / 64);
            let found = words.flat_map(move |index| {
                ones(self.bits.row(row)[index]).map(move |bit| 64 * index + bit)
            });
            let columns = columns.clone();
            let found = found.filter(move |column| columns.contains(column));
            found.map(move |column| self.number(column, row))
        })
    }

    /// The cells connected to a start line: R_S.
    pub fn component(&self, start: &StartLine) -> Self {
        let size = [self.columns(), self.rows()];
        let mut bits = Bits::empty(size[0], size[1]);
        let mut found: Vec<[usize; 2]> = start.cells(self);
        found.retain(|&[column, row]| bits.insert(column, row));
        while let Some(cell) = found.pop() {
            for [column, row] in neighbours(cell, size) {
                if self.bits.contains(column, row) && bits.insert(column, row) {
                    found.push([column, row]);
                }
            }
        }
        Self { ground: self.ground, cell_m: self.cell_m, bits }
    }
}

/// The cells, column and row, that share a side or a corner with a cell of a raster of that size.
pub(crate) fn neighbours(
    [column, row]: [usize; 2],
    [columns, rows]: [usize; 2],
) -> impl Iterator<Item = [usize; 2]> {
    let around = |index: usize, count: usize| index.saturating_sub(1)..(index + 2).min(count);
    let all = around(row, rows).flat_map(move |r| around(column, columns).map(move |c| [c, r]));
    all.filter(move |cell| *cell != [column, row])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::distance_to_segment_m;
    use proptest::prelude::*;

    const GROUND: Ground = Ground { size_m: [60.0, 40.3] };

    fn map(roads: Vec<Vec<Point>>, road_widths_m: Vec<f64>) -> Map {
        Map { roads, road_widths_m, ..Map::open(GROUND) }
    }

    fn point() -> impl Strategy<Value = Point> {
        [-45.0..45.0f64, -35.0..35.0f64]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn a_cell_is_road_if_its_middle_is_near_enough_to_a_centre_line(
            roads in prop::collection::vec(prop::collection::vec(point(), 2..5), 0..4),
            widths in prop::collection::vec(0.3..9.0f64, 0..4),
        ) {
            let map = map(roads, widths);
            let area = RoadArea::new(&map, CELL_M);
            let mut count = 0;
            for cell in 0..(area.columns() * area.rows()) as u32 {
                let middle = area.middle(cell);
                prop_assert_eq!(area.cell_at(middle), Some(cell));
                let excess = |(index, road): (usize, &Vec<Point>)| {
                    let radius = map.road_width_m(index) / 2.0;
                    let distances = road.windows(2);
                    distances.map(|w| distance_to_segment_m(middle, w[0], w[1]) - radius).reduce(f64::min)
                };
                let excess = map.roads.iter().enumerate().filter_map(excess);
                let excess = excess.fold(f64::INFINITY, f64::min);
                // On the border either answer is right.
                prop_assert!(excess.abs() < 1e-9 || area.contains(cell) == (excess < 0.0));
                count += usize::from(area.contains(cell));
            }
            prop_assert_eq!(area.cells().count(), count);
            prop_assert_eq!(area.area_m2(), count as f64 * 0.25);
        }
    }

    #[test]
    fn the_raster_covers_the_region_and_ends_with_it() {
        let area = RoadArea::new(&map(vec![vec![[-99.0, 0.1], [99.0, 0.1]]], vec![4.0]), CELL_M);
        assert_eq!((area.columns(), area.rows()), (120, 81));
        assert_eq!((area.area_m2(), area.is_empty()), (60.0 * 4.0, false));
        assert!(area.is_road([-30.0, 0.0]) && area.is_road([30.0, 0.0]));
        assert!(!area.is_road([-30.01, 0.0]) && !area.is_road([0.0, 3.0]));
        assert_eq!(area.cell_at([30.0, 20.15]), Some(120 * 81 - 1));
        assert_eq!(area.cell_at([0.0, f64::NAN]), None);
        assert!(!area.contains(u32::MAX));
    }

    #[test]
    fn cells_are_found_by_place_and_can_be_taken_out() {
        let mut area =
            RoadArea::new(&map(vec![vec![[-99.0, 0.1], [99.0, 0.1]]], vec![4.0]), CELL_M);
        let corners = [[-10.0, -30.0], [25.0, 1.1]];
        let is_in = |area: &RoadArea, cell: &u32| {
            let [x, y] = area.middle(*cell);
            (-10.0..=25.5).contains(&x) && y < 1.6
        };
        let all: Vec<u32> = area.cells().filter(|cell| is_in(&area, cell)).collect();
        assert_eq!(area.cells_in(corners).collect::<Vec<_>>(), all);
        assert!(area.cells_in([[90.0, 90.0], [99.0, 99.0]]).next().is_none());
        area.set(all[3], false);
        assert!(!area.contains(all[3]) && area.cells_in(corners).count() == all.len() - 1);
        area.set(all[3], true);
        assert_eq!(area.cells_in(corners).collect::<Vec<_>>(), all);
    }

    #[test]
    fn a_component_holds_what_is_connected_by_sides_or_corners() {
        // A slanted road as narrow as a cell touches itself at corners only.
        let roads = vec![vec![[-40.0, -35.0], [40.0, 45.0]], vec![[-30.0, 15.0], [-10.0, 15.0]]];
        let area = RoadArea::new(&map(roads, vec![0.6, 4.0]), CELL_M);
        let start = StartLine::choose(&area, Some([-30.0, 15.0])).unwrap();
        let apart = area.component(&start);
        assert!(apart.is_road([-10.0, 15.0]) && !apart.is_road([0.0, 5.0]));
        let other = area.component(&StartLine::choose(&area, Some([-25.0, -20.0])).unwrap());
        assert!(other.is_road([14.7, 19.7]), "from border to border");
        assert_eq!(other.common_m2(&apart), 0.0);
        assert_eq!(other.area_m2() + apart.area_m2(), area.area_m2());
        assert_eq!(area.common_m2(&apart), apart.area_m2());
    }
}
