//! From a seed to a scenario: every fault has its own rate, which is often 0.

use csat_agent::config::{Criterion, EstimatorConfig, ExchangeMode, Schedule};
use csat_experiments::scenario::Scenario;
use csat_experiments::set_membership::SetMembership;
use csat_netem::config::{
    DelayConfig, JammerConfig, LossConfig, NetemConfig, OutageConfig, OutageKind, PartitionConfig,
    RateConfig,
};
use csat_proto::model::{Driving, Station};
use csat_world::lie::{Liar, LieKind};
use csat_world::observer::{Denied, ObserverModel};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{Exercise, Handicapped};
use crate::faulty::Handicap;
use crate::missions::{small, world_of};

/// Steps with faults.
const STEPS: u32 = 24;

const LIES: u64 = 0x6c69_6573 << 32;
const POSES: u64 = 0x706f_7365 << 32;
const PLANNER: u64 = 0x706c_616e << 32;

/// The mission of a seed.
#[derive(Debug, Clone)]
pub struct Draw {
    /// The mission, with its faults.
    pub scenario: Scenario,
    /// Steps with faults.
    pub steps: u32,
    /// The links afterwards: perfect within the core, none to the other agents.
    pub healed: NetemConfig,
    /// The agents whose links are healed.
    pub core: Vec<u16>,
    /// Steps until the core has to agree.
    pub settle_steps: u32,
    /// The handicap of each agent's clock and camera, by index.
    pub handicaps: Vec<Handicap>,
}

impl Draw {
    /// The mission of a seed.
    pub fn new(seed: u64) -> Self {
        let mut draw = Self::plain(seed);
        // From streams of their own: what a seed draws besides stays as it was.
        lies(&mut draw.scenario, &mut ChaCha8Rng::seed_from_u64(seed ^ LIES));
        poses(&mut draw.scenario, &mut ChaCha8Rng::seed_from_u64(seed ^ POSES));
        planner(&mut draw.scenario, &mut ChaCha8Rng::seed_from_u64(seed ^ PLANNER));
        draw
    }

    /// The same with exact poses and without liars.
    pub fn plain(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut scenario = town(seed, &mut rng);
        exchange(&mut scenario, &mut rng);
        let end_s = f64::from(STEPS) * scenario.run.period_s;
        let count = scenario.agent_count();
        links(&mut scenario.netem, count, end_s, &mut rng);
        let core: Vec<u16> = (0..count).filter(|_| rng.random_bool(0.7)).collect();
        let core = if core.len() < 2 { vec![0, 1] } else { core };
        let healed = healed(&core, count, end_s, rng.random());
        let settle_steps = settle_steps(&scenario, core.len() as u32);
        let handicaps = handicaps(&mut scenario, &mut rng);
        let (healed, handicaps) = match scenario.agents.avoid_buildings {
            true => decided_in_time(&mut scenario, healed, handicaps),
            false => (healed, handicaps),
        };
        if rng.random_bool(0.5) {
            scenario.targets.driving = Driving::Evasive;
        }
        // Sometimes sets exceed their limit of vertices.
        if rng.random_bool(0.2) {
            scenario.estimator.max_vertices = rng.random_range(50..120);
        }
        Self { scenario, steps: STEPS, healed, core, settle_steps, handicaps }
    }

    /// The mission, with the handicaps of its agents.
    pub fn mission(&self) -> Handicapped {
        let mission = SetMembership::new(&self.scenario);
        Handicapped::new(mission, self.scenario.run.period_s, self.handicaps.clone())
    }

    /// What the seed exercises, by its draw.
    pub fn exercise(&self) -> Exercise {
        let missed = self.handicaps.iter().flat_map(|h| h.missed.clone().into_iter().flatten());
        Exercise {
            missed: missed.count() as u64,
            skewed: self.handicaps.iter().any(|h| h.ahead != self.handicaps[0].ahead).into(),
            evasive: (self.scenario.targets.driving == Driving::Evasive).into(),
            stationed: (!self.scenario.stations.is_empty()).into(),
            uncertain: (self.scenario.own != Scenario::default().own).into(),
            walled: self.scenario.agents.avoid_buildings.into(),
            lying: (!self.scenario.faults.liar.is_empty()).into(),
            ..Exercise::default()
        }
    }

