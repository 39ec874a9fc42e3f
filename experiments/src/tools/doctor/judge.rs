//! What follows from what was heard.

use std::collections::BTreeSet;

use zenoh::key_expr::KeyExpr;

use super::finding::Finding;
use super::place::Places;
use super::run::Run;
use crate::tools::keys::{When, intersects, nearest, when};
use crate::tools::rates;
use csat_mission::words::named;

/// Why a session may have no peer, though something takes connections.
pub const LOCKED_OUT: &str = "whoever takes the connection is no Zenoh that lets this one in: another \
                              program's port, TLS, access control, or a client (clients meet routers and \
                              peers only)";

/// A session that does not open.
pub fn unopened(problem: &str, advice: &str) -> Finding {
    Finding::problem("session", problem).advice(advice)
}

/// A session that is open. It `is_hopeless` when no process takes connections.
pub fn session(zid: &str, peers: usize, places: &Places, is_hopeless: bool) -> Finding {
    if peers > 0 {
        let processes = if peers == 1 { "process" } else { "processes" };
        return Finding::ok("session", format!("{zid}, connected to {peers} {processes}"));
    }
    let text = format!("{zid}, connected to nobody");
    let finding = Finding::problem("session", text);
    if is_hopeless {
        return finding.advice("no endpoint takes connections, see above");
    }
    if places.connect.is_empty() {
        return finding.advice("nobody came: others need --connect to where this one listens");
    }
    finding.advice(LOCKED_OUT)
}

/// No run, or not the one that was asked for.
pub fn nobody(wanted: Option<u64>, others: &[Run], peers: usize) -> Finding {
    let numbers: Vec<String> = others.iter().map(|run| run.run.to_string()).collect();
    match (wanted, others.first()) {
        (Some(wanted), Some(other)) => {
            let text = format!("run {wanted} is not here; got {}", numbers.join(", "));
            Finding::problem("runs", text)
                .advice(format!("a run's number is its seed: expected --run {}", other.run))
        }
        (wanted, _) => {
            let which = wanted.map_or("no run".to_owned(), |wanted| format!("no run {wanted}"));
            Finding::problem("runs", format!("{which} of csat among {peers} connected processes"))
                .advice("start `csat spawn`, or connect to where a world listens")
        }
    }
}

/// What came faster than it was read.
pub fn missed(count: u64) -> Option<Finding> {
    (count > 0).then(|| {
        Finding::warning("keys", format!("{count} samples came faster than they were counted"))
            .advice("a slow subscriber misses some as well: subscribe to fewer keys")
    })
}

/// Everything about a run that was listened to for so long.
pub fn run(run: &Run, seconds: f64) -> Vec<Finding> {
    let check = format!("run {}", run.run);
    let mut findings = vec![alive(run, &check)];
    if let Some(reason) = &run.ended {
        let text = format!("it ended while it was listened to: {reason}");
        findings.push(Finding::note(&check, text));
    }
    findings.extend(clock(run, seconds, &check));
    findings.extend(traffic(run, seconds, &check));
    findings.extend(views(run, seconds, &check));
    findings
}

/// Agents by name, as far as it is known what they are.
fn names(run: &Run, agents: impl IntoIterator<Item = u16>) -> String {
    named(agents, run.uavs.unwrap_or(u16::MAX))
}

fn alive(run: &Run, check: &str) -> Finding {
    let missing = run.missing();
    let all = names(run, run.agents.iter().copied());
    let lacking = names(run, missing.iter().copied());
    let start = || {
        let first = missing.first().copied().unwrap_or_default();
        format!("start `csat agent --id {first}`; `csat spawn --restart` does that by itself")
    };
    match (run.world, run.expected) {
        (false, _) if run.ended.is_some() => Finding::note(check, "its processes end"),
        (false, _) if run.agents.is_empty() => {
            Finding::warning(check, "something is published, but no process of it is alive").advice(
                "a program that is no csat, or one behind a router that does not pass tokens on",
            )
        }
        (false, _) => Finding::problem(check, format!("{all} alive, but no world"))
            .advice("its `csat world` ended or is not connected to these processes"),
        (true, _) if !missing.is_empty() && run.orders == 0 => {
            Finding::problem(check, format!("the world waits: processes of {lacking} are missing"))
                .advice(start())
        }
        (true, _) if !missing.is_empty() => {
            Finding::warning(check, format!("processes of {lacking} are gone; the others carry on"))
                .advice(start())
        }
        (true, Some(count)) => {
            Finding::ok(check, format!("the world and all {count} agents are alive"))
        }
        (true, None) if run.agents.is_empty() => {
            Finding::warning(check, "the world is alive, but no agent; how many it has is unknown")
                .advice("it waits for them: start `csat agent --id 0` and so on")
        }
        (true, None) => {
            Finding::ok(check, format!("the world and {all} are alive; how many it has is unknown"))
        }
    }
}

