//! Moments recorded in the middle of a mission, and the [`stages`] of an agent-step as calls on them.
//!
//! A stage's cost depends on how much is known by then, so nothing here is made up: the engine flies
//! a scenario, and what goes into each stage of agent 0 at some step is kept.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use csat_agent::agent::SetMembershipAgent;
use csat_agent::config::AgentConfig;
use csat_agent::estimate::Estimator;
use csat_agent::estimate::evidence::ReceivedFact;
use csat_agent::estimate::state::Knowledge;
use csat_agent::identity::Identity;
use csat_agent::sense::{Measured, Sensor};
use csat_experiments::flight::{self, RunOptions};
use csat_experiments::record::{RecordOptions, Recorder};
use csat_experiments::run_folder::Destination;
use csat_experiments::scenario::{self, Loaded, Request};
use csat_experiments::set_membership::SetMembership;
use csat_mission::engine::Engine;
use csat_mission::mission::Mission;
use csat_proto::agent::Agent;
use csat_proto::camera::Pose;
use csat_proto::envelope::Envelope;
use csat_proto::frame::Frame;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::message::{Fact, HeldFacts, Known, Message};
use csat_proto::oem::{OemCell, OemPatch};
use csat_proto::radio::Reception;
use csat_proto::raster::Raster;
use csat_proto::time::{SimTime, Step};
use csat_world::camera::Renderer;
use csat_world::scene::Scene;

mod stages;
pub use stages::*;

/// The scenario that is flown, with its own seed 1.
const SCENARIO: &str = "city";
const ME: AgentId = AgentId(0);

/// What goes into, and comes out of, the stages of agent 0 at one step, at which it decides.
pub struct Moment {
    pub config: AgentConfig,
    pub scene: Scene,
    pub seed: u64,
    pub now: SimTime,
    pub frame: Frame,
    /// Before the frame.
    pub sensor: Sensor,
    /// Before the frame.
    pub before: Knowledge,
    /// X̄ before the frame.
    pub unexplored_cells: Raster,
    pub measured: Measured,
    /// Cells of the map that the frame changed.
    pub changed: BTreeMap<u32, OemCell>,
    /// Facts held before the frame.
    pub held: Vec<HeldFacts>,
    /// After the frame alone.
    pub corrected: Knowledge,
    /// The neighbours' messages of this step, as they travel.
    pub heard: Vec<Vec<u8>>,
    pub facts: Vec<ReceivedFact>,
    /// What the neighbours would say in a snapshot at this step.
    pub snapshots: Vec<ReceivedFact>,
    /// After the frame and `facts`.
    pub fused: Knowledge,
    /// The neighbours' plans.
    pub plans: Vec<Vec<Pose>>,
    neighbours_hidden: Vec<Raster>,
}

/// Flies until the last of `times_s`, increasing multiples of T_MPC in seconds, and records each.
pub fn moments(times_s: &[f64]) -> Vec<Moment> {
    let Loaded { scenario, world, .. } = load(&[]);
    let mission = SetMembership::new(&scenario);
    let config = mission.agent(ME, Incarnation(0)).config().clone();
    let mut engine = Engine::new(mission, world, &scenario.netem, scenario.seed);
    let mut renderer = Renderer::new(config.camera);
    let mut sensor = Sensor::new(&config);
    let mut moments = Vec::new();
    for &time_s in times_s {
        let last = Step((time_s / config.period_s).round() as u32);
        loop {
            let agents: Vec<_> = engine.nodes().iter().map(|node| node.agent.clone()).collect();
            let step = engine.step().step;
            let (scene, poses) = (engine.world().scene(), engine.world().poses());
            let mut look = |id: usize| {
                renderer.frame(&scene, &poses[id], step, scenario.seed, AgentId(id as u16))
            };
            if step < last {
                sensor.measure(&look(0));
                continue;
            }
            let frames: Vec<Frame> = (0..poses.len()).map(look).collect();
            let now = SimTime::from_seconds(f64::from(step.0) * config.period_s);
            let before = sensor.clone();
            sensor.measure(&frames[0]);
            let moment = record(before, agents, frames, now, scene, scenario.seed);
            let flown = engine.nodes()[0].agent.digest();
            assert_eq!(moment.fused.digest(), flown, "recorded something else than was flown");
            moments.push(moment);
            break;
        }
    }
    moments
}

