//! One rule, one verdict; the rules of a channel in their order.

use std::sync::Arc;

use csat_proto::ids::ChannelId;
use csat_proto::time::SimTime;

pub use crate::fate::{Delivery, Fate, Reason};

use crate::chain::Chain;
use crate::config::{ChannelConfig, NetemConfig};
use crate::delay::{Delay, Scores};
use crate::draw::{Block, Draws};
use crate::fate::{Sent, after};
use crate::jam::Jamming;
use crate::loss::{Loss, LossState};
use crate::outage::SourceOutage;
use crate::partition::Partitions;
use crate::propagation::{Obstruction, Propagation, Shadowing};
use crate::range::Range;
use crate::rate::Departure;
use crate::repeat::{Corruption, Duplication};

/// A rule of a channel: parameters only. What changes from message to message lives in
/// [`LinkState`], so that parameters may be replaced at any time.
pub trait Rule: Send + Sync {
    /// Writes what it does to the message into `case`, or says why the message is lost.
    ///
    /// # Errors
    /// The reason of the loss.
    fn judge(&self, case: &mut Case<'_>) -> Result<(), Reason>;
}

/// A message before the rules, and what they made of it so far.
pub struct Case<'a> {
    /// The message.
    pub sent: &'a Sent,
    /// Its random numbers.
    pub block: Block,
    /// What its link remembers.
    pub link: &'a mut LinkState,
    /// When it leaves the sender's queue: the same for all receivers.
    pub departure: Departure,
    /// Whether it arrives damaged.
    pub corrupted: bool,
    /// Whether it arrives twice.
    pub duplicated: bool,
    /// Seconds until it arrives, and until its copy does.
    pub delays_s: [f64; 2],
}

impl Case<'_> {
    /// When the message leaves its sender, as far as that depends on the queue.
    pub(crate) fn departs(&self) -> SimTime {
        match self.departure {
            Departure::After(seconds) => after(self.sent.time, seconds),
            Departure::Dropped => self.sent.time,
        }
    }
}

/// What one life of a link remembers. All of it can be computed again from the seed.
#[derive(Debug, Clone)]
pub struct LinkState {
    /// The seed of the run.
    pub seed: u64,
    /// The random numbers of its messages.
    pub draws: Draws,
    /// Where its losses are.
    pub loss: Chain<LossState>,
    /// Where its delays are.
    pub delay: Chain<Scores>,
    /// The shadowing at the latest place.
    pub shadowing: Option<Shadowing>,
    /// What distinguishes it from other links in all its lives.
    pub own_bits: u64,
}

impl LinkState {
    /// The link that `sent` passes, before its first message.
    pub fn new(seed: u64, sent: &Sent) -> Self {
        Self {
            seed,
            draws: Draws::of_messages(seed, sent),
            loss: Chain::default(),
            delay: Chain::default(),
            shadowing: None,
            own_bits: crate::draw::of_link(seed, sent),
        }
    }
}

/// The rules of one channel, in the order of docs/links.md; those that can do nothing are left
/// out. The receiver's outage is not here: it is asked last, for each copy when it arrives.
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

/// Asks the rules in order; the first one that loses the message names the reason. A message that
/// is lost after it was duplicated is lost with its copy.
///
/// # Errors
/// The reason of the loss.
pub fn judge(rules: &[Box<dyn Rule>], case: &mut Case<'_>) -> Result<(), Reason> {
    rules.iter().try_for_each(|rule| rule.judge(case))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// What one rule makes of a message on a fresh link.
    pub(crate) fn judge_alone(
        rule: &dyn Rule,
        sent: &Sent,
    ) -> Result<(bool, bool, [f64; 2]), Reason> {
        judge_on(rule, sent, &mut LinkState::new(3, sent))
    }

    /// What one rule makes of a message on a link.
    pub(crate) fn judge_on(
        rule: &dyn Rule,
        sent: &Sent,
        link: &mut LinkState,
    ) -> Result<(bool, bool, [f64; 2]), Reason> {
        let block = *link.draws.block(sent.sequence);
        let mut case = Case {
            sent,
            block,
            link,
            departure: Departure::After(0.0),
            corrupted: false,
            duplicated: false,
            delays_s: [0.0; 2],
        };
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
