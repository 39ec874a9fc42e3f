//! One mission in one process, in virtual time: the engine steps, this loop measures and records.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use csat_netem::fate::Sent;
use csat_netem::link::Counters;
use csat_netem::rule::Reason;
use csat_proto::agent::Agent;
use csat_proto::ids::{AgentId, TargetId};
use csat_world::truth::Fault;
use csat_world::world::World;
use rayon::prelude::*;
use serde::Serialize;

use crate::engine::{Drop, Engine, StepTrace};
use crate::metrics::{Coverage, StepRecord, targets_in_fov};
use crate::plug::Mission;
use crate::record::{Outcome, RecordError, Recorder};
use crate::scenario::Loaded;
use crate::set_membership::SetMembership;
use crate::summary::Messages;
use crate::view::{Building, UavTrack, View};

/// Side of the cells that coverage is counted in, metres.
const COVERAGE_CELL_M: f64 = 1.0;

/// What the mission loop needs to know besides the scenario.
#[derive(Debug, Clone, Default)]
pub struct RunOptions {
    /// Set when the user wants the mission to end after the current step.
    pub interrupted: Arc<AtomicBool>,
}

/// Flies the mission of a scenario and records its steps and events.
///
/// # Errors
/// When a step or an event cannot be written down.
pub fn run(
    loaded: Loaded,
    options: &RunOptions,
    recorder: &mut Recorder,
) -> Result<Outcome, RecordError> {
    let Loaded { name, scenario, world, .. } = loaded;
    let mission = SetMembership::new(&scenario);
    let view = View {
        scenario: name,
        seed: scenario.seed,
        size_m: scenario.map.size_m,
        ..still_view(&world)
    };
    let engine = Engine::new(mission.clone(), world, &scenario.netem, scenario.seed);
    let coverage = Coverage::new(scenario.ground(), COVERAGE_CELL_M);
    Flight { mission, engine, coverage, view, inconsistencies: 0 }.fly(
        scenario.steps(),
        scenario.run.period_s,
        options,
        recorder,
    )
}

/// The part of the picture that does not move.
fn still_view(world: &World) -> View {
    let buildings = world.obstacles().iter();
    View {
        obstacles: buildings
            .map(|o| Building { rings: o.rings().collect(), height_m: o.height_m })
            .collect(),
        roads: world.roads().edges().iter().map(|edge| edge.line.clone()).collect(),
        uavs: vec![UavTrack::default(); world.poses().len()],
        targets: vec![Vec::new(); world.targets().len()],
        attribution: world.map().attribution.clone(),
        ..View::default()
    }
}

/// A mission under way.
struct Flight<M: Mission> {
    mission: M,
    engine: Engine<M>,
    coverage: Coverage,
    view: View,
    inconsistencies: u64,
}

/// A line of `events.jsonl`: an agent's report.
#[derive(Serialize)]
struct AgentLine<'a, E> {
    agent: AgentId,
    #[serde(flatten)]
    event: &'a E,
}

/// A line of `events.jsonl`: a lost message.
#[derive(Serialize)]
struct DropLine {
    event: &'static str,
    step: u32,
    src: AgentId,
    dst: AgentId,
    sequence: u64,
    reason: Reason,
}

/// A line of `events.jsonl`: something that must never happen did.
#[derive(Serialize)]
struct ViolationLine<'a> {
    event: &'static str,
    step: u32,
    #[serde(flatten)]
    fault: &'a Fault,
}

impl<M: Mission> Flight<M> {
    /// Flies steps 0 to `steps`.
    fn fly(
        mut self,
        steps: u32,
        period_s: f64,
        options: &RunOptions,
        recorder: &mut Recorder,
    ) -> Result<Outcome, RecordError> {
        let mut flown = 0;
        for step in 0..=steps {
            let trace = self.engine.step();
            self.record_events(&trace, recorder)?;
            let rows = self.measure(&trace, f64::from(step) * period_s);
            recorder.step(&rows, self.engine.monitor().counts().total())?;
            self.draw_tracks();
            flown = step;
            if options.interrupted.load(Ordering::SeqCst) {
                break;
            }
        }
        let interrupted = flown < steps;
        Ok(self.outcome(flown, f64::from(flown) * period_s, interrupted))
    }

