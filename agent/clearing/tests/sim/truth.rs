//! The road area, and where evaders of unbounded speed may be.

use csat_clearing::bitmap::{Bitmap, Rect};

use super::town::Town;

pub const CELL_M: f64 = 0.5;
/// The side of an image, metres, and of its pixels.
pub const IMAGE_M: f64 = 2.0 * 70.0 * 0.839_099_631_177_280_1;
pub const PIXEL_M: f64 = IMAGE_M / 256.0;

/// By how much the place of an image on the lattice may be wrong, pixels, rounded up.
pub const SLACK_PX: u16 = 3;

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
    /// 𝒱, and what is near it: all that a cleaner may have taken for cleared.
    pub taken: Bitmap,
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
        let [claimed, taken] = [(); 2].map(|()| Bitmap::new(size, size));
        let contaminated = road.clone();
        Self { half_m: town.half_m, size, contaminated, road, reached, claimed, taken }
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
    pub fn claim(&mut self, place_m: [f64; 2], claims: &Bitmap) {
        for rect in self.touched(place_m, claims) {
            self.claimed.fill(&rect);
        }
    }

    /// Notes what an agent at this place takes for cleared by itself.
    pub fn take(&mut self, place_m: [f64; 2], mine: &Bitmap) {
        for rect in self.touched(place_m, &mine.dilated(SLACK_PX)) {
            self.taken.fill(&rect);
        }
    }

    /// The cells that touch pixels of the image of an agent at this place.
    fn touched(&self, [x, y]: [f64; 2], mask: &Bitmap) -> Vec<Rect> {
        let mut found = Vec::new();
        let mut pixels = mask.pixels().peekable();
        while let Some([row, first]) = pixels.next() {
            let mut last = first;
            while pixels.next_if_eq(&[row, last + 1]).is_some() {
                last += 1;
            }
            let top = y + IMAGE_M / 2.0 - f64::from(row) * PIXEL_M;
            let left = x - IMAGE_M / 2.0;
            let columns = [f64::from(first), f64::from(last) + 1.0].map(|c| left + c * PIXEL_M);
            let rows = self.cells(top - PIXEL_M, top, false);
            let columns = self.cells(columns[0], columns[1], false);
            found.extend(rows.zip(columns).map(|(rows, columns)| Rect { rows, columns }));
        }
        found
    }

    /// A pixel of the image of an agent at this place that shows road which nobody has taken for cleared, and which
    /// is not near to what the agent takes for unknown road.
    pub fn overlooked(&self, [x, y]: [f64; 2], unknown: &Bitmap, margin: u16) -> Option<[u16; 2]> {
        let allowed = unknown.dilated(SLACK_PX);
        let middle = |index: u16| (f64::from(index) + 0.5) * PIXEL_M - IMAGE_M / 2.0;
        let inside = margin..256 - margin;
        inside.clone().flat_map(|row| inside.clone().map(move |column| [row, column])).find(
            |[row, column]| {
                let cell = self.index(y - middle(*row)).zip(self.index(x + middle(*column)));
                let is_open =
                    |(row, column)| self.road.get(row, column) && !self.taken.get(row, column);
                cell.is_some_and(is_open) && !allowed.get(*row, *column)
            },
        )
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
