//! The laws that hold at every step of every mission, and in the end.

use std::collections::{BTreeMap, BTreeSet};

use csat_bayes::agent::{BayesAgent, Event};
use csat_bayes::config::BeliefKind;
use csat_bayes::factor::{Factor, FactorId};
use csat_bayes::likelihood::{Likelihood, Sensor};
use csat_bayes::search_map::CELL_M;
use csat_mission::engine::{LifeEvent, StepTrace};
use csat_mission::node::Node;
use csat_proto::camera::Pose;
use csat_proto::ids::AgentId;
use csat_proto::model::Driving;
use csat_proto::raster::Grid;

use super::draw::Draw;
use super::factors::{Ledger, Now};
use super::{Exercise, Handicapped, Swarm};

/// Allowed difference of ln of a density and the product of factors, relative to the largest sum of logarithms
/// on the way, at least to 1.
const TOLERANCE: f64 = 1e-9;

/// What happened in a step.
pub type Trace = StepTrace<Handicapped>;

/// Checks one mission.
pub struct Laws<'a> {
    draw: &'a Draw,
    ledger: Ledger,
    likelihoods: BTreeMap<FactorId, Likelihood>,
    is_healed: bool,
    exercise: Exercise,
}

impl<'a> Laws<'a> {
    /// The state before the first step.
    pub fn new(draw: &'a Draw) -> Self {
        Self {
            draw,
            ledger: Ledger::default(),
            likelihoods: BTreeMap::new(),
            is_healed: draw.is_perfect,
            exercise: Exercise::default(),
        }
    }

    /// From now on links are perfect.
    pub fn heal(&mut self) {
        self.is_healed = true;
    }

    /// Checks one step.
    ///
    /// # Errors
    /// The first law that does not hold.
    pub fn check(&mut self, engine: &Swarm, trace: &Trace) -> Result<(), String> {
        for (agent, life) in &trace.lives {
            if let LifeEvent::Crashed { .. } = life {
                self.exercise.crashes += 1;
                self.ledger.forget(*agent);
            }
        }
        if let Some(violation) = trace.violations.first() {
            return Err(format!("violated: {:?}", violation.fault));
        }
        let is_conflict = |(_, event): &&(AgentId, Event)| matches!(event, Event::Conflict { .. });
        if let Some((agent, event)) = trace.events.iter().find(is_conflict) {
            return Err(format!("agent {agent}: {event:?}"));
        }
        if !engine.counters().conserved() {
            return Err(format!("messages vanish: {:?}", engine.counters()));
        }
        self.check_factors(engine, trace)?;
        for (id, node) in alive(engine) {
            self.check_product(id, &node.agent.inner)?;
        }
        self.check_equal(engine, trace)
    }

    /// Agents hold what was stated and what they were told.
    fn check_factors(&mut self, engine: &Swarm, trace: &Trace) -> Result<(), String> {
        let reported = engine.world().reported_poses();
        for (id, node) in alive(engine) {
            if self.draw.misses(id, trace.step) {
                self.exercise.missed += 1;
                continue;
            }
            let pose = reported
                .get(usize::from(id.0))
                .map_or_else(Pose::default, |estimate| estimate.pose);
            let incarnation = node.incarnation();
            let is_seen =
                self.ledger.state(id, incarnation, &node.agent.inner, trace.step, &pose)?;
            self.exercise.sightings += u64::from(is_seen);
        }
        let now = Now {
            period_s: self.draw.scenario.run.period_s,
            max_age_s: self.draw.tables.exchange.max_age_s,
        };
        let late_us = (now.period_s * 1e6) as u64;
        for passage in &trace.passages {
            let copies = passage.fate.copies().flatten();
            let late = copies.filter(|copy| copy.at.0 >= passage.sent.time.0 + late_us);
            self.exercise.late += late.count() as u64;
        }
        for arrival in &trace.arrivals {
            if engine.is_alive(arrival.dst) {
                self.ledger.hear(arrival, now, &mut self.exercise)?;
            }
        }
        alive(engine).try_for_each(|(id, node)| self.ledger.check(id, &node.agent.inner))
    }

    /// The belief of an agent is the product of the factors that it holds.
    fn check_product(&mut self, id: AgentId, agent: &BayesAgent) -> Result<(), String> {
        if !self.draw.is_product() {
            return Ok(());
        }
        let sensor = Sensor::new(agent.config());
        for factor in agent.factors().iter() {
            let new = || Likelihood::new(&sensor, factor);
            self.likelihoods.entry(factor.id).or_insert_with(new);
        }
        // An agent that missed a frame holds factors of steps to which its belief has not come.
        let is_applied = |factor: &&Factor| factor.step <= agent.filter().step();
        let applied = agent.factors().iter().filter(is_applied);
        let held: Vec<&Likelihood> =
            applied.filter_map(|factor| self.likelihoods.get(&factor.id)).collect();
        let belief = agent.filter().belief();
        let mut first = None;
        for place in places(agent) {
            let Some((centre, ln)) = belief.at(place) else { continue };
            let (mut product, mut scale) = (0.0f64, 1.0f64);
            for likelihood in &held {
                product += likelihood.ln_ratio(centre);
                scale = scale.max(product.abs());
            }
            self.exercise.products += 1;
            let (zero, product_there) = *first.get_or_insert((ln, product));
            // False for what is no number.
            let is_right = (ln - zero - (product - product_there)).abs() <= TOLERANCE * scale;
            if !is_right {
                return Err(format!(
                    "agent {id} with {} factors believes {ln} at {centre:?} and {zero} elsewhere, where products \
                     are {product} and {product_there}",
                    held.len()
                ));
            }
        }
        Ok(())
    }

