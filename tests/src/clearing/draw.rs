//! From a seed to a scenario of road clearing: every fault has its own rate, which is often 0.

use csat_clearing::config::{Coding, Give, Rules};
use csat_flight::scenario::Scenario;
use csat_flight::scenario::clearing::Tables;
use csat_netem::config::{
    ChannelConfig, DelayConfig, LossConfig, OutageConfig, OutageKind, PartitionConfig,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::missions::{shipped, with_tables};

/// The mission of a seed.
#[derive(Debug, Clone)]
pub struct Draw {
    /// The mission, with its faults.
    pub scenario: Scenario,
    /// Its own tables.
    pub tables: Tables,
    /// Whether links are perfect.
    pub is_perfect: bool,
}

impl Draw {
    /// The mission of a seed.
    ///
    /// # Panics
    /// When something is wrong with it.
    pub fn new(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut scenario = shipped("clearing");
        scenario.seed = rng.random::<u32>().into();
        let mut tables = Tables::default();
        world(&mut scenario, &mut tables, &mut rng);
        let is_perfect = rng.random_bool(0.25);
        if !is_perfect {
            links(&mut scenario, &mut rng);
        }
        let scenario = with_tables(scenario, &tables);
        Self { scenario, tables, is_perfect }
    }
}

fn pick<T: Copy>(rng: &mut ChaCha8Rng, of: &[T]) -> T {
    of[rng.random_range(0..of.len())]
}

fn world(scenario: &mut Scenario, tables: &mut Tables, rng: &mut ChaCha8Rng) {
    scenario.run.duration_s = rng.random_range(150..=300).into();
    scenario.map.size_m = [0; 2].map(|_| pick(rng, &[200.0, 260.0, 330.0]));
    scenario.map.road_spacing_m = rng.random_range(45.0..130.0);
    scenario.agents.count = pick(rng, &[1, 2, 3, 4, 6, 8]);
    scenario.agents.multirotor.motion_error_m = pick(rng, &[0.0, 0.02, 0.05, 0.11]);
    tables.odometry.jitter_m = pick(rng, &[0.0, 0.05, 0.1, 0.5]);
    tables.odometry.drift_share = pick(rng, &[0.0, 0.001, 0.002, 0.05]);
    let noise = &mut tables.segmentation;
    noise.gap_px = pick(rng, &[0, 1, 1]);
    noise.gap_share = if noise.gap_px > 0 { rng.random_range(0.0..0.3) } else { 0.0 };
    noise.edge_share = rng.random_range(0.0..0.5);
    noise.speckle_share = pick(rng, &[0.0, 0.001, 0.01]);
    let clearing = &mut tables.clearing;
    clearing.rules = Rules::Acknowledged;
    clearing.give = pick(rng, &[Give::Paper, Give::Balanced]);
    clearing.coding = pick(rng, &[Coding::Bitmap, Coding::Runs]);
    clearing.lost_after_s = pick(rng, &[10.0, 40.0]);
}

fn links(scenario: &mut Scenario, rng: &mut ChaCha8Rng) {
    let (agents, end_s) = (scenario.agents.count, scenario.run.duration_s);
    let hbsr = scenario.netem.channels.get_mut("hbsr").expect("the scenario has it");
    hbsr.range_m = rng.random_range(60.0..160.0);
    hbsr.offset_error_m = Some(pick(rng, &[0.0, 0.3, 0.6]));
    faults(hbsr, rng);
    let lblr = scenario.netem.channels.get_mut("lblr").expect("the scenario has it");
    lblr.bearing_error_deg = pick(rng, &[0.0, 5.0, 20.0]);
    faults(lblr, rng);
    if agents > 1 && rng.random_bool(0.2) {
        let from_s = rng.random_range(0.0..end_s * 0.7);
        let until_s = from_s + rng.random_range(1.0..end_s / 3.0);
        let cut = rng.random_range(1..agents);
        let groups = vec![(0..cut).collect(), (cut..agents).collect()];
        scenario.netem.partition.push(PartitionConfig { from_s, until_s, groups, one_way: false });
    }
    for agent in 0..agents {
        if rng.random_bool(0.1) {
            let from_s = rng.random_range(0.0..end_s * 0.8);
            let until_s = (from_s + rng.random_range(1.0..60.0)).min(end_s);
            let kind = pick(rng, &[OutageKind::Radio, OutageKind::Crash]);
            scenario.netem.outage.push(OutageConfig { agent, from_s, until_s, kind });
        }
    }
}

/// Losses of up to 60 %, delays of up to 2 s, copies, damage.
fn faults(channel: &mut ChannelConfig, rng: &mut ChaCha8Rng) {
    channel.loss = LossConfig::Iid { p: rate(0.6, rng) };
    let mean_s = rng.random_range(0.05..2.0);
    channel.delay = match rng.random_range(0..3) {
        0 => DelayConfig::Constant { mean_s: 0.0 },
        1 => DelayConfig::Constant { mean_s },
        _ => {
            DelayConfig::Uniform { mean_s: mean_s / 2.0, spread_s: mean_s / 2.0, correlation: 0.0 }
        }
    };
    channel.corruption = rate(0.2, rng);
    channel.duplication = rate(0.5, rng);
}

/// 0 half of the time.
fn rate(most: f64, rng: &mut ChaCha8Rng) -> f64 {
    if rng.random_bool(0.5) { 0.0 } else { rng.random_range(0.0..most) }
}
