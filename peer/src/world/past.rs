//! The counters of processes that are gone: they stay part of the mission's.

use std::collections::BTreeMap;

use csat_netem::counters::{Counters, LinkCounters};
use csat_netem::fate::Reason;
use csat_netem::link::LinkId;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::report::StepReport;
use crate::wire::refusals;

/// The counters of an agent's processes that are gone.
#[derive(Debug, Default)]
pub struct PastProcesses {
    /// What the links to them did.
    pub counters: Counters,
    /// How many frames they handed to their agents.
    pub frames: u64,
    /// How many samples they refused, by kind.
    pub refused: BTreeMap<String, u64>,
    links: BTreeMap<LinkId, LinkCounters>,
}

impl PastProcesses {
    /// Takes the counters out of the last report of a process that is gone.
    pub fn add<R: Serialize + DeserializeOwned>(&mut self, report: &mut StepReport<R>) {
        let links = std::mem::take(&mut report.links);
        self.add_links(std::mem::take(&mut report.counters), links);
        self.frames += std::mem::take(&mut report.header.frames);
        refusals::add(&mut self.refused, &std::mem::take(&mut report.header.refused));
    }

    /// Messages that were on their way to the process are lost.
    fn add_links(&mut self, mut counters: Counters, links: Vec<(LinkId, LinkCounters)>) {
        counters.lose_in_flight(Reason::Outage);
        self.counters.add(&counters);
        for (id, mut link) in links {
            link.counts.lose_in_flight(Reason::Outage);
            self.links.entry(id).or_default().add(&link);
        }
    }

    /// The counters of each link, with those of the present process, `now`.
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

    fn counters(sent: u64, delivered: u64) -> LinkCounters {
        let in_flight = sent - delivered;
        let counts = Counters { sent, delivered, in_flight, ..Counters::default() };
        LinkCounters { counts, bytes_delivered: 100, delay_s: 0.5, distance_m: 0.0 }
    }

    #[test]
    fn links_of_processes_that_are_gone_are_counted_on() {
        let mut past = PastProcesses::default();
        let all = Counters { sent: 12, delivered: 10, in_flight: 2, ..Counters::default() };
        past.add_links(all, vec![(link(0), counters(7, 5)), (link(1), counters(5, 5))]);
        let links = past.with(&[(link(0), counters(4, 3))]);
        let counts = Counters {
            sent: 11,
            delivered: 8,
            in_flight: 1,
            dropped: [(Reason::Outage, 2)].into(),
            ..Counters::default()
        };
        let expected = LinkCounters { counts, bytes_delivered: 200, delay_s: 1.0, distance_m: 0.0 };
        assert_eq!(links[&link(0)], expected);
        assert_eq!(links[&link(1)], counters(5, 5));
        assert!(past.counters.conserved() && links.values().all(|link| link.counts.conserved()));
        assert_eq!((past.counters.in_flight, past.counters.dropped[&Reason::Outage]), (0, 2));
    }
}
