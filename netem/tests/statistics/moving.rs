//! Radios that move: packet errors by distance, shadowing by place, and settings that change.

use csat_netem::config::{ChannelConfig, NetemConfig, PropagationConfig};
use csat_netem::fate::{Reason, Sent};
use csat_netem::propagation::packet_error_rate;
use csat_proto::ids::AgentId;

use crate::estimate::mean;
use crate::losses::ge;
use crate::theory::Hidden;
use crate::{links, sent};

/// (SNR in dB, bytes, packet error rate), computed with Python's `math.erfc`.
const ERROR_RATES: [(f64, usize, f64); 14] = [
    (-5.0, 1, 0.853178017429),
    (0.0, 1, 0.480723562663),
    (3.0, 10, 0.843003910647),
    (5.0, 50, 0.908247893479),
    (6.0, 100, 0.852351058104),
    (6.8, 100, 0.546337173689),
    (7.5, 400, 0.720960743235),
    (8.0, 100, 0.141647821644),
    (8.0, 1500, 0.898846082996),
    (9.0, 400, 0.102021308899),
    (9.6, 1500, 0.110267729332),
    (10.0, 100, 0.00309289967035),
    (11.0, 1500, 0.00313077083789),
    (12.0, 1500, 0.000108066285112),
];

#[test]
fn packet_error_rates_are_the_closed_forms() {
    for (snr_db, bytes, expected) in ERROR_RATES {
        let got = packet_error_rate(snr_db, bytes);
        assert!((got - expected).abs() < 1e-10, "{snr_db} dB, {bytes} bytes: {got} {expected}");
    }
    // And on a grid, with another library and the plain formula.
    for snr_db in (-60..=150).map(|i| f64::from(i) / 10.0) {
        let snr = 10f64.powf(snr_db / 10.0);
        let bit = 0.5 * statrs::function::erf::erfc(snr.sqrt());
        for bytes in [1, 40, 200, 1500] {
            let expected = 1.0 - (1.0 - bit).powi(8 * bytes);
            let got = packet_error_rate(snr_db, bytes as usize);
            assert!((got - expected).abs() < 1e-5, "{snr_db} dB, {bytes}: {got} {expected}");
        }
    }
}

/// 10 dB of SNR at 100 m, exponent 3, no shadowing.
const RADIO: PropagationConfig = PropagationConfig {
    tx_power_dbm: 20.0,
    noise_dbm: -90.0,
    exponent: 3.0,
    loss_at_1m_db: 40.0,
    shadowing_sigma_db: 0.0,
    shadowing_cell_m: 10.0,
    obstruction_db: 20.0,
};

/// An independent implementation of the formulas.
fn expected_loss(distance_m: f64, shadowing_db: f64, bytes: i32) -> f64 {
    let snr_db = 20.0 - 40.0 - 30.0 * distance_m.max(1.0).log10() - shadowing_db + 90.0;
    let bit = 0.5 * statrs::function::erf::erfc(10f64.powf(snr_db / 10.0).sqrt());
    1.0 - (1.0 - bit).powi(8 * bytes)
}

fn at(sequence: u64, distance_m: f64) -> Sent {
    Sent { dst_p_world: [distance_m, 0.0, 50.0], ..sent(sequence) }
}

/// A UAV flies to and fro between 1 m and 200 m.
#[test]
fn a_moving_link_loses_by_distance() {
    const N: u64 = 1_000_000;
    const BIN_M: f64 = 10.0;
    let mut links = links(ChannelConfig { propagation: Some(RADIO), ..Default::default() }, 31);
    let mut bins = vec![(0.0, 0.0, 0.0); 20];
    for i in 0..N {
        let phase = (i % 40_000) as f64 / 20_000.0;
        let distance_m = 1.0 + 198.0 * if phase < 1.0 { phase } else { 2.0 - phase };
        let lost = links.fate(&at(i, distance_m)).first == Err(Reason::Propagation);
        let p = expected_loss(distance_m, 0.0, 100);
        let bin = &mut bins[(distance_m / BIN_M) as usize];
        bin.0 += f64::from(u8::from(lost));
        bin.1 += p;
        bin.2 += p * (1.0 - p);
    }
    for (i, (lost, expected, variance)) in bins.into_iter().enumerate() {
        let sigmas = (lost - expected) / (variance + 1e-9).sqrt();
        println!("{:4} m: lost {lost:6} of {expected:9.1} ({sigmas:+.1}σ)", i * 10);
        // Where less than one message is expected, counts are whole numbers.
        assert!((lost - expected).abs() < 4.0 * variance.sqrt() + 1.0, "bin {i}: {sigmas} sigma");
    }
}

/// Over many places the shadowing is normal: the loss is the mean over its distribution.
#[test]
fn shadowing_is_normal_over_places() {
    let (sigma, distance_m) = (6.0, 100.0);
    let shadowed = PropagationConfig { shadowing_sigma_db: sigma, ..RADIO };
    let mut links = links(ChannelConfig { propagation: Some(shadowed), ..Default::default() }, 32);
    let mut losses = Vec::new();
    for place in 0..4000u32 {
        // Pairs of agents and places in turn; losses at one place are correlated.
        let offset_m = 10.0 * f64::from(place / 40);
        for i in 0..250 {
            let message = Sent {
                dst: AgentId(1 + (place % 40) as u16),
                src_p_world: [5.0 + offset_m, 5.0, 50.0],
                dst_p_world: [5.0 + offset_m + distance_m, 5.0, 50.0],
                ..sent(u64::from(place / 40) * 250 + i)
            };
            losses.push(f64::from(u8::from(links.fate(&message).first.is_err())));
        }
    }
    let step = 0.01;
    let expected: f64 = (-800..=800)
        .map(|i| {
            let z = f64::from(i) * step;
            let density = (-z * z / 2.0).exp() / (2.0 * std::f64::consts::PI).sqrt();
            density * step * expected_loss(distance_m, sigma * z, 100)
        })
        .sum();
    let got = mean(&losses);
    println!("shadowed: {:.4} ± {:.4} of {expected:.4}", got.value, got.error);
    assert!(got.sigmas(expected) < 4.0, "{got:?} {expected}");
}

/// A link whose settings change with every message still has bursts: its chain goes on.
#[test]
fn settings_that_change_every_tick_leave_bursts_whole() {
    const N: u64 = 200_000;
    let loss = ge(0.02, 0.1, 0.0, 1.0);
    let radio = |range_m| ChannelConfig { range_m, loss: loss.clone(), ..Default::default() };
    let mut links = links(radio(100.0), 33);
    let lost: Vec<bool> = (0..N)
        .map(|i| {
            let radio = radio(60.0 + (i % 50) as f64);
            links.reconfigure(&NetemConfig { radio, ..Default::default() });
            links.fate(&sent(i)).first.is_err()
        })
        .collect();
    let theory = Hidden::new(&loss, 1).unwrap();
    let run = crate::estimate::run_length(&lost, theory.run_length());
    println!("runs of {:.3} ± {:.3} of {:.3}", run.value, run.error, theory.run_length());
    assert!(run.sigmas(theory.run_length()) < 4.0, "{run:?}");
    assert_eq!(lost, crate::losses::losses(&loss, 0, 33, N), "nothing was reset");
}
