//! Rule 10: how long a message takes.
//!
//! A delay is a quantile of its distribution. Without correlation it is the quantile at a uniform
//! random number of the message; with correlation it is the quantile at Φ of a normal score that
//! depends on the score of the message before (`DelayConfig`). Messages with different delays
//! overtake each other; there is no other reordering.

use crate::config::{ChannelConfig, DelayConfig};
use crate::draw::{Block, Draws, Purpose, normal_cdf, normal_quantile};
use crate::fate::Reason;
use crate::rule::{Case, Rule};

/// Speed of light, m/s.
const LIGHT_M_S: f64 = 299_792_458.0;

/// The normal scores of a message of a link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scores {
    /// The score of the message before; `None` at the beginning of an epoch.
    before: Option<f64>,
    /// The score of the message itself.
    now: f64,
}

/// Delays messages.
pub struct Delay {
    distribution: Distribution,
    correlation: f64,
    light: bool,
}

impl Delay {
    /// `None` when messages arrive at once.
    pub fn new(channel: &ChannelConfig) -> Option<Self> {
        let none = channel.delay == DelayConfig::Constant { mean_s: 0.0 };
        let (distribution, correlation) = Distribution::new(&channel.delay);
        (!none || channel.light_delay).then_some(Self {
            distribution,
            correlation,
            light: channel.light_delay,
        })
    }

    /// The delay of a message, seconds.
    fn of_message(&self, case: &mut Case<'_>) -> f64 {
        let u = case.block.uniform(Purpose::Delay);
        if self.correlation == 0.0 {
            return self.distribution.quantile(u, 1.0 - u);
        }
        let now = self.scores(case).now;
        self.of_score(now)
    }

    /// The delay of a message's copy: another draw, correlated with the same predecessor.
    fn of_copy(&self, case: &mut Case<'_>) -> f64 {
        let mut draws = Draws::of_copies(case.link.seed, case.sent);
        let block = *draws.block(case.sent.sequence);
        let u = block.uniform(Purpose::Delay);
        if self.correlation == 0.0 {
            return self.distribution.quantile(u, 1.0 - u);
        }
        let before = self.scores(case).before;
        self.of_score(self.after(before, &block).now)
    }

    fn scores(&self, case: &mut Case<'_>) -> Scores {
        let link = &mut *case.link;
        link.delay.at(
            case.sent.sequence,
            &mut link.draws,
            |block| self.after(None, block),
            |Scores { now, .. }, block| self.after(Some(now), block),
        )
    }

    fn after(&self, before: Option<f64>, block: &Block) -> Scores {
        let fresh = block.normal(Purpose::Delay);
        let rho = self.correlation;
        let now = before.map_or(fresh, |z| rho * z + libm::sqrt(1.0 - rho * rho) * fresh);
        Scores { before, now }
    }

    fn of_score(&self, z: f64) -> f64 {
        self.distribution.quantile(normal_cdf(z), normal_cdf(-z))
    }
}

impl Rule for Delay {
    fn judge(&self, case: &mut Case<'_>) -> Result<(), Reason> {
        if let Distribution::Constant(seconds) = self.distribution {
            case.delays_s = case.delays_s.map(|delay| delay + seconds);
        } else {
            case.delays_s[0] += self.of_message(case);
            if case.duplicated {
                case.delays_s[1] += self.of_copy(case);
            }
        }
        if self.light {
            let seconds = case.sent.distance_m() / LIGHT_M_S;
            case.delays_s = case.delays_s.map(|delay| delay + seconds);
        }
        Ok(())
    }
}

/// A distribution of delays.
enum Distribution {
    Constant(f64),
    Uniform { low_s: f64, width_s: f64 },
    Normal { mean_s: f64, sd_s: f64, below_zero: f64 },
    Pareto { minimum_s: f64, exponent: f64 },
    Table(Vec<f64>),
}

impl Distribution {
    fn new(config: &DelayConfig) -> (Self, f64) {
        match config {
            &DelayConfig::Constant { mean_s } => (Self::Constant(mean_s), 0.0),
            &DelayConfig::Uniform { mean_s, spread_s, correlation } => {
                (Self::Uniform { low_s: mean_s - spread_s, width_s: 2.0 * spread_s }, correlation)
            }
            &DelayConfig::Normal { mean_s, sd_s: 0.0, .. } => (Self::Constant(mean_s), 0.0),
            &DelayConfig::Normal { mean_s, sd_s, correlation } => {
                let below_zero = normal_cdf(-mean_s / sd_s);
                (Self::Normal { mean_s, sd_s, below_zero }, correlation)
            }
            &DelayConfig::Pareto { mean_s, shape, correlation } => {
                let minimum_s = mean_s * (shape - 1.0) / shape;
                (Self::Pareto { minimum_s, exponent: -1.0 / shape }, correlation)
            }
            DelayConfig::Table { quantiles_s, correlation } => match quantiles_s[..] {
                [] => (Self::Constant(0.0), 0.0),
                [only] => (Self::Constant(only), 0.0),
                _ => (Self::Table(quantiles_s.clone()), *correlation),
            },
        }
    }

