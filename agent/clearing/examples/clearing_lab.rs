//! Flies missions of the test simulator and prints how they end.
//!
//! - `clearing_lab TOWN [SEED] [UAVS] [SECONDS]`: one mission, and where the agents are every so many seconds.
//! - `clearing_lab survey [MISSIONS] [UAVS] [LINKS]`: so many deserts, with `good` or `bad` links.

#[path = "../tests/sim/mod.rs"]
#[allow(dead_code)]
mod sim;

use sim::links::LinkModel;
use sim::town::Town;
use sim::{Flight, Outcome, Setup, fly};

fn town(name: &str, seed: u64) -> Option<Town> {
    Some(match name {
        "straight" => Town::straight(),
        "tee" => Town::tee(),
        "cross" => Town::cross(),
        "ring" => Town::ring(),
        "rear" => Town::rear(),
        "hooks" => Town::hooks(),
        "fork" => Town::fork(),
        "ladder" => Town::ladder(60.0, &[-120.0, 0.0, 120.0]),
        "desert" => Town::desert(seed, 110.0),
        _ => return None,
    })
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |index: usize, otherwise: f64| {
        words.get(index).and_then(|word| word.parse().ok()).unwrap_or(otherwise)
    };
    let name = words.first().map_or("desert", String::as_str);
    if name == "survey" {
        let is_bad = words.get(3).is_some_and(|word| word == "bad");
        return survey(number(1, 20.0) as u64, number(2, 8.0) as u16, is_bad);
    }
    let seed = number(1, 0.0) as u64;
    let Some(town) = town(name, seed) else { return eprintln!("no town {name}") };
    let setup = Setup { uavs: number(2, 8.0) as u16, ..Setup::new(town, seed) };
    let mut setup = setup;
    if words.get(4).is_some_and(|word| word == "paper") {
        setup.clearing.rules = csat_clearing::config::Rules::Paper;
    }
    let every = (number(3, 60.0) * 8.0) as u32;
    let mut flight = Flight::new(&setup);
    while flight.advance() {
        if flight.step.is_multiple_of(every) {
            tell(&flight);
        }
    }
    tell(&flight);
    println!("{:#?}", flight.finish());
}

/// Flies deserts, two at a time.
fn survey(missions: u64, uavs: u16, is_bad: bool) {
    let bad = LinkModel { loss: 0.6, max_delay_s: 2.0, duplication: 0.2, hbsr_range_m: 60.0 };
    let links = if is_bad { bad } else { LinkModel::default() };
    let fly = |seed| fly(&Setup { uavs, links, ..Setup::new(Town::desert(seed, 110.0), seed) });
    let flown = |seed| {
        let outcome = fly(seed);
        tell_outcome(seed, &outcome);
        (seed, outcome)
    };
    let half = |first: u64| (first..missions).step_by(2).map(flown);
    let all: Vec<(u64, Outcome)> = std::thread::scope(|scope| {
        let other = scope.spawn(|| half(1).collect::<Vec<_>>());
        let own: Vec<_> = half(0).collect();
        own.into_iter().chain(other.join().unwrap()).collect()
    });
    let cleared: Vec<f64> = all.iter().filter_map(|(_, outcome)| outcome.cleared_s).collect();
    let mean = cleared.iter().sum::<f64>() / cleared.len() as f64;
    let violations: u32 = all.iter().map(|(_, outcome)| outcome.violations).sum();
    println!("{} of {missions} cleared, in {mean:.0} s; {violations} violations", cleared.len());
}

fn tell_outcome(seed: u64, outcome: &Outcome) {
    let Outcome { cleared_s, violations, cleaners_max, splits, encounters, .. } = outcome;
    println!(
        "{seed:3} {:5.1} % cleared {cleared_s:?} end {:6.1} s stalled {} lost {} violations {violations} {:?} \
         cleaners {cleaners_max} splits {splits} encounters {encounters} merges {} rejected {}",
        100.0 * outcome.cleared_share,
        outcome.end_s,
        outcome.is_stalled,
        outcome.has_lost,
        outcome.first_violation,
        outcome.merges,
        outcome.rejected,
    );
}

fn tell(flight: &Flight) {
    println!("{:7.1} s, {:5.1} %", flight.time_s(), 100.0 * flight.truth.cleared_share());
    for (agent, vehicle) in flight.agents.iter().zip(&flight.vehicles) {
        let runs: Vec<_> =
            agent.runs().iter().map(|run| (run.rect.rows, run.rect.columns)).collect();
        println!(
            "  {} {:10} at {:6.1} {:6.1} leader {:?} followers {} stalled {} runs {runs:?}",
            agent.config().id,
            agent.role().name(),
            vehicle.place_m[0],
            vehicle.place_m[1],
            agent.leader().map(|id| id.0),
            agent.followers(),
            agent.is_stalled(),
        );
    }
}
