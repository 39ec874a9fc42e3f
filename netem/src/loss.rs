//! Rule 6: random loss.
//!
//! Gilbert-Elliott and the four-state model of Linux netem share one implementation: a Markov chain
//! over four states, each with a probability of loss. It takes one step per sequence number of a link
//! and starts in its stationary distribution, so the loss rate holds from the first message on.

use crate::config::{ChannelConfig, LossConfig};
use crate::draw::{Block, Purpose};
use crate::fate::Reason;
use crate::rule::{Case, Rule};
use crate::trace::Trace;

/// The state of a link in its chain of losses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LossState {
    /// Received between bursts; good of Gilbert-Elliott. State 1 of Linux.
    Gap = 0,
    /// Received within a burst. State 2 of Linux.
    BurstReceived = 1,
    /// Lost within a burst; bad of Gilbert-Elliott. State 3 of Linux.
    Burst = 2,
    /// Lost alone. State 4 of Linux.
    GapLost = 3,
}

const STATES: [LossState; 4] =
    [LossState::Gap, LossState::BurstReceived, LossState::Burst, LossState::GapLost];

/// Loses messages at random.
pub struct Loss {
    model: Model,
    /// 0 for no limit.
    mtu_bytes: u32,
}

enum Model {
    Iid { p: f64 },
    Markov(Box<Markov>),
    Trace(Trace),
}

/// The probabilities of the chain; rows of transitions are cumulated.
struct Markov {
    first: [f64; 4],
    next: [[f64; 4]; 4],
    loss: [f64; 4],
}

impl Loss {
    /// `None` when no message is lost. Also `None` for a trace that cannot be read, which
    /// `NetemConfig::mistakes` reports.
    pub fn new(channel: &ChannelConfig) -> Option<Self> {
        let model = match &channel.loss {
            LossConfig::Iid { p } if *p == 0.0 => return None,
            LossConfig::Iid { p } => Model::Iid { p: *p },
            &LossConfig::GilbertElliott { p, r, h, k } => {
                Model::Markov(Box::new(gilbert_elliott(p, r, h, k)))
            }
            &LossConfig::Markov4 { p13, p31, p32, p23, p14 } => {
                Model::Markov(Box::new(markov4(p13, p31, p32, p23, p14)))
            }
            LossConfig::Trace { lost, .. } => {
                Model::Trace(Trace::parse(lost.as_deref().unwrap_or_default()).ok()?)
            }
        };
        Some(Self { model, mtu_bytes: channel.mtu_bytes })
    }

    /// The probability that a message is lost if each of its fragments is lost independently with
    /// probability `p`.
    fn of_message(&self, p: f64, bytes: usize) -> f64 {
        let fragments = fragments(bytes, self.mtu_bytes);
        if fragments == 1 || p == 0.0 || p == 1.0 {
            return p;
        }
        -libm::expm1(fragments as f64 * libm::log1p(-p))
    }
}

/// The number of fragments of a message; one when `mtu_bytes` is 0.
fn fragments(bytes: usize, mtu_bytes: u32) -> usize {
    match mtu_bytes {
        0 => 1,
        mtu => bytes.div_ceil(mtu as usize).max(1),
    }
}

impl Rule for Loss {
    fn judge(&self, case: &mut Case<'_>) -> Result<(), Reason> {
        let sent = case.sent;
        let p = match &self.model {
            Model::Iid { p } => *p,
            Model::Markov(markov) => {
                let link = &mut *case.link;
                let state = link.loss.at(
                    sent.sequence,
                    &mut link.draws,
                    |block| pick(&markov.first, block),
                    |state, block| pick(&markov.next[state as usize], block),
                );
                markov.loss[state as usize]
            }
            Model::Trace(trace) => {
                f64::from(u8::from(trace.lost(case.link.own_bits, sent.sequence)))
            }
        };
        let lost = case.block.uniform(Purpose::Loss) < self.of_message(p, sent.bytes);
        if lost { Err(Reason::Loss) } else { Ok(()) }
    }
}

fn pick(cumulated: &[f64; 4], block: &Block) -> LossState {
    let u = block.uniform(Purpose::Chain);
    // The number of sums up to u is the index. There is no branch, because no predictor could guess it.
    let index = cumulated[..3].iter().map(|&sum| usize::from(u >= sum)).sum::<usize>();
    STATES[index]
}

fn cumulated(row: [f64; 4]) -> [f64; 4] {
    let mut sum = 0.0;
    row.map(|p| {
        sum += p;
        sum
    })
}

/// The two states are `Gap` and `Burst`. A link may be in one of the other two states when another
/// model was configured before; each of these has the probabilities of the state that it resembles.
fn gilbert_elliott(p: f64, r: f64, h: f64, k: f64) -> Markov {
    let bad = if p + r > 0.0 { p / (p + r) } else { 0.0 };
    let from_good = cumulated([1.0 - p, 0.0, p, 0.0]);
    let from_bad = cumulated([r, 0.0, 1.0 - r, 0.0]);
    Markov {
        first: cumulated([1.0 - bad, 0.0, bad, 0.0]),
        next: [from_good, from_bad, from_bad, from_good],
        loss: [1.0 - k, 1.0 - h, 1.0 - h, 1.0 - k],
    }
}

