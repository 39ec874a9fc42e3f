//! Known defects of other emulators, and the same tests on one of them (`str0m-netem`) for
//! comparison. Only the results of csat are asserted; those of the other one are printed.

use std::time::{Duration, Instant};

use csat_netem::config::{ChannelConfig, DelayConfig, LossConfig, NetemConfig};
use str0m_netem::{GilbertElliot, Input, Netem, Output, Probability, RandomLoss};

use crate::losses::{ge, losses};
use crate::theory::Hidden;
use crate::{estimate, links, sent};

type Theirs = str0m_netem::NetemConfig;

#[expect(clippy::disallowed_methods, reason = "their time is an Instant; the difference counts")]
fn start() -> Instant {
    Instant::now()
}

/// Numbers of the packets that came through, in order, of `n` sent 1 ms apart.
fn theirs(config: Theirs, n: u32) -> Vec<u32> {
    let mut netem: Netem<Vec<u8>> = Netem::new(config);
    let start = start();
    let mut got = Vec::new();
    let mut drain = |netem: &mut Netem<Vec<u8>>| {
        while let Some(output) = netem.poll_output() {
            if let Output::Packet(bytes) = output {
                got.push(u32::from_le_bytes(bytes.try_into().unwrap()));
            }
        }
    };
    for i in 0..n {
        let now = start + Duration::from_millis(u64::from(i));
        netem.handle_input(Input::Timeout(now));
        drain(&mut netem);
        netem.handle_input(Input::Packet(now, i.to_le_bytes().to_vec()));
        drain(&mut netem);
    }
    netem.handle_input(Input::Timeout(start + Duration::from_secs(86_400)));
    drain(&mut netem);
    got
}

fn their_losses(config: Theirs, n: u32) -> Vec<bool> {
    let mut lost = vec![true; n as usize];
    for i in theirs(config, n) {
        lost[i as usize] = false;
    }
    lost
}

fn rate(lost: &[bool]) -> f64 {
    lost.iter().filter(|&&lost| lost).count() as f64 / lost.len() as f64
}

#[test]
fn losses_beside_theirs() {
    const N: u32 = 1_000_000;
    for (p, r, h, k) in
        [(0.05, 0.25, 0.0, 1.0), (0.01, 0.1, 0.0, 1.0), (0.02, 0.1, 0.5, 1.0), (0.1, 0.4, 0.3, 0.9)]
    {
        let loss = ge(p, r, h, k);
        let theory = Hidden::new(&loss, 1).unwrap();
        let ours = losses(&loss, 0, 51, u64::from(N));
        let model = GilbertElliot::new()
            .good_duration(1.0 / p as f32)
            .bad_duration(1.0 / r as f32)
            .loss_in_bad(Probability::new(1.0 - h as f32))
            .loss_in_good(Probability::new(1.0 - k as f32));
        let theirs = their_losses(Theirs::new().loss(model).seed(51), N);
        let [own, other] =
            [&ours, &theirs].map(|lost| estimate::run_length(lost, theory.run_length()));
        println!(
            "p {p} r {r} h {h} k {k}: rate {:.5}, str0m-netem {:.5}, theory {:.5}; run {:.3}, \
             str0m-netem {:.3}, theory {:.3}",
            rate(&ours),
            rate(&theirs),
            theory.mean(),
            own.value,
            other.value,
            theory.run_length()
        );
        let error = theory.variance_of_mean(f64::from(N)).sqrt();
        assert!((rate(&ours) - theory.mean()).abs() < 4.0 * error);
        assert!(own.sigmas(theory.run_length()) < 4.0);
    }
}

/// The model of correlated loss that Linux netem has too: a moving average of uniform numbers is not
/// uniform, so it misses its own rate.
#[test]
fn correlated_loss_beside_theirs() {
    const N: u32 = 1_000_000;
    for (p, correlation) in [(0.1, 0.5), (0.1, 0.9), (0.01, 0.5)] {
        let leave = 1.0 - correlation;
        let loss = ge(p * leave, (1.0 - p) * leave, 0.0, 1.0);
        let ours = rate(&losses(&loss, 0, 52, u64::from(N)));
        let model = RandomLoss::new(Probability::new(p as f32))
            .correlation(Probability::new(correlation as f32));
        let theirs = rate(&their_losses(Theirs::new().loss(model).seed(52), N));
        println!("{p} with correlation {correlation}: rate {ours:.5}, str0m-netem {theirs:.5}");
        let error = Hidden::new(&loss, 1).unwrap().variance_of_mean(f64::from(N)).sqrt();
        assert!((ours - p).abs() < 4.0 * error, "{ours}");
    }
}

fn inversions(order: &[u64]) -> f64 {
    let late = order.windows(2).filter(|pair| pair[0] > pair[1]).count();
    late as f64 / order.len() as f64
}

/// Messages 1 ms apart with 10 ms of jitter must overtake each other.
#[test]
fn jitter_reorders() {
    const N: u32 = 100_000;
    let delay = DelayConfig::Uniform { mean_s: 0.05, spread_s: 0.01, correlation: 0.0 };
    let mut ours = links(ChannelConfig { delay, ..Default::default() }, 53);
    for i in 0..u64::from(N) {
        ours.send(&sent(i), i.to_le_bytes().as_slice().into());
    }
    let number = |bytes: &[u8]| u64::from_le_bytes(bytes.try_into().unwrap());
    let last = csat_proto::time::SimTime(u64::MAX);
    let order: Vec<u64> =
        std::iter::from_fn(|| ours.receive(last)).map(|arrival| number(&arrival.bytes)).collect();
    let jitter =
        Theirs::new().latency(Duration::from_millis(50)).jitter(Duration::from_millis(10)).seed(53);
    let theirs: Vec<u64> = theirs(jitter, N).into_iter().map(u64::from).collect();
    let (ours, theirs) = (inversions(&order), inversions(&theirs));
    println!("overtaken by the next: {ours:.3}, str0m-netem {theirs:.3}");
    assert_eq!(order.len(), N as usize);
    assert!(ours > 0.3, "{ours}");
}

/// In `str0m-netem` a new configuration restarts the random numbers: a link whose settings follow its
/// motion loses all its messages or none.
#[test]
fn moving_settings_beside_theirs() {
    const N: u32 = 20_000;
    let loss = LossConfig::Iid { p: 0.3 };
    let mut ours = links(ChannelConfig { loss: loss.clone(), ..Default::default() }, 54);
    let lost = (0..N).filter(|&i| {
        let range_m = 100.0 + f64::from(i);
        let radio = ChannelConfig { range_m, loss: loss.clone(), ..Default::default() };
        ours.reconfigure(&NetemConfig { radio, ..Default::default() });
        ours.fate(&sent(u64::from(i))).first.is_err()
    });
    let ours = lost.count() as f64 / f64::from(N);
    let config = || Theirs::new().loss(RandomLoss::new(Probability::new(0.3))).seed(54);
    let mut netem: Netem<Vec<u8>> = Netem::new(config());
    let start = start();
    let mut arrived = 0u32;
    for i in 0..N {
        netem.set_config(config());
        let now = start + Duration::from_millis(u64::from(i));
        netem.handle_input(Input::Packet(now, vec![0]));
        while let Some(output) = netem.poll_output() {
            arrived += u32::from(matches!(output, Output::Packet(_)));
        }
    }
    let theirs = 1.0 - f64::from(arrived) / f64::from(N);
    println!("loss of 0.3 while settings change: {ours:.3}, str0m-netem {theirs:.3}");
    assert!((ours - 0.3).abs() < 4.0 * (0.21 / f64::from(N)).sqrt(), "{ours}");
}
