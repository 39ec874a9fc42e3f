//! Checks of values that have the right type and are impossible.

use std::collections::BTreeMap;

use super::judge_channel::channel;
use super::read::is_channel_name;
use super::{JammerConfig, NetemConfig, OutageConfig, OutageKind, PartitionConfig};

/// Channels are numbered in 8 bits.
const MAX_CHANNELS: usize = 256;

/// Collects (key under `netem`, what is wrong).
#[derive(Default)]
pub(super) struct Judge(Vec<(String, String)>);

impl Judge {
    /// Reports `what` under `key` unless it `holds`.
    pub(super) fn demand(&mut self, holds: bool, key: impl Into<String>, what: String) {
        if !holds {
            self.0.push((key.into(), what));
        }
    }

    /// Requires a probability.
    pub(super) fn probability(&mut self, key: String, name: &str, p: f64) {
        let what = format!("expected a probability {name} between 0 and 1, got {p}");
        self.demand((0.0..=1.0).contains(&p), key, what);
    }

    /// Requires a finite number of at least 0.
    pub(super) fn amount(&mut self, key: String, name: &str, unit: &str, value: f64) {
        let what = format!("expected a finite {name} of at least 0 {unit}, got {value}");
        self.demand(value.is_finite() && value >= 0.0, key, what);
    }

    /// Requires a time span that is not empty.
    fn span(&mut self, key: &str, from_s: f64, until_s: f64) {
        self.amount(format!("{key}.from_s"), "time", "s", from_s);
        let what = format!("expected a time after from_s = {from_s} s (or inf), got {until_s}");
        // A start that is not finite is reported already.
        self.demand(until_s > from_s || !from_s.is_finite(), format!("{key}.until_s"), what);
    }

    fn agent(&mut self, key: String, agent: u16, agents: u16) {
        let what =
            format!("expected an agent below {agents}, agents.count and stations, got {agent}");
        self.demand(agent < agents, key, what);
    }
}

impl NetemConfig {
    /// Every impossible value in a scenario of `agents` agents, as (key under `netem`, what is wrong).
    /// Elements of arrays have keys such as `outage[1].agent`.
    pub fn mistakes(&self, agents: u16) -> Vec<(String, String)> {
        let mut judge = Judge::default();
        let count = 1 + self.channels.len();
        let what = format!("expected at most {MAX_CHANNELS} channels, got {count}");
        judge.demand(count <= MAX_CHANNELS, "", what);
        for (name, config) in self.all_channels() {
            if name != super::RADIO {
                let what = "expected lowercase letters, digits, - and _, and no reserved key";
                judge.demand(is_channel_name(name), name, format!("{what}, got {name:?}"));
            }
            channel(&mut judge, name, config);
        }
        for (i, outage) in self.outage.iter().enumerate() {
            let key = format!("outage[{i}]");
            judge.agent(format!("{key}.agent"), outage.agent, agents);
            judge.span(&key, outage.from_s, outage.until_s);
        }
        crashes(&mut judge, &self.outage);
        for (i, config) in self.partition.iter().enumerate() {
            partition(&mut judge, &format!("partition[{i}]"), config, agents);
        }
        for (i, config) in self.jammer.iter().enumerate() {
            self.jammer_mistakes(&mut judge, &format!("jammer[{i}]"), config);
        }
        judge.0
    }

    fn jammer_mistakes(&self, judge: &mut Judge, key: &str, jammer: &JammerConfig) {
        let JammerConfig { p_m, radius_m, from_s, until_s, loss, channel } = jammer;
        let what = format!("expected two finite coordinates, got {p_m:?}");
        judge.demand(p_m.iter().all(|p| p.is_finite()), format!("{key}.p_m"), what);
        let what = format!("expected a radius of at least 0 m (or inf), got {radius_m}");
        judge.demand(*radius_m >= 0.0, format!("{key}.radius_m"), what);
        judge.span(key, *from_s, *until_s);
        judge.probability(format!("{key}.loss"), "loss", *loss);
        if let Some(name) = channel {
            let names: Vec<&str> = self.channel_names().collect();
            let what = format!("expected one of the channels {}, got {name}", names.join(", "));
            judge.demand(names.contains(&name.as_str()), format!("{key}.channel"), what);
        }
    }
}

/// Reports crashes of an agent that overlap: a process that is down cannot crash.
fn crashes(judge: &mut Judge, outages: &[OutageConfig]) {
    let is_crash = |outage: &OutageConfig| outage.kind == OutageKind::Crash;
    for (i, later) in outages.iter().enumerate().filter(|(_, o)| is_crash(o)) {
        let overlapping = outages[..i].iter().position(|earlier| {
            is_crash(earlier)
                && earlier.agent == later.agent
                && earlier.from_s < later.until_s
                && later.from_s < earlier.until_s
        });
        if let Some(j) = overlapping {
            let OutageConfig { agent, from_s, until_s, .. } = outages[j];
            let what = format!(
                "expected a crash outside outage[{j}], in which agent {agent} is down from \
                 {from_s} s to {until_s} s, got {} s to {} s",
                later.from_s, later.until_s
            );
            judge.demand(false, format!("outage[{i}].from_s"), what);
        }
    }
}

fn partition(judge: &mut Judge, key: &str, partition: &PartitionConfig, agents: u16) {
    let PartitionConfig { from_s, until_s, groups, one_way: _ } = partition;
    judge.span(key, *from_s, *until_s);
    let key = format!("{key}.groups");
    let what = format!("expected at least two groups, got {}", groups.len());
    judge.demand(groups.len() >= 2, key.as_str(), what);
    let mut group_of: BTreeMap<u16, usize> = BTreeMap::new();
    for (g, group) in groups.iter().enumerate() {
        let what = "expected at least one agent in the group, got none".to_owned();
        judge.demand(!group.is_empty(), format!("{key}[{g}]"), what);
        for (i, &agent) in group.iter().enumerate() {
            let place = format!("{key}[{g}][{i}]");
            judge.agent(place.clone(), agent, agents);
            if let Some(first) = group_of.insert(agent, g) {
                let what =
                    format!("expected an agent once, got {agent}, which is in group {first} too");
                judge.demand(false, place, what);
            }
        }
    }
}
