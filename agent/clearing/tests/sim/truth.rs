//! The road area, and where evaders of unbounded speed may be.

use csat_clearing::bitmap::{Bitmap, Rect};

use super::town::Town;

pub const CELL_M: f64 = 0.5;
/// The side of an image, metres, and of its pixels.
pub const IMAGE_M: f64 = 2.0 * 70.0 * 0.839_099_631_177_280_1;
pub const PIXEL_M: f64 = IMAGE_M / 256.0;

/// Row 0 of the raster is the southern one.
pub struct Truth {
    half_m: f64,
    size: u16,
    pub road: Bitmap,
    /// R_S.
    pub reached: Bitmap,
    pub contaminated: Bitmap,
    /// All that was ever claimed to be cleared.
    pub claimed: Bitmap,
}

impl Truth {
    pub fn new(town: &Town) -> Self {
        let size = (2.0 * town.half_m / CELL_M).round() as u16;
        let mut road = Bitmap::new(size, size);
        let at = |index: u16| (f64::from(index) + 0.5) * CELL_M - town.half_m;
        for row in 0..size {
            for column in 0..size {
                if town.is_road([at(column), at(row)]) {
                    road.set(row, column);
                }
            }
        }
        let mut start = Bitmap::new(size, size);
        let row = ((town.start_m + town.half_m) / CELL_M) as u16;
        start.set(row, 0);
        let reached = Bitmap::flood(&start, &road);
        assert!(!reached.is_empty(), "no road at the start");
        let claimed = Bitmap::new(size, size);
        Self { half_m: town.half_m, size, contaminated: road.clone(), road, reached, claimed }
    }

    /// The cells that lie wholly between two coordinates, or that touch what is between them.
    fn cells(&self, from_m: f64, to_m: f64, is_whole: bool) -> Option<[u16; 2]> {
        let [from, to] = [from_m, to_m].map(|at| (at + self.half_m) / CELL_M);
        let [first, last] = if is_whole {
            [from.ceil(), to.floor() - 1.0]
        } else {
            [from.floor(), to.ceil() - 1.0]
        };
        let last = last.min(f64::from(self.size) - 1.0);
        let first = first.max(0.0);
        (first <= last).then_some([first as u16, last as u16])
    }

    /// Whether the cell at a point is road.
    pub fn is_road(&self, row: Option<u16>, column: Option<u16>) -> bool {
        row.zip(column).is_some_and(|(row, column)| self.road.get(row, column))
    }

    pub fn index(&self, at_m: f64) -> Option<u16> {
        let index = ((at_m + self.half_m) / CELL_M).floor();
        (index >= 0.0 && index < f64::from(self.size)).then_some(index as u16)
    }

    /// A step with these cleaners: what they see is free, all else that an evader can reach is not.
    pub fn contaminate(&mut self, places: &[[f64; 2]]) {
        let mut seen = Bitmap::new(self.size, self.size);
        for [x, y] in places {
            let half = IMAGE_M / 2.0;
            let rows = self.cells(y - half, y + half, true);
            let columns = self.cells(x - half, x + half, true);
            if let Some((rows, columns)) = rows.zip(columns) {
                seen.fill(&Rect { rows, columns });
            }
        }
        let hidden = self.road.clone().and_not(&seen);
        self.contaminated = Bitmap::flood(&self.contaminated, &hidden);
    }

    /// Notes what an agent at this place claims in its image: all cells that touch a pixel.
    pub fn claim(&mut self, [x, y]: [f64; 2], claims: &Bitmap) {
        let mut pixels = claims.pixels().peekable();
        while let Some([row, first]) = pixels.next() {
            let mut last = first;
            while pixels.next_if_eq(&[row, last + 1]).is_some() {
                last += 1;
            }
            let top = y + IMAGE_M / 2.0 - f64::from(row) * PIXEL_M;
            let left = x - IMAGE_M / 2.0;
            let columns = [f64::from(first), f64::from(last) + 1.0].map(|c| left + c * PIXEL_M);
            let rows = self.cells(top - PIXEL_M, top, false);
            if let Some((rows, columns)) = rows.zip(self.cells(columns[0], columns[1], false)) {
                self.claimed.fill(&Rect { rows, columns });
            }
        }
    }

    /// A place that was claimed to be cleared and is contaminated, metres.
    pub fn violation(&self) -> Option<[f64; 2]> {
        let wrong = self.contaminated.clone().and(&self.claimed);
        let [row, column] = wrong.first()?;
        Some([column, row].map(|index| (f64::from(index) + 0.5) * CELL_M - self.half_m))
    }

    pub fn is_cleared(&self) -> bool {
        !self.contaminated.meets(&self.reached)
    }

    pub fn cleared_share(&self) -> f64 {
        let left = self.contaminated.clone().and(&self.reached).count();
        1.0 - f64::from(left) / f64::from(self.reached.count())
    }
}
