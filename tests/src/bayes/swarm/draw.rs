//! From a seed to a scenario: every fault has its own rate, which is often 0.

use csat_bayes::config::{BeliefKind, Criterion, ExchangeMode, Fusion};
use csat_flight::scenario::Scenario;
use csat_netem::config::{
    DelayConfig, LossConfig, NetemConfig, OutageConfig, OutageKind, PartitionConfig,
};
use csat_proto::ids::AgentId;
use csat_proto::model::{Driving, StartPose, Station};
use csat_proto::time::Step;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::bayes::missions::Tables;
use crate::faulty::Handicap;
use crate::missions::{shipped, with_tables};

/// The mission of a seed.
#[derive(Debug, Clone)]
pub struct Draw {
    /// The mission, with its faults.
    pub scenario: Scenario,
    /// Its own tables.
    pub tables: Tables,
    /// The step at which all links become perfect.
    pub heal_at: u32,
    /// Whether links are perfect from the start, and no frame is missed.
    pub is_perfect: bool,
    /// The frames that each agent misses, by index.
    pub handicaps: Vec<Handicap>,
}

impl Draw {
    /// The mission of a seed.
    ///
    /// # Panics
    /// When something is wrong with it.
    pub fn new(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut scenario = shipped("tisdale");
        scenario.seed = rng.random::<u32>().into();
        world(&mut scenario, &mut rng);
        let mut tables = Tables::default();
        let is_perfect = rng.random_bool(0.2);
        belief(&mut tables, &mut rng);
        exchange(&mut tables, is_perfect, &mut rng);
        let heal_at = scenario.steps() * 2 / 3;
        if !is_perfect {
            let end_s = f64::from(heal_at) * scenario.run.period_s;
            let agents = scenario.agent_count();
            links(&mut scenario.netem, agents, end_s, &mut rng);
        }
        let agents = if is_perfect { 0 } else { scenario.agent_count() };
        let handicaps = (0..agents).map(|_| handicap(heal_at, &mut rng)).collect();
        let scenario = with_tables(scenario, &tables);
        Self { scenario, tables, heal_at, is_perfect, handicaps }
    }

    /// Whether an agent misses the frame of a step.
    pub fn misses(&self, id: AgentId, step: Step) -> bool {
        self.handicaps.get(usize::from(id.0)).is_some_and(|handicap| handicap.misses(step))
    }

    /// Whether agents tell all factors that they state, at once.
    pub fn tells_all(&self) -> bool {
        let exchange = &self.tables.exchange;
        matches!(exchange.mode, ExchangeMode::Facts | ExchangeMode::FactsRepair)
            && exchange.budget_bytes_s.is_infinite()
    }

    /// Whether all agents have to hold the same in the end.
    pub fn must_converge(&self) -> bool {
        self.tells_all() && self.tables.exchange.mode == ExchangeMode::FactsRepair
    }

    /// Whether the belief is the product of the factors held, in any order.
    pub fn is_product(&self) -> bool {
        self.scenario.targets.driving == Driving::Static
            && self.tables.belief.kind != BeliefKind::Particles
            && self.tables.exchange.mode != ExchangeMode::Snapshot
    }
}

fn pick<T: Copy>(rng: &mut ChaCha8Rng, of: &[T]) -> T {
    of[rng.random_range(0..of.len())]
}

fn world(scenario: &mut Scenario, rng: &mut ChaCha8Rng) {
    scenario.run.period_s = pick(rng, &[0.25, 0.5, 0.5, 1.0]);
    scenario.run.duration_s = rng.random_range(60..=90).into();
    scenario.map.size_m = [0; 2].map(|_| pick(rng, &[300.0, 331.0, 400.0, 500.0]));
    let half_m = scenario.map.size_m.map(|size| size / 2.0);
    let agents = &mut scenario.agents;
    agents.count = pick(rng, &[2, 2, 3, 4]);
    agents.speed_m_s = rng.random_range(12.0..25.0);
    agents.altitude_m = rng.random_range(80.0..95.0);
    let mut place = |reach: f64| half_m.map(|half| rng.random_range(-reach..reach) * half);
    agents.start = (0..agents.count)
        .map(|index| {
            let [x_m, y_m] = place(1.1);
            StartPose { x_m, y_m, yaw_deg: 90.0 * f64::from(index) - 170.0 }
        })
        .collect();
    let [x_m, y_m] = place(1.5);
    if rng.random_bool(0.3) {
        scenario.stations = vec![Station { x_m, y_m, z_m: 2.0 }];
    }
    if rng.random_bool(0.15) {
        scenario.targets.driving = Driving::RandomWalk;
        scenario.targets.walk_m_sqrt_s = rng.random_range(0.5..4.0);
    }
}

