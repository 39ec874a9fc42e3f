//! `summary.json`: a mission in numbers.

use std::collections::BTreeMap;

use csat_mission::measures::{Column, Level};
use csat_mission::mission::Kind;
use csat_world::truth::CheckCounts;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::scenario::missions::kind;
use crate::station::StationSummary;
use crate::timing::TimingSummary;
use crate::values::{Numbers, in_words};
use csat_mission::fleet::Frames;
use csat_mission::words::named;

/// A mission in numbers. Outside checks rely on these keys.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// The kind of mission.
    #[serde(default = "first_kind")]
    pub mission: String,
    /// Name of the scenario.
    pub scenario: String,
    /// Its seed.
    pub seed: u64,
    /// N^u.
    pub agents: u16,
    /// N^t.
    pub targets: u16,
    /// Whether its setting is that of the thesis's missions under `str3`, κ = 1, so that its numbers may be
    /// set beside the published ones.
    #[serde(default)]
    pub thesis_setting: bool,
    /// Steps flown.
    pub steps: u32,
    /// Whether the user ended the run early.
    pub interrupted: bool,
    /// Failures of what is promised, found from outside.
    pub violations: u64,
    /// Of how many checks.
    #[serde(default)]
    pub checks: u64,
    /// Reports of agents that came too late to be checked: in real time only.
    #[serde(default)]
    pub unchecked: u64,
    /// Checks and violations by promise.
    #[serde(default)]
    pub checked: CheckCounts,
    /// Sets of honest agents that turned out empty: an assumption failed or an agent sent false facts.
    pub inconsistencies: u64,
    /// The agents that honest ones named as liars, by index; none if there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub liars: Vec<NamedLiar>,
    /// The mission's own numbers: values at the end, milestones, and means over the second half of the mission
    /// and over the UAVs.
    #[serde(flatten)]
    pub numbers: Numbers,
    /// The means over the UAVs at the last step.
    #[serde(rename = "final")]
    pub last: Numbers,
    /// What the ground stations knew, none if there are none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stations: Vec<StationSummary>,
    /// What became of each agent's frames, by index, stations last: in real time slow agents miss some. A
    /// station has no frames, but the steps that it was told of.
    #[serde(default)]
    pub frames: Vec<Frames>,
    /// What the processes of a fleet did not believe of what was said to them, by kind; empty unless a
    /// stranger, or a simulator that is at fault, speaks on their keys.
    #[serde(default)]
    pub refused: BTreeMap<String, u64>,
    /// What became of the messages.
    pub messages: Messages,
    /// Bytes that agents sent, each message once however many hear it.
    pub bytes_sent: u64,
    /// What an agent-step takes.
    pub timing_ms: TimingSummary,
    /// What the run took, seconds.
    pub wall_s: f64,
    /// What it simulated, seconds.
    pub sim_s: f64,
    /// sim_s / wall_s.
    pub realtime_factor: f64,
    /// Hash of every agent's state at every step, hexadecimal: equal digests mean equal runs.
    pub digest: String,
}

impl Summary {
    /// Checks that `value` is a summary.
    ///
    /// # Errors
    /// What it lacks, or has otherwise.
    pub fn check(value: &Value) -> Result<(), String> {
        let summary = Self::deserialize(value).map_err(|e| format!("its summary is none: {e}"))?;
        let columns = kind(&summary.mission).map_or(&[][..], |kind| kind.columns);
        for key in columns.iter().filter(|column| column.in_summary).map(|column| column.key) {
            for (path, value) in [("", value), ("final.", &value["final"])] {
                let complaint = match value.get(key) {
                    Some(Value::Null | Value::Number(_)) => continue,
                    Some(got) => format!("`{path}{key}` is {got}, expected a number or null"),
                    None => format!("it has no `{path}{key}`"),
                };
                return Err(format!("its summary is none: {complaint}"));
            }
        }
        Ok(())
    }
}

/// The mission of summaries from before there were several.
pub const FIRST: &str = "set-membership";

fn first_kind() -> String {
    FIRST.to_owned()
}

/// An agent that honest ones have proven to have said something false.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedLiar {
    /// Its index.
    pub agent: u16,
    /// When it was named first, seconds.
    pub first_s: f64,
    /// By which agents, the first ones first.
    pub named_by: Vec<u16>,
}

