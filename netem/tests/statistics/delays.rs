//! Distributions and correlations of every delay model.

use csat_netem::config::{ChannelConfig, DelayConfig};
use statrs::distribution::{ContinuousCDF, Normal};

use crate::estimate::{KS_BOUND, kolmogorov_smirnov};
use crate::{links, sent};

const N: u64 = 1_000_000;

fn standard() -> Normal {
    Normal::new(0.0, 1.0).unwrap()
}

/// The exact distribution, implemented independently from its definition.
fn cdf(delay: &DelayConfig, x: f64) -> f64 {
    let f = match delay {
        DelayConfig::Constant { mean_s } => f64::from(u8::from(x >= *mean_s)),
        DelayConfig::Uniform { mean_s, spread_s, .. } => (x - mean_s + spread_s) / (2.0 * spread_s),
        DelayConfig::Normal { mean_s, sd_s, .. } => {
            let normal = Normal::new(*mean_s, *sd_s).unwrap();
            (normal.cdf(x) - normal.cdf(0.0)) / (1.0 - normal.cdf(0.0))
        }
        DelayConfig::Pareto { mean_s, shape, .. } => {
            1.0 - (mean_s * (shape - 1.0) / shape / x).powf(*shape)
        }
        DelayConfig::Table { quantiles_s, .. } => {
            let n = quantiles_s.len() - 1;
            let i = quantiles_s.partition_point(|q| *q <= x).clamp(1, n);
            let part = (x - quantiles_s[i - 1]) / (quantiles_s[i] - quantiles_s[i - 1]);
            ((i - 1) as f64 + part) / n as f64
        }
    };
    f.clamp(0.0, 1.0)
}

fn correlation_of(delay: &DelayConfig) -> f64 {
    match *delay {
        DelayConfig::Constant { .. } => 0.0,
        DelayConfig::Uniform { correlation, .. }
        | DelayConfig::Normal { correlation, .. }
        | DelayConfig::Pareto { correlation, .. }
        | DelayConfig::Table { correlation, .. } => correlation,
    }
}

/// Delays of the first messages of a link, and of their copies.
fn delays(delay: &DelayConfig, seed: u64) -> [Vec<f64>; 2] {
    let radio = ChannelConfig { delay: delay.clone(), duplication: 1.0, ..Default::default() };
    let mut links = links(radio, seed);
    let mut all = [Vec::new(), Vec::new()];
    for message in (0..N).map(sent) {
        for (copy, delays) in links.fate(&message).copies().zip(&mut all) {
            delays.push(copy.unwrap().at.seconds_since(message.time));
        }
    }
    all
}

/// Σ a b / n.
fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / a.len().min(b.len()) as f64
}

/// The innovation of each score but the first: z_n - ρ z_{n-1}, of variance 1 - ρ².
fn innovations(scores: &[f64], before: &[f64], rho: f64) -> Vec<f64> {
    scores[1..].iter().zip(before).map(|(z, before)| z - rho * before).collect()
}

fn check(delay: &DelayConfig, seed: u64) {
    let rho = correlation_of(delay);
    let both = delays(delay, seed);
    // Far enough apart to be independent.
    let apart = if rho == 0.0 { 1 } else { (1e-3f64.ln() / rho.ln()).ceil() as usize };
    let ks = both.clone().map(|delays| {
        let mut samples: Vec<f64> = delays.into_iter().step_by(apart).collect();
        kolmogorov_smirnov(&mut samples, |x| cdf(delay, x))
    });
    let normal = standard();
    let score = |x: &f64| normal.inverse_cdf(cdf(delay, *x).clamp(1e-12, 1.0 - 1e-12));
    let [scores, copies] = both.each_ref().map(|d| d.iter().map(score).collect::<Vec<f64>>());
    // The lag-1 correlation by regression on the score before, whose error is √((1 - ρ²)/n).
    let (n, news) = (N as f64, (1.0 - rho * rho).sqrt());
    let lag_1 = product(&scores[1..], &scores) / product(&scores, &scores);
    let lag_2 = product(&scores[2..], &scores) / product(&scores, &scores);
    // Bartlett's formula for an AR(1) series.
    let error_2 = ((1.0 + rho * rho).powi(2) - 4.0 * rho.powi(4)).sqrt() / n.sqrt();
    // A copy has the same predecessor as its message and is otherwise independent of it.
    let fresh = innovations(&scores, &scores, rho);
    let fresh_copies = innovations(&copies, &scores, rho);
    let copy = product(&fresh, &fresh_copies);
    let past = product(&copies[1..], &scores) / product(&scores, &scores);
    let sigmas = [
        (lag_1 - rho).abs() * n.sqrt() / news,
        (lag_2 - rho * rho).abs() / error_2,
        copy.abs() * n.sqrt() / (news * news),
        (past - rho).abs() * n.sqrt() / news,
    ];
    println!(
        "{delay:?}: KS {:.2} and {:.2} of {KS_BOUND:.2}, lag 1 {lag_1:.4}, lag 2 {lag_2:.4}, copy \
         with message {copy:.4}, with past {past:.4}: {sigmas:.1?}σ",
        ks[0], ks[1]
    );
    assert!(ks.iter().all(|&ks| ks < KS_BOUND), "{delay:?}, seed {seed}: {ks:?}");
    assert!(sigmas.iter().all(|&s| s < 4.0), "{delay:?}, seed {seed}: {sigmas:?}");
}

#[test]
fn uniform_delays_are_uniform() {
    for (i, correlation) in [0.0, 0.5, 0.9].into_iter().enumerate() {
        check(&DelayConfig::Uniform { mean_s: 1.0, spread_s: 0.5, correlation }, 10 + i as u64);
    }
}

#[test]
fn normal_delays_are_normal_and_not_negative() {
    let sets = [(0.2, 0.05, 0.0), (0.1, 0.1, 0.0), (0.1, 0.1, 0.3), (0.0, 0.3, 0.6)];
    for (i, (mean_s, sd_s, correlation)) in sets.into_iter().enumerate() {
        check(&DelayConfig::Normal { mean_s, sd_s, correlation }, 20 + i as u64);
    }
}

#[test]
fn pareto_delays_are_pareto() {
    let sets = [(0.2, 3.0, 0.0), (0.2, 3.0, 0.5), (1.0, 1.5, 0.0), (1.0, 8.0, 0.95)];
    for (i, (mean_s, shape, correlation)) in sets.into_iter().enumerate() {
        check(&DelayConfig::Pareto { mean_s, shape, correlation }, 30 + i as u64);
    }
}

#[test]
fn tables_are_followed() {
    let quantiles_s = vec![0.01, 0.02, 0.05, 0.06, 0.5];
    for (i, correlation) in [0.0, 0.5].into_iter().enumerate() {
        let quantiles_s = quantiles_s.clone();
        check(&DelayConfig::Table { quantiles_s, correlation }, 40 + i as u64);
    }
}
