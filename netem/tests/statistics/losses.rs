//! Loss rate, mean length of runs and autocovariance of every loss model.

use csat_netem::config::{ChannelConfig, LossConfig};

use crate::estimate::{autocovariance, run_length};
use crate::theory::{Hidden, variance_of_mean};
use crate::{links, sent};

const N: u64 = 1_000_000;

pub fn ge(p: f64, r: f64, h: f64, k: f64) -> LossConfig {
    LossConfig::GilbertElliott { p, r, h, k }
}

fn markov4([p13, p31, p32, p23, p14]: [f64; 5]) -> LossConfig {
    LossConfig::Markov4 { p13, p31, p32, p23, p14 }
}

/// Whether each of the first messages of a link is lost.
pub fn losses(loss: &LossConfig, mtu_bytes: u32, seed: u64, n: u64) -> Vec<bool> {
    let mut links =
        links(ChannelConfig { loss: loss.clone(), mtu_bytes, ..Default::default() }, seed);
    (0..n).map(|i| links.fate(&sent(i)).first.is_err()).collect()
}

/// Checks one set of parameters; messages have 100 bytes.
fn check(loss: &LossConfig, mtu_bytes: u32, seed: u64) {
    let fragments = if mtu_bytes == 0 { 1 } else { 100u32.div_ceil(mtu_bytes) as i32 };
    let theory = Hidden::new(loss, fragments).unwrap();
    let lost = losses(loss, mtu_bytes, seed, N);
    let rate = lost.iter().filter(|&&lost| lost).count() as f64 / N as f64;
    let error = match *loss {
        LossConfig::GilbertElliott { p, r, h, k } if fragments == 1 => {
            variance_of_mean(p, r, h, k, N as f64)
        }
        _ => theory.variance_of_mean(N as f64),
    }
    .sqrt();
    let mean = theory.mean();
    let run = run_length(&lost, theory.run_length());
    let covariances = theory.autocovariance(5);
    let lags: Vec<f64> = (1..=5)
        .map(|lag| autocovariance(&lost, mean, lag, covariances[lag]).sigmas(covariances[lag]))
        .collect();
    let rate_sigmas = (rate - mean).abs() / error;
    let run_sigmas = run.sigmas(theory.run_length());
    println!(
        "{loss:?} in {fragments}: rate {rate:.6} of {mean:.6} ({rate_sigmas:.1}σ), run {:.4} of \
         {:.4} ({run_sigmas:.1}σ), lags {lags:.1?}σ",
        run.value,
        theory.run_length()
    );
    let worst = lags.iter().fold(rate_sigmas.max(run_sigmas), |a, &b| a.max(b));
    assert!(worst < 4.0, "{loss:?}, mtu {mtu_bytes}, seed {seed}: {worst} sigma");
}

#[test]
fn independent_losses_keep_their_promises() {
    for (i, p) in [0.001, 0.1, 0.5, 0.97].into_iter().enumerate() {
        check(&LossConfig::Iid { p }, 0, 100 + i as u64);
    }
    check(&LossConfig::Iid { p: 0.02 }, 40, 110);
}

#[test]
fn gilbert_elliott_keeps_its_promises() {
    let sets = [
        ge(0.1, 0.9, 0.0, 1.0),
        ge(0.05, 0.25, 0.0, 1.0),
        ge(0.01, 0.1, 0.0, 1.0),
        ge(0.001, 0.05, 0.0, 1.0),
        ge(0.002, 0.01, 0.0, 1.0),
        ge(0.3, 0.3, 0.0, 1.0),
        ge(0.5, 0.9, 0.0, 1.0),
        ge(0.05, 0.25, 0.2, 0.99),
        ge(0.02, 0.1, 0.5, 1.0),
        ge(0.1, 0.4, 0.3, 0.9),
    ];
    for (i, loss) in sets.iter().enumerate() {
        check(loss, 0, 200 + i as u64);
    }
    check(&ge(0.05, 0.25, 0.9, 0.99), 30, 210);
    check(&ge(0.02, 0.1, 0.6, 0.98), 50, 211);
}

#[test]
fn four_states_keep_their_promises() {
    let sets = [
        [0.05, 0.4, 0.2, 0.3, 0.01],
        [0.01, 0.1, 0.05, 0.5, 0.002],
        [0.2, 0.6, 0.4, 0.7, 0.1],
        [0.02, 0.3, 0.0, 1.0, 0.05],
        [0.005, 0.05, 0.02, 0.1, 0.0],
        [0.0, 1.0, 0.0, 1.0, 0.1],
    ];
    for (i, set) in sets.into_iter().enumerate() {
        check(&markov4(set), 0, 300 + i as u64);
    }
}

/// Linux netem's correlated loss of 10 % and 50 % loses 0.11 %.
#[test]
fn correlated_loss_keeps_its_rate() {
    for (rate, correlation) in [(0.1, 0.5), (0.1, 0.9), (0.01, 0.5), (0.5, 0.5), (0.9, 0.25)] {
        let leave = 1.0 - correlation;
        check(&ge(rate * leave, (1.0 - rate) * leave, 0.0, 1.0), 0, 400);
    }
}

#[test]
fn recordings_are_replayed_exactly() {
    let text: String = (0..997u32).map(|i| if i * i % 7 < 2 { '1' } else { '0' }).collect();
    let recorded = text.matches('1').count();
    let loss = LossConfig::Trace { file: None, lost: Some(text) };
    let lost = losses(&loss, 0, 1, 997 * 1003);
    for round in lost.chunks(997) {
        assert_eq!(round.iter().filter(|&&lost| lost).count(), recorded);
        assert_eq!(round, &lost[..997]);
    }
}