impl NamedLiar {
    /// Notes that `by` named `agent` at `time_s`, seconds. An agent that crashed names it again.
    pub fn note(all: &mut Vec<Self>, agent: u16, by: u16, time_s: f64) {
        let index = all.binary_search_by_key(&agent, |liar| liar.agent).unwrap_or_else(|index| {
            all.insert(index, Self { agent, first_s: time_s, named_by: Vec::new() });
            index
        });
        let named_by = &mut all[index].named_by;
        if !named_by.contains(&by) {
            named_by.push(by);
        }
    }
}

/// What became of the messages, per receiver.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Messages {
    /// Messages on their way to a receiver: one to three others counts three.
    pub sent: u64,
    /// Of those, how many arrived.
    pub delivered: u64,
    /// Of those, how many were lost, by reason.
    pub dropped: BTreeMap<String, u64>,
    /// Extra copies that the links made.
    pub duplicated: u64,
    /// Of what arrived, how many were damaged on the way: the receivers' checksums drop them.
    pub corrupted: u64,
    /// Still on their way at the end: sent + duplicated = delivered + dropped + in flight.
    pub in_flight: u64,
    /// Of what arrived, how many were not believed, by reason.
    pub rejected: BTreeMap<String, u64>,
    /// Agent-steps that were not told of because nothing fitted the budget.
    pub withheld: u64,
}

impl Summary {
    /// As JSON.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("a summary is JSON") + "\n"
    }

    /// In a few lines for a person.
    pub fn describe(&self) -> String {
        let ended = if self.interrupted { ", ended early by the user" } else { "" };
        let kind = kind(&self.mission);
        let headline = kind.map(|kind| self.headline(kind)).unwrap_or_default();
        let means = kind.map(|kind| self.means(kind)).unwrap_or_default();
        let stations = self.stations.iter().map(|s| s.describe(kind, self.targets));
        format!(
            "{} seed {}: {} s flown in {:.1} s ({:.1}x real time){ended}\n\
             {headline}violations {}, inconsistencies {}\n{means}\
             messages by receiver: {}; {:.2} MB said; digest {}{}{}",
            self.scenario,
            self.seed,
            self.sim_s,
            self.wall_s,
            self.realtime_factor,
            self.violations_of_checks(),
            self.inconsistencies,
            self.messages.describe(),
            self.bytes_sent as f64 / 1e6,
            self.digest,
            self.named() + &stations.collect::<String>() + &self.missed(),
            self.refused(),
        )
    }

    /// What the mission had reached at the end, and when: `identified 8/8 (all after 93 s), `.
    fn headline(&self, kind: &Kind) -> String {
        let reached = |column: &Column| {
            let value = self.numbers.get(column.last_as?)?;
            let number = in_words(column, Some(value), self.targets);
            Some(format!("{} {number}{}, ", column.name, self.milestones(kind, column.key)))
        };
        let columns = kind.headline.iter().filter_map(|key| kind.column(key));
        // Those that are plotted stand in the next lines.
        let unsaid = |column: &&Column| column.is_flag && column.plot.is_none();
        let flags = kind.columns.iter().filter(unsaid).filter(|column| self.is_set(column));
        let flags = flags.map(|column| format!("{}, ", column.name));
        columns.filter_map(reached).chain(flags).collect()
    }

    /// Whether a flag was set at the end: `lost, `.
    fn is_set(&self, column: &Column) -> bool {
        column.last_as.and_then(|key| self.numbers.get(key)).is_some_and(|value| value >= 0.5)
    }

    /// When a column reached what: ` (all after 93 s)`.
    fn milestones(&self, kind: &Kind, column: &str) -> String {
        let milestones = kind.milestones.iter().filter(|milestone| milestone.fleet == column);
        let told = milestones.map(|m| match self.numbers.get(m.key) {
            Some(time_s) => format!(" ({} after {time_s} s)", m.name),
            None if m.level == Level::Targets && self.targets == 0 => " (no targets)".to_owned(),
            None => format!(" (not {})", m.name),
        });
        told.collect()
    }

    /// A line of the values at the end and one of the means over the second half that sweeps show.
    fn means(&self, kind: &Kind) -> String {
        let [means, ends] = [true, false].map(|is_mean| self.shown(kind, is_mean));
        let line = |(when, shown): (&str, String)| match shown.is_empty() {
            true => String::new(),
            false => format!("{when}: {shown}\n"),
        };
        [("at the end", ends), ("second half", means)].map(line).concat()
    }

    /// The means over the second half, or else the values at the end, that sweeps show.
    fn shown(&self, kind: &Kind, is_mean: bool) -> String {
        let value = |column: &Column| {
            let value = self.numbers.get(column.key);
            format!("{} {}", column.name, in_words(column, value, self.targets))
        };
        let shown = kind.plotted().filter(|column| column.in_summary == is_mean).map(value);
        shown.collect::<Vec<String>>().join(", ")
    }

    /// How many of the checks failed, and how many reports could not be checked.
    fn violations_of_checks(&self) -> String {
        let Self { violations, checks, unchecked, .. } = self;
        let unchecked = match unchecked {
            0 => String::new(),
            n => format!(" ({n} reports came too late to be checked)"),
        };
        format!("{violations} of {checks} checks{unchecked}")
    }

    /// A line for each agent that was named as a liar.
    fn named(&self) -> String {
        let line = |NamedLiar { agent, first_s, named_by }: &NamedLiar| {
            let by = named(named_by.iter().copied(), self.agents);
            format!(
                "\n{} named as a liar by {by}, first at {first_s} s",
                named([*agent], self.agents)
            )
        };
        self.liars.iter().map(line).collect()
    }

    /// A line for each agent that missed frames, and when nothing was heard of it.
    fn missed(&self) -> String {
        let slow = self.frames.iter().enumerate().filter(|(_, frames)| frames.missed > 0);
        let line = |(agent, Frames { shown, missed, silent_s }): (usize, &Frames)| {
            let spans = silent_s.iter().map(|[from, to]| format!(" from {from} s to {to} s"));
            let spans: Vec<String> = spans.collect();
            let silent = if spans.is_empty() { "" } else { ", silent" };
            let frames = if agent < usize::from(self.agents) { "frames" } else { "steps" };
            let name = named([agent as u16], self.agents);
            format!(
                "\nwarning: {name} missed {missed} of {shown} {frames}{silent}{}",
                spans.join(" and")
            )
        };
        slow.map(line).collect()
    }

    /// A line if something was said that was not believed.
    fn refused(&self) -> String {
        if self.refused.is_empty() {
            return String::new();
        }
        let kinds = self.refused.iter().map(|(kind, count)| format!("{kind} {count}"));
        let kinds: Vec<String> = kinds.collect();
        format!(
            "\nwarning: refused what cannot be of this fleet ({}): see docs/processes.md",
            kinds.join(", ")
        )
    }
}

