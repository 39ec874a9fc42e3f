//! Rule 1: during an outage an agent neither sends nor receives.

use csat_proto::ids::AgentId;
use csat_proto::time::SimTime;

use crate::config::{NetemConfig, OutageKind};
use crate::fate::{Reason, Sent};
use crate::rule::{Case, Rule};

/// A span of time: its first instant belongs to it, its end does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TimeSpan {
    from: SimTime,
    until: SimTime,
}

impl TimeSpan {
    /// From `from_s` to before `until_s`, seconds; infinity is the last instant of [`SimTime`].
    pub(crate) fn new(from_s: f64, until_s: f64) -> Self {
        Self { from: SimTime::from_seconds(from_s), until: SimTime::from_seconds(until_s) }
    }

    /// Whether any instant from `first` to `last` is in it.
    fn meets(&self, first: SimTime, last: SimTime) -> bool {
        self.contains(last) || (self.from <= last && self.until > first)
    }

    /// Whether `time` is in it.
    pub(crate) fn contains(&self, time: SimTime) -> bool {
        self.from <= time && (time < self.until || self.until == SimTime(u64::MAX))
    }
}

/// When each agent has an outage.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Outages(Vec<(AgentId, TimeSpan, OutageKind)>);

impl Outages {
    /// The outages of a scenario; a crash is one too.
    pub fn new(config: &NetemConfig) -> Self {
        let outages = config.outage.iter();
        Self(
            outages
                .map(|o| (AgentId(o.agent), TimeSpan::new(o.from_s, o.until_s), o.kind))
                .collect(),
        )
    }

    /// Whether `agent` has an outage at `time`.
    pub fn is_out(&self, agent: AgentId, time: SimTime) -> bool {
        self.0.iter().any(|(out, span, _)| *out == agent && span.contains(time))
    }

    /// Whether a message that `agent` sent at `sent` cannot leave at `departs`: its radio is off, or
    /// the message waited in a queue that was lost in a crash.
    fn silence(&self, agent: AgentId, sent: SimTime, departs: SimTime) -> bool {
        self.0.iter().any(|(out, span, kind)| {
            let is_silent = match kind {
                OutageKind::Radio => span.contains(departs),
                OutageKind::Crash => span.meets(sent, departs),
            };
            *out == agent && is_silent
        })
    }
}

/// Loses messages that would leave an agent during its outage; those that left before are in flight.
pub struct SourceOutage(Outages);

impl SourceOutage {
    /// `None` without outages.
    pub fn new(config: &NetemConfig) -> Option<Self> {
        (!config.outage.is_empty()).then(|| Self(Outages::new(config)))
    }
}

impl Rule for SourceOutage {
    fn judge(&self, case: &mut Case<'_>) -> Result<(), Reason> {
        let is_silent = self.0.silence(case.sent.src, case.sent.time, case.departs());
        if is_silent { Err(Reason::Outage) } else { Ok(()) }
    }

    fn cuts(&self, probe: &Sent, _: u64) -> bool {
        self.0.is_out(probe.src, probe.time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{OutageConfig, OutageKind};
    use crate::fate::tests::sent;
    use crate::rule::tests::judge_alone;

    #[test]
    fn outages_have_a_first_instant_and_end_before_the_last() {
        let outage = |agent, from_s, until_s, kind| OutageConfig { agent, from_s, until_s, kind };
        let config = NetemConfig {
            outage: vec![
                outage(0, 1.0, 2.0, OutageKind::Radio),
                outage(1, 5.0, f64::INFINITY, OutageKind::Crash),
                outage(2, 5.0, 6.0, OutageKind::Crash),
            ],
            ..Default::default()
        };
        let outages = Outages::new(&config);
        let out = |agent, time| outages.is_out(AgentId(agent), SimTime(time));
        assert!(!out(0, 999_999) && out(0, 1_000_000) && out(0, 1_999_999) && !out(0, 2_000_000));
        assert!(!out(1, 1_500_000) && out(1, 5_000_000) && out(1, u64::MAX) && !out(2, 1_500_000));

        let rule = SourceOutage::new(&config).unwrap();
        assert_eq!(judge_alone(&rule, &sent(0)), Err(Reason::Outage));
        let later = Sent { time: SimTime::from_seconds(2.0), ..sent(0) };
        assert!(judge_alone(&rule, &later).is_ok());
        let silence =
            |agent, sent, departs| outages.silence(AgentId(agent), SimTime(sent), SimTime(departs));
        assert!(silence(0, 0, 1_500_000), "it waited until the radio was off");
        assert!(!silence(0, 0, 2_000_000), "it waited until the radio was on again");
        assert!(silence(1, 0, 9_000_000) && silence(1, 0, u64::MAX) && !silence(1, 0, 4_999_999));
        assert!(silence(2, 0, 9_000_000), "the queue of its first incarnation is lost");
        assert!(!silence(2, 6_000_000, 9_000_000), "it is alive again");
        // The receiver's outage counts when the message arrives, not when it is sent.
        let to_the_dead = Sent { src: AgentId(2), dst: AgentId(0), ..sent(0) };
        assert!(judge_alone(&rule, &to_the_dead).is_ok());
    }
}
