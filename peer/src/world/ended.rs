//! What the links to an agent did in processes that are gone: it stays part of the mission.

use std::collections::BTreeMap;

use csat_netem::counters::{Counters, LinkCounters};
use csat_netem::fate::Reason;
use csat_netem::link::LinkId;

/// What links did in processes that are gone.
#[derive(Debug, Default)]
pub struct Ended {
    /// All of them.
    pub all: Counters,
    /// How many frames they looked at.
    pub looked: u64,
    /// What they did not believe, by kind.
    pub refused: BTreeMap<String, u64>,
    links: BTreeMap<LinkId, LinkCounters>,
}

impl Ended {
    /// Takes over what a process that is gone told last. What was on its way to it is lost.
    pub fn bury(&mut self, mut all: Counters, links: Vec<(LinkId, LinkCounters)>) {
        all.lose_in_flight(Reason::Outage);
        self.all.add(&all);
        for (id, mut link) in links {
            link.counts.lose_in_flight(Reason::Outage);
            self.links.entry(id).or_default().add(&link);
        }
    }

    /// What each link did, with what it did in the process that is there now, by link.
    pub fn with(&self, now: &[(LinkId, LinkCounters)]) -> BTreeMap<LinkId, LinkCounters> {
        let mut links = self.links.clone();
        for (id, link) in now {
            links.entry(*id).or_default().add(link);
        }
        links
    }
}

#[cfg(test)]
mod tests {
    use csat_proto::ids::{AgentId, ChannelId};

    use super::*;

    fn link(src: u16) -> LinkId {
        (AgentId(src), AgentId(9), ChannelId(0))
    }

    fn told(sent: u64, delivered: u64) -> LinkCounters {
        let in_flight = sent - delivered;
        let counts = Counters { sent, delivered, in_flight, ..Counters::default() };
        LinkCounters { counts, bytes_delivered: 100, delay_s: 0.5, distance_m: 0.0 }
    }

    #[test]
    fn links_of_processes_that_are_gone_are_counted_on() {
        let mut ended = Ended::default();
        let all = Counters { sent: 12, delivered: 10, in_flight: 2, ..Counters::default() };
        ended.bury(all, vec![(link(0), told(7, 5)), (link(1), told(5, 5))]);
        let links = ended.with(&[(link(0), told(4, 3))]);
        let counts = Counters {
            sent: 11,
            delivered: 8,
            in_flight: 1,
            dropped: [(Reason::Outage, 2)].into(),
            ..Counters::default()
        };
        let expected = LinkCounters { counts, bytes_delivered: 200, delay_s: 1.0, distance_m: 0.0 };
        assert_eq!(links[&link(0)], expected);
        assert_eq!(links[&link(1)], told(5, 5));
        assert!(ended.all.conserved() && links.values().all(|link| link.counts.conserved()));
        assert_eq!((ended.all.in_flight, ended.all.dropped[&Reason::Outage]), (0, 2));
    }
}