    fn record_events(
        &mut self,
        trace: &StepTrace<<M::Agent as Agent>::Event>,
        recorder: &mut Recorder,
    ) -> Result<(), RecordError> {
        let step = trace.step.0;
        for (agent, event) in &trace.events {
            self.inconsistencies += u64::from(self.mission.is_inconsistency(event));
            recorder.event(&AgentLine { agent: *agent, event })?;
        }
        for Drop { sent, reason } in &trace.drops {
            let Sent { src, dst, sequence, .. } = *sent;
            let reason = *reason;
            recorder.event(&DropLine { event: "drop", step, src, dst, sequence, reason })?;
        }
        for violation in &trace.violations {
            let fault = &violation.fault;
            recorder.event(&ViolationLine { event: "violation", step, fault })?;
        }
        Ok(())
    }

    /// One row per agent.
    fn measure(
        &mut self,
        trace: &StepTrace<<M::Agent as Agent>::Event>,
        time_s: f64,
    ) -> Vec<StepRecord> {
        let truth: Vec<[f64; 2]> =
            self.engine.world().targets().iter().map(|t| t.location).collect();
        let fleet = self.measure_fleet(&truth);
        let mut broken = vec![0; self.engine.seats().len()];
        for violation in &trace.violations {
            if let Fault::Guarantee { agent, .. } = violation.fault {
                broken[usize::from(agent.0)] += 1;
            }
        }
        let poses = self.engine.world().poses();
        let (mission, step) = (&self.mission, trace.step.0);
        let seats = self.engine.seats_mut().par_iter_mut();
        seats
            .zip(&poses)
            .zip(&broken)
            .enumerate()
            .map(|(index, ((seat, pose), &violations))| {
                let [x_m, y_m, z_m] = pose.p_world;
                let mut row = StepRecord {
                    step,
                    time_s,
                    agent: index as u16,
                    x_m,
                    y_m,
                    z_m,
                    yaw_rad: pose.yaw_rad,
                    bytes_sent: seat.bytes_sent,
                    violations,
                    times: seat.times,
                    ..fleet
                };
                mission.measure(&mut seat.agent, &truth, &mut row);
                row
            })
            .collect()
    }

    /// What is the same in every row of a step.
    fn measure_fleet(&mut self, truth: &[[f64; 2]]) -> StepRecord {
        let watched: Vec<_> =
            self.engine.seats().iter().map(|seat| self.mission.watched(&seat.agent)).collect();
        let mut fleet = StepRecord::default();
        let (mut identified, mut detected) =
            (BTreeSet::<TargetId>::new(), BTreeSet::<TargetId>::new());
        for (uav, w) in self.view.uavs.iter_mut().zip(&watched) {
            identified.extend(&w.identified);
            detected.extend(&w.detected);
            if let Some(clear_ground) = w.clear_ground {
                self.coverage.add(&w.footprint, clear_ground);
            }
            uav.footprint.clone_from(&w.footprint);
        }
        fleet.identified_union = identified.len() as u16;
        fleet.targets_detected = detected.len() as u16;
        let footprints: Vec<_> = watched.into_iter().map(|w| w.footprint).collect();
        fleet.targets_in_fov = targets_in_fov(&footprints, truth);
        fleet.set_coverage(self.coverage.finish_step());
        fleet
    }

    fn draw_tracks(&mut self) {
        let world = self.engine.world();
        for (uav, pose) in self.view.uavs.iter_mut().zip(world.poses()) {
            uav.path.push([pose.p_world[0], pose.p_world[1]]);
            uav.yaw_rad = pose.yaw_rad;
        }
        for (path, target) in self.view.targets.iter_mut().zip(world.targets()) {
            path.push(target.location);
        }
    }

    fn outcome(mut self, steps: u32, sim_s: f64, interrupted: bool) -> Outcome {
        let seats = self.engine.seats();
        self.view.time_s = sim_s;
        self.view.agents = seats.iter().map(|seat| self.mission.view(&seat.agent)).collect();
        let receivers = seats.len().saturating_sub(1).max(1) as u64;
        Outcome {
            steps,
            sim_s,
            interrupted,
            violations: self.engine.monitor().counts().total(),
            inconsistencies: self.inconsistencies,
            // The links count a message once per receiver.
            bytes_sent: self.engine.counters().bytes_sent / receivers,
            messages: messages(self.engine.counters()),
            digest: self.engine.digest(),
            view: self.view.rounded(),
        }
    }
}

fn messages(counters: &Counters) -> Messages {
    let name = |reason| match serde_json::to_value(reason) {
        Ok(serde_json::Value::String(name)) => name,
        _ => format!("{reason:?}"),
    };
    Messages {
        sent: counters.sent,
        delivered: counters.delivered,
        dropped: counters.dropped.iter().map(|(reason, n)| (name(reason), *n)).collect(),
        duplicated: counters.duplicated,
    }
}