fn clock(run: &Run, seconds: f64, check: &str) -> Option<Finding> {
    if run.orders > 0 {
        let rate = run.orders as f64 / seconds;
        let step = run.step.map_or(String::new(), |step| format!(", at step {step}"));
        return Some(Finding::ok(check, format!("the clock ticks: {rate:.1} orders/s{step}")));
    }
    run.world.then(|| {
        Finding::problem(check, format!("the clock is silent: no order within {seconds:.1} s")).advice(
            "the mission has not begun or does not go on: a process that is missing, stopped or very \
             slow; the world says whom it waits for when its --patience is over",
        )
    })
}

/// What is published, by topic.
fn traffic(run: &Run, seconds: f64, check: &str) -> Option<Finding> {
    let topics = run.topics.iter().map(|(topic, traffic)| {
        let (messages, bytes) = traffic.per_second(seconds);
        format!("{topic} {messages:.1}/s {}/s", rates::size(bytes))
    });
    let topics: Vec<String> = topics.collect();
    (!topics.is_empty()).then(|| Finding::ok(check, format!("published: {}", topics.join(", "))))
}

/// Views are made only for those who listen, which this process did.
fn views(run: &Run, seconds: f64, check: &str) -> Option<Finding> {
    if run.orders == 0 || !run.world {
        return None;
    }
    if run.viewed.is_empty() {
        let text = format!("no `view/**` within {seconds:.1} s, though somebody listened");
        return Some(Finding::warning(check, text).advice(
            "views come at the end of a step: look again when a step takes long; agents of another \
             program or version may show nothing",
        ));
    }
    let silent: Vec<u16> = run.agents.difference(&run.viewed).copied().collect();
    if silent.is_empty() {
        return Some(Finding::ok(
            check,
            format!("{} show what they know", names(run, run.viewed.iter().copied())),
        ));
    }
    let text = format!("{} showed nothing within {seconds:.1} s", names(run, silent));
    Some(
        Finding::warning(check, text).advice("an agent that is down by the scenario shows nothing"),
    )
}

/// Whether anybody says what a key expression stands for.
pub fn key(keys: &KeyExpr<'_>, heard: &BTreeSet<String>, seconds: f64) -> Finding {
    let check = "key";
    let matching: Vec<&String> = heard.iter().filter(|key| intersects(keys, key)).collect();
    if let Some(first) = matching.first() {
        let others = match matching.len() - 1 {
            0 => String::new(),
            count => format!(" and {count} more"),
        };
        return Finding::ok(check, format!("`{keys}` is heard: `{first}`{others}"));
    }
    let near = |known| match nearest(keys, heard.iter().map(String::as_str), known) {
        Some(near) => format!("nearest is `{near}`"),
        None => {
            "docs/topics.md lists what there is, `csat echo --rates` what is said now".to_owned()
        }
    };
    let text = format!("nothing on `{keys}` within {seconds:.1} s");
    match when(keys) {
        Some(When::Token) => {
            Finding::warning(check, format!("{text}: these are liveliness tokens"))
                .advice(format!("expected `csat echo --alive '{keys}'`"))
        }
        Some(When::Asked) => Finding::warning(check, format!("{text}: only who asks is answered"))
            .advice("expected a Zenoh `get`, not a subscriber"),
        Some(When::Rarely(when)) => {
            Finding::warning(check, format!("{text}: something comes {when}"))
                .advice(format!("wait for it: `csat echo '{keys}'`"))
        }
        Some(When::Flying) => {
            let text = format!("{text}, though csat has such keys");
            Finding::problem(check, text).advice(format!(
                "another run's number or UAV, or nobody flies or shows it now; {}",
                near(false)
            ))
        }
        None => {
            let text = format!("{text}: csat has no such key");
            Finding::problem(check, text).advice(near(true))
        }
    }
}

/// How programs that are not csat look at the same.
pub fn other_tools(places: &Places) -> Finding {
    let endpoint = places.connect.first().or(places.listen.first());
    let endpoint = endpoint.map_or("tcp/HOST:PORT", String::as_str);
    Finding::note(
        "others",
        format!(
            "Zenoh's own command needs `zenoh --mode client --connect {endpoint} subscribe -k \
             'csat/*/view/**' --decoder json`: multicast is off here, so its scouting finds nobody, \
             and without a decoder it shows base64"
        ),
    )
}

#[cfg(test)]
mod tests;