    /// The `u`-quantile of the delays, seconds; `above` is 1 - u. The caller passes both, because
    /// near 0 or 1 only one of them has all its significant digits.
    fn quantile(&self, u: f64, above: f64) -> f64 {
        match self {
            Self::Constant(seconds) => *seconds,
            Self::Uniform { low_s, width_s } => low_s + u * width_s,
            Self::Normal { mean_s, sd_s, below_zero } => {
                // From the upper end: for a mean far above 0 it has more significant digits.
                let above = above * (1.0 - below_zero);
                (mean_s - sd_s * normal_quantile(above)).max(0.0)
            }
            Self::Pareto { minimum_s, exponent } => minimum_s * libm::pow(above, *exponent),
            Self::Table(quantiles_s) => {
                let place = u * (quantiles_s.len() - 1) as f64;
                let index = (place as usize).min(quantiles_s.len() - 2);
                let [low, high] = [quantiles_s[index], quantiles_s[index + 1]];
                low + (place - index as f64) * (high - low)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fate::Sent;
    use crate::fate::tests::sent;
    use crate::rule::LinkState;
    use crate::rule::tests::{judge_alone, judge_on};

    fn quantile(config: &DelayConfig, u: f64) -> f64 {
        Distribution::new(config).0.quantile(u, 1.0 - u)
    }

    #[test]
    fn quantiles_are_those_of_the_distributions() {
        let uniform = DelayConfig::Uniform { mean_s: 2.0, spread_s: 0.5, correlation: 0.0 };
        assert_eq!([0.0, 0.25, 1.0].map(|u| quantile(&uniform, u)), [1.5, 1.75, 2.5]);
        let normal = DelayConfig::Normal { mean_s: 10.0, sd_s: 1.0, correlation: 0.0 };
        assert!((quantile(&normal, 0.5) - 10.0).abs() < 1e-12);
        // A mean of 0 leaves the half normal distribution, whose median is 0.6745 sd.
        let half = DelayConfig::Normal { mean_s: 0.0, sd_s: 1.0, correlation: 0.0 };
        assert!((quantile(&half, 0.5) - 0.674489750196082).abs() < 1e-12);
        assert!(quantile(&half, 1e-16) >= 0.0);
        let pareto = DelayConfig::Pareto { mean_s: 3.0, shape: 3.0, correlation: 0.0 };
        assert!((quantile(&pareto, 0.0) - 2.0).abs() < 1e-15);
        assert!((quantile(&pareto, 0.875) - 4.0).abs() < 1e-12);
        let table = DelayConfig::Table { quantiles_s: vec![1.0, 2.0, 4.0], correlation: 0.0 };
        let at = [0.0, 0.25, 0.5, 0.75, 1.0].map(|u| quantile(&table, u));
        assert_eq!(at, [1.0, 1.5, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn tables_that_are_too_short_are_constants() {
        let of = |quantiles_s| quantile(&DelayConfig::Table { quantiles_s, correlation: 0.5 }, 0.3);
        assert_eq!((of(vec![]), of(vec![2.0])), (0.0, 2.0));
    }

    fn rule(delay: DelayConfig, light_delay: bool) -> Delay {
        Delay::new(&ChannelConfig { delay, light_delay, ..Default::default() }).unwrap()
    }

    #[test]
    fn light_takes_its_time() {
        let still = DelayConfig::Constant { mean_s: 0.0 };
        assert!(Delay::new(&ChannelConfig::default()).is_none());
        let far = Sent { dst_p_world: [LIGHT_M_S, 0.0, 50.0], ..sent(0) };
        let (_, _, [delay_s, _]) = judge_alone(&rule(still, true), &far).unwrap();
        assert!((delay_s - 1.0).abs() < 1e-12);
    }

    /// With nearly full correlation delays change in small steps, in any order of queries.
    #[test]
    fn correlated_delays_remember_and_are_functions() {
        let delay = DelayConfig::Uniform { mean_s: 1.0, spread_s: 1.0, correlation: 0.9999 };
        let rule = rule(delay, false);
        let mut link = LinkState::new(3, &sent(0));
        let mut delay = |i| judge_on(&rule, &sent(i), &mut link).unwrap().2[0];
        let forward: Vec<f64> = (0..200).map(&mut delay).collect();
        assert!(forward.windows(2).all(|w| (w[1] - w[0]).abs() < 0.1 && w[1] != w[0]));
        assert!((0..200).rev().all(|i| delay(i) == forward[i as usize]));
    }
}
