//! A likelihood at many points at once, in single precision, for particles and for the coarse raster of (8).
//!
//! Its loops have no branches, so compilers make them of vector instructions. They consist of +, −, ×, ÷ and √, which
//! are the same to the last bit on every machine. Ratios differ by less than 5·10⁻⁵ from those in double precision.
//!
//! Coordinates of the image are tangents here: (u, v) = (x, y) / z in `camera`, pixels over the focal length. With S the
//! sum of d dᵀ over the three translations and T that of a aᵀ over the axes a of the three rotations,
//!
//! Σ(u, v) = Jₛ S Jₛᵀ / z² + Jₜ T Jₜᵀ, Jₛ = (1, 0, −u; 0, 1, −v), Jₜ = (−uv, 1 + u², −v; −1 − v², uv, u).

use std::f32::consts::LOG2_E;

use nalgebra::{Matrix3, Vector3};
use pulp::{Arch, Simd, WithSimd};

use super::{DetectionTable, Kind, LEAST, Likelihood, MIN_DEPTH_M, Optics, Rect, TABLE};

/// How many points are weighed together.
pub const BLOCK: usize = 32;

/// No likelihood is more times its constant.
const MOST: f32 = 1e30;

/// A likelihood, ready to weigh points.
#[derive(Debug)]
pub struct Weigher {
    /// West, south, east and north of where it differs from a constant.
    bounds: [f32; 4],
    view: View,
    kind: Weighed,
}

#[derive(Debug)]
enum Weighed {
    /// Half the size of the image, least variance, what p(D, V | x) is multiplied by, and p(D | V, r).
    NoDetection { half: [f32; 2], least: f32, factor: f32, table: Box<Table> },
    /// The detection, and `gain` / 2π.
    Detection { z: [f32; 2], gain: f32 },
}

/// A camera.
#[derive(Debug)]
struct View {
    axes: [[f32; 3]; 3],
    /// S and T by rows, from the diagonal on.
    shifts: [f32; 6],
    turns: [f32; 6],
}

/// The image of a point.
#[derive(Debug, Clone, Copy)]
struct Seen {
    mean: [f32; 2],
    covariance: [f32; 3],
    inverse_depth: f32,
    /// Whether it is in front of the camera.
    is_ahead: bool,
}

/// [`DetectionTable`]: values, and differences from the next one.
#[derive(Debug)]
struct Table {
    first: f32,
    per_inverse_m: f32,
    values: [f32; TABLE],
    steps: [f32; TABLE],
}

impl Weigher {
    /// Weighs by p(z | x) over its constant; `None` if the likelihood is constant in the region.
    pub fn new(likelihood: &Likelihood) -> Option<Self> {
        let bounds = likelihood.bounds?;
        let Kind::Detection { z, gain } = likelihood.kind else {
            return Some(Self::unseen(likelihood, bounds, -1.0 / (1.0 - likelihood.p_false)));
        };
        let optics = &likelihood.optics;
        let focal_px = optics.focal_px;
        let kind = Weighed::Detection {
            z: [0, 1].map(|i| ((optics.size_px[i] / 2.0 - z[i]) / focal_px) as f32),
            gain: (gain / (std::f64::consts::TAU * focal_px * focal_px)).min(MOST.into()) as f32,
        };
        Some(Self::of(optics, bounds, kind))
    }

    /// Weighs by 1 − p(D, V | x), the probability that the frame does not detect a target at x, whatever it showed;
    /// `None` if it sees nothing of the region.
    pub fn of_survival(likelihood: &Likelihood) -> Option<Self> {
        Some(Self::unseen(likelihood, likelihood.footprint?, -1.0))
    }

    /// Weighs by 1 + `factor` p(D, V | x).
    fn unseen(likelihood: &Likelihood, bounds: Rect, factor: f64) -> Self {
        let optics = &likelihood.optics;
        let kind = Weighed::NoDetection {
            half: optics.size_px.map(|size| (size / 2.0 / optics.focal_px) as f32),
            least: (1e-3 / optics.focal_px).powi(2) as f32,
            factor: factor as f32,
            table: Box::new(Table::new(&likelihood.detected)),
        };
        Self::of(optics, bounds, kind)
    }