    /// Whether the core has to agree in the end. It does not where lost facts are not repaired, where
    /// facts did not fit a budget, where clocks differ, so that the agents have sets of different
    /// steps, and where agents may lie.
    pub fn must_converge(&self) -> bool {
        let exchange = &self.scenario.exchange;
        // Where some may lie, each agent believes its own frames more than those of others.
        if exchange.liars > 0 {
            return false;
        }
        matches!(exchange.mode, ExchangeMode::FactsRepair | ExchangeMode::Snapshot)
            && exchange.budget_bytes_s.is_infinite()
            && exchange.clock_skew_s == 0.0
    }

    /// Whether the limit of vertices is the default, which sets do not reach: agents simplify larger
    /// sets in different ways.
    pub fn is_precise(&self) -> bool {
        self.scenario.estimator.max_vertices == EstimatorConfig::default().max_vertices
    }

    /// Whether each agent of the core sends regular snapshots while the core settles.
    pub fn says_snapshots(&self) -> bool {
        let Scenario { exchange, run, .. } = &self.scenario;
        exchange.mode == ExchangeMode::Snapshot
            || exchange.snapshot_period_s <= f64::from(self.settle_steps) * run.period_s
    }
}

/// Sometimes UAVs predict who hears whom, and pass on plans.
fn planner(scenario: &mut Scenario, rng: &mut ChaCha8Rng) {
    if rng.random_bool(0.8) {
        return;
    }
    let Scenario { guidance, netem, .. } = scenario;
    guidance.criterion = Criterion::Str5;
    (guidance.str4.n_mpc, guidance.str4.beam) = (5, 8);
    netem.radio.range_m = netem.radio.range_m.min(rng.random_range(30.0..150.0));
}

/// Poses are known to boxes: with errors of some components, rare fixes, and zones without.
fn poses(scenario: &mut Scenario, rng: &mut ChaCha8Rng) {
    if rng.random_bool(0.75) || scenario.agents.avoid_buildings {
        return;
    }
    let error = [2.0, 2.0, 0.5, 0.5, 0.5, 3.0]
        .map(|most| if rng.random_bool(0.6) { rng.random_range(0.0..most) } else { 0.0 });
    let zone = Denied { min_m: [-200.0; 2], max_m: [20.0, 200.0], from_s: 1.0, until_s: 9.0 };
    let pose = ObserverModel {
        error,
        time_constant_s: rng.random_range(0.5..20.0),
        fix_period_s: if rng.random_bool(0.5) { rng.random_range(0.0..8.0) } else { 0.0 },
        drift: rng.random_range(0.0..0.3),
        denied: if rng.random_bool(0.3) { vec![zone] } else { Vec::new() },
    };
    let table = toml::Value::try_from(pose).expect("a model is TOML");
    scenario.own.insert("pose".to_owned(), table);
}

/// Agents that allow for liars, and no more liars than they allow for.
fn lies(scenario: &mut Scenario, rng: &mut ChaCha8Rng) {
    if rng.random_bool(0.7) {
        return;
    }
    let uavs = scenario.agents.count;
    scenario.exchange.liars = rng.random_range(1..=2.min(uavs - 1));
    let mut kinds = vec![LieKind::Clear, LieKind::Phantom];
    kinds.extend((scenario.targets.count > 1).then_some(LieKind::Misidentify));
    let first = rng.random_range(0..uavs);
    for i in 0..rng.random_range(0..=scenario.exchange.liars) {
        let (agent, from_s) = ((first + i) % uavs, rng.random_range(0.0..6.0));
        let kind = kinds[rng.random_range(0..kinds.len())];
        scenario.faults.liar.push(Liar { agent, from_s, kind });
    }
}

/// To keep clear of buildings a UAV must decide in time. Processes that crash or miss frames make no
/// decisions, so their radios fail instead. A clock that is ahead by a part of the period of decisions makes
/// the first decision late, so clocks are ahead by whole periods.
fn decided_in_time(
    scenario: &mut Scenario,
    mut healed: NetemConfig,
    mut handicaps: Vec<Handicap>,
) -> (NetemConfig, Vec<Handicap>) {
    for outage in scenario.netem.outage.iter_mut().chain(&mut healed.outage) {
        outage.kind = OutageKind::Radio;
    }
    let decision_steps =
        (scenario.guidance.period_s / scenario.run.period_s).round().max(1.0) as u32;
    for handicap in &mut handicaps {
        handicap.missed.clear();
        handicap.ahead -= handicap.ahead % decision_steps;
    }
    (healed, handicaps)
}

