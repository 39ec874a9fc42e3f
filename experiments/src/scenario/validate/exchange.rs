//! `[exchange]`.

use csat_agent::config::ExchangeConfig;
use csat_netem::config::NetemConfig;

use super::Check;

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
            between >= shortest && between.is_finite(),
            &[key, "run.period_s"],
            &between.to_string(),
            &format!("at least run.period_s = {shortest} s"),
        );
    }
    check.not_negative("exchange.repair_delay_s", exchange.repair_delay_s);
    let budget = exchange.budget_bytes_s;
    check.that(
        budget >= LEAST_BUDGET_BYTES_S,
        &["exchange.budget_bytes_s"],
        &budget.to_string(),
        &format!("at least {LEAST_BUDGET_BYTES_S} bytes per second, or inf for no limit"),
    );
    check.positive("exchange.max_age_s", exchange.max_age_s);
    check.not_negative("exchange.clock_skew_s", exchange.clock_skew_s);
    let vertices = exchange.max_vertices;
    let holds = vertices >= 4;
    check.that(holds, &["exchange.max_vertices"], &vertices.to_string(), "4 or more");
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
}