    fn of(optics: &Optics, Rect { min, max }: Rect, kind: Weighed) -> Self {
        let bounds = [min[0], min[1], max[0], max[1]].map(|x| x as f32);
        Self { bounds, view: View::new(optics), kind }
    }

    /// Multiplies the weights of points.
    pub fn weigh(&self, x: &[f32], y: &[f32], weights: &mut [f32]) {
        Arch::new().dispatch(Weighing { weigher: self, x, y, weights });
    }

    /// Multiplies the weights of at most [`BLOCK`] points.
    #[inline(always)]
    fn weigh_block(&self, x: &[f32], y: &[f32], weights: &mut [f32]) {
        let mut inside = 0;
        for (x, y) in x.iter().zip(y) {
            inside += u32::from(self.contains(*x, *y));
        }
        if inside == 0 {
            return;
        }
        let mut ratios = [1.0; BLOCK];
        let places = x.iter().zip(y).zip(&mut ratios);
        match &self.kind {
            Weighed::Detection { z, gain } => {
                for ((x, y), ratio) in places {
                    let seen = self.view.see(*x, *y);
                    let excess = seen.density(*z) * gain;
                    let counts = self.contains(*x, *y) & seen.is_ahead & (excess > 0.0);
                    let excess = if excess < MOST { excess } else { MOST };
                    *ratio = 1.0 + if counts { excess } else { 0.0 };
                }
            }
            Weighed::NoDetection { half, least, factor, table } => {
                for ((x, y), ratio) in places {
                    let seen = self.view.see(*x, *y);
                    let inside = seen.p_inside(*half, *least);
                    let counts = self.contains(*x, *y) & seen.is_ahead & (inside > 0.0);
                    let p = inside * table.at(seen.inverse_depth);
                    let sum = 1.0 + if counts { p } else { 0.0 } * factor;
                    *ratio = if sum > LEAST as f32 { sum } else { LEAST as f32 };
                }
            }
        }
        weights.iter_mut().zip(ratios).for_each(|(weight, ratio)| *weight *= ratio);
    }

    #[inline(always)]
    fn contains(&self, x: f32, y: f32) -> bool {
        let [west, south, east, north] = self.bounds;
        (x >= west) & (x <= east) & (y >= south) & (y <= north)
    }
}

/// A call of [`Weigher::weigh`], compiled for the vector instructions that every processor has and for those that some
/// have. The compiler never joins a product and a sum into one rounding, so all of them give the same bits.
struct Weighing<'a> {
    weigher: &'a Weigher,
    x: &'a [f32],
    y: &'a [f32],
    weights: &'a mut [f32],
}

impl WithSimd for Weighing<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let points = self.x.chunks(BLOCK).zip(self.y.chunks(BLOCK));
        for ((x, y), weights) in points.zip(self.weights.chunks_mut(BLOCK)) {
            self.weigher.weigh_block(x, y, weights);
        }
    }
}

impl View {
    fn new(optics: &Optics) -> Self {
        let gram = |vectors: &[Vector3<f64>; 3]| {
            let m: Matrix3<f64> = vectors.iter().map(|v| v * v.transpose()).sum();
            [m.m11, m.m12, m.m13, m.m22, m.m23, m.m33].map(|x| x as f32)
        };
        Self {
            axes: optics.axes.map(|v| [v.x as f32, v.y as f32, v.z as f32]),
            shifts: gram(&optics.shifts),
            turns: gram(&optics.turns),
        }
    }

    #[inline(always)]
    fn see(&self, x: f32, y: f32) -> Seen {
        let [origin, east, north] = &self.axes;
        let along = |i: usize| origin[i] + x * east[i] + y * north[i];
        let depth = along(2);
        let least = MIN_DEPTH_M as f32;
        let inverse_depth = 1.0 / if depth > least { depth } else { least };
        let (u, v) = (along(0) * inverse_depth, along(1) * inverse_depth);
        let [xx, xy, xz, yy, yz, zz] = self.shifts;
        let square = inverse_depth * inverse_depth;
        let (xu, yv) = (xz - u * zz, yz - v * zz);
        let shifted = [xx - u * (xz + xu), xy - v * xz - u * yv, yy - v * (yz + yv)];
        let turned = self.turned(u, v);
        let covariance = [0, 1, 2].map(|i| square * shifted[i] + turned[i]);
        Seen { mean: [u, v], covariance, inverse_depth, is_ahead: depth > least }
    }

