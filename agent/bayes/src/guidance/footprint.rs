//! What a camera detects on the ground about its aircraft, tabulated.

use csat_proto::camera::Pose;
use csat_proto::raster::Grid;

use super::navigation::Airframe;
use crate::likelihood::{Likelihood, Optics, Sensor};

/// Side of the entries, metres.
const STEP_M: f64 = 4.0;
/// From one tabulated bank to the next, radians.
const ROLL_STEP_RAD: f64 = 0.044;
/// Places where a target is detected less probably than this in a second are left out.
const LEAST: f32 = 0.005;

/// What one second of frames tells of a place.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Seen {
    /// The probability that none of the frames detects a target there.
    pub missed: f32,
    /// Expected information on a target there, Σ p(D, V) Hᵀ Σ_z⁻¹ H: along the heading, mixed, and to the left,
    /// 1/m².
    pub information: [f32; 3],
}

/// For each bank, what is seen about an aircraft in the second of flight that ends there.
#[derive(Debug, Clone)]
pub struct Footprints {
    /// From the steepest bank to the left on.
    tables: Vec<Table>,
}

/// Entries at places (u, v): ahead and to the left.
#[derive(Debug, Clone)]
struct Table {
    /// The first u and v, metres.
    first: [f64; 2],
    /// How many.
    size: [usize; 2],
    /// v runs fastest.
    entries: Vec<Seen>,
}

impl Footprints {
    /// The footprints of the camera of an aircraft.
    pub fn new(sensor: &Sensor, airframe: &Airframe, height_m: f64) -> Self {
        let most = (airframe.model.roll_max_deg.to_radians() / ROLL_STEP_RAD).ceil() as i32;
        let roll = |index: i32| f64::from(index) * ROLL_STEP_RAD;
        let table = |index: i32| Table::new(sensor, airframe, height_m, roll(index));
        Self { tables: (-most..=most).map(table).collect() }
    }

    fn table(&self, roll_rad: f64) -> &Table {
        let middle = (self.tables.len() / 2) as f64;
        let index = (roll_rad / ROLL_STEP_RAD + middle).round().max(0.0) as usize;
        &self.tables[index.min(self.tables.len() - 1)]
    }

    /// What is seen of a place, `world`, metres, from a pose.
    pub fn at(&self, pose: &Pose, [x, y]: [f64; 2]) -> Option<Seen> {
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let (dx, dy) = (x - pose.p_world[0], y - pose.p_world[1]);
        self.table(pose.roll_rad).at(dx * cos + dy * sin, dy * cos - dx * sin)
    }

    /// Calls `each` with the index of every cell that is seen from a pose and the probability that a target
    /// there is missed.
    #[inline]
    pub fn cells(&self, grid: &Grid, pose: &Pose, mut each: impl FnMut(usize, f32)) {
        let table = self.table(pose.roll_rad);
        let (sin, cos) = pose.yaw_rad.sin_cos();
        let [px, py, _] = pose.p_world;
        let [u0, v0] = table.first;
        let (u1, v1) = (u0 + table.size[0] as f64 * STEP_M, v0 + table.size[1] as f64 * STEP_M);
        // The box about the four corners of the table.
        let range = |of: [f64; 4]| {
            of.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)))
        };
        let corners = [(u0, v0), (u1, v0), (u1, v1), (u0, v1)];
        let (west, east) = range(corners.map(|(u, v)| px + u * cos - v * sin));
        let (south, north) = range(corners.map(|(u, v)| py + u * sin + v * cos));
        let columns = grid.columns_between(west, east);
        for row in grid.rows_between(south, north) {
            let [x, y] = grid.centre(columns.start, row);
            let (dx, dy) = (x - px, y - py);
            let (mut u, mut v) = (dx * cos + dy * sin, dy * cos - dx * sin);
            let base = row as usize * grid.columns as usize;
            for column in columns.clone() {
                if let Some(seen) = table.at(u, v)
                    && seen.missed < 1.0
                {
                    each(base + column as usize, seen.missed);
                }
                u += grid.cell_m * cos;
                v -= grid.cell_m * sin;
            }
        }
    }
}

impl Table {
    fn new(sensor: &Sensor, airframe: &Airframe, height_m: f64, roll_rad: f64) -> Self {
        let frames = airframe.per_second();
        let spacing = airframe.airspeed_m_s / f64::from(frames);
        let p_world = [0.0, 0.0, height_m];
        let pitch_rad = -airframe.model.pitch_trim_deg.to_radians() / roll_rad.cos();
        let pose = Pose { p_world, yaw_rad: 0.0, pitch_rad, roll_rad };
        // The region must not cut what is tabulated.
        let mut sensor = sensor.clone();
        sensor.ground.size_m = [1e5; 2];
        let frame = Frame {
            likelihood: Likelihood::of_frame(&sensor, &pose, None),
            optics: Optics::new(&sensor, &pose),
        };
        let Some(bounds) = frame.likelihood.bounds() else { return Self::nothing() };
        let back = f64::from(frames - 1) * spacing;
        let reach = 4.0 * height_m;
        let first = [bounds.min[0] - back, bounds.min[1]].map(|x| x.max(-reach));
        let last = bounds.max.map(|x| x.min(reach));
        let size =
            [0, 1].map(|axis| ((last[axis] - first[axis]) / STEP_M).ceil().max(1.0) as usize);
        let mut entries = Vec::with_capacity(size[0] * size[1]);
        for index in 0..size[0] * size[1] {
            let (i, j) = (index / size[1], index % size[1]);
            let [u, v] =
                [first[0] + (i as f64 + 0.5) * STEP_M, first[1] + (j as f64 + 0.5) * STEP_M];
            let mut seen = Seen { missed: 1.0, information: [0.0; 3] };
            for k in 0..frames {
                frame.add([u + f64::from(k) * spacing, v], &mut seen);
            }
            if 1.0 - seen.missed < LEAST {
                seen = Seen { missed: 1.0, information: [0.0; 3] };
            }
            entries.push(seen);
        }
        Self { first, size, entries }.trimmed()
    }

