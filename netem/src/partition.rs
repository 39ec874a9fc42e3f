//! Rule 2: groups of agents that cannot hear each other, from one time to another.

use csat_proto::ids::AgentId;
use csat_proto::time::SimTime;

use crate::config::NetemConfig;
use crate::fate::{Reason, Sent};
use crate::outage::TimeSpan;
use crate::rule::{Case, Rule};

/// All partitions. A message is judged when it is sent: one in flight survives a partition that
/// begins later.
pub struct Partitions(Vec<Partition>);

struct Partition {
    span: TimeSpan,
    one_way: bool,
    /// The group of each agent that is in one, by agent.
    groups: Vec<(AgentId, usize)>,
}

impl Partitions {
    /// `None` without partitions.
    pub fn new(config: &NetemConfig) -> Option<Self> {
        let partitions = config.partition.iter().map(|partition| {
            let members = partition.groups.iter().enumerate();
            let mut groups: Vec<(AgentId, usize)> = members
                .flat_map(|(g, group)| group.iter().map(move |&a| (AgentId(a), g)))
                .collect();
            groups.sort_unstable();
            let span = TimeSpan::new(partition.from_s, partition.until_s);
            Partition { span, one_way: partition.one_way, groups }
        });
        (!config.partition.is_empty()).then(|| Self(partitions.collect()))
    }

    fn separates(&self, sent: &Sent) -> bool {
        self.0.iter().any(|partition| partition.separates(sent.src, sent.dst, sent.time))
    }
}

impl Partition {
    fn group_of(&self, agent: AgentId) -> Option<usize> {
        let index = self.groups.binary_search_by_key(&agent, |&(member, _)| member).ok()?;
        Some(self.groups[index].1)
    }

    fn separates(&self, src: AgentId, dst: AgentId, time: SimTime) -> bool {
        let (Some(from), Some(to)) = (self.group_of(src), self.group_of(dst)) else { return false };
        let apart = if self.one_way { from < to } else { from != to };
        apart && self.span.contains(time)
    }
}

impl Rule for Partitions {
    fn judge(&self, case: &mut Case<'_>) -> Result<(), Reason> {
        if self.separates(case.sent) { Err(Reason::Partition) } else { Ok(()) }
    }

    fn cuts(&self, probe: &Sent, _: u64) -> bool {
        self.separates(probe)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::PartitionConfig;
    use crate::fate::tests::sent;
    use crate::rule::tests::judge_alone;

    fn hears(one_way: bool, src: u16, dst: u16, time_s: f64) -> bool {
        let partition = PartitionConfig {
            from_s: 10.0,
            until_s: 20.0,
            groups: vec![vec![3, 0], vec![1, 2]],
            one_way,
        };
        let config = NetemConfig { partition: vec![partition], ..Default::default() };
        let time = SimTime::from_seconds(time_s);
        let message = Sent { src: AgentId(src), dst: AgentId(dst), time, ..sent(0) };
        judge_alone(&Partitions::new(&config).unwrap(), &message).is_ok()
    }

    #[test]
    fn groups_are_apart_for_a_time() {
        for (src, dst) in [(0, 1), (1, 0), (3, 2), (2, 3)] {
            assert!(!hears(false, src, dst, 10.0));
            assert!(hears(false, src, dst, 9.999) && hears(false, src, dst, 20.0));
        }
        for (src, dst) in [(0, 3), (2, 1), (0, 4), (4, 1), (4, 5)] {
            assert!(hears(false, src, dst, 15.0), "{src} {dst}");
        }
    }

    #[test]
    fn one_way_loses_only_from_earlier_groups_to_later_ones() {
        assert!(!hears(true, 0, 1, 15.0) && !hears(true, 3, 2, 15.0));
        assert!(hears(true, 1, 0, 15.0) && hears(true, 2, 3, 15.0) && hears(true, 0, 3, 15.0));
    }
}
