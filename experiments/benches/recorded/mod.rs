//! Moments recorded in the middle of a mission, and the stages of an agent-step as calls on them.
//!
//! A stage's cost depends on how much is known by then, so nothing here is made up: the engine flies
//! a scenario, and what goes into each stage of agent 0 at some step is kept.

use std::hint::black_box;
use std::path::Path;

use csat_agent::agent::SetMembershipAgent;
use csat_agent::config::{AgentConfig, Criterion, ExchangeMode};
use csat_agent::estimate::correct::{Changes, correct};
use csat_agent::estimate::fuse::{Fused, Fuser};
use csat_agent::estimate::predict::Predictor;
use csat_agent::estimate::state::Knowledge;
use csat_agent::exchange::inbox::Inbox;
use csat_agent::exchange::outbox::Outbox;
use csat_agent::guidance::{Decision, Picture, Planner};
use csat_agent::sense::{Measured, Sensor};
use csat_experiments::engine::Engine;
use csat_experiments::mission::{self, RunOptions};
use csat_experiments::plug::Mission;
use csat_experiments::record::{RecordOptions, Recorder};
use csat_experiments::run_folder::Destination;
use csat_experiments::scenario::{self, Loaded, Request};
use csat_experiments::set_membership::SetMembership;
use csat_proto::agent::Agent;
use csat_proto::camera::Pose;
use csat_proto::envelope::Envelope;
use csat_proto::frame::Frame;
use csat_proto::ids::AgentId;
use csat_proto::message::{Fact, Message, Snapshot};
use csat_proto::raster::Raster;
use csat_proto::time::{SimTime, Step};
use csat_world::camera::Renderer;
use csat_world::scene::Scene;

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
    pub measured: Measured,
    pub changes: Changes,
    /// After the frame.
    pub corrected: Knowledge,
    /// The neighbours' messages of this step, as they travel.
    pub heard: Vec<Vec<u8>>,
    pub facts: Vec<Fact>,
    /// What the neighbours would say in a snapshot at this step.
    pub snapshots: Vec<Snapshot>,
    /// After `facts`.
    pub fused: Knowledge,
    /// The neighbours' plans.
    pub plans: Vec<Vec<Pose>>,
    neighbours_hidden: Vec<Raster>,
}

