//! The numbers of a run that reports and comparisons show first.

use csat_mission::measures::{Level, Milestone, Plot};
use csat_mission::mission::Kind;

use super::record::{RunRecord, kind_of};

/// What is drawn of a run.
#[derive(Debug, Clone, Copy)]
pub struct Metric {
    /// Its key in `sweep.csv`.
    pub key: &'static str,
    /// How it is drawn.
    pub plot: Plot,
}

/// Share of the messages that arrived, per cent.
pub const DELIVERED: &str = "messages.delivered_pct";

/// What runs of any mission have.
const COMMON: [Metric; 3] = [
    Metric {
        key: "bytes_sent",
        plot: Plot::less("Bytes sent by all agents", "bytes sent", "bytes")
            .note("Each message once, however many hear it."),
    },
    Metric {
        key: DELIVERED,
        plot: Plot::more("Messages that arrived", "delivered, %", "% of those sent")
            .up_to(100.0)
            .note("Per receiver."),
    },
    Metric {
        key: "violations",
        plot: Plot::less("Violations of what is guaranteed", "violations", "count")
            .note("Any other value than 0 is a fault of the program."),
    },
];

/// Everything that is drawn of a kind of mission, if the runs have it: first what people ask for first.
pub fn metrics(kind: &Kind) -> Vec<Metric> {
    let plotted = kind.plotted().filter_map(|c| c.plot.map(|plot| Metric { key: c.key, plot }));
    let milestones = kind.milestones.iter().map(|m| Metric { key: m.restricted, plot: m.plot });
    plotted.chain(milestones).chain(COMMON).collect()
}

/// Everything that is drawn of several kinds of missions.
pub fn metrics_of(kinds: impl IntoIterator<Item = &'static Kind>) -> Vec<Metric> {
    let mut all: Vec<Metric> = Vec::new();
    for metric in kinds.into_iter().flat_map(metrics) {
        if all.iter().all(|known| known.key != metric.key) {
            all.push(metric);
        }
    }
    // What any mission has comes last.
    all.sort_by_key(|metric| COMMON.iter().any(|common| common.key == metric.key));
    all
}

/// The milestone of a run whose restricted time has this key.
pub fn milestone(record: &RunRecord, key: &str) -> Option<&'static Milestone> {
    kind_of(record)?.milestones.iter().find(|milestone| milestone.restricted == key)
}

/// A number of a run, those that follow from its summary included.
pub fn metric(record: &RunRecord, key: &str) -> Option<f64> {
    if key == DELIVERED {
        let sent = record.number("messages.sent").filter(|sent| *sent > 0.0)?;
        return Some(100.0 * record.number("messages.delivered")? / sent);
    }
    match milestone(record, key) {
        // A fleet that has nothing to find finds it neither in time nor late.
        Some(m) if m.level == Level::Targets && record.number("targets") == Some(0.0) => None,
        Some(milestone) => record.number(milestone.key).or_else(|| record.number("sim_s")),
        None => record.number(key),
    }
}

/// Whether a run never reached the milestone whose restricted time has this key.
pub fn is_open(record: &RunRecord, key: &str) -> bool {
    milestone(record, key).is_some_and(|milestone| record.number(milestone.key).is_none())
}
