//! Estimates with their standard errors, from batch means: batches much longer than the correlation are
//! nearly independent.

const BATCHES: usize = 200;

/// An estimate.
#[derive(Debug, Clone, Copy)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard error.
    pub error: f64,
}

impl Estimate {
    /// The difference from `truth`, in standard errors.
    pub fn sigmas(&self, truth: f64) -> f64 {
        // Differences by rounding alone do not count.
        let off = (self.value - truth).abs();
        if off < 1e-9 { 0.0 } else { off / self.error }
    }
}

/// The mean of a series.
pub fn mean(series: &[f64]) -> Estimate {
    let length = series.len() / BATCHES;
    let means: Vec<f64> = series
        .chunks_exact(length)
        .map(|batch| batch.iter().sum::<f64>() / length as f64)
        .collect();
    let n = means.len() as f64;
    let value = means.iter().sum::<f64>() / n;
    let variance = means.iter().map(|m| (m - value).powi(2)).sum::<f64>() / (n - 1.0);
    Estimate { value, error: (variance / n).sqrt() }
}

/// The autocovariance at `lag` of a series that should have the mean `mean_value` and at this lag the
/// autocovariance `theory`.
///
/// Where losses are so rare that no batch has a pair of them, all batches are equal. So the error is at
/// least that of independent products with the variance of the theory.
pub fn autocovariance(lost: &[bool], mean_value: f64, lag: usize, theory: f64) -> Estimate {
    let centred = |x: bool| f64::from(u8::from(x)) - mean_value;
    let products: Vec<f64> =
        lost.iter().zip(&lost[lag..]).map(|(&a, &b)| centred(a) * centred(b)).collect();
    let Estimate { value, error } = mean(&products);
    // (x - μ)² = (1 - 2μ) x + μ² for x in {0, 1}.
    let (m, both) = (mean_value, theory + mean_value * mean_value);
    let slope = 1.0 - 2.0 * m;
    let square = slope * slope * both + 2.0 * slope * m.powi(3) + m.powi(4);
    let least = ((square - theory * theory).max(0.0) / products.len() as f64).sqrt();
    Estimate { value, error: error.max(least) }
}

/// The mean number of losses in a row, which should be `theory`: losses per run, by the delta method
/// for ratios; the error is at least that of independent runs of geometric length.
pub fn run_length(lost: &[bool], theory: f64) -> Estimate {
    let length = lost.len() / BATCHES;
    let count = |batch: &[bool]| {
        let losses = batch[1..].iter().filter(|&&lost| lost).count() as f64;
        let runs = batch.windows(2).filter(|pair| !pair[0] && pair[1]).count() as f64;
        (losses, runs)
    };
    // Batches overlap by one message, so that no start of a run falls between two.
    let end = |batch: usize| ((batch + 1) * length + 1).min(lost.len());
    let batches: Vec<(f64, f64)> =
        (0..BATCHES).map(|batch| count(&lost[batch * length..end(batch)])).collect();
    let (losses, runs) = batches.iter().fold((0.0, 0.0), |(l, r), b| (l + b.0, r + b.1));
    let value = losses / runs;
    let n = BATCHES as f64;
    let variance = batches.iter().map(|b| (b.0 - value * b.1).powi(2)).sum::<f64>() / (n - 1.0);
    let least = (theory * (theory - 1.0) / runs).max(0.0).sqrt();
    Estimate { value, error: ((variance * n).sqrt() / runs).max(least) }
}

/// The Kolmogorov-Smirnov statistic √n sup|F_n - F| of samples against an exact distribution. With
/// `probability` 10⁻⁴ it exceeds [`KS_BOUND`].
pub fn kolmogorov_smirnov(samples: &mut [f64], cdf: impl Fn(f64) -> f64) -> f64 {
    samples.sort_by(f64::total_cmp);
    let n = samples.len() as f64;
    let above = |(i, &x): (usize, &f64)| {
        let f = cdf(x);
        (f - i as f64 / n).abs().max((f - (i + 1) as f64 / n).abs())
    };
    n.sqrt() * samples.iter().enumerate().map(above).fold(0.0, f64::max)
}

/// 2 exp(-2 x²) = 10⁻⁴.
pub const KS_BOUND: f64 = 2.2254;
