//! One rule, one verdict; the chain of rules of a channel.

use csat_proto::time::SimTime;
use serde::Serialize;

use crate::config::{ChannelConfig, DelayConfig, LossConfig};
use crate::fate::{Purpose, Sent, uniform};

/// Why a message was lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// Too far.
    Range,
    /// Random loss.
    Loss,
}

/// What becomes of a message: when it arrives, or why it does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fate {
    /// It arrives then.
    Delivered(SimTime),
    /// It is lost.
    Lost(Reason),
}

/// A rule of a channel. Rules are asked in a fixed order; the first that loses a message names the
/// reason, and what they add to its delay adds up.
pub trait Rule: Send + Sync {
    /// The delay that this rule adds, in seconds, or why the message is lost.
    fn judge(&self, sent: &Sent) -> Result<f64, Reason>;
}

struct Range {
    range_m: f64,
}

impl Rule for Range {
    fn judge(&self, sent: &Sent) -> Result<f64, Reason> {
        if sent.distance_m() <= self.range_m { Ok(0.0) } else { Err(Reason::Range) }
    }
}

struct IidLoss {
    seed: u64,
    p: f64,
}

impl Rule for IidLoss {
    fn judge(&self, sent: &Sent) -> Result<f64, Reason> {
        let lost = uniform(self.seed, sent, Purpose::Loss) < self.p;
        if lost { Err(Reason::Loss) } else { Ok(0.0) }
    }
}

struct ConstantDelay {
    seconds: f64,
}

impl Rule for ConstantDelay {
    fn judge(&self, _: &Sent) -> Result<f64, Reason> {
        Ok(self.seconds)
    }
}

/// The rules of one channel, in the order of `spec/links.md`; those that can do nothing are left out.
pub fn rules(config: &ChannelConfig, seed: u64) -> Vec<Box<dyn Rule>> {
    let mut rules: Vec<Box<dyn Rule>> = Vec::new();
    if config.range_m.is_finite() {
        rules.push(Box::new(Range { range_m: config.range_m }));
    }
    let LossConfig::Iid { p } = config.loss;
    if p > 0.0 {
        rules.push(Box::new(IidLoss { seed, p }));
    }
    let DelayConfig::Constant { mean_s } = config.delay;
    if mean_s > 0.0 {
        rules.push(Box::new(ConstantDelay { seconds: mean_s }));
    }
    rules
}

/// The fate of a message under `rules`.
pub fn fate(rules: &[Box<dyn Rule>], sent: &Sent) -> Fate {
    let delays: Result<Vec<f64>, Reason> = rules.iter().map(|rule| rule.judge(sent)).collect();
    match delays {
        Ok(delays) => Fate::Delivered(sent.time.after(delays.iter().sum())),
        Err(reason) => Fate::Lost(reason),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fate::tests::sent;

    fn fate_under(config: &ChannelConfig, sequence: u64) -> Fate {
        fate(&rules(config, 3), &sent(sequence))
    }

    #[test]
    fn a_perfect_channel_delivers_at_once() {
        assert_eq!(fate_under(&ChannelConfig::default(), 0), Fate::Delivered(sent(0).time));
    }

    #[test]
    fn range_is_a_disc_in_space() {
        // The ends are 50 m apart.
        let within = ChannelConfig { range_m: 50.0, ..Default::default() };
        let beyond = ChannelConfig { range_m: 49.9, ..Default::default() };
        assert_eq!(fate_under(&within, 0), Fate::Delivered(sent(0).time));
        assert_eq!(fate_under(&beyond, 0), Fate::Lost(Reason::Range));
    }

    #[test]
    fn loss_has_its_rate_and_delay_its_length() {
        let config = ChannelConfig {
            loss: LossConfig::Iid { p: 0.3 },
            delay: DelayConfig::Constant { mean_s: 1.5 },
            ..Default::default()
        };
        let n = 20_000;
        let fates: Vec<Fate> = (0..n).map(|i| fate_under(&config, i)).collect();
        let lost = fates.iter().filter(|f| **f == Fate::Lost(Reason::Loss)).count() as f64;
        let sigma = (0.3f64 * 0.7 / n as f64).sqrt();
        assert!((lost / n as f64 - 0.3).abs() < 4.0 * sigma);
        let arrival = Fate::Delivered(SimTime::from_seconds(2.5));
        assert!(fates.iter().all(|f| *f == arrival || *f == Fate::Lost(Reason::Loss)));
    }
}