impl Messages {
    /// In a line that adds up: sent + duplicated = delivered + dropped + in flight.
    fn describe(&self) -> String {
        let by_reason = |counts: &BTreeMap<String, u64>| {
            let reasons: Vec<String> =
                counts.iter().map(|(reason, n)| format!("{reason} {n}")).collect();
            (counts.values().sum::<u64>(), reasons.join(", "))
        };
        let mut text = format!("{} sent", self.sent);
        if self.duplicated > 0 {
            text += &format!(" + {} duplicated", self.duplicated);
        }
        text += &format!(", {} delivered", self.delivered);
        if let (sum @ 1.., reasons) = by_reason(&self.rejected) {
            text += &format!(" ({sum} not believed: {reasons}; see csat.log)");
        }
        if let (sum @ 1.., reasons) = by_reason(&self.dropped) {
            text += &format!(", {sum} dropped ({reasons})");
        }
        if self.in_flight > 0 {
            text += &format!(", {} still on their way", self.in_flight);
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::summary as sample;

    #[test]
    fn what_is_set_at_the_end_is_said() {
        let mut summary = sample();
        summary.mission = "clearing".to_owned();
        assert!(!summary.describe().contains("stalled"));
        summary.numbers.set("stalled", Some(1.0));
        summary.numbers.set("lost", Some(0.0));
        let told = summary.describe();
        assert!(told.contains("stalled, violations") && !told.contains("lost,"), "{told}");
    }

    /// docs/outputs.md; whoever reads summaries relies on these names.
    #[test]
    fn every_promised_key_is_there() {
        let json: serde_json::Value = serde_json::from_str(&sample().to_json()).unwrap();
        for key in [
            "mission",
            "scenario",
            "seed",
            "agents",
            "targets",
            "thesis_setting",
            "steps",
            "violations",
            "checks",
            "unchecked",
            "checked",
            "inconsistencies",
            "identified",
            "all_identified_s",
            "unexplored_pct",
            "hidden_pct",
            "explored_pct",
            "footprint_pct",
            "ground_seen_pct",
            "localization_error_m",
            "target_radius_m",
            "oem_iou_pct",
            "final",
            "frames",
            "refused",
            "messages",
            "bytes_sent",
            "timing_ms",
            "wall_s",
            "sim_s",
            "realtime_factor",
            "digest",
            "interrupted",
        ] {
            assert!(json.get(key).is_some(), "{key}");
        }
        assert_eq!(json["unexplored_pct"], 21.5);
        assert_eq!(json["final"]["unexplored_pct"], 20.0);
        assert_eq!(json["localization_error_m"], serde_json::Value::Null);
        assert_eq!(json["messages"]["dropped"]["range"], 3);
        for stage in ["render", "sense", "estimate", "fuse", "guidance"] {
            for key in ["median", "p95", "max"] {
                assert!(json["timing_ms"][stage][key].is_number(), "{stage} {key}");
            }
        }
        let back: Summary = serde_json::from_value(json).unwrap();
        assert_eq!(back, sample());
    }

    #[test]
    fn what_is_said_of_messages_adds_up() {
        let messages = Messages { duplicated: 4, in_flight: 4, ..sample().messages };
        assert_eq!(
            messages.describe(),
            "12 sent + 4 duplicated, 9 delivered, 3 dropped (range 3), 4 still on their way"
        );
        let rejected = BTreeMap::from([("checksum".to_owned(), 2), ("clock".to_owned(), 1)]);
        let doubted = Messages { rejected, ..sample().messages };
        assert_eq!(
            doubted.describe(),
            "12 sent, 9 delivered (3 not believed: checksum 2, clock 1; see csat.log), 3 dropped \
             (range 3)"
        );
    }

    #[test]
    fn a_person_reads_the_same() {
        let text = sample().describe();
        assert!(text.contains("city seed 7: 300 s flown in 12.5 s (24.0x real time)\n"), "{text}");
        assert!(
            text.contains("identified 8/8 (all after 93.5 s), violations 0 of 49000 checks, "),
            "{text}"
        );
        let late = Summary { unchecked: 12, ..sample() }.describe();
        let said = "violations 0 of 49000 checks (12 reports came too late to be checked), ";
        assert!(late.contains(said), "{late}");
        assert!(
            text.contains("12 sent, 9 delivered, 3 dropped (range 3); 1.23 MB said;"),
            "{text}"
        );
        assert!(!text.contains("missed") && !text.contains("liar"), "{text}");
        let mut liars = Vec::new();
        for (agent, by, time_s) in [(2, 3, 61.5), (1, 0, 62.0), (2, 0, 64.0), (2, 3, 99.0)] {
            NamedLiar::note(&mut liars, agent, by, time_s);
        }
        let named = Summary { liars, ..sample() }.describe();
        let expected = "\nUAV 1 named as a liar by UAV 0, first at 62 s\n\
                        UAV 2 named as a liar by UAVs 3, 0, first at 61.5 s";
        assert!(named.ends_with(expected), "{named}");
        let mut slow = sample();
        slow.frames[3].missed = 449;
        let text = slow.describe();
        assert!(text.ends_with("\nwarning: UAV 3 missed 449 of 601 frames"), "{text}");
        slow.frames[3].silent_s = vec![[12.0, 42.5], [60.0, 61.0]];
        let text = slow.describe();
        let silent = "missed 449 of 601 frames, silent from 12 s to 42.5 s and from 60 s to 61 s";
        assert!(text.ends_with(silent), "{text}");
        slow.refused = BTreeMap::from([("frame".into(), 2), ("order".into(), 1)]);
        assert!(slow.describe().contains("\nwarning: refused what cannot be"), "{slow:?}");
        assert!(slow.describe().contains("(frame 2, order 1)"), "{slow:?}");
        assert!(!text.contains("station"), "{text}");
        slow.stations = vec![crate::station::tests::sample()];
        slow.refused = BTreeMap::new();
        slow.frames = vec![Frames { shown: 601, ..Frames::default() }; 5];
        slow.frames[4].missed = 2;
        let text = slow.describe();
        let expected = "messages reached it
warning: station 4 missed 2 of 601 steps";
        assert!(text.ends_with(expected), "{text}");
        let mut early = Summary { interrupted: true, ..sample() };
        early.numbers.set("all_identified_s", None);
        let early = early.describe();
        assert!(
            early.contains("ended early by the user") && early.contains("(not all)"),
            "{early}"
        );
    }
}
