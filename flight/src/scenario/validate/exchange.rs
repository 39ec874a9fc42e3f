//! `[exchange]`.

use csat_agent::config::{ChannelNames, ExchangeConfig};
use csat_netem::config::{NetemConfig, RADIO};

use super::super::mistake::{Mistake, did_you_mean};
use super::{Check, Issue, MAX_TIME_S};

/// The least a budget may be, bytes per second: below, not even flight plans fit.
const LEAST_BUDGET_BYTES_S: f64 = 50.0;

/// Judges what is said, how often, on which of the scenario's radios, and what is believed.
pub(super) fn judge(
    check: &mut Check,
    exchange: &ExchangeConfig,
    netem: &NetemConfig,
    period_s: Option<f64>,
) {
    let shortest = period_s.unwrap_or(f64::MIN_POSITIVE);
    for (key, between) in [
        ("exchange.snapshot_period_s", exchange.snapshot_period_s),
        ("exchange.repair_period_s", exchange.repair_period_s),
    ] {
        check.that(
            (shortest..=MAX_TIME_S).contains(&between),
            &[key, "run.period_s"],
            &between.to_string(),
            &format!("at least run.period_s = {shortest} s and at most {MAX_TIME_S} s"),
        );
    }
    check.time("exchange.repair_delay_s", exchange.repair_delay_s);
    let budget = exchange.budget_bytes_s;
    check.that(
        budget >= LEAST_BUDGET_BYTES_S,
        &["exchange.budget_bytes_s"],
        &budget.to_string(),
        &format!("at least {LEAST_BUDGET_BYTES_S} bytes per second, or inf for no limit"),
    );
    let max_age_s = exchange.max_age_s;
    check.that(
        max_age_s > 0.0 && max_age_s <= MAX_TIME_S,
        &["exchange.max_age_s"],
        &max_age_s.to_string(),
        &format!("a time above 0 and up to {MAX_TIME_S} s"),
    );
    check.time("exchange.clock_skew_s", exchange.clock_skew_s);
    check.whole("exchange.max_vertices", exchange.max_vertices);
    let names: Vec<String> = netem.channel_names().map(|name| format!("`{name}`")).collect();
    let expected = format!("a radio of [netem]: {}", names.join(", "));
    for (key, name) in [
        ("exchange.channels.facts", &exchange.channels.facts),
        ("exchange.channels.snapshots", &exchange.channels.snapshots),
        ("exchange.channels.plans", &exchange.channels.plans),
    ] {
        let got = format!("`{name}`");
        check.that(netem.channel_id(name).is_some(), &[key], &got, &expected);
    }
    let ChannelNames { facts, snapshots, plans } = &exchange.channels;
    let keys = ["exchange.channels", "exchange.channels.facts, snapshots or plans"];
    idle_radios(check, netem, &[facts, snapshots, plans], keys);
}

/// A radio that is not in `used`, the values of some keys, is a name mistyped: the radio that was meant keeps its
/// defaults, and a mission over other links than asked for would be flown without a word.
pub(super) fn idle_radios(
    check: &mut Check,
    netem: &NetemConfig,
    used: &[&str],
    [table, keys]: [&str; 2],
) {
    for name in netem.channels.keys().filter(|name| !used.contains(&name.as_str())) {
        let text = format!("radio `{name}` carries nothing: nothing in {table} names it");
        let mut mistake = Mistake::new(text).expected(format!("`{RADIO}`, or {keys} = \"{name}\""));
        if let Some(guess) = did_you_mean(name, netem.channel_names().filter(|other| other != name))
        {
            mistake = mistake.help(guess);
        }
        let keys = vec![format!("netem.{name}")];
        check.0.push(Issue { keys, mistake, is_warning: false });
    }
}