    /// Jₜ T Jₜᵀ.
    #[inline(always)]
    fn turned(&self, u: f32, v: f32) -> [f32; 3] {
        let [xx, xy, xz, yy, yz, zz] = self.turns;
        let a = [-u * v, 1.0 + u * u, -v];
        let b = [-1.0 - v * v, u * v, u];
        let times = |[x, y, z]: [f32; 3]| {
            [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
        };
        let dot = |p: [f32; 3], q: [f32; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        let (of_a, of_b) = (times(a), times(b));
        [dot(a, of_a), dot(b, of_a), dot(b, of_b)]
    }
}

impl Seen {
    /// The density of a normal image point at z, times 2π.
    #[inline(always)]
    fn density(&self, z: [f32; 2]) -> f32 {
        let [cc, cr, rr] = self.covariance;
        let (c, r) = (z[0] - self.mean[0], z[1] - self.mean[1]);
        let inverse = 1.0 / (cc * rr - cr * cr);
        let distance_squared = (rr * c * c - 2.0 * cr * c * r + cc * r * r) * inverse;
        let exponent = -0.5 * LOG2_E * distance_squared;
        exp2(if exponent > -126.0 { exponent } else { -126.0 }) * inverse.sqrt()
    }

    /// The probability that the point is inside the image: of (Φ(a) − Φ(b)) (Φ(c) − Φ(d)) with one division.
    #[inline(always)]
    fn p_inside(&self, half: [f32; 2], least: f32) -> f32 {
        let [cc, _, rr] = self.covariance;
        let along = |mean: f32, variance: f32, half: f32| {
            let inverse = 1.0 / if variance > least { variance } else { least }.sqrt();
            let [far, near] = [mean + half, mean - half].map(|edge| odds_against(edge * inverse));
            (near - far, (1.0 + far) * (1.0 + near))
        };
        let columns = along(self.mean[0], cc, half[0]);
        let rows = along(self.mean[1], rr, half[1]);
        (columns.0 * rows.0) / (columns.1 * rows.1)
    }
}

impl Table {
    fn new(table: &DetectionTable) -> Self {
        let values = table.values.map(|value| value as f32);
        let steps = std::array::from_fn(|i| values[(i + 1).min(TABLE - 1)] - values[i]);
        let (first, per_inverse_m) = (table.first as f32, table.per_inverse_m as f32);
        Self { first, per_inverse_m, values, steps }
    }

    #[inline(always)]
    fn at(&self, inverse_depth: f32) -> f32 {
        let place = (inverse_depth - self.first) * self.per_inverse_m;
        let place = if place > 0.0 { place } else { 0.0 };
        let place = if place < (TABLE - 1) as f32 { place } else { (TABLE - 1) as f32 };
        let sum = place - 0.5 + ROUND;
        let at = sum.to_bits() as usize % TABLE;
        self.values[at] + (place - (sum - ROUND)) * self.steps[at]
    }
}

/// 1 / Φ(t) − 1 by the logistic curve of [`super::phi`]. Beyond 5.5 deviations nothing changes: a product of four would
/// leave the range of numbers, and Φ is 1 to single precision.
#[inline(always)]
fn odds_against(t: f32) -> f32 {
    let t = if t > -5.5 { t } else { -5.5 };
    let t = if t < 5.5 { t } else { 5.5 };
    exp2(t * (-1.5976 * LOG2_E - 0.070_566 * LOG2_E * (t * t)))
}

/// Added to a number below 2²² and taken away again, it leaves the nearest whole number, which is in the last bits of
/// the sum.
const ROUND: f32 = 12_582_912.0;

/// 2^x for |x| ≤ 126, relative error below 3·10⁻⁶: the polynomial of degree 4 whose greatest error is least.
#[inline(always)]
fn exp2(x: f32) -> f32 {
    let sum = x + ROUND;
    let r = x - (sum - ROUND);
    let series = 0.240_247_45 + r * (0.055_917_86 + r * 0.009_570_102);
    let series = 0.999_999_3 + r * (0.693_121_8 + r * series);
    series * f32::from_bits((sum.to_bits() << 23).wrapping_add(1.0f32.to_bits()))
}

#[cfg(test)]
#[path = "many_tests.rs"]
mod tests;