/// Clocks that differ by up to the bound of the agents, and frames that are missed, several in a row.
fn handicaps(scenario: &mut Scenario, rng: &mut ChaCha8Rng) -> Vec<Handicap> {
    let skew = if rng.random_bool(0.25) { rng.random_range(1..=4) } else { 0 };
    scenario.exchange.clock_skew_s = f64::from(skew) * scenario.run.period_s;
    let misses = rng.random_bool(0.35);
    let handicap = |_| {
        let ahead = if rng.random_bool(0.5) { skew } else { 0 };
        let gaps = if misses { rng.random_range(0..4) } else { 0 };
        let gap = |_| {
            let from = rng.random_range(0..STEPS);
            from..(from + rng.random_range(1..=8)).min(STEPS)
        };
        Handicap { ahead, missed: (0..gaps).map(gap).collect() }
    };
    (0..scenario.agent_count()).map(handicap).collect()
}

/// A town of a few blocks; it is drawn again when the cars find no room.
fn town(seed: u64, rng: &mut ChaCha8Rng) -> Scenario {
    loop {
        let side_m = rng.random_range(80.0..130.0);
        let mut scenario = small(seed, side_m, [2, 2, 3, 3, 4][rng.random_range(0..5)]);
        scenario.seed = rng.random::<u32>().into();
        scenario.targets.count = rng.random_range(1..=5);
        scenario.targets.v_max_m_s = [0.5, 1.0, 2.0, 4.0][rng.random_range(0..4)];
        scenario.agents.start_offset_m = [0.0, 0.1 * side_m][rng.random_range(0..2)];
        // Sometimes cars are located well and keep far apart, so that exclusions are large.
        let sharp = rng.random_bool(0.3);
        (scenario.camera.columns, scenario.camera.rows) = if sharp { (96, 72) } else { (48, 36) };
        scenario.targets.target_distance_m = if sharp { 14.0 } else { 8.0 };
        scenario.estimator.disc_vertices = [4, 6, 8][rng.random_range(0..3)];
        scenario.estimator.simplify_m = [0.0, 0.3, 1.0, 1.0][rng.random_range(0..4)];
        scenario.estimator.simplify_margin_m = 1.0;
        scenario.estimator.outline_tolerance_px = 2.0;
        scenario.guidance.n_mpc = 1;
        scenario.guidance.increments_deg = vec![-60.0, 0.0, 60.0];
        let schedules =
            [Schedule::Sequential, Schedule::SequentialLoopback, Schedule::Asynchronous];
        scenario.guidance.schedule = schedules[rng.random_range(0..3)];
        if rng.random_bool(0.3) {
            let station = |_| {
                let [x_m, y_m] = [0; 2].map(|_| rng.random_range(-0.6..0.6) * side_m);
                Station { x_m, y_m, z_m: rng.random_range(0.0..3.0) }
            };
            scenario.stations = (0..1 + seed % 2).map(station).collect();
        }
        // Sometimes buildings are higher than the UAVs fly.
        if rng.random_bool(0.15) {
            scenario.map.max_height_m = 60.0;
            scenario.agents.avoid_buildings = true;
        }
        if world_of(&scenario).is_ok() {
            return scenario;
        }
    }
}

fn exchange(scenario: &mut Scenario, rng: &mut ChaCha8Rng) {
    let exchange = &mut scenario.exchange;
    exchange.mode = match rng.random_range(0..20) {
        0 => ExchangeMode::None,
        1..4 => ExchangeMode::Facts,
        4..8 => ExchangeMode::Snapshot,
        _ => ExchangeMode::FactsRepair,
    };
    // Half of the missions have no regular snapshots.
    exchange.snapshot_period_s =
        if rng.random_bool(0.5) { 1000.0 } else { rng.random_range(2.0..8.0) };
    exchange.repair_period_s = rng.random_range(0.5..1.0);
    exchange.repair_delay_s = rng.random_range(0.2..1.0);
    if rng.random_bool(0.25) {
        exchange.budget_bytes_s = rng.random_range(200.0..4000.0);
    }
    if rng.random_bool(0.2) {
        exchange.max_age_s = rng.random_range(1.0..6.0);
    }
}

