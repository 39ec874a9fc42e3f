//! Means with their 95 % confidence.

/// Mean and spread of a few values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stats {
    /// How many values.
    pub n: usize,
    /// Their mean.
    pub mean: f64,
    /// Standard deviation of the sample (n - 1); `None` for a single value.
    pub sd: Option<f64>,
    /// Half the width of the 95 % confidence interval of the mean, by Student's t; `None` for a
    /// single value.
    pub half_width: Option<f64>,
    /// The least value.
    pub min: f64,
    /// The greatest value.
    pub max: f64,
}

/// The fewest values whose confidence interval is worth drawing: with two, Student's t is 12.7, and the
/// interval hides everything else.
pub const FEWEST_DRAWN: usize = 3;

impl Stats {
    /// Half the width of the interval, if it is worth drawing.
    pub fn drawn_half_width(&self) -> Option<f64> {
        self.half_width.filter(|_| self.n >= FEWEST_DRAWN)
    }
}

/// The statistics of values; `None` for none.
pub fn stats(values: &[f64]) -> Option<Stats> {
    let n = values.len();
    if n == 0 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n as f64;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let sd = (n > 1).then(|| (squares / (n - 1) as f64).sqrt());
    Some(Stats {
        n,
        mean,
        sd,
        half_width: sd.map(|sd| student_t(n - 1) * sd / (n as f64).sqrt()),
        min: values.iter().copied().fold(f64::INFINITY, f64::min),
        max: values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
    })
}

/// The 97.5 % quantile of Student's t with 1 to 20 degrees of freedom.
const SMALL: [f64; 20] = [
    12.706205, 4.302653, 3.182446, 2.776445, 2.570582, 2.446912, 2.364624, 2.306004, 2.262157,
    2.228139, 2.200985, 2.178813, 2.160369, 2.144787, 2.131450, 2.119905, 2.109816, 2.100922,
    2.093024, 2.085963,
];

/// The 97.5 % quantile of Student's t; from 21 degrees of freedom on by the expansion of Cornish and
/// Fisher (Abramowitz and Stegun 26.7.5), right to five digits.
pub fn student_t(freedom: usize) -> f64 {
    match freedom {
        0 => f64::INFINITY,
        1..=20 => SMALL[freedom - 1],
        _ => {
            let (z, v) = (1.959_963_984_540_054_f64, freedom as f64);
            let g1 = (z.powi(3) + z) / 4.0;
            let g2 = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
            let g3 = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
            z + g1 / v + g2 / v.powi(2) + g3 / v.powi(3)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (freedom, expected) in [
            (1, 12.7062),
            (4, 2.7764),
            (10, 2.2281),
            (20, 2.0860),
            (21, 2.0796),
            (30, 2.0423),
            (120, 1.9799),
        ] {
            assert!((student_t(freedom) - expected).abs() < 1e-4, "{freedom}");
        }
        let falls = (1..200).all(|v| student_t(v) > student_t(v + 1));
        assert!(falls && student_t(1_000_000) > 1.9599);
    }

    #[test]
    fn means_by_hand() {
        let s = stats(&[2.0, 4.0, 6.0]).unwrap();
        assert_eq!((s.n, s.mean, s.sd, s.min, s.max), (3, 4.0, Some(2.0), 2.0, 6.0));
        assert!((s.half_width.unwrap() - 4.302653 * 2.0 / 3f64.sqrt()).abs() < 1e-12);
        assert_eq!(s.drawn_half_width(), s.half_width);
        let two = stats(&[2.0, 4.0]).unwrap();
        assert!(two.half_width.is_some() && two.drawn_half_width().is_none());
        let one = stats(&[5.0]).unwrap();
        assert_eq!((one.sd, one.half_width), (None, None));
        assert_eq!(stats(&[]), None);
    }
}
