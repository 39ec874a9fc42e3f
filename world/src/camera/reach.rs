//! d_max and the horizon.

use super::lens::Lens;

/// Whether a plane 1/z = g · (c, r, 1) is in front of the camera and within `d_max_m` at image
/// point (c, r).
fn within(lens: &Lens, [g0, g1, g2]: [f64; 3], d_max_m: f64, c: f64, r: f64) -> bool {
    let inv_z = g0 * c + g1 * r + g2;
    let limit = d_max_m * inv_z;
    inv_z > 0.0 && lens.ray_norm_squared(c, r) <= limit * limit
}

/// Whether a plane is within `d_max_m` on all of a pixel; the set of such rays is convex.
pub(super) fn pixel_within(
    lens: &Lens,
    plane: [f64; 3],
    d_max_m: f64,
    column: usize,
    row: usize,
) -> bool {
    (0..4).all(|corner| {
        let (c, r) = ((column + corner % 2) as f64, (row + corner / 2) as f64);
        within(lens, plane, d_max_m, c, r)
    })
}

/// The pixels of a row that see a plane within d_max everywhere, which form an interval; row after row.
#[derive(Debug, Clone)]
pub(super) struct RowReach {
    plane: [f64; 3],
    d_max_m: f64,
    columns: usize,
    /// First and last corner within d_max on the row's lower border; first > last when there is none.
    corners: [usize; 2],
}

impl RowReach {
    /// Starts at row 0.
    pub fn new(lens: &Lens, plane: [f64; 3], d_max_m: f64, columns: usize) -> Self {
        let mut reach = Self { plane, d_max_m, columns, corners: [1, 0] };
        reach.corners = reach.corners_of(lens, 0);
        reach
    }

    /// The columns of pixels of `row` that are within d_max. To be called for rows 0, 1, 2, ...
    pub fn next_row(&mut self, lens: &Lens, row: usize) -> std::ops::Range<usize> {
        let above = self.corners_of(lens, row + 1);
        let below = std::mem::replace(&mut self.corners, above);
        below[0].max(above[0])..below[1].min(above[1])
    }

    fn corners_of(&self, lens: &Lens, row: usize) -> [usize; 2] {
        let good =
            |column: &usize| within(lens, self.plane, self.d_max_m, *column as f64, row as f64);
        let first = (0..=self.columns).find(good);
        let last = (0..=self.columns).rev().find(good);
        first.zip(last).map_or([1, 0], |(first, last)| [first, last])
    }
}