fn links(netem: &mut NetemConfig, agents: u16, end_s: f64, rng: &mut ChaCha8Rng) {
    let radio = &mut netem.radio;
    if rng.random_bool(0.3) {
        radio.range_m = rng.random_range(15.0..100.0);
    }
    radio.loss = match rng.random_range(0..4) {
        0 | 1 => LossConfig::Iid { p: rate(rng) },
        2 => LossConfig::GilbertElliott {
            p: rate(rng),
            r: rng.random_range(0.05..1.0),
            h: 0.0,
            k: 1.0,
        },
        _ => {
            let lost = (0..50).map(|_| if rng.random_bool(0.4) { '1' } else { '0' }).collect();
            LossConfig::Trace { file: None, lost: Some(lost) }
        }
    };
    radio.delay = delay(rng);
    radio.corruption = rate(rng) * 0.3;
    radio.duplication = rate(rng);
    if rng.random_bool(0.15) {
        let bytes_s = rng.random_range(1000.0..20_000.0);
        radio.rate = RateConfig { bytes_s, burst_bytes: 3000, queue_bytes: 20_000 };
    }
    if rng.random_bool(0.15) {
        radio.mtu_bytes = rng.random_range(200..1500);
    }
    for agent in 0..agents {
        if rng.random_bool(0.3) {
            let from_s = rng.random_range(0.0..end_s * 0.8);
            let until_s = from_s + rng.random_range(0.3..end_s * 0.4);
            let kind = [OutageKind::Radio, OutageKind::Crash][rng.random_range(0..2)];
            netem.outage.push(OutageConfig { agent, from_s, until_s: until_s.min(end_s), kind });
        }
    }
    if rng.random_bool(0.3) {
        let from_s = rng.random_range(0.0..end_s * 0.7);
        let until_s = from_s + rng.random_range(1.0..end_s);
        let cut = rng.random_range(1..agents);
        let groups = vec![(0..cut).collect(), (cut..agents).collect()];
        let one_way = rng.random_bool(0.3);
        netem.partition.push(PartitionConfig {
            from_s,
            until_s: until_s.min(end_s),
            groups,
            one_way,
        });
    }
    if rng.random_bool(0.15) {
        netem.jammer.push(JammerConfig {
            p_m: [rng.random_range(-50.0..50.0), rng.random_range(-50.0..50.0)],
            radius_m: rng.random_range(10.0..60.0),
            from_s: 0.0,
            until_s: end_s,
            loss: rng.random_range(0.3..1.0),
            channel: None,
        });
    }
}

/// 0 half of the time.
fn rate(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random_bool(0.5) { 0.0 } else { rng.random_range(0.0..0.7) }
}

fn delay(rng: &mut ChaCha8Rng) -> DelayConfig {
    let mean_s = rng.random_range(0.01..4.0);
    let correlation = [0.0, 0.7][rng.random_range(0..2)];
    match rng.random_range(0..6) {
        0 | 1 => DelayConfig::Constant { mean_s: 0.0 },
        2 => DelayConfig::Constant { mean_s },
        3 => DelayConfig::Uniform { mean_s, spread_s: mean_s, correlation },
        4 => DelayConfig::Normal { mean_s, sd_s: mean_s / 2.0, correlation },
        _ => DelayConfig::Pareto { mean_s, shape: 2.0, correlation },
    }
}

/// Perfect links within the core; the other agents have no radio for ever, or crashed.
fn healed(core: &[u16], agents: u16, end_s: f64, crashed: bool) -> NetemConfig {
    let others = (0..agents).filter(|agent| !core.contains(agent));
    let kind = if crashed { OutageKind::Crash } else { OutageKind::Radio };
    let gone = |agent| OutageConfig { agent, from_s: end_s, until_s: f64::INFINITY, kind };
    NetemConfig { outage: others.map(gone).collect(), ..NetemConfig::default() }
}

/// How long the core may take to agree: each agent may have facts that the others are missing,
/// detects that after the delay that messages may have, waits for its turn, and may have to wait for
/// its period; cells of the map have turns of their own.
fn settle_steps(scenario: &Scenario, core: u32) -> u32 {
    let steps = |seconds: f64| (seconds / scenario.run.period_s).ceil() as u32;
    let exchange = &scenario.exchange;
    let turns = 2 * u32::from(scenario.agent_count());
    let one = steps(exchange.repair_delay_s) + steps(exchange.repair_period_s) + turns + 2;
    match exchange.mode {
        ExchangeMode::FactsRepair => core * one,
        _ => 3,
    }
}
