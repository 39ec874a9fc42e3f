//! What an agent of the Bayesian search tells its observers.

use csat_bayes::agent::BayesAgent;
use csat_bayes::belief::region::CellSet;
use csat_bayes::config::{BeliefKind, ExchangeMode};
use csat_bayes::factor::{Factor, FactorId};
use csat_bayes::search_map::{Gaussian, SearchMap};
use csat_mission::mission::{self, Detail, Tally};
use csat_proto::camera::Pose;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::Step;
use serde::{Deserialize, Serialize};

/// How much of the probability the region holds.
pub const SHARE: f64 = 0.95;

/// The most sightings of a picture.
const MAX_SIGHTINGS: usize = 200;

/// What an agent knows at the end of a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Report {
    /// Whose.
    pub agent: AgentId,
    /// Its life.
    pub incarnation: Incarnation,
    /// The step that its belief is of.
    pub step: Step,
    /// The reported pose of its last frame, or where a ground station stands.
    pub pose: Pose,
    /// Where it intends to be, one pose per second.
    pub planned: Vec<Pose>,
    /// The factor of its last frame; `None` before the first one, and of a ground station.
    pub own: Option<Factor>,
    /// Mean and covariance of its belief.
    pub estimate: Gaussian,
    /// The densest part of the region that holds [`SHARE`] of the probability.
    pub region: CellSet,
    /// P(D) of the frames whose factors it holds (8).
    pub cumulative_detection: f64,
    /// How many factors its belief has.
    pub held: u64,
    /// Those of them that it got to hold in this step and in the one before.
    pub news: Vec<Factor>,
    /// Factors that were too late for a target that moves.
    pub left_out: u64,
    /// Places, `world`, metres, and ln of the density there, up to a constant that is the same for all; empty where the
    /// belief is not the product of the factors held.
    pub probes: Vec<([f64; 2], f64)>,
    /// What it did not believe and did not say.
    pub tally: Tally,
    /// What there is to draw, where [`Detail::Full`] was asked for.
    pub maps: Option<Maps>,
}

/// What there is to draw.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Maps {
    /// The probability of each cell of a coarse raster.
    pub belief: SearchMap,
    /// The particles, `world`, metres, if it has any.
    pub particles: Vec<[f64; 2]>,
    /// The newest sightings that it knows of, and where they are on the ground, `world`, metres.
    pub sightings: Vec<(FactorId, Step, [f64; 2])>,
}

impl Report {
    /// What `agent` knows now.
    pub fn of(agent: &BayesAgent, detail: Detail) -> Self {
        let (config, filter) = (agent.config(), agent.filter());
        let belief = filter.belief();
        let (step, estimate) = (filter.step(), belief.gaussian());
        // An agent that missed a frame hears of steps to which its belief has not come.
        let ahead = agent.factors().since(step.after(1)).count();
        Self {
            agent: config.id,
            incarnation: config.incarnation,
            step,
            pose: *agent.pose(),
            planned: agent.planned().to_vec(),
            own: agent.own_factor().copied(),
            estimate,
            region: belief.highest_density(SHARE),
            cumulative_detection: filter.cumulative_detection(),
            held: (agent.factors().len() - ahead) as u64,
            news: agent.recent().filter(|factor| factor.step <= step).copied().collect(),
            left_out: filter.left_out(),
            probes: probes(agent, &estimate),
            tally: Tally { rejected: agent.rejected().clone(), withheld: agent.withheld() },
            maps: (detail == Detail::Full).then(|| Maps::of(agent)),
        }
    }
}

/// Some places and the density there: the mean, the place below the aircraft, and fixed ones.
fn probes(agent: &BayesAgent, estimate: &Gaussian) -> Vec<([f64; 2], f64)> {
    let config = agent.config();
    let is_product = config.walk_m == 0.0
        && config.belief.kind != BeliefKind::Particles
        && config.exchange.mode != ExchangeMode::Snapshot;
    if !is_product {
        return Vec::new();
    }
    let [width, depth] = config.ground.size_m;
    let [x, y, _] = agent.pose().p_world;
    let places = [
        estimate.mean,
        [x, y],
        [0.0, 0.0],
        [-0.31 * width, 0.27 * depth],
        [0.42 * width, -0.36 * depth],
    ];
    places.into_iter().filter_map(|p| agent.filter().belief().at(p)).collect()
}

impl Maps {
    fn of(agent: &BayesAgent) -> Self {
        let belief = agent.filter().belief();
        let camera = agent.config().camera;
        let place = |factor: &Factor| {
            let [c, r] = factor.sighting?.map(f64::from);
            let location = camera.at(&factor.pose.into()).ground_point(c, r)?;
            Some((factor.id, factor.step, location))
        };
        let newest = agent.factors().since(Step(0)).rev().filter_map(place);
        Self {
            belief: belief.map(),
            particles: belief.particles(),
            sightings: newest.take(MAX_SIGHTINGS).collect(),
        }
    }
}

impl mission::Report for Report {
    fn step(&self) -> Step {
        self.step
    }

    fn pose(&self) -> &Pose {
        &self.pose
    }

    fn planned(&self) -> &[Pose] {
        &self.planned
    }

    fn tally(&self) -> &Tally {
        &self.tally
    }
}
