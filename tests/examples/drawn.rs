//! Flies drawn legal scenarios, or scenario files, and prints their speeds.
//!
//! Usage: `drawn FIRST COUNT` flies the scenarios of COUNT seeds; `drawn SEED` prints the scenario of
//! one seed, for `csat run`; `drawn FILE...` flies files. One line each: simulated seconds, speed
//! relative to real time by the clock and on two fully used cores, the most vertices of a set, the
//! number of violations, and the warnings of `csat check`.

use csat_experiments::scenario::Loaded;
use csat_experiments::set_membership::SetMembership;
use csat_mission::engine::Engine;
use csat_mission::timing::Stopwatch;
use csat_tests::drawn;
use csat_tests::drawn::largest_set;

/// Seconds of processor time of this process so far; 0 where the system has no such count.
fn cpu_s() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    let ticks: f64 = fields.skip(11).take(2).filter_map(|field| field.parse::<f64>().ok()).sum();
    ticks / 100.0
}

fn fly(name: &str, loaded: Loaded) {
    let Loaded { scenario, world, warnings, .. } = loaded;
    let mission = SetMembership::new(&scenario);
    let mut engine = Engine::new(mission, world, &scenario.netem, scenario.seed);
    let (watch, cpu_before_s) = (Stopwatch::start(), cpu_s());
    let (mut largest, mut violations) = (0, 0);
    for _ in 0..=scenario.steps() {
        violations += engine.step().violations.len();
        let most = engine.nodes().iter().map(|node| largest_set(node.agent.knowledge())).max();
        largest = largest.max(most.unwrap_or(0));
    }
    let (wall_s, cpu_s) = (watch.elapsed_s(), cpu_s() - cpu_before_s);
    let flown_s = scenario.run.duration_s;
    println!(
        "{name}: {flown_s:.0} s, {:.1} x real time, {:.1} x on two cores, {largest} vertices, \
         {violations} violations{}",
        flown_s / wall_s,
        2.0 * flown_s / cpu_s.max(0.01),
        warnings.iter().map(|w| format!("\n    warning: {}", w.message)).collect::<String>(),
    );
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.iter().map(|a| a.parse::<u64>()).collect::<Result<Vec<u64>, _>>().as_deref() {
        Ok(&[seed]) => print!("{}", drawn::scenario(seed).scenario.to_toml()),
        Ok(&[first, count]) => {
            (first..first + count).for_each(|seed| fly(&seed.to_string(), drawn::scenario(seed)));
        }
        _ => arguments.iter().for_each(|file| match drawn::load(file) {
            Some(loaded) => fly(file, loaded),
            None => println!("{file}: refused"),
        }),
    }
}
