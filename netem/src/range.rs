//! Rule 3: a maximum distance between the ends.

use crate::config::ChannelConfig;
use crate::fate::{Reason, Sent};
use crate::rule::{Case, Rule};

/// Loses messages from senders beyond the range.
pub struct Range {
    range_m: f64,
}

impl Range {
    /// `None` without a limit.
    pub fn new(channel: &ChannelConfig) -> Option<Self> {
        channel.range_m.is_finite().then_some(Self { range_m: channel.range_m })
    }
}

impl Rule for Range {
    fn judge(&self, case: &mut Case<'_>) -> Result<(), Reason> {
        if self.cuts(case.sent, 0) { Err(Reason::Range) } else { Ok(()) }
    }

    fn cuts(&self, probe: &Sent, _: u64) -> bool {
        probe.distance_m() > self.range_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fate::tests::sent;
    use crate::rule::tests::judge_alone;

    #[test]
    fn range_is_a_ball() {
        // The ends are 50 m apart.
        for (range_m, expected) in [(50.0, Ok(())), (49.9, Err(Reason::Range))] {
            let rule = Range::new(&ChannelConfig { range_m, ..Default::default() }).unwrap();
            assert_eq!(judge_alone(&rule, &sent(0)).map(|_| ()), expected);
        }
        assert!(Range::new(&ChannelConfig::default()).is_none());
    }
}