/// Repeats a step with clones of the agents to see what they say to each other.
fn record(
    sensor: Sensor,
    mut agents: Vec<SetMembershipAgent>,
    mut frames: Vec<Frame>,
    now: SimTime,
    scene: Scene,
    seed: u64,
) -> Moment {
    let config = agents[0].config().clone();
    let before = Knowledge::clone(agents[0].knowledge());
    let unexplored_cells = Raster::of_region(config.raster_grid(), before.unexplored.region());
    let known: Vec<Known> = agents.iter().skip(1).map(|agent| known(agent.knowledge())).collect();
    for (agent, frame) in agents.iter_mut().zip(&frames) {
        agent.handle_frame(now, frame);
    }
    let measured = sensor.clone().measure(&frames[0]);
    assert_eq!(Some(&measured), agents[0].measured(), "the sensor saw something else");
    let changed = before.oem.changes(&measured.oem);
    let neighbours_hidden = agents
        .iter()
        .skip(1)
        .map(|agent| agent.measured().map_or_else(|| measured.hidden.clone(), |m| m.hidden.clone()))
        .collect();
    let heard = settle(&mut agents, now);
    let (facts, plans) = read(&heard);
    assert_eq!((facts.len(), plans.len()), (agents.len() - 1, agents.len() - 1));
    let held = facts[0].fact.held.facts.clone();
    let snapshots = facts.iter().zip(known).map(|(h, known)| snapshot(h, known, &before)).collect();
    let estimator = Estimator::new(&config);
    let (mut corrected, mut fused) = (before.clone(), before.clone());
    let own = Some((frames[0].step, &measured));
    estimator.update(&mut corrected, own, Vec::new());
    estimator.update(&mut fused, own, facts.clone());
    Moment {
        config,
        scene,
        seed,
        now,
        frame: frames.swap_remove(0),
        sensor,
        before,
        unexplored_cells,
        measured,
        changed,
        held,
        corrected,
        heard,
        facts,
        snapshots,
        fused,
        plans,
        neighbours_hidden,
    }
}

/// The facts, and the plans of the first pass.
fn read(letters: &[Vec<u8>]) -> (Vec<ReceivedFact>, Vec<Vec<Pose>>) {
    let (mut facts, mut plans) = (Vec::new(), Vec::new());
    for bytes in letters {
        let Envelope { src, incarnation, body, .. } =
            Envelope::decode(bytes).expect("an agent's own envelope");
        match postcard::from_bytes(&body).expect("an agent's own message") {
            Message::Fact(fact) => {
                let (fact, identity) = (Arc::new(fact), Identity::of(bytes));
                let is_answer = false;
                facts.push(ReceivedFact {
                    src,
                    incarnation,
                    fact,
                    known: None,
                    is_answer,
                    identity,
                });
            }
            Message::Plan(plan) if plan.pass == 0 => {
                plans.push(plan.poses.into_iter().map(Pose::from).collect());
            }
            Message::Plan(_) | Message::Relay(_) | Message::Snapshot(_) => {}
        }
    }
    (facts, plans)
}

fn known(knowledge: &Knowledge) -> Known {
    Known {
        step: knowledge.step,
        targets: knowledge.targets.iter().map(|(&j, set)| (j, set.region().clone())).collect(),
        unexplored: knowledge.unexplored.region().clone(),
        obstacle_margin: knowledge.margin.region().clone(),
    }
}

/// The same fact as a snapshot, with the whole map.
fn snapshot(heard: &ReceivedFact, known: Known, before: &Knowledge) -> ReceivedFact {
    let fact = Fact { oem: OemPatch::of(before.oem.known()), ..Fact::clone(&heard.fact) };
    ReceivedFact { fact: Arc::new(fact), known: Some(Arc::new(known)), ..heard.clone() }
}

/// Lets the agents talk until nothing is left to say; returns all that agent 0 heard.
fn settle(agents: &mut [SetMembershipAgent], now: SimTime) -> Vec<Vec<u8>> {
    let mut heard = Vec::new();
    loop {
        for src in 0..agents.len() {
            while let Some(transmit) = agents[src].poll_transmit() {
                let message = Reception {
                    channel: transmit.channel,
                    at: now,
                    bearing_rad: 0.0,
                    offset_m: None,
                    bytes: transmit.bytes[..].into(),
                };
                for dst in (0..agents.len()).filter(|&dst| dst != src) {
                    agents[dst].handle_message(now, &message);
                }
                heard.extend((src != 0).then_some(transmit.bytes));
            }
        }
        let due = |agent: &SetMembershipAgent| agent.poll_timeout().is_some_and(|due| due <= now);
        if !agents.iter().any(due) {
            return heard;
        }
        agents.iter_mut().filter(|agent| due(agent)).for_each(|agent| agent.handle_timeout(now));
    }
}

/// The scenario with changes, ready to fly.
fn load(sets: &[String]) -> Loaded {
    let request = Request { scenario: Some(SCENARIO), sets, seed: Some(1) };
    scenario::load(request).unwrap_or_else(|mistakes| panic!("{mistakes}"))
}

/// Flies, measures and records a whole mission, pictures included.
pub fn whole_mission((loaded, mut recorder): (Loaded, Recorder)) {
    let outcome =
        flight::run::<SetMembership>(loaded, &RunOptions::default(), &mut recorder, &mut ());
    recorder.finish(outcome.expect("a mission flies")).expect("a run folder");
}

/// A mission of `duration_s` about to be recorded in a new folder under `runs`.
pub fn about_to_fly(duration_s: u32, runs: &Path) -> (Loaded, Recorder) {
    let loaded = load(&[format!("run.duration_s={duration_s}")]);
    let destination = Destination::Numbered(runs.join(SCENARIO));
    let recorder = Recorder::create(&loaded, &RecordOptions { destination, quiet: true });
    (loaded, recorder.expect("a run folder"))
}