fn markov4(p13: f64, p31: f64, p32: f64, p23: f64, p14: f64) -> Markov {
    // Stationary weights relative to state 1, from the balance between gap and burst, within the
    // gap and within the burst.
    let share = |into: f64, out: f64| if into > 0.0 { into / out } else { 0.0 };
    let burst = share(p13, p31);
    let weights = [1.0, burst * share(p32, p23), burst, p14];
    let total: f64 = weights.iter().sum();
    Markov {
        first: cumulated(weights.map(|weight| weight / total)),
        next: [
            cumulated([1.0 - p13 - p14, 0.0, p13, p14]),
            cumulated([0.0, 1.0 - p23, p23, 0.0]),
            cumulated([p31, p32, 1.0 - p31 - p32, 0.0]),
            cumulated([1.0, 0.0, 0.0, 0.0]),
        ],
        loss: [0.0, 0.0, 1.0, 1.0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fate::Sent;
    use crate::fate::tests::sent;
    use crate::rule::LinkState;
    use crate::rule::tests::{judge_on, loss_share};
    use csat_proto::ids::AgentId;

    fn rule(loss: LossConfig, mtu_bytes: u32) -> Loss {
        Loss::new(&ChannelConfig { loss, mtu_bytes, ..Default::default() }).unwrap()
    }

    #[test]
    fn fragments_fill_the_mtu() {
        let counts = [(0, 1), (1, 1), (100, 1), (101, 2), (200, 2), (1000, 10)];
        assert!(counts.iter().all(|&(bytes, n)| fragments(bytes, 100) == n));
        assert_eq!(fragments(usize::MAX, 0), 1);
    }

    #[test]
    fn one_lost_fragment_loses_the_message() {
        let rule = rule(LossConfig::Iid { p: 0.1 }, 30);
        // 100 bytes are four fragments.
        let expected = 1.0 - 0.9f64.powi(4);
        let share = loss_share(&rule, 40_000, sent);
        let sigma = (expected * (1.0 - expected) / 40_000.0).sqrt();
        assert!((share - expected).abs() < 4.0 * sigma, "{share}");
    }

    /// All fragments of a message are in one state: with certain loss in one and none in the other,
    /// fragments make no difference.
    #[test]
    fn fragments_share_the_state() {
        let bursts = LossConfig::GilbertElliott { p: 0.1, r: 0.3, h: 0.0, k: 1.0 };
        let whole = loss_share(&rule(bursts.clone(), 0), 10_000, sent);
        assert_eq!(loss_share(&rule(bursts, 10), 10_000, sent), whole);
        assert!((whole - 0.25).abs() < 0.03, "{whole}");
    }

    #[test]
    fn extremes_are_certain() {
        let always = rule(LossConfig::Iid { p: 1.0 }, 7);
        assert_eq!(loss_share(&always, 1000, sent), 1.0);
        assert!(Loss::new(&ChannelConfig::default()).is_none());
        let good = rule(LossConfig::GilbertElliott { p: 0.0, r: 0.5, h: 0.0, k: 1.0 }, 0);
        assert_eq!(loss_share(&good, 1000, sent), 0.0);
        let alternating = rule(LossConfig::GilbertElliott { p: 1.0, r: 1.0, h: 0.0, k: 1.0 }, 0);
        assert_eq!(loss_share(&alternating, 1000, sent), 0.5);
        let never = LossConfig::Markov4 { p13: 0.0, p31: 0.0, p32: 0.0, p23: 0.0, p14: 0.0 };
        assert_eq!(loss_share(&rule(never, 0), 1000, sent), 0.0);
    }

    #[test]
    fn a_recording_repeats_and_links_begin_at_their_own_places() {
        let text = "0000000000000000 1111111111111111";
        let rule = rule(LossConfig::Trace { file: None, lost: Some(text.into()) }, 40);
        let on_link = |dst: u16| {
            let sent = |i| Sent { dst: AgentId(dst), ..sent(i) };
            let mut link = LinkState::new(3, &sent(0));
            let judge = |i| judge_on(&rule, &sent(i), &mut link).is_err();
            (0..64).map(judge).collect::<Vec<bool>>()
        };
        let links: Vec<Vec<bool>> = (1..9).map(on_link).collect();
        for lost in &links {
            assert_eq!(lost[..32], lost[32..]);
            assert_eq!(lost[..32].iter().filter(|&&lost| lost).count(), 16);
            assert!(lost.windows(2).filter(|w| w[0] != w[1]).count() <= 4, "one burst per round");
        }
        assert!(links.iter().any(|lost| lost != &links[0]));
    }
}
