//! The statistics of the loss models, computed from their transition matrices alone.

use csat_netem::config::LossConfig;

/// A Markov chain whose states lose messages with given probabilities.
pub struct Hidden {
    rows: Vec<Vec<f64>>,
    loss: Vec<f64>,
    stationary: Vec<f64>,
}

impl Hidden {
    /// The chain of `loss` for messages of `fragments` fragments; `None` for a recording.
    pub fn new(loss: &LossConfig, fragments: i32) -> Option<Self> {
        let (rows, loss) = match *loss {
            LossConfig::Iid { p } => (vec![vec![1.0]], vec![p]),
            LossConfig::GilbertElliott { p, r, h, k } => {
                (vec![vec![1.0 - p, p], vec![r, 1.0 - r]], vec![1.0 - k, 1.0 - h])
            }
            LossConfig::Markov4 { p13, p31, p32, p23, p14 } => (
                vec![
                    vec![1.0 - p13 - p14, 0.0, p13, p14],
                    vec![0.0, 1.0 - p23, p23, 0.0],
                    vec![p31, p32, 1.0 - p31 - p32, 0.0],
                    vec![1.0, 0.0, 0.0, 0.0],
                ],
                vec![0.0, 0.0, 1.0, 1.0],
            ),
            LossConfig::Trace { .. } => return None,
        };
        let loss = loss.iter().map(|q: &f64| 1.0 - (1.0 - q).powi(fragments)).collect();
        let stationary = stationary(&rows);
        Some(Self { rows, loss, stationary })
    }

    /// μ.
    pub fn mean(&self) -> f64 {
        dot(&self.stationary, &self.loss)
    }

    /// Autocovariance of the losses at lags 0 to `lags`.
    pub fn autocovariance(&self, lags: usize) -> Vec<f64> {
        let mean = self.mean();
        let mut weights: Vec<f64> =
            self.stationary.iter().zip(&self.loss).map(|(p, q)| p * q).collect();
        let mut all = vec![mean * (1.0 - mean)];
        for _ in 0..lags {
            weights = times(&weights, &self.rows);
            all.push(dot(&weights, &self.loss) - mean * mean);
        }
        all
    }

    /// Mean number of losses in a row.
    pub fn run_length(&self) -> f64 {
        let mean = self.mean();
        let both = self.autocovariance(1)[1] + mean * mean;
        mean / (mean - both)
    }

    /// Variance of the share of n lost messages, for large n.
    pub fn variance_of_mean(&self, n: f64) -> f64 {
        let all = self.autocovariance(100_000);
        (all[0] + 2.0 * all[1..].iter().sum::<f64>()) / n
    }
}

/// The same for Gilbert-Elliott in the closed form of `links.md`.
pub fn variance_of_mean(p: f64, r: f64, h: f64, k: f64, n: f64) -> f64 {
    let mean = (r * (1.0 - k) + p * (1.0 - h)) / (p + r);
    let c = p * r * (k - h).powi(2) / (p + r).powi(2);
    let lambda = 1.0 - p - r;
    (mean * (1.0 - mean) + 2.0 * c * lambda / (1.0 - lambda)) / n
}

/// Power iteration on (I + P)/2, which has the same stationary distribution and no period.
fn stationary(rows: &[Vec<f64>]) -> Vec<f64> {
    let mut weights = vec![1.0 / rows.len() as f64; rows.len()];
    for _ in 0..200_000 {
        let next = times(&weights, rows);
        weights = weights.iter().zip(next).map(|(a, b)| 0.5 * (a + b)).collect();
    }
    weights
}

fn times(weights: &[f64], rows: &[Vec<f64>]) -> Vec<f64> {
    let column = |j: usize| weights.iter().zip(rows).map(|(w, row)| w * row[j]).sum();
    (0..weights.len()).map(column).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[test]
fn the_closed_forms_agree_with_the_matrices() {
    for [p, r, h, k] in [[0.05, 0.25, 0.1, 0.98], [0.5, 0.9, 0.0, 1.0], [0.001, 0.01, 0.3, 1.0]] {
        let chain = Hidden::new(&LossConfig::GilbertElliott { p, r, h, k }, 1).unwrap();
        let mean = (r * (1.0 - k) + p * (1.0 - h)) / (p + r);
        assert!((chain.mean() / mean - 1.0).abs() < 1e-9);
        let ratio = chain.variance_of_mean(1e6) / variance_of_mean(p, r, h, k, 1e6);
        assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
    }
    let [p13, p31, p32, p23, p14] = [0.05, 0.4, 0.2, 0.3, 0.01];
    let chain = Hidden::new(&LossConfig::Markov4 { p13, p31, p32, p23, p14 }, 1).unwrap();
    let a = p13 / p31;
    let mean = (a + p14) / (1.0 + p14 + a * (1.0 + p32 / p23));
    assert!((chain.mean() / mean - 1.0).abs() < 1e-9);
}
