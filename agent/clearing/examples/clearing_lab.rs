//! Flies missions of the test simulator and prints how they end: `clearing_lab NAME SEED [UAVS] [every seconds]`.

#[path = "../tests/sim/mod.rs"]
#[allow(dead_code)]
mod sim;

use sim::town::Town;
use sim::{Flight, Setup};

fn town(name: &str, seed: u64) -> Option<Town> {
    Some(match name {
        "straight" => Town::straight(),
        "tee" => Town::tee(),
        "cross" => Town::cross(),
        "ring" => Town::ring(),
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
    let seed = number(1, 0.0) as u64;
    let Some(town) = town(name, seed) else { return eprintln!("no town {name}") };
    let setup = Setup { uavs: number(2, 8.0) as u16, ..Setup::new(town, seed) };
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
