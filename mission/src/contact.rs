//! How well the UAVs of a mission are in touch: what is measured of every mission.
//!
//! All three values are of the UAVs that run. One that has crashed is neither heard nor missed: what is measured is
//! what radios cost, not what crashes do.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use csat_netem::link::{End, Links};
use csat_proto::camera::Pose;
use csat_proto::ids::AgentId;
use csat_proto::time::SimTime;

use crate::engine::{LifeEvent, Passage};
use crate::measures::{Column, Curve, Panel, Plot, Values};

/// The mean age of what UAVs last heard from each other.
const STALENESS: &str = "staleness_s";
/// How many pairs of UAVs have a working link.
const CONTACT: &str = "contact_pct";
/// How many groups of UAVs can tell each other everything.
const COMPONENTS: &str = "components";

const OVER_PAIRS: &str = "fleet, mean over the ordered pairs of UAVs that run";

/// The columns, in the order of `metrics.csv`.
pub const COLUMNS: &[Column] = &[
    Column::of_fleet(STALENESS, "staleness", "s")
        .defined(
            "age of what a UAV last heard from the other: time since the newest message that has arrived undamaged \
             was sent, or since the start if none has; nothing with fewer than two UAVs",
            "",
        )
        .over(OVER_PAIRS)
        .in_summary()
        .plotted(Plot::less("Age of what UAVs last heard from each other", "staleness, s", "s")),
    Column::of_fleet(CONTACT, "in contact", "%")
        .defined(
            "share of the ordered pairs of UAVs that run with a working link, in % of these pairs: no outage, \
             partition, range, propagation or jamming cuts it; nothing with fewer than two UAVs",
            "[links](links.md#working-links)",
        )
        .in_summary()
        .plotted(Plot::more("Pairs of UAVs with a working link", "in contact, %", "% of the pairs").up_to(100.0)),
    Column::of_fleet(COMPONENTS, "components", "")
        .defined(
            "groups of UAVs that run: in a group each one can reach each other over working links, directly or through \
             others of the group",
            "[links](links.md#working-links)",
        )
        .count()
        .in_summary()
        .plotted(Plot::less("Groups of UAVs connected by working links", "components", "groups")),
];

const BLUE: &str = "#0072b2";

/// The panels, after those of the mission.
pub const PANELS: &[Panel] = &[
    Panel {
        title: "Pairs of UAVs with a working link",
        live: Some("In contact"),
        unit: "%",
        axis: [100.0, 100.0],
        curves: &[Curve::new(CONTACT, "", BLUE)],
        of_stations: None,
    },
    Panel {
        title: "Age of what UAVs last heard from each other",
        live: Some("Staleness"),
        unit: "s",
        axis: [5.0, f64::INFINITY],
        curves: &[Curve::new(STALENESS, "", BLUE)],
        of_stations: None,
    },
    Panel {
        title: "Groups of UAVs connected by working links",
        live: Some("Components"),
        unit: "",
        axis: [2.0, f64::INFINITY],
        curves: &[Curve::new(COMPONENTS, "", BLUE)],
        of_stations: None,
    },
];

/// What there is to know of a step.
pub struct Moment<'a> {
    /// The instant of the step's frames.
    pub now: SimTime,
    /// The instant of the next ones: what arrives before is heard in this step.
    pub next: SimTime,
    /// Where the UAVs are, by index.
    pub poses: &'a [Pose],
    /// Which of them run, by index.
    pub alive: &'a [bool],
    /// Who crashed or was restarted.
    pub lives: &'a [(AgentId, LifeEvent)],
    /// What became of the messages of this step.
    pub passages: &'a [Passage],
}

/// Measures a run, step by step.
pub struct Contact {
    /// No message is sent over them: they are asked which links work.
    links: Links,
    heard: Heard,
}

impl Contact {
    /// Before the first step of a mission over links like `links`.
    pub fn new(links: Links) -> Self {
        Self { links, heard: Heard::default() }
    }

    /// The values of the next step.
    pub fn measure(&mut self, moment: &Moment<'_>) -> Values {
        let running: Vec<usize> =
            (0..moment.poses.len()).filter(|&uav| moment.alive[uav]).collect();
        self.heard.hear(moment);
        let network = Network::of(&self.links, moment, &running);
        vec![
            (STALENESS, self.heard.mean_age_s(moment.now, &running)),
            (CONTACT, network.contact_pct()),
            (COMPONENTS, network.components()),
        ]
    }
}

/// Sender and receiver.
type Pair = (usize, usize);

