//! Intervals of numbers whose arithmetic rounds outward: what is proved with them is true.
//!
//! Of the libraries, `inari` compiles only for processors newer than the default target, and `parry`'s product is too
//! narrow where both factors straddle 0. Five operations are enough here.

use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// The sine and the cosine of the standard library err by less than this.
const TRIGONOMETRY: f64 = 1e-15;

/// All numbers from the first to the second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// The least.
    pub low: f64,
    /// The greatest.
    pub high: f64,
}

impl Interval {
    /// All numbers between two.
    pub const fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    /// One number.
    pub const fn point(x: f64) -> Self {
        Self::new(x, x)
    }

    /// The number in the middle, or near it.
    pub fn middle(self) -> f64 {
        0.5 * (self.low + self.high)
    }

    /// How long it is, or nearly so.
    pub fn width(self) -> f64 {
        self.high - self.low
    }

    /// Whether all of it is in `other`.
    pub fn is_in(self, other: Self) -> bool {
        other.low <= self.low && self.high <= other.high
    }

    /// Whether nothing of it is in `other`.
    pub fn misses(self, other: Self) -> bool {
        self.high < other.low || other.high < self.low
    }

    /// The absolute values.
    pub fn abs(self) -> Self {
        let [a, b] = [self.low.abs(), self.high.abs()];
        let least = if self.low <= 0.0 && self.high >= 0.0 { 0.0 } else { a.min(b) };
        Self::new(least, a.max(b))
    }

    /// The greater of each number and 0.
    pub fn or_zero(self) -> Self {
        Self::new(self.low.max(0.0), self.high.max(0.0))
    }

    /// The lengths of vectors with these components.
    pub fn length(x: Self, y: Self) -> Self {
        let (x, y) = (x.abs(), y.abs());
        let Self { low, high } = x * x + y * y;
        Self::outward(low.max(0.0).sqrt(), high.sqrt()).or_zero()
    }

    /// The sines and the cosines.
    pub fn sin_cos(self) -> [Self; 2] {
        // The extremes are at first_peak + k π: 1 for even k, -1 for odd.
        let range = |f: fn(f64) -> f64, first_peak: f64| {
            let (a, b) = (f(self.low), f(self.high));
            let (mut low, mut high) = (a.min(b), a.max(b));
            let first = ((self.low - first_peak) / PI - TRIGONOMETRY).ceil() as i64;
            let last = ((self.high - first_peak) / PI + TRIGONOMETRY).floor() as i64;
            for k in first..=last.min(first + 1) {
                if k.rem_euclid(2) == 0 { high = 1.0 } else { low = -1.0 }
            }
            Self::new(low - TRIGONOMETRY, high + TRIGONOMETRY)
        };
        [range(f64::sin, FRAC_PI_2), range(f64::cos, 0.0)]
    }

    fn outward(low: f64, high: f64) -> Self {
        Self::new(low.next_down(), high.next_up())
    }

    fn around(values: [f64; 4]) -> Self {
        let low = values.into_iter().fold(f64::INFINITY, f64::min);
        Self::outward(low, values.into_iter().fold(f64::NEG_INFINITY, f64::max))
    }
}

impl Add for Interval {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::outward(self.low + other.low, self.high + other.high)
    }
}

impl Sub for Interval {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::outward(self.low - other.high, self.high - other.low)
    }
}

impl Neg for Interval {
    type Output = Self;

    fn neg(self) -> Self {
        Self::new(-self.high, -self.low)
    }
}

impl Mul for Interval {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let Self { low, high } = self;
        Self::around([low * other.low, low * other.high, high * other.low, high * other.high])
    }
}

/// By an interval of numbers above 0.
impl Div for Interval {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let Self { low, high } = self;
        Self::around([low / other.low, low / other.high, high / other.low, high / other.high])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each operation, at many numbers of many intervals.
    #[test]
    fn results_are_in_the_intervals_of_results() {
        let number = |i: Interval, k: i32| {
            (i.low + (i.high - i.low) * f64::from(k) / 8.0).clamp(i.low, i.high)
        };
        let numbers = |i: Interval| (0..=8).map(move |k| number(i, k));
        let ends = [-3.5, -1.0, -0.1, 0.0, 0.3, 2.0, 7.0];
        let all = ends.iter().flat_map(|&a| {
            ends.iter().filter(move |b| **b >= a).map(move |&b| Interval::new(a, b))
        });
        let all: Vec<Interval> = all.collect();
        let holds = |i: Interval, x: f64| assert!(i.low <= x && x <= i.high, "{x} in {i:?}");
        for &a in &all {
            let [sin, cos] = a.sin_cos();
            for x in numbers(a) {
                holds(a.abs(), x.abs());
                holds(a.or_zero(), x.max(0.0));
                holds(sin, x.sin());
                holds(cos, x.cos());
            }
            for &b in &all {
                for (x, y) in numbers(a).flat_map(|x| numbers(b).map(move |y| (x, y))) {
                    holds(a + b, x + y);
                    holds(a - b, x - y);
                    holds(a * b, x * y);
                    holds(Interval::length(a, b), x.hypot(y));
                    if b.low > 0.0 {
                        holds(a / b, x / y);
                    }
                }
            }
        }
        assert_eq!(Interval::new(0.0, 7.0).sin_cos()[0].high, 1.0 + TRIGONOMETRY);
        assert!(
            Interval::new(1.0, 2.0).is_in(Interval::new(1.0, 3.0))
                && !Interval::new(0.9, 2.0).is_in(Interval::new(1.0, 3.0))
        );
        assert!(
            Interval::new(1.0, 2.0).misses(Interval::new(2.1, 3.0))
                && !Interval::new(1.0, 2.0).misses(Interval::new(2.0, 3.0))
        );
    }
}
