//! `[faults]`, and what agents are told of it: agents that lie or are mistaken.

use csat_agent::config::ExchangeMode;
use csat_mission::words::counted;
use csat_world::lie::{Liar, LieKind};

use super::{Check, Scenario, end_s};
use crate::scenario::mistake::Mistake;

/// Judges the liars, and how many of them the agents allow for.
pub(super) fn judge(check: &mut Check, scenario: &Scenario) {
    let (liars, uavs) = (scenario.exchange.liars, scenario.agents.count);
    check.that(
        liars == 0 || liars < uavs,
        &["exchange.liars", "agents.count"],
        &liars.to_string(),
        &format!("fewer liars than UAVs, agents.count = {uavs}"),
    );
    let all = &scenario.faults.liar;
    for (index, liar) in all.iter().enumerate() {
        of_liar(check, index, liar, scenario);
        let is_twice = all[..index].iter().any(|other| other.agent == liar.agent);
        let expected = "each UAV once: it is a liar already";
        check.at(!is_twice, &path(index, "agent"), &liar.agent, expected);
    }
    heard(check, scenario);
}

/// Warns of lies that nobody hears, and of more liars than the agents allow for.
fn heard(check: &mut Check, scenario: &Scenario) {
    let end_s = end_s(&scenario.run);
    let liars = scenario.faults.liar.iter().filter(|liar| liar.from_s <= end_s).count();
    let q = scenario.exchange.liars;
    if scenario.exchange.mode == ExchangeMode::None {
        if liars > 0 || q > 0 {
            let text = "no agent hears a lie: `exchange.mode` is `none`";
            let expected = "another mode, or neither `[[faults.liar]]` nor exchange.liars";
            let key = if liars > 0 { "faults.liar" } else { "exchange.liars" };
            check.warn(&[key, "exchange.mode"], Mistake::new(text).expected(expected));
        }
    } else if liars > usize::from(q) {
        let text = format!(
            "{} in `faults.liar`, more than exchange.liars = {q}: the guarantee does not hold",
            counted(liars, "liar")
        );
        let expected = format!("at most {q}, or a larger exchange.liars");
        check.warn(&["faults.liar", "exchange.liars"], Mistake::new(text).expected(expected));
    }
    let p = scenario.camera.misidentify;
    if p > 0.0 && p <= 1.0 && q == 0 {
        let text = format!(
            "with `camera.misidentify` = {p} and exchange.liars = 0 the guarantee does not hold"
        );
        let mistake = Mistake::new(text).expected("exchange.liars of 1 or more");
        check.warn(&["camera.misidentify", "exchange.liars"], mistake);
    }
}

fn of_liar(check: &mut Check, index: usize, liar: &Liar, scenario: &Scenario) {
    let uavs = scenario.agents.count;
    let expected = match scenario.stations.is_empty() {
        true => format!("the index of a UAV, below agents.count = {uavs}"),
        false => format!("the index of a UAV, below agents.count = {uavs}: stations see nothing"),
    };
    check.at(liar.agent < uavs, &path(index, "agent"), &liar.agent, &expected);
    let help = format!("UAV {} does not lie", liar.agent);
    check.begins(&path(index, "from_s"), liar.from_s, &scenario.run, &help);
    let targets = scenario.targets.count;
    let is_alone = liar.kind == LieKind::Misidentify && targets < 2;
    let expected = "another kind, or 2 cars or more to be taken for each other (targets.count)";
    check.at(!is_alone, &path(index, "kind"), &"`misidentify`", expected);
}

/// The path of a key of the liar at `index`.
fn path(index: usize, key: &str) -> String {
    format!("faults.liar[{index}].{key}")
}