/// Flies until the last of `times_s`, increasing multiples of T_MPC in seconds, and records each.
pub fn moments(times_s: &[f64]) -> Vec<Moment> {
    let Loaded { scenario, world, .. } = load(&[]);
    let mission = SetMembership::new(&scenario);
    let config = mission.agent(ME).config().clone();
    let mut engine = Engine::new(mission, world, &scenario.netem, scenario.seed);
    let mut renderer = Renderer::new(config.camera);
    let mut sensor = Sensor::new(&config);
    let mut moments = Vec::new();
    for &time_s in times_s {
        let last = Step((time_s / config.period_s).round() as u32);
        loop {
            let agents: Vec<_> = engine.seats().iter().map(|seat| seat.agent.clone()).collect();
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
            let flown = engine.seats()[0].agent.digest();
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
    let before = agents[0].knowledge().clone();
    for (agent, frame) in agents.iter_mut().zip(&frames) {
        agent.handle_frame(now, frame);
    }
    let measured = sensor.clone().measure(&frames[0]);
    assert_eq!(Some(&measured), agents[0].measured(), "the sensor saw something else");
    let mut corrected = before.clone();
    let changes = estimate(&Predictor::new(&config), &mut corrected, &frames[0], &measured);
    assert_eq!(corrected.digest(), agents[0].digest());
    let others = || agents.iter().skip(1);
    let snapshots = others().map(snapshot).collect();
    let neighbours_hidden = others()
        .map(|agent| agent.measured().map_or_else(|| measured.hidden.clone(), |m| m.hidden.clone()))
        .collect();
    let heard = settle(&mut agents, now);
    let (mut facts, mut plans) = (Vec::new(), Vec::new());
    for bytes in &heard {
        match decode(bytes) {
            Message::Fact(fact) => facts.push(fact),
            Message::Plan(plan) if plan.pass == 0 => plans.push(plan.poses),
            Message::Plan(_) | Message::Snapshot(_) => {}
        }
    }
    assert_eq!((facts.len(), plans.len()), (agents.len() - 1, agents.len() - 1));
    let mut fused = corrected.clone();
    Fuser::new(&config).fuse(&mut fused, &facts, &[]);
    Moment {
        config,
        scene,
        seed,
        now,
        frame: frames.swap_remove(0),
        sensor,
        before,
        measured,
        changes,
        corrected,
        heard,
        facts,
        snapshots,
        fused,
        plans,
        neighbours_hidden,
    }
}

/// What the agent would say in a snapshot.
fn snapshot(agent: &SetMembershipAgent) -> Snapshot {
    let (knowledge, measured) = (agent.knowledge(), agent.measured().expect("it had a frame"));
    Snapshot {
        step: knowledge.step,
        targets: knowledge.targets.iter().map(|(&j, set)| (j, set.region().clone())).collect(),
        unexplored: knowledge.unexplored.region().clone(),
        obstacle_margin: knowledge.margin.region().clone(),
        hidden: measured.hidden.clone(),
        seen: measured.seen.clone(),
        oem: knowledge.oem.known(),
    }
}

/// Lets the agents talk until nothing is left to say; returns all that agent 0 heard.
fn settle(agents: &mut [SetMembershipAgent], now: SimTime) -> Vec<Vec<u8>> {
    let mut heard = Vec::new();
    loop {
        for src in 0..agents.len() {
            while let Some(transmit) = agents[src].poll_transmit() {
                for dst in (0..agents.len()).filter(|&dst| dst != src) {
                    agents[dst].handle_message(now, &transmit.bytes);
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

fn decode(bytes: &[u8]) -> Message {
    let envelope = Envelope::decode(bytes).expect("an agent's own envelope");
    postcard::from_bytes(&envelope.body).expect("an agent's own message")
}

/// A planner by its criterion.
pub fn planner(config: &AgentConfig, criterion: Criterion) -> Planner {
    let mut config = config.clone();
    config.guidance.criterion = criterion;
    Planner::new(&config)
}

/// An outbox that says only facts, as most steps do: a new one would begin with a snapshot.
pub fn outbox(config: &AgentConfig) -> Outbox {
    let mut config = config.clone();
    config.exchange.mode = ExchangeMode::Facts;
    Outbox::new(&config)
}

/// One pass of guidance as the agent does it: picture, then search.
fn decide(planner: &mut Planner, moment: &Moment) -> Decision {
    let knowledge = &moment.fused;
    let margin = Raster::of_region(moment.config.raster_grid(), knowledge.margin.region());
    let neighbours_hidden_now: Vec<Option<&Raster>> =
        moment.neighbours_hidden.iter().map(Some).collect();
    let picture = Picture {
        wanted: &knowledge.wanted(),
        margin: &margin,
        hidden_now: &moment.measured.hidden,
        neighbours_hidden_now: &neighbours_hidden_now,
        hidden_recent: &knowledge.hidden_recently(),
        oem: &knowledge.oem,
    };
    planner.plan(&picture, &moment.frame.pose, &moment.plans)
}

fn estimate(
    predictor: &Predictor,
    knowledge: &mut Knowledge,
    frame: &Frame,
    measured: &Measured,
) -> Changes {
    let predicted = predictor.predict(knowledge, frame.step);
    correct(knowledge, &predicted, measured)
}

fn hear(inbox: &mut Inbox, moment: &Moment) {
    for bytes in &moment.heard {
        inbox.receive(moment.before.step, bytes).expect("an agent's own message");
    }
}

// The stages. `bench/callgrind.sh` counts what happens between entry and exit of functions with
// `stage_` in their name: they must not be inlined, nor hold closures, which would match as well, nor be equal,
// as the compiler would merge them.

/// A frame of the world.
#[inline(never)]
pub fn stage_render(renderer: &mut Renderer, moment: &Moment) -> Frame {
    renderer.frame(&moment.scene, &moment.frame.pose, moment.frame.step, moment.seed, ME)
}

/// Frame to measured sets.
#[inline(never)]
pub fn stage_sense(sensor: &mut Sensor, frame: &Frame) -> Measured {
    sensor.measure(frame)
}

/// Prediction and correction.
#[inline(never)]
pub fn stage_estimate(
    predictor: &Predictor,
    knowledge: &mut Knowledge,
    frame: &Frame,
    measured: &Measured,
) -> Changes {
    estimate(predictor, knowledge, frame, measured)
}

/// Serialises the step's fact.
#[inline(never)]
pub fn stage_say(outbox: &mut Outbox, moment: &Moment) {
    let Moment { now, frame, corrected, measured, changes, .. } = moment;
    outbox.say_step(*now, frame.pose, corrected, measured, changes);
}

/// Decodes and validates everything that the neighbours said in this step.
#[inline(never)]
pub fn stage_hear(inbox: &mut Inbox, moment: &Moment) {
    hear(inbox, moment);
}

/// Fuses the neighbours' facts.
#[inline(never)]
pub fn stage_fuse(fuser: &Fuser, knowledge: &mut Knowledge, facts: &[Fact]) -> Fused {
    fuser.fuse(knowledge, facts, &[])
}

/// Fuses the neighbours' snapshots.
#[inline(never)]
pub fn stage_fuse_snapshots(
    fuser: &Fuser,
    knowledge: &mut Knowledge,
    snapshots: &[Snapshot],
) -> Fused {
    fuser.fuse(knowledge, &[], snapshots)
}

/// One pass of guidance under (5.16).
#[inline(never)]
pub fn stage_guidance_str1(planner: &mut Planner, moment: &Moment) -> Decision {
    black_box("str1");
    decide(planner, moment)
}

/// One pass of guidance under (5.21).
#[inline(never)]
pub fn stage_guidance_str2(planner: &mut Planner, moment: &Moment) -> Decision {
    black_box("str2");
    decide(planner, moment)
}

/// One pass of guidance under (5.27) and (5.32).
#[inline(never)]
pub fn stage_guidance_str3(planner: &mut Planner, moment: &Moment) -> Decision {
    black_box("str3");
    decide(planner, moment)
}

/// The scenario with changes, ready to fly.
fn load(sets: &[String]) -> Loaded {
    let request = Request { scenario: Some(SCENARIO), sets, seed: Some(1) };
    scenario::load(request).unwrap_or_else(|mistakes| panic!("{mistakes}"))
}

/// Flies, measures and records a whole mission, pictures included.
pub fn whole_mission((loaded, mut recorder): (Loaded, Recorder)) {
    let outcome = mission::run(loaded, &RunOptions::default(), &mut recorder);
    recorder.finish(outcome.expect("a mission flies")).expect("a run folder");
}

/// A mission of `duration_s` about to be recorded in a new folder under `runs`.
pub fn about_to_fly(duration_s: u32, runs: &Path) -> (Loaded, Recorder) {
    let loaded = load(&[format!("run.duration_s={duration_s}")]);
    let destination = Destination::Numbered(runs.join(SCENARIO));
    let recorder = Recorder::create(&loaded, &RecordOptions { destination, quiet: true });
    (loaded, recorder.expect("a run folder"))
}