fn belief(tables: &mut Tables, rng: &mut ChaCha8Rng) {
    let belief = &mut tables.belief;
    (belief.kind, belief.cell_m) = match rng.random_range(0..10) {
        0..5 => (BeliefKind::Grid, pick(rng, &[5.0, 12.5, 20.0])),
        5..9 => (BeliefKind::Adaptive, pick(rng, &[12.5, 25.0])),
        _ => (BeliefKind::Particles, 12.5),
    };
    belief.min_cell_m = pick(rng, &[0.5, 2.0]);
    belief.particles = 500;
    belief.lag_s = pick(rng, &[0.0, 2.0, 10.0]);
    if rng.random_bool(0.3) {
        (tables.detector.p_detection, tables.detector.p_false) = (0.8, 0.05);
    }
    let guidance = &mut tables.guidance;
    guidance.criterion = pick(rng, &[Criterion::Information, Criterion::Lawnmower]);
    guidance.horizon_s = 8.0;
    guidance.beam = 4;
}

fn exchange(tables: &mut Tables, is_perfect: bool, rng: &mut ChaCha8Rng) {
    let exchange = &mut tables.exchange;
    exchange.mode = match rng.random_range(0..20) {
        0 => ExchangeMode::None,
        1 => ExchangeMode::Snapshot,
        2..7 => ExchangeMode::Facts,
        _ => ExchangeMode::FactsRepair,
    };
    if exchange.mode == ExchangeMode::Snapshot && tables.belief.kind == BeliefKind::Particles {
        tables.belief.kind = BeliefKind::Adaptive;
    }
    exchange.fusion = pick(rng, &[Fusion::Chernoff, Fusion::Product]);
    exchange.repair_period_s = rng.random_range(0.3..2.0);
    exchange.repair_delay_s = rng.random_range(0.2..2.0);
    if !is_perfect && rng.random_bool(0.25) {
        exchange.budget_bytes_s = rng.random_range(60.0..1000.0);
    }
    if rng.random_bool(0.25) {
        exchange.max_age_s = rng.random_range(1.0..6.0);
    }
}

fn links(netem: &mut NetemConfig, agents: u16, end_s: f64, rng: &mut ChaCha8Rng) {
    let radio = &mut netem.radio;
    if rng.random_bool(0.3) {
        radio.range_m = rng.random_range(60.0..350.0);
    }
    radio.loss = match rng.random_range(0..2) {
        0 => LossConfig::Iid { p: rate(rng) },
        _ => LossConfig::GilbertElliott {
            p: 0.5 * rate(rng),
            r: rng.random_range(0.05..1.0),
            h: 0.0,
            k: 1.0,
        },
    };
    let mean_s = rng.random_range(0.05..4.0);
    radio.delay = match rng.random_range(0..4) {
        0 => DelayConfig::Constant { mean_s: 0.0 },
        1 => DelayConfig::Constant { mean_s },
        2 => DelayConfig::Uniform { mean_s, spread_s: mean_s, correlation: 0.0 },
        _ => DelayConfig::Pareto { mean_s, shape: 2.5, correlation: 0.5 },
    };
    radio.corruption = 0.3 * rate(rng);
    radio.duplication = rate(rng);
    if rng.random_bool(0.2) {
        radio.mtu_bytes = rng.random_range(100..1000);
    }
    outages(netem, agents, end_s, rng);
    if rng.random_bool(0.3) {
        let from_s = rng.random_range(0.0..end_s * 0.7);
        let until_s = from_s + rng.random_range(1.0..end_s);
        let cut = rng.random_range(1..agents);
        let groups = vec![(0..cut).collect(), (cut..agents).collect()];
        let one_way = rng.random_bool(0.3);
        netem.partition.push(PartitionConfig { from_s, until_s, groups, one_way });
    }
}

/// Radios and processes that fail, some of them twice.
fn outages(netem: &mut NetemConfig, agents: u16, end_s: f64, rng: &mut ChaCha8Rng) {
    for agent in 0..agents {
        let mut from_s = 0.0;
        for _ in 0..2 {
            from_s += rng.random_range(0.0..end_s * 0.6);
            let longest_s = pick(rng, &[2.0, 0.3 * end_s]);
            let until_s = from_s + rng.random_range(0.3..longest_s);
            if rng.random_bool(0.4) && until_s < end_s {
                let kind = pick(rng, &[OutageKind::Radio, OutageKind::Crash, OutageKind::Crash]);
                netem.outage.push(OutageConfig { agent, from_s, until_s, kind });
                from_s = until_s + 0.1;
            }
        }
    }
}

/// Frames that an agent misses before step `end`, often none.
fn handicap(end: u32, rng: &mut ChaCha8Rng) -> Handicap {
    let gaps = if rng.random_bool(0.3) { rng.random_range(1..6) } else { 0 };
    let gap = |_| {
        let from = rng.random_range(0..end);
        from..(from + rng.random_range(1..=20)).min(end)
    };
    Handicap { ahead: 0, missed: (0..gaps).map(gap).collect() }
}

/// 0 half of the time.
fn rate(rng: &mut ChaCha8Rng) -> f64 {
    if rng.random_bool(0.5) { 0.0 } else { rng.random_range(0.0..0.7) }
}
