//! The start line S: the piece of the region's border across a road, from where the roads are cleared.

use crate::plane::{Point, between, distance_m, distance_to_segment_m};
use crate::road_area::RoadArea;

/// A piece of the border across a road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartLine {
    /// Its western or southern end, `world`, metres.
    pub a: [f64; 2],
    /// Its other end.
    pub b: [f64; 2],
}

/// Why there is no start line.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum StartLineError {
    /// No road is inside of the region.
    #[error(
        "map.start_line: got a map without roads, expected roads that cross the region's border"
    )]
    NoRoads,
    /// No road reaches the border.
    #[error(
        "map.start_line: got a map whose {area_m2:.0} m² of road are all inside of the region, expected \
         a road that crosses the region's border"
    )]
    NoCrossing {
        /// The area of the roads, m².
        area_m2: f64,
    },
    /// The point of the scenario is not on a road at the border.
    #[error(
        "map.start_line: got {got:?}, expected a point on a road at the region's border; the nearest one \
         is [{:.1}, {:.1}], {distance_m:.1} m away",
        nearest[0], nearest[1]
    )]
    OffRoad {
        /// The point of the scenario, `world`, metres.
        got: [f64; 2],
        /// The middle of the nearest start line, `world`, metres.
        nearest: [f64; 2],
        /// The distance of the point to that start line, metres.
        distance_m: f64,
    },
}

impl StartLine {
    /// The start line at a point, `world`, metres. Without one: of those to which most of the roads are connected, the
    /// nearest to the middle of the western border.
    ///
    /// # Errors
    /// When no road crosses the border, or the point is farther than a cell from those that do.
    pub fn choose(area: &RoadArea, at: Option<[f64; 2]>) -> Result<Self, StartLineError> {
        if area.is_empty() {
            return Err(StartLineError::NoRoads);
        }
        let point = at.unwrap_or([-area.ground().size_m[0] / 2.0, 0.0]);
        let distance_m = |line: &Self| distance_to_segment_m(point, line.a, line.b);
        let mut lines = Self::all(area);
        if at.is_none() {
            let connected = |line: &Self| area.component(line).bits.count();
            let sizes: Vec<usize> = lines.iter().map(connected).collect();
            let most = sizes.iter().copied().max();
            let mut sizes = sizes.into_iter();
            lines.retain(|_| sizes.next() == most);
        }
        let nearest = lines.into_iter().min_by(|p, q| distance_m(p).total_cmp(&distance_m(q)));
        let Some(nearest) = nearest else {
            return Err(StartLineError::NoCrossing { area_m2: area.area_m2() });
        };
        let distance_m = distance_m(&nearest);
        // A point that is not a number is at no distance.
        if at.is_some() && (distance_m > area.cell_m() || distance_m.is_nan()) {
            let nearest = nearest.middle();
            return Err(StartLineError::OffRoad { got: point, nearest, distance_m });
        }
        Ok(nearest)
    }

    /// All places where roads cross the border: side by side from west and south to north and east. A road over
    /// a corner of the region crosses two sides.
    pub fn all(area: &RoadArea) -> Vec<Self> {
        let size = [area.columns(), area.rows()];
        let mut lines = Vec::new();
        for across in [0, 1] {
            let half_m = area.ground().size_m[across] / 2.0;
            for (index, border_m) in [(0, -half_m), (size[across] - 1, half_m)] {
                let is_road = |i: usize| match across {
                    0 => area.bits.contains(index, i),
                    _ => area.bits.contains(i, index),
                };
                for run in runs(size[1 - across], is_road) {
                    lines.push(Self::on_side(area, across, border_m, run));
                }
            }
        }
        lines
    }

    /// The line along cells of a side: across axis 0 are the western and eastern border.
    fn on_side(area: &RoadArea, across: usize, border_m: f64, [first, end]: [usize; 2]) -> Self {
        let along = 1 - across;
        let half_m = area.ground().size_m[along] / 2.0;
        let at = |index: usize| {
            let mut p = [border_m; 2];
            p[along] = (index as f64 * area.cell_m() - half_m).min(half_m);
            p
        };
        Self { a: at(first), b: at(end) }
    }

    /// Its middle, `world`, metres.
    pub fn middle(&self) -> [f64; 2] {
        between(self.a, self.b, 0.5)
    }

    /// Its length, metres.
    pub fn length_m(&self) -> f64 {
        distance_m(self.a, self.b)
    }