    /// With perfect links all agents hold the factors of this step. If links were always perfect, all hold the
    /// same, and the same bits follow.
    fn check_equal(&mut self, engine: &Swarm, trace: &Trace) -> Result<(), String> {
        if !self.is_healed || !self.draw.tells_all() {
            return Ok(());
        }
        let uavs = self.draw.scenario.agents.count;
        for (id, node) in alive(engine) {
            let of_now = node.agent.inner.factors().since(trace.step).count();
            if of_now != usize::from(uavs) {
                return Err(format!("agent {id} holds {of_now} factors of this step"));
            }
        }
        self.exercise.equal += 1;
        if !self.draw.is_perfect {
            return Ok(());
        }
        let all = usize::from(uavs) * (trace.step.0 as usize + 1);
        let mut bits = alive(engine).map(|(id, node)| {
            let count = node.agent.inner.factors().len();
            let filter = node.agent.inner.filter();
            let mut bits = vec![filter.cumulative_detection().to_bits()];
            if self.draw.tables.belief.kind != BeliefKind::Particles {
                filter.belief().numbers(&mut |x| bits.push(x.to_bits()));
            }
            (id, count, bits)
        });
        let (_, _, expected) = bits.next().ok_or("nobody flies")?;
        for (id, count, bits) in bits {
            if count != all || bits != expected {
                return Err(format!("agent {id} holds {count} of {all}, or believes other bits"));
            }
        }
        self.exercise.identical += 1;
        Ok(())
    }

    /// The end of the mission.
    ///
    /// # Errors
    /// Agents that have to hold the same do not.
    pub fn finish(mut self, engine: &Swarm) -> Result<Exercise, String> {
        alive(engine).try_for_each(|(id, node)| self.check_detection(id, &node.agent.inner))?;
        if self.draw.must_converge() {
            self.check_converged(engine)?;
            self.exercise.converged = u64::from(!self.draw.is_perfect);
        }
        let counters = engine.counters();
        Ok(Exercise {
            missions: 1,
            delivered: counters.delivered,
            dropped: counters.dropped.values().sum(),
            corrupted: counters.corrupted,
            duplicated: counters.duplicated,
            tight: u64::from(engine.tally().withheld > 0),
            stationed: u64::from(!self.draw.scenario.stations.is_empty()),
            moving: u64::from(self.draw.scenario.targets.driving == Driving::RandomWalk),
            ..self.exercise
        })
    }

    /// P(D) is that of the factors held (8).
    fn check_detection(&self, id: AgentId, agent: &BayesAgent) -> Result<(), String> {
        if !self.draw.is_product() {
            return Ok(());
        }
        let grid = Grid::covering(&agent.config().ground, CELL_M);
        let ids = agent.factors().iter().map(|factor| factor.id);
        let held: Vec<&Likelihood> = ids.filter_map(|id| self.likelihoods.get(&id)).collect();
        let mut missed = 0.0;
        for row in 0..grid.rows {
            for column in 0..grid.columns {
                let x = grid.centre(column, row);
                let in_sight =
                    |frame: &&&Likelihood| frame.footprint().is_some_and(|f| f.contains(x));
                let frames = held.iter().filter(in_sight);
                missed += frames.map(|frame| 1.0 - frame.p_detection(x)).product::<f64>();
            }
        }
        let expected = 1.0 - missed / grid.cells() as f64;
        let got = agent.filter().cumulative_detection();
        // Agents compute p(D, V | x) in single precision.
        match (got - expected).abs() < 1e-6 {
            true => Ok(()),
            false => Err(format!("P(D) of agent {id} is {got}, of its factors {expected}")),
        }
    }

    fn check_converged(&self, engine: &Swarm) -> Result<(), String> {
        let held: Vec<(AgentId, BTreeSet<FactorId>)> =
            alive(engine).map(|(id, _)| (id, self.ledger.held(id))).collect();
        let all: BTreeSet<FactorId> = held.iter().flat_map(|(_, held)| held).copied().collect();
        match held.iter().find(|(_, held)| *held != all) {
            Some((id, held)) => {
                let missing: Vec<_> = all.difference(held).take(3).collect();
                let count = all.len() - held.len();
                Err(format!("healed, but agent {id} is missing {count} factors: {missing:?} …"))
            }
            None => Ok(()),
        }
    }
}

fn alive(engine: &Swarm) -> impl Iterator<Item = (AgentId, &Node<Handicapped>)> {
    (0..).map(AgentId).zip(engine.nodes()).filter(|(_, node)| node.is_alive())
}

/// Where a belief is compared: at its mean, around it, below the aircraft, and at fixed places.
fn places(agent: &BayesAgent) -> Vec<[f64; 2]> {
    let [mx, my] = agent.filter().belief().gaussian().mean;
    let [x, y, _] = agent.pose().p_world;
    let [width, depth] = agent.config().ground.size_m;
    let fixed = [[-0.4, -0.3], [0.1, 0.45], [0.37, -0.21]].map(|[i, j]| [i * width, j * depth]);
    let moving = [[mx, my], [mx + 9.0, my - 4.0], [x, y], [x - 20.0, y + 13.0]];
    [&fixed[..], &moving].concat()
}
