//! Rule 4: path loss, and packet errors by the signal-to-noise ratio that is left.
//!
//! Path loss PL = loss_at_1m + 10 n log₁₀(max(d, 1 m)) + shadowing, and `obstruction_db` more when a
//! building stands between the ends. SNR = tx_power - PL - noise; bit error rate of coherent BPSK
//! BER = ½ erfc(√SNR) with the SNR as a ratio; packet error rate PER = 1 - (1 - BER)^(8 bytes).
//!
//! Shadowing is normal in dB and the same in both directions. It is a function of the pair of agents
//! and of the cells that they are in: a UAV that flies back to a cell has the same shadowing there
//! again.

use std::sync::Arc;

use csat_proto::ids::AgentId;

use crate::config::{ChannelConfig, PropagationConfig};
use crate::draw::{Purpose, of_place};
use crate::fate::{Reason, Sent};
use crate::rule::{Case, Rule};

/// What stands between the ends of a link.
pub trait Obstruction: Send + Sync {
    /// Whether something solid stands between `a` and `b`; `world`, metres.
    fn blocked(&self, a: [f64; 3], b: [f64; 3]) -> bool;
}

/// The shadowing of a link at the current cells of its ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shadowing {
    cells: [[i32; 3]; 2],
    /// In standard deviations.
    normal: f64,
}

/// Loses messages by packet errors.
pub struct Propagation {
    config: PropagationConfig,
    /// `None` when there are no obstacles, or `obstruction_db` is 0.
    obstruction: Option<Arc<dyn Obstruction>>,
}

impl Propagation {
    /// `None` without propagation.
    pub fn new(
        channel: &ChannelConfig,
        obstruction: Option<&Arc<dyn Obstruction>>,
    ) -> Option<Self> {
        let config = channel.propagation?;
        let obstruction = obstruction.filter(|_| config.obstruction_db != 0.0).cloned();
        Some(Self { config, obstruction })
    }

    /// Signal-to-noise ratio, dB, under a shadowing of `normal` standard deviations.
    fn snr_db(&self, sent: &Sent, normal: f64) -> f64 {
        let PropagationConfig { tx_power_dbm, noise_dbm, exponent, loss_at_1m_db, .. } =
            self.config;
        let spread_db = 10.0 * exponent * libm::log10(sent.distance_m().max(1.0));
        let shadowing_db = self.config.shadowing_sigma_db * normal;
        let between = self.obstruction.as_ref();
        let blocked = between.is_some_and(|o| o.blocked(sent.src_p_world, sent.dst_p_world));
        let obstruction_db = if blocked { self.config.obstruction_db } else { 0.0 };
        tx_power_dbm - loss_at_1m_db - spread_db - shadowing_db - obstruction_db - noise_dbm
    }

    fn cell(&self, p_world: [f64; 3]) -> [i32; 3] {
        // The cast saturates.
        p_world.map(|p| libm::floor(p / self.config.shadowing_cell_m) as i32)
    }

    /// The ends of a message and their cells, the same in both directions.
    fn places(&self, sent: &Sent) -> ([AgentId; 2], [[i32; 3]; 2]) {
        let Sent { src, dst, src_p_world, dst_p_world, .. } = *sent;
        let ends = [(src, self.cell(src_p_world)), (dst, self.cell(dst_p_world))];
        let [(low, low_cell), (high, high_cell)] =
            if src <= dst { ends } else { [ends[1], ends[0]] };
        ([low, high], [low_cell, high_cell])
    }

    fn shadowing(&self, case: &mut Case<'_>) -> f64 {
        if self.config.shadowing_sigma_db == 0.0 {
            return 0.0;
        }
        let (pair, cells) = self.places(case.sent);
        match case.link.shadowing {
            Some(known) if known.cells == cells => known.normal,
            _ => {
                let normal = of_place(case.link.seed, pair, case.sent.channel, cells);
                case.link.shadowing = Some(Shadowing { cells, normal });
                normal
            }
        }
    }
}

impl Rule for Propagation {
    fn judge(&self, case: &mut Case<'_>) -> Result<(), Reason> {
        let normal = self.shadowing(case);
        let error_rate = packet_error_rate(self.snr_db(case.sent, normal), case.sent.bytes);
        let lost = case.block.uniform(Purpose::Propagation) < error_rate;
        if lost { Err(Reason::Propagation) } else { Ok(()) }
    }

    fn cuts(&self, probe: &Sent, seed: u64) -> bool {
        let normal = match self.config.shadowing_sigma_db {
            0.0 => 0.0,
            _ => {
                let (pair, cells) = self.places(probe);
                of_place(seed, pair, probe.channel, cells)
            }
        };
        packet_error_rate(self.snr_db(probe, normal), probe.bytes) > 0.5
    }
}