    /// The cells, column and row, of an area that the line touches from inside the region.
    pub(crate) fn cells(&self, area: &RoadArea) -> Vec<[usize; 2]> {
        let count = (self.length_m() / area.cell_m()).round().max(1.0);
        let at = |index: f64| -> Point { between(self.a, self.b, (index + 0.5) / count) };
        let cells = (0..count as u32).filter_map(|index| area.cell_at(at(f64::from(index))));
        cells.filter(|cell| area.contains(*cell)).map(|cell| area.place(cell)).collect()
    }
}

/// The longest runs, first and end, of indices below `count` that are road.
fn runs(count: usize, is_road: impl Fn(usize) -> bool) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for index in (0..count).filter(|index| is_road(*index)) {
        match runs.last_mut() {
            Some([_, end]) if *end == index => *end += 1,
            _ => runs.push([index, index + 1]),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Map;
    use crate::road_area::CELL_M;
    use csat_proto::model::Ground;

    fn area(roads: &[[Point; 2]]) -> RoadArea {
        let roads = roads.iter().map(|road| road.to_vec()).collect();
        RoadArea::new(&Map { roads, ..Map::open(Ground { size_m: [60.0, 40.3] }) }, CELL_M)
    }

    #[test]
    fn the_default_is_the_road_nearest_to_the_middle_of_the_west() {
        let roads = area(&[
            [[-40.0, 12.0], [0.0, 12.0]],
            [[10.0, 0.0], [50.0, 0.0]],
            [[0.0, 0.0], [0.0, 30.0]],
        ]);
        let all = StartLine::all(&roads);
        assert_eq!(all.len(), 3);
        let west = StartLine::choose(&roads, None).unwrap();
        assert_eq!(west, all[0]);
        assert_eq!(west.a[0], -30.0);
        assert!(
            (west.length_m() - 6.0).abs() <= CELL_M && (west.middle()[1] - 12.0).abs() <= CELL_M
        );
        let cells = west.cells(&roads);
        assert!((11..=13).contains(&cells.len()) && cells.iter().all(|cell| cell[0] == 0));
    }

    #[test]
    fn by_default_a_stub_is_no_start() {
        let roads = area(&[[[-40.0, 0.0], [-25.0, 0.0]], [[-5.0, -15.0], [50.0, -15.0]]]);
        let east = StartLine::choose(&roads, None).unwrap();
        assert_eq!(east.a[0], 30.0, "most of the roads are connected to it");
        let stub = StartLine::choose(&roads, Some([-30.0, 0.0])).unwrap();
        assert_eq!(stub.a[0], -30.0);
    }

    #[test]
    fn a_point_on_a_road_at_the_border_chooses_it() {
        let roads = area(&[[[-40.0, 12.0], [40.0, 12.0]], [[0.0, -30.0], [0.0, 12.0]]]);
        for (at, side) in [([30.0, 12.0], [1, 0]), ([30.0, 15.2], [1, 0]), ([2.0, -20.15], [0, -1])]
        {
            let line = StartLine::choose(&roads, Some(at)).unwrap();
            let half = [30.0, 20.15];
            let axis = usize::from(side[0] == 0);
            assert_eq!(line.a[axis], half[axis] * f64::from(side[axis]), "{at:?}");
            assert_eq!(line.a[axis], line.b[axis]);
        }
    }

    #[test]
    fn every_error_says_what_was_expected() {
        let crossing = area(&[[[-40.0, 12.0], [0.0, 12.0]]]);
        for at in [[-30.0, 8.0], [0.0, 12.0], [f64::NAN, 0.0]] {
            let error = StartLine::choose(&crossing, Some(at)).unwrap_err();
            assert!(matches!(error, StartLineError::OffRoad { .. }), "{error}");
            let text = error.to_string();
            assert!(
                text.starts_with("map.start_line: got [") && text.contains("expected"),
                "{text}"
            );
        }
        let inside = area(&[[[-10.0, 0.0], [10.0, 0.0]]]);
        let error = StartLine::choose(&inside, None).unwrap_err();
        assert_eq!(error, StartLineError::NoCrossing { area_m2: inside.area_m2() });
        assert!(error.to_string().contains("m² of road are all inside"), "{error}");
        let error = StartLine::choose(&area(&[]), None).unwrap_err();
        assert_eq!(error, StartLineError::NoRoads);
        assert!(error.to_string().contains("got a map without roads"), "{error}");
        let outside = area(&[[[-100.0, 100.0], [100.0, 100.0]]]);
        assert_eq!(StartLine::choose(&outside, None), Err(StartLineError::NoRoads));
    }
}
