//! The stages of an agent-step, as calls on a recorded moment.
//!
//! `bench/callgrind.sh` counts what happens between entry and exit of functions with `stage_` in their
//! name: they must not be inlined, nor hold closures, which would match as well, nor be equal, as the
//! compiler would merge them.

use std::hint::black_box;

use csat_agent::config::{AgentConfig, Criterion, ExchangeMode};
use csat_agent::estimate::evidence::ReceivedFact;
use csat_agent::estimate::state::Knowledge;
use csat_agent::estimate::{Changes, Estimator};
use csat_agent::exchange::receiver::{CheckedMessage, Receiver};
use csat_agent::exchange::repair::Repair;
use csat_agent::exchange::transmitter::{StepContent, Transmitter};
use csat_agent::exchange::version_vector::VersionVector;
use csat_agent::guidance::{Decision, Planner, PlannerInput, PlannerRasters, ViewCache};
use csat_agent::identity::Identity;
use csat_agent::sense::{Measured, Sensor};
use csat_proto::frame::Frame;
use csat_proto::message::Digest;
use csat_proto::raster::Raster;
use csat_proto::time::Step;
use csat_world::camera::Renderer;

use super::{ME, Moment};

/// A planner by its criterion.
pub fn planner(config: &AgentConfig, criterion: Criterion) -> Planner {
    let mut config = config.clone();
    config.guidance.criterion = criterion;
    Planner::new(&config)
}

/// A transmitter that sends only facts, as most steps do: a new one would begin with a snapshot.
pub fn transmitter(config: &AgentConfig) -> (Transmitter, Repair) {
    let mut config = config.clone();
    config.exchange.mode = ExchangeMode::Facts;
    (Transmitter::new(&config), Repair::new(&config))
}

/// A receiver without any message.
pub fn receiver(config: &AgentConfig) -> (Receiver, VersionVector) {
    (Receiver::new(config), VersionVector::new(config))
}

/// Passes of guidance as the agent does them: picture, then search.
fn decide(planner: &mut Planner, moment: &Moment, passes: usize) -> Option<Decision> {
    let knowledge = &moment.fused;
    let unexplored = Raster::of_region(moment.config.raster_grid(), knowledge.unexplored.region());
    let rasters = PlannerRasters::of(knowledge, unexplored);
    let neighbours_hidden_now: Vec<Option<&Raster>> =
        moment.neighbours_hidden.iter().map(Some).collect();
    let view_cache = ViewCache::default();
    let input = PlannerInput {
        wanted: &rasters.wanted,
        margin: &rasters.margin,
        hidden_now: &moment.measured.hidden,
        neighbours: &[],
        plan_ages: &[],
        silent: &[],
        neighbours_hidden_now: &neighbours_hidden_now,
        hidden_recent: &rasters.hidden_recently,
        oem: &knowledge.oem,
        view_cache: Some(&view_cache),
        pose_error: moment.config.pose_error,
        ways: None,
    };
    let pass = |_| planner.plan(&input, &moment.frame.pose, &moment.plans);
    (0..passes).map(pass).last()
}

fn own(moment: &Moment) -> Option<(Step, &Measured)> {
    Some((moment.frame.step, &moment.measured))
}

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

/// An update with the own frame only: prediction and correction.
#[inline(never)]
pub fn stage_estimate(
    estimator: &Estimator,
    knowledge: &mut Knowledge,
    moment: &Moment,
) -> Changes {
    black_box("estimate");
    estimator.update(knowledge, own(moment), Vec::new())
}

/// The digest of what is held, and the step's fact with it, serialised.
#[inline(never)]
pub fn stage_say((transmitter, repair): &mut (Transmitter, Repair), moment: &Moment) {
    let content = StepContent {
        now: moment.now,
        step: moment.frame.step,
        pose: moment.frame.pose,
        measured: &moment.measured,
        changed: moment.changed.clone(),
        knowledge: &moment.before,
        unexplored_cells: &moment.unexplored_cells,
        held: Digest {
            facts: moment.held.clone(),
            oem: moment.before.oem.block_hashes().told_at(moment.frame.step),
        },
        uavs: vec![[0.0; 2]; 4],
    };
    assert!(transmitter.say_step(&content, repair).is_some());
}

/// Decodes and validates everything that the neighbours said in this step.
#[inline(never)]
pub fn stage_hear((receiver, held): &mut (Receiver, VersionVector), moment: &Moment) {
    for bytes in &moment.heard {
        let identity = Identity::of(bytes);
        let message = CheckedMessage::decode(&moment.config, moment.before.step, identity, bytes)
            .expect("an agent's own message");
        black_box(receiver.receive(&message, held).expect("an agent's own message"));
    }
}

/// An update as every step makes it: the own frame and the neighbours' facts at once.
#[inline(never)]
pub fn stage_update(
    estimator: &Estimator,
    knowledge: &mut Knowledge,
    (moment, facts): (&Moment, Vec<ReceivedFact>),
) -> Changes {
    black_box("update");
    estimator.update(knowledge, own(moment), facts)
}

/// The same with the neighbours' snapshots.
#[inline(never)]
pub fn stage_update_snapshots(
    estimator: &Estimator,
    knowledge: &mut Knowledge,
    (moment, snapshots): (&Moment, Vec<ReceivedFact>),
) -> Changes {
    black_box("update-snapshots");
    estimator.update(knowledge, own(moment), snapshots)
}

/// The neighbours' facts apart from a frame.
#[inline(never)]
pub fn stage_fuse(
    estimator: &Estimator,
    knowledge: &mut Knowledge,
    facts: Vec<ReceivedFact>,
) -> Changes {
    black_box("fuse");
    estimator.update(knowledge, None, facts)
}

/// The neighbours' snapshots apart from a frame: what was known is a step old by then.
#[inline(never)]
pub fn stage_fuse_snapshots(
    estimator: &Estimator,
    knowledge: &mut Knowledge,
    snapshots: Vec<ReceivedFact>,
) -> Changes {
    black_box("fuse-snapshots");
    estimator.update(knowledge, None, snapshots)
}

/// One pass of guidance under (5.16).
#[inline(never)]
pub fn stage_guidance_str1(planner: &mut Planner, moment: &Moment) -> Option<Decision> {
    black_box("str1");
    decide(planner, moment, 1)
}

/// One pass of guidance under (5.21).
#[inline(never)]
pub fn stage_guidance_str2(planner: &mut Planner, moment: &Moment) -> Option<Decision> {
    black_box("str2");
    decide(planner, moment, 1)
}

/// One pass of guidance under (5.27) and (5.32).
#[inline(never)]
pub fn stage_guidance_str3(planner: &mut Planner, moment: &Moment) -> Option<Decision> {
    black_box("str3");
    decide(planner, moment, 1)
}

/// Both passes of a decision under (5.27) and (5.32).
#[inline(never)]
pub fn stage_guidance_decision(planner: &mut Planner, moment: &Moment) -> Option<Decision> {
    black_box("decision");
    decide(planner, moment, 2)
}
