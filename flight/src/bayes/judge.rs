//! What the mission promises at every step: each agent holds only what UAVs stated, and its belief is the
//! product of the factors that it holds. (That the truth is in the 95 % region in 95 % of the missions is a promise
//! of many missions: a test keeps it.)

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use csat_bayes::factor::{Factor, FactorId};
use csat_bayes::likelihood::{Likelihood, Sensor};
use csat_mission::judge::{Broken, Judge, Judged, Promise, Truth};
use csat_proto::ids::{AgentId, Incarnation};
use serde_json::json;

use super::report::Report;

/// Allowed difference of ln of a density, relative to its sum of logarithms and at least to 1.
const TOLERANCE: f64 = 1e-9;

/// The belief is the product of the factors held.
pub const POSTERIOR: &str = "posterior";
/// Factors are those of UAVs.
pub const FACTORS: &str = "factors";

/// All that the mission promises of each report.
pub const PROMISES: &[Promise] = &[
    Promise { key: POSTERIOR, broken: "a belief that is not the product of the factors held" },
    Promise { key: FACTORS, broken: "a factor held that differs from the one that was stated" },
];

/// Holds beliefs against the factors that agents hold.
pub struct Posterior {
    sensor: Sensor,
    known: BTreeMap<FactorId, (Factor, Arc<Likelihood>)>,
    agents: BTreeMap<AgentId, Account>,
}

/// What the judge knows of an agent.
#[derive(Default)]
struct Account {
    incarnation: Incarnation,
    ids: BTreeSet<FactorId>,
    held: Vec<Arc<Likelihood>>,
    /// The places of the last probes, and the sum of ln ℓ there over `counted` factors.
    sums: Vec<([f64; 2], f64)>,
    counted: usize,
}

impl Posterior {
    /// A judge of agents with this sensor.
    pub fn new(sensor: Sensor) -> Self {
        Self { sensor, known: BTreeMap::new(), agents: BTreeMap::new() }
    }

    /// The likelihood of a factor that an agent holds, and whether it is the one that others hold.
    fn likelihood(&mut self, factor: &Factor) -> (Arc<Likelihood>, bool) {
        let sensor = &self.sensor;
        let new = || (*factor, Arc::new(Likelihood::new(sensor, factor)));
        let (first, likelihood) = self.known.entry(factor.id).or_insert_with(new);
        (likelihood.clone(), first == factor)
    }
}

impl Account {
    /// ln of the product of all factors held at each place.
    fn products(&mut self, places: impl Iterator<Item = [f64; 2]>) -> Vec<f64> {
        let (held, counted) = (&self.held, self.counted);
        let sum = |x: [f64; 2]| {
            let before = self.sums.iter().find(|(place, _)| *place == x);
            let (start, first) = before.map_or((0.0, 0), |(_, sum)| (*sum, counted));
            held[first..].iter().fold(start, |sum, likelihood| sum + likelihood.ln_ratio(x))
        };
        self.sums = places.map(|x| (x, sum(x))).collect();
        self.counted = self.held.len();
        self.sums.iter().map(|(_, sum)| *sum).collect()
    }
}

impl Judge<Report> for Posterior {
    fn judge(&mut self, agent: AgentId, report: &Report, _: &Truth<'_>) -> Judged {
        let mut judged = Judged::default();
        let account = self.agents.entry(agent).or_default();
        if account.incarnation != report.incarnation {
            *account = Account { incarnation: report.incarnation, ..Account::default() };
        }
        let is_new = |factor: &&Factor| !account.ids.contains(&factor.id);
        let news: Vec<Factor> = report.news.iter().filter(is_new).copied().collect();
        judged.checks.push((FACTORS, news.len() as u64));
        for factor in news {
            let (likelihood, is_same) = self.likelihood(&factor);
            if !is_same {
                judged.faults.push(Broken::new(FACTORS, agent, json!({ "factor": factor.id })));
            }
            let account = self.agents.entry(agent).or_default();
            if account.ids.insert(factor.id) {
                account.held.push(likelihood);
            }
        }
        let account = self.agents.entry(agent).or_default();
        // In real time reports may get lost: then it is not known what the agent holds.
        if account.held.len() as u64 != report.held || report.probes.len() < 2 {
            return judged;
        }
        let products = account.products(report.probes.iter().map(|(place, _)| *place));
        let (first_product, (first_place, first)) = (products[0], report.probes[0]);
        for ((place, ln), product) in report.probes.iter().zip(&products).skip(1) {
            let (told, expected) = (ln - first, product - first_product);
            let scale = ln.abs().max(first.abs()).max(1.0);
            // False for what is no number.
            let is_right = (told - expected).abs() <= TOLERANCE * scale;
            if !is_right {
                let detail = json!({
                    "places": [first_place, place], "ln_ratio": told, "expected": expected,
                });
                judged.faults.push(Broken::new(POSTERIOR, agent, detail));
            }
        }
        judged.checks.push((POSTERIOR, report.probes.len() as u64 - 1));
        judged
    }
}
