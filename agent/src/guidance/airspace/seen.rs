//! The airspace before the camera that the Ground pixels of a frame prove to be free.
//!
//! Directions are binned by the tangent of their angle to the heading. A run of Ground pixels in a
//! row of the image shows every point of a segment of the ground: all airspace between the camera and
//! the segment is free.

use csat_proto::camera::CameraView;
use csat_proto::frame::{Frame, Label};
use csat_proto::model::FLIGHT_CLEARANCE_M;
use csat_proto::raster::{Grid, Raster};

/// Bins per unit of the tangent.
const BINS: f64 = 256.0;
/// Directions with a greater tangent are left out.
const MOST: f64 = 4.0;

/// Ground that is seen in all directions of a bin: start and end, metres ahead.
type GroundSpan = [f64; 2];

/// The farthest and the nearest seen ground by direction.
pub(super) struct SeenGround {
    /// The point below the camera, `world`, metres.
    nadir: [f64; 2],
    /// Cosine and sine of the heading.
    cos_sin: [f64; 2],
    /// Airspace at less than this share of the way to seen ground is not proven to be free down to
    /// the clearance below.
    least_share: f64,
    far: Vec<GroundSpan>,
    near: Vec<GroundSpan>,
}

impl SeenGround {
    /// The seen ground of `frame`.
    pub(super) fn through(view: &CameraView, frame: &Frame) -> Self {
        let [x, y, z] = frame.pose.p_world;
        let bins = (2.0 * MOST * BINS) as usize;
        let mut seen = Self {
            nadir: [x, y],
            cos_sin: [frame.pose.yaw_rad.cos(), frame.pose.yaw_rad.sin()],
            least_share: FLIGHT_CLEARANCE_M / z,
            far: vec![[0.0, f64::INFINITY]; bins],
            near: vec![[f64::INFINITY; 2]; bins],
        };
        let columns = usize::from(view.model().columns).max(1);
        for (row, labels) in frame.labels.chunks_exact(columns).enumerate() {
            let mut first = 0;
            for run in labels.chunk_by(|a, b| a == b) {
                let end = first + run.len();
                if run[0] == Label::Ground {
                    let at = |column: usize| view.ground_point(column as f64, row as f64 + 0.5);
                    if let (Some(a), Some(b)) = (at(first), at(end)) {
                        seen.add(seen.ahead(a), seen.ahead(b));
                    }
                }
                first = end;
            }
        }
        seen
    }

    /// A point of the ground, metres ahead and to the left.
    fn ahead(&self, p: [f64; 2]) -> [f64; 2] {
        let ([x, y], [cos, sin]) = ([p[0] - self.nadir[0], p[1] - self.nadir[1]], self.cos_sin);
        [x * cos + y * sin, y * cos - x * sin]
    }

    /// Adds a segment of the ground that is seen, from its right to its left end.
    fn add(&mut self, a: [f64; 2], b: [f64; 2]) {
        // Also false for NaN.
        let is_ahead = a[0] > 0.0 && b[0] > 0.0;
        if !is_ahead {
            return;
        }
        let (a, b) = if a[1] * b[0] <= b[1] * a[0] { (a, b) } else { (b, a) };
        let [from, to] = [a, b].map(|[x, y]| (y / x + MOST) * BINS);
        let bins =
            from.max(0.0).ceil() as usize..(to.max(0.0).floor() as usize).min(self.far.len());
        // The distance ahead at which a direction meets the segment.
        let d = [b[0] - a[0], b[1] - a[1]];
        let ahead = |bin: usize| {
            let tangent = bin as f64 / BINS - MOST;
            a[0] + d[0] * (tangent * a[0] - a[1]) / (d[1] - tangent * d[0])
        };
        for bin in bins {
            // Between two directions it is monotone in the tangent.
            let (p, q) = (ahead(bin), ahead(bin + 1));
            let span = [p.min(q), p.max(q)];
            if span[0] > self.far[bin][0] {
                self.far[bin] = span;
            }
            if span[1] < self.near[bin][1] {
                self.near[bin] = span;
            }
        }
    }

    /// Removes the cells that are entirely free from `unknown`.
    pub(super) fn clear_from(&self, unknown: &mut Raster) {
        let grid = *unknown.grid();
        let half_m = grid.cell_m * std::f64::consts::FRAC_1_SQRT_2;
        let (rows, columns) = self.cells(&grid);
        for row in rows {
            for column in columns.clone() {
                if unknown.get(column, row) && self.is_free(grid.centre(column, row), half_m) {
                    unknown.clear(column, row);
                }
            }
        }
    }

    /// The rows and columns around all seen ground.
    fn cells(&self, grid: &Grid) -> (std::ops::Range<u32>, std::ops::Range<u32>) {
        let (mut low, mut high) = (self.nadir, self.nadir);
        let seen = self.far.iter().enumerate().filter(|(_, [ahead, _])| *ahead > 0.0);
        for (bin, [ahead, _]) in seen {
            for bin in [bin, bin + 1] {
                let left = ahead * (bin as f64 / BINS - MOST);
                let [cos, sin] = self.cos_sin;
                let p = [ahead * cos - left * sin, ahead * sin + left * cos];
                for axis in 0..2 {
                    low[axis] = low[axis].min(self.nadir[axis] + p[axis]);
                    high[axis] = high[axis].max(self.nadir[axis] + p[axis]);
                }
            }
        }
        (grid.rows_between(low[1], high[1]), grid.columns_between(low[0], high[0]))
    }

    /// Whether all airspace within `half_m` of a point is free.
    fn is_free(&self, p: [f64; 2], half_m: f64) -> bool {
        let [x, y] = self.ahead(p);
        let [from, to] = [x - half_m, x + half_m];
        if from <= 0.0 {
            return false;
        }
        let right = (y - half_m) / if y < half_m { from } else { to };
        let left = (y + half_m) / if y > -half_m { from } else { to };
        let [first, last] = [right, left].map(|tangent| (tangent + MOST) * BINS);
        if first < 0.0 || last >= self.far.len() as f64 {
            return false;
        }
        let holds = |[near, far]: GroundSpan| to <= near && from >= self.least_share * far;
        (first as usize..=last as usize).all(|bin| holds(self.far[bin]) || holds(self.near[bin]))
    }
}