/// Probability that at least one bit of `bytes` bytes is wrong at a signal-to-noise ratio in dB.
pub fn packet_error_rate(snr_db: f64, bytes: usize) -> f64 {
    let snr = libm::pow(10.0, snr_db / 10.0);
    let bit_error_rate = 0.5 * libm::erfc(libm::sqrt(snr));
    // 1 - (1 - BER)^bits without the loss of digits where BER is small.
    -libm::expm1(8.0 * bytes as f64 * libm::log1p(-bit_error_rate))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fate::tests::sent;
    use crate::rule::LinkState;
    use crate::rule::tests::judge_alone;

    struct Wall;

    impl Obstruction for Wall {
        fn blocked(&self, a: [f64; 3], b: [f64; 3]) -> bool {
            (a[0] > 10.0) != (b[0] > 10.0)
        }
    }

    /// SNR 10 dB over 50 m without shadowing; a wall takes 30 dB.
    fn config() -> PropagationConfig {
        PropagationConfig {
            tx_power_dbm: 0.0,
            noise_dbm: -10.0 - 40.0 - 20.0 * 50f64.log10(),
            exponent: 2.0,
            loss_at_1m_db: 40.0,
            shadowing_sigma_db: 0.0,
            shadowing_cell_m: 10.0,
            obstruction_db: 30.0,
        }
    }

    fn rule(config: PropagationConfig, walls: bool) -> Propagation {
        let wall: Arc<dyn Obstruction> = Arc::new(Wall);
        let channel = ChannelConfig { propagation: Some(config), ..Default::default() };
        Propagation::new(&channel, walls.then_some(&wall)).unwrap()
    }

    #[test]
    fn free_space_is_heard_and_a_wall_is_not() {
        assert!((rule(config(), false).snr_db(&sent(0), 0.0) - 10.0).abs() < 1e-12);
        assert!((rule(config(), true).snr_db(&sent(0), 0.0) + 20.0).abs() < 1e-12);
        assert!(judge_alone(&rule(config(), false), &sent(0)).is_ok());
        assert_eq!(judge_alone(&rule(config(), true), &sent(0)), Err(Reason::Propagation));
        // Nearer than 1 m is 1 m.
        let touching = Sent { dst_p_world: sent(0).src_p_world, ..sent(0) };
        assert!(rule(config(), false).snr_db(&touching, 0.0).is_finite());
    }

    #[test]
    fn error_rates_keep_their_digits() {
        // BPSK at 9.6 dB has 1e-5 in every textbook.
        assert!((packet_error_rate(9.5879, 1) / 8e-5 - 1.0).abs() < 1e-3);
        assert!(packet_error_rate(16.0, 1000) > 1e-17, "not rounded to 0");
        assert_eq!(packet_error_rate(-400.0, 1000), 1.0);
        assert_eq!(packet_error_rate(400.0, 1000), 0.0);
        assert_eq!(packet_error_rate(-400.0, 0), 0.0);
    }

    /// A probe meets the shadowing and the walls that messages meet.
    #[test]
    fn a_link_is_cut_where_most_messages_are_lost() {
        let shadowed = PropagationConfig { shadowing_sigma_db: 6.0, ..config() };
        let rules = [rule(shadowed, false), rule(config(), false), rule(config(), true)];
        for (index, rule) in rules.iter().enumerate() {
            let probe = |x: f64| Sent { src_p_world: [x, 40.0, 50.0], ..sent(0) };
            let places = (0..9).map(|i| f64::from(i) * 11.0);
            let is_cut: Vec<bool> = places.clone().map(|x| rule.cuts(&probe(x), 3)).collect();
            for (x, is_cut) in places.zip(&is_cut) {
                let message = |sequence| Sent { sequence, ..probe(x) };
                let lost = (0..200).filter(|&n| judge_alone(rule, &message(n)).is_err()).count();
                // Between, chance decides which side of a half is counted.
                let is_clear = !(70..=130).contains(&lost);
                assert!(
                    !is_clear || *is_cut == (lost > 100),
                    "rule {index} at {x} m: {lost} of 200"
                );
            }
            assert!(is_cut.contains(&false), "rule {index}");
        }
    }

    fn shadowing_of(rule: &Propagation, sent: &Sent, link: &mut LinkState) -> f64 {
        let mut case = Case::new(sent, link, crate::rate::Departure::After(0.0));
        rule.shadowing(&mut case)
    }

    #[test]
    fn shadowing_stays_at_its_place_and_is_the_same_both_ways() {
        let rule = rule(PropagationConfig { shadowing_sigma_db: 6.0, ..config() }, false);
        let there = sent(0);
        let back = Sent {
            src: there.dst,
            dst: there.src,
            src_p_world: there.dst_p_world,
            dst_p_world: there.src_p_world,
            ..there
        };
        let near = Sent { src_p_world: [9.9, 0.1, 59.0], sequence: 7, ..there };
        let far = Sent { src_p_world: [10.1, 0.1, 59.0], ..there };
        let mut link = LinkState::new(3, &there);
        let here = shadowing_of(&rule, &there, &mut link);
        assert_ne!(shadowing_of(&rule, &far, &mut link), here);
        assert_eq!(shadowing_of(&rule, &near, &mut link), here);
        assert_eq!(shadowing_of(&rule, &back, &mut LinkState::new(3, &back)), here);
        assert_ne!(shadowing_of(&rule, &there, &mut LinkState::new(4, &there)), here);
    }
}
