//! How often the target is where it is believed to be, over many short missions.

use csat_bayes::config::{ExchangeConfig, ExchangeMode, Fusion};
use csat_flight::scenario::Scenario;
use csat_mission::engine::Engine;
use csat_netem::config::LossConfig;
use csat_proto::model::StartPose;
use csat_world::navigation::Noise;
use rayon::prelude::*;
use statrs::distribution::{Binomial, DiscreteCDF};

use super::missions::Tables;
use super::quiet::Quiet;
use crate::missions::world_of;
use crate::missions::{shipped, with_tables};

/// The share of the probability that a region holds.
pub const SHARE: f64 = 0.95;
/// A right program is found wrong this often, in each direction.
const ERROR: f64 = 0.0005;

/// A kind of mission.
#[derive(Debug, Clone)]
pub struct Setting {
    /// Side of the region, metres.
    pub side_m: f64,
    /// When beliefs are looked at, seconds: the last time is the end of the mission.
    pub looks_s: Vec<f64>,
    /// Whether links have 300 m of range and lose three messages of ten, in bursts.
    pub is_lossy: bool,
    /// `[exchange]`.
    pub exchange: ExchangeConfig,
    /// How errors of poses change.
    pub noise: Noise,
}

impl Default for Setting {
    fn default() -> Self {
        Self {
            side_m: 400.0,
            looks_s: vec![15.0, 40.0, 90.0],
            is_lossy: false,
            exchange: ExchangeConfig::default(),
            noise: Noise::White,
        }
    }
}

impl Setting {
    /// Beliefs are told, and fused in this way.
    pub fn of_beliefs(fusion: Fusion) -> Self {
        let exchange =
            ExchangeConfig { mode: ExchangeMode::Snapshot, fusion, ..ExchangeConfig::default() };
        Self { exchange, ..Self::default() }
    }

    fn scenario(&self, seed: u64) -> Scenario {
        let mut scenario = shipped("tisdale");
        scenario.seed = seed;
        scenario.run.duration_s = self.looks_s.last().copied().unwrap_or_default();
        scenario.run.period_s = 0.5;
        scenario.map.size_m = [self.side_m; 2];
        let x_m = 0.48 * self.side_m;
        let start = |x_m| StartPose { x_m, y_m: -0.52 * self.side_m, yaw_deg: 90.0 };
        scenario.agents.start = vec![start(-x_m), start(x_m)];
        if self.is_lossy {
            scenario.netem.radio.range_m = 300.0;
            // Bursts of ten messages.
            let (r, k) = (0.1, 1.0);
            scenario.netem.radio.loss =
                LossConfig::GilbertElliott { p: 0.3 / 0.7 * r, r, h: 0.0, k };
        }
        let mut tables = Tables { exchange: self.exchange.clone(), ..Tables::default() };
        tables.pose.noise = self.noise;
        // Guidance takes more time than the filter.
        (tables.guidance.horizon_s, tables.guidance.beam) = (8.0, 4);
        tables.guidance.period_s = 2.0;
        with_tables(scenario, &tables)
    }
}

/// What UAV 0 believed when it was looked at.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    /// Whether the target was in the 95 % region.
    pub is_in: bool,
    /// How sure it was: the square root of the trace of the covariance, metres.
    pub sigma_m: f64,
    /// From the mean to the target, metres.
    pub error_m: f64,
}

/// Flies the missions of these seeds: for each time of [`Setting::looks_s`] a look at each.
pub fn fly(setting: &Setting, seeds: std::ops::Range<u64>) -> Vec<Vec<Look>> {
    let missions: Vec<Vec<Look>> = seeds.into_par_iter().map(|seed| looks(setting, seed)).collect();
    let of = |index: usize| missions.iter().map(|looks| looks[index]).collect();
    (0..setting.looks_s.len()).map(of).collect()
}

fn looks(setting: &Setting, seed: u64) -> Vec<Look> {
    let scenario = setting.scenario(seed);
    let world = world_of(&scenario).expect("open ground");
    let mut engine = Engine::new(Quiet::new(&scenario), world, &scenario.netem, scenario.seed);
    let mut flown = 0;
    let mut looks = Vec::new();
    for at_s in &setting.looks_s {
        let until = (at_s / scenario.run.period_s) as u32 + 1;
        (flown..until).for_each(|_| drop(engine.step()));
        flown = until;
        looks.push(look(&engine));
    }
    looks
}

fn look(engine: &Engine<Quiet>) -> Look {
    let [x, y] = engine.world().targets()[0].location;
    let belief = engine.nodes()[0].agent.filter().belief();
    let estimate = belief.gaussian();
    Look {
        is_in: belief.highest_density(SHARE).contains([x, y]),
        sigma_m: estimate.sigma_m(),
        error_m: (estimate.mean[0] - x).hypot(estimate.mean[1] - y),
    }
}

/// In how many missions the target was where it was believed to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Coverage {
    /// Where it was.
    pub hits: u64,
    /// All of them.
    pub missions: u64,
}

impl Coverage {
    /// Counts.
    pub fn of(looks: &[Look]) -> Self {
        let hits = looks.iter().filter(|look| look.is_in).count() as u64;
        Self { hits, missions: looks.len() as u64 }
    }

    /// The share.
    pub fn share(self) -> f64 {
        self.hits as f64 / self.missions as f64
    }

    /// Whether so few hits are no accident where 95 % are promised.
    pub fn is_too_low(self) -> bool {
        self.binomial().cdf(self.hits) < ERROR
    }

    /// Whether so many hits are no accident.
    pub fn is_too_high(self) -> bool {
        self.hits > 0 && self.binomial().sf(self.hits - 1) < ERROR
    }

    fn binomial(self) -> Binomial {
        Binomial::new(SHARE, self.missions).expect("a probability")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accidents_are_told_from_mistakes() {
        let of = |hits| Coverage { hits, missions: 200 };
        assert!((181..199).all(|hits| !of(hits).is_too_low() && !of(hits).is_too_high()));
        assert!(of(176).is_too_low() && of(178).is_too_low(), "0.88 is too low");
        assert!(of(200).is_too_high() && !of(200).is_too_low());
        assert!(Coverage { hits: 0, missions: 4 }.is_too_low());
    }
}