    fn nothing() -> Self {
        Self { first: [0.0; 2], size: [0; 2], entries: Vec::new() }
    }

    /// Without borders in which nothing is seen.
    fn trimmed(self) -> Self {
        let mut low = self.size;
        let mut high = [0; 2];
        for (index, seen) in self.entries.iter().enumerate() {
            if seen.missed < 1.0 {
                let at = [index / self.size[1], index % self.size[1]];
                low = [0, 1].map(|axis| low[axis].min(at[axis]));
                high = [0, 1].map(|axis| high[axis].max(at[axis] + 1));
            }
        }
        if low[0] >= high[0] {
            return Self::nothing();
        }
        let rows = (low[0]..high[0]).map(|i| &self.entries[i * self.size[1]..][low[1]..high[1]]);
        Self {
            first: [0, 1].map(|axis| self.first[axis] + low[axis] as f64 * STEP_M),
            size: [0, 1].map(|axis| high[axis] - low[axis]),
            entries: rows.flatten().copied().collect(),
        }
    }

    #[inline]
    fn at(&self, u: f64, v: f64) -> Option<Seen> {
        let (i, j) = ((u - self.first[0]) / STEP_M, (v - self.first[1]) / STEP_M);
        if i < 0.0 || j < 0.0 {
            return None;
        }
        let (i, j) = (i as usize, j as usize);
        (i < self.size[0] && j < self.size[1]).then(|| self.entries[i * self.size[1] + j])
    }
}

/// One frame at the origin.
struct Frame {
    likelihood: Likelihood,
    optics: Optics,
}

impl Frame {
    fn add(&self, x: [f64; 2], seen: &mut Seen) {
        let p = self.likelihood.p_detection(x);
        seen.missed *= (1.0 - p) as f32;
        let Some(information) = self.information(x) else { return };
        for (sum, each) in seen.information.iter_mut().zip(information) {
            *sum += (p * each) as f32;
        }
    }

    /// Hᵀ Σ_z⁻¹ H, H = ∂z/∂x by central differences, 1/m².
    fn information(&self, [x, y]: [f64; 2]) -> Option<[f64; 3]> {
        const H_M: f64 = 0.5;
        let [cc, cr, rr] = self.optics.see([x, y])?.covariance;
        let slope = |a: [f64; 2], b: [f64; 2]| {
            let (a, b) = (self.optics.see(a)?.mean, self.optics.see(b)?.mean);
            Some([(b[0] - a[0]) / (2.0 * H_M), (b[1] - a[1]) / (2.0 * H_M)])
        };
        let hx = slope([x - H_M, y], [x + H_M, y])?;
        let hy = slope([x, y - H_M], [x, y + H_M])?;
        let determinant = cc * rr - cr * cr;
        let product = |a: [f64; 2], b: [f64; 2]| {
            let mixed = cr * (a[0] * b[1] + a[1] * b[0]);
            (rr * a[0] * b[0] - mixed + cc * a[1] * b[1]) / determinant
        };
        (determinant > 0.0).then(|| [product(hx, hx), product(hx, hy), product(hy, hy)])
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::config;
    use super::*;
    use crate::config::Criterion;

    /// Against the likelihoods of four frames.
    #[test]
    fn the_table_says_what_the_frames_of_a_second_see() {
        let config = config(Criterion::Information);
        let (sensor, airframe) = (Sensor::new(&config), Airframe::new(&config));
        let footprints = Footprints::new(&sensor, &airframe, 90.0);
        let (yaw_rad, roll_rad) = (0.6f64, 0.3f64);
        let pitch_rad = -4.0f64.to_radians() / roll_rad.cos();
        let pose = |k: f64| Pose {
            p_world: [30.0 - 5.0 * k * yaw_rad.cos(), 10.0 - 5.0 * k * yaw_rad.sin(), 90.0],
            yaw_rad,
            pitch_rad,
            roll_rad,
        };
        let frames = [0.0, 1.0, 2.0, 3.0].map(|k| Likelihood::of_frame(&sensor, &pose(k), None));
        let (mut sum, mut expected_sum) = (0.0, 0.0);
        let grid = Grid { cell_m: 12.5, columns: 80, rows: 80 };
        footprints.cells(&grid, &pose(0.0), |cell, missed| {
            let x = grid.centre(cell as u32 % 80, cell as u32 / 80);
            let expected: f64 = frames.iter().map(|f| 1.0 - f.p_detection(x)).product();
            assert!((f64::from(missed) - expected).abs() < 0.25, "{x:?}: {missed} {expected}");
            assert_eq!(footprints.at(&pose(0.0), x).map(|seen| seen.missed), Some(missed));
            sum += 1.0 - f64::from(missed);
            expected_sum += 1.0 - expected;
        });
        assert!((sum / expected_sum - 1.0).abs() < 0.02 && sum > 30.0, "{sum} {expected_sum}");
    }
}