/// What each UAV last heard from each other one.
#[derive(Debug, Default)]
struct Heard {
    /// When the newest message that has arrived was sent.
    newest: BTreeMap<Pair, SimTime>,
    /// Messages under way: when they arrive and when they were sent.
    under_way: BinaryHeap<Reverse<(SimTime, SimTime, Pair)>>,
}

impl Heard {
    /// Lets arrive what arrives in a step. Whoever was restarted has heard nothing in its life.
    fn hear(&mut self, moment: &Moment<'_>) {
        for (agent, event) in moment.lives {
            if matches!(event, LifeEvent::Restarted { .. }) {
                self.newest.retain(|(_, dst), _| *dst != usize::from(agent.0));
            }
        }
        let uavs = moment.poses.len();
        for Passage { sent, fate, .. } in moment.passages {
            let pair = (usize::from(sent.src.0), usize::from(sent.dst.0));
            if pair.0 >= uavs || pair.1 >= uavs {
                continue;
            }
            let whole = fate.copies().flatten().filter(|delivery| !delivery.corrupted);
            self.under_way.extend(whole.map(|delivery| Reverse((delivery.at, sent.time, pair))));
        }
        while let Some(&Reverse((at, sent, pair))) = self.under_way.peek()
            && at < moment.next
        {
            self.under_way.pop();
            // A crashed agent reads nothing.
            if moment.alive[pair.1] {
                let newest = self.newest.entry(pair).or_default();
                *newest = sent.max(*newest);
            }
        }
    }

    /// The mean age over the ordered pairs of `running`, seconds; `None` without a pair.
    fn mean_age_s(&self, now: SimTime, running: &[usize]) -> Option<f64> {
        let pairs = running.iter().flat_map(|&a| running.iter().map(move |&b| (a, b)));
        let (mut count, mut sum_s) = (0.0, 0.0);
        for pair in pairs.filter(|(src, dst)| src != dst) {
            // The start is the first instant of all.
            let newest = self.newest.get(&pair).copied().unwrap_or_default();
            count += 1.0;
            sum_s += now.seconds_since(newest.min(now));
        }
        (count > 0.0).then(|| sum_s / count)
    }
}

/// Which links between UAVs that run work.
#[derive(Debug)]
struct Network {
    /// By sender, the receivers; both by place among those that run.
    reached: Vec<Vec<usize>>,
    /// By receiver, the senders.
    heard: Vec<Vec<usize>>,
}

impl Network {
    fn of(links: &Links, moment: &Moment<'_>, running: &[usize]) -> Self {
        let end =
            |uav: usize| End { agent: AgentId(uav as u16), p_world: moment.poses[uav].p_world };
        Self::new(running.len(), |src, dst| {
            links.works(end(running[src]), end(running[dst]), moment.now)
        })
    }

    /// Of `count` UAVs.
    fn new(count: usize, works: impl Fn(usize, usize) -> bool) -> Self {
        let mut network = Self { reached: vec![Vec::new(); count], heard: vec![Vec::new(); count] };
        for (src, dst) in (0..count).flat_map(|src| (0..count).map(move |dst| (src, dst))) {
            if src != dst && works(src, dst) {
                network.reached[src].push(dst);
                network.heard[dst].push(src);
            }
        }
        network
    }

    /// The share of the ordered pairs with a working link, per cent; `None` without a pair.
    fn contact_pct(&self) -> Option<f64> {
        let count = self.reached.len();
        let pairs = count * count.saturating_sub(1);
        let working: usize = self.reached.iter().map(Vec::len).sum();
        (pairs > 0).then(|| 100.0 * working as f64 / pairs as f64)
    }

    /// The number of groups in which each one reaches each other; `None` when nobody runs.
    fn components(&self) -> Option<f64> {
        let count = self.reached.len();
        let mut is_grouped = vec![false; count];
        let mut groups = 0u32;
        for first in 0..count {
            if is_grouped[first] {
                continue;
            }
            groups += 1;
            let (to, from) = (spread(&self.reached, first), spread(&self.heard, first));
            for (is_grouped, is_mutual) in
                is_grouped.iter_mut().zip(to.iter().zip(from).map(|(&to, from)| to && from))
            {
                *is_grouped |= is_mutual;
            }
        }
        (count > 0).then_some(f64::from(groups))
    }
}

/// Who is reached from `first`, step by step, itself included.
fn spread(next: &[Vec<usize>], first: usize) -> Vec<bool> {
    let mut is_reached = vec![false; next.len()];
    is_reached[first] = true;
    let mut open = vec![first];
    while let Some(at) = open.pop() {
        for &other in &next[at] {
            if !std::mem::replace(&mut is_reached[other], true) {
                open.push(other);
            }
        }
    }
    is_reached
}

#[cfg(test)]
#[path = "contact_tests.rs"]
mod tests;
