//! The contaminated part C of the road area: where somebody may be whom no image shows and no image has shown
//! since.
//!
//! Whoever hides on the roads may be of any speed. In each step the cells that lie wholly in an image leave C.
//! Then every connected part of the other cells of R (connected by sides or corners) that still holds a cell of C
//! becomes contaminated whole.
//!
//! # Why a step is cheap
//!
//! After a step, every connected part of R outside the images is contaminated whole or not at all. Images that
//! move on cover cells, which divides parts but joins none, and uncover cells, which are not in C. So a part can hold
//! both kinds only if an uncovered cell joins them, and it is enough to spread from the uncovered cells that
//! touch C. A step costs as much as there are cells between the old images and the new ones, and cells that become
//! contaminated.

use csat_proto::camera::{CameraModel, Pose};

use crate::bits::Bits;
use crate::road_area::{RoadArea, neighbours};
use rectangle::Rectangle;

mod rectangle;
#[cfg(test)]
mod tests;

/// The ground that an image shows: an axis-aligned square.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Square {
    /// Its middle, `world`, metres.
    pub middle: [f64; 2],
    /// Its side, metres.
    pub side_m: f64,
}

impl Square {
    /// What a camera that looks straight down from a level pose shows; its image is as high as it is wide.
    pub fn of_image(camera: &CameraModel, pose: &Pose) -> Self {
        let [x, y, height_m] = pose.p_world;
        let side_m = f64::from(camera.columns) * height_m / camera.focal_px();
        Self { middle: [x, y], side_m }
    }
}

/// What a step has contaminated.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Spread {
    /// The cells of the raster that were clean and are contaminated now, ascending.
    pub recontaminated: Vec<u32>,
}

/// C, and what images showed last.
#[derive(Debug, Clone)]
pub struct Contamination {
    roads: RoadArea,
    contaminated: Bits,
    /// The cells that lie wholly in an image, by image.
    covered: Vec<Rectangle>,
}

impl Contamination {
    /// Before the first step: all of R is contaminated.
    pub fn new(roads: &RoadArea) -> Self {
        let contaminated = roads.bits.clone();
        Self { roads: roads.clone(), contaminated, covered: Vec::new() }
    }

    /// A step, in which these are the images. Their number and order may differ from the last step's.
    pub fn step(&mut self, images: &[Square]) -> Spread {
        let covered: Vec<Rectangle> =
            images.iter().map(|image| Rectangle::within(image, &self.roads)).collect();
        let before = std::mem::replace(&mut self.covered, covered);
        for entered in self.covered.iter().flat_map(|image| image.without(&before)) {
            for row in entered.rows() {
                self.contaminated.set_span(row, entered.span(), false);
            }
        }
        let mut spread = Vec::new();
        let left: Vec<Rectangle> =
            before.iter().flat_map(|image| image.without(&self.covered)).collect();
        for left in left {
            for cell in left.cells() {
                if self.roads.bits.contains(cell[0], cell[1]) && self.touches_contamination(cell) {
                    self.spread_from(cell, &mut spread);
                }
            }
        }
        spread.sort_unstable();
        Spread { recontaminated: spread }
    }

    fn size(&self) -> [usize; 2] {
        [self.roads.columns(), self.roads.rows()]
    }

    fn touches_contamination(&self, cell: [usize; 2]) -> bool {
        neighbours(cell, self.size()).any(|[column, row]| self.contaminated.contains(column, row))
    }

    /// Contaminates a cell outside the images and all that is connected to it there.
    fn spread_from(&mut self, cell: [usize; 2], spread: &mut Vec<u32>) {
        let size = self.size();
        let mut found = vec![cell];
        while let Some(cell @ [column, row]) = found.pop() {
            if self.contaminated.insert(column, row) {
                spread.push(self.roads.number(column, row));
                found.extend(neighbours(cell, size).filter(|next| self.can_be_reached(*next)));
            }
        }
    }

    /// Whether a cell is a road outside the images and not contaminated yet.
    fn can_be_reached(&self, cell @ [column, row]: [usize; 2]) -> bool {
        self.roads.bits.contains(column, row)
            && !self.contaminated.contains(column, row)
            && !self.covered.iter().any(|image| image.contains(cell))
    }

    /// Whether a cell is in C.
    pub fn is_contaminated(&self, cell: u32) -> bool {
        let [column, row] = self.roads.place(cell);
        row < self.roads.rows() && self.contaminated.contains(column, row)
    }

    /// The cells of C, ascending.
    pub fn cells(&self) -> impl Iterator<Item = u32> + '_ {
        self.contaminated.cells().map(|[column, row]| self.roads.number(column, row))
    }

    /// The area of C, m².
    pub fn contaminated_m2(&self) -> f64 {
        self.contaminated_m2_in(&self.roads)
    }

    /// The area of C in a part of R, m².
    pub fn contaminated_m2_in(&self, part: &RoadArea) -> f64 {
        let cell_m = self.roads.cell_m();
        self.contaminated.count_common(&part.bits) as f64 * cell_m * cell_m
    }
}
