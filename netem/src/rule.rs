//! What a rule is, and the rules of a channel in their order.

use std::sync::Arc;

use csat_proto::ids::ChannelId;
use csat_proto::time::SimTime;

use crate::chain::MarkovChain;
use crate::config::{ChannelConfig, NetemConfig};
use crate::delay::{Delay, Scores};
use crate::draw::{Block, Draws};
use crate::fate::{Reason, Sent, after};
use crate::jam::Jamming;
use crate::loss::{Loss, LossState};
use crate::outage::SourceOutage;
use crate::partition::Partitions;
use crate::propagation::{Obstruction, Propagation, Shadowing};
use crate::range::Range;
pub use crate::rate::Departure;
use crate::repeat::{Corruption, Duplication};

/// A rule of a channel. A rule holds parameters only; state that changes from message to message is in
/// [`LinkState`], so that parameters can be replaced at any time.
pub trait Rule: Send + Sync {
    /// Writes the effects of the rule on the message into `case`, or returns why the message is lost.
    ///
    /// # Errors
    /// The reason of the loss.
    fn judge(&self, case: &mut Case<'_>) -> Result<(), Reason>;

    /// Whether the rule cuts the link of `probe`, a message that nobody sends, in a mission of `seed`: for rules
    /// about times and places. A rule that makes a loss likely there cuts what it loses more often than not.
    /// It draws none of the probe's random numbers. Rules of chance cut nothing.
    fn cuts(&self, _probe: &Sent, _seed: u64) -> bool {
        false
    }
}

/// A message that the rules judge, and the effects of the rules so far.
pub struct Case<'a> {
    /// The message.
    pub sent: &'a Sent,
    /// Its random numbers.
    pub(crate) block: Block,
    /// The state of its link.
    pub(crate) link: &'a mut LinkState,
    /// When it leaves the sender's queue; the same for all receivers.
    pub departure: Departure,
    /// Whether it arrives damaged.
    pub corrupted: bool,
    /// Whether it arrives twice.
    pub duplicated: bool,
    /// Seconds until it arrives, and until its copy does.
    pub delays_s: [f64; 2],
}

impl<'a> Case<'a> {
    /// A message before the first rule, with the state of its link; `departure` is when it leaves the
    /// sender's queue.
    pub fn new(sent: &'a Sent, link: &'a mut LinkState, departure: Departure) -> Self {
        let block = *link.draws.block(sent.sequence);
        Self {
            sent,
            block,
            link,
            departure,
            corrupted: false,
            duplicated: false,
            delays_s: [0.0; 2],
        }
    }

    /// When the message leaves its sender's queue.
    pub(crate) fn departs(&self) -> SimTime {
        match self.departure {
            Departure::After(seconds) => after(self.sent.time, seconds),
            Departure::Dropped => self.sent.time,
        }
    }
}

/// The state of a link for one incarnation of its sender. It can be computed again from the seed.
#[derive(Debug, Clone)]
pub struct LinkState {
    /// The seed of the run.
    pub(crate) seed: u64,
    /// The random numbers of its messages.
    pub(crate) draws: Draws,
    /// The chain of its losses.
    pub(crate) loss: MarkovChain<LossState>,
    /// The chain of its delays.
    pub(crate) delay: MarkovChain<Scores>,
    /// The shadowing at the latest cells of its ends.
    pub(crate) shadowing: Option<Shadowing>,
    /// Random bits of this link, the same for all incarnations.
    pub(crate) own_bits: u64,
}

impl LinkState {
    /// The state of the link of `sent` before its first message.
    pub fn new(seed: u64, sent: &Sent) -> Self {
        Self {
            seed,
            draws: Draws::of_messages(seed, sent),
            loss: MarkovChain::default(),
            delay: MarkovChain::default(),
            shadowing: None,
            own_bits: crate::draw::of_link(seed, sent),
        }
    }
}

/// The rules of one channel, in the order of docs/links.md, without those that have no effect. The
/// receiver's outage is not among them: [`crate::link::Links`] checks it for each copy when it arrives.
pub fn rules(
    config: &NetemConfig,
    id: ChannelId,
    channel: &ChannelConfig,
    obstruction: Option<&Arc<dyn Obstruction>>,
) -> Vec<Box<dyn Rule>> {
    let jamming = Jamming::new(config, id);
    let all: [Option<Box<dyn Rule>>; 10] = [
        boxed(SourceOutage::new(config)),
        boxed(Partitions::new(config)),
        boxed(Range::new(channel)),
        boxed(Propagation::new(channel, obstruction)),
        boxed(jamming),
        boxed(Loss::new(channel)),
        boxed(Corruption::new(channel)),
        boxed(Duplication::new(channel)),
        boxed(Some(crate::rate::Queue)),
        boxed(Delay::new(channel)),
    ];
    all.into_iter().flatten().collect()
}

fn boxed<R: Rule + 'static>(rule: Option<R>) -> Option<Box<dyn Rule>> {
    rule.map(|rule| Box::new(rule) as Box<dyn Rule>)
}

/// Applies the rules in order; the first rule that loses the message gives the reason. A message that
/// is lost after it was duplicated is lost together with its copy.
///
/// # Errors
/// The reason of the loss.
pub fn judge(rules: &[Box<dyn Rule>], case: &mut Case<'_>) -> Result<(), Reason> {
    rules.iter().try_for_each(|rule| rule.judge(case))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The verdict of one rule on a message of a new link.
    pub(crate) fn judge_alone(
        rule: &dyn Rule,
        sent: &Sent,
    ) -> Result<(bool, bool, [f64; 2]), Reason> {
        judge_on(rule, sent, &mut LinkState::new(3, sent))
    }

    /// The verdict of one rule on a message of a link.
    pub(crate) fn judge_on(
        rule: &dyn Rule,
        sent: &Sent,
        link: &mut LinkState,
    ) -> Result<(bool, bool, [f64; 2]), Reason> {
        let mut case = Case::new(sent, link, Departure::After(0.0));
        rule.judge(&mut case)?;
        Ok((case.corrupted, case.duplicated, case.delays_s))
    }

    /// The share of messages 0..n of one link that a rule loses.
    pub(crate) fn loss_share(rule: &dyn Rule, n: u64, sent: impl Fn(u64) -> Sent) -> f64 {
        let mut link = LinkState::new(3, &sent(0));
        let lost = (0..n).filter(|&i| judge_on(rule, &sent(i), &mut link).is_err()).count();
        lost as f64 / n as f64
    }
}
