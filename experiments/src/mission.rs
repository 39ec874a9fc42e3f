//! One mission in one process, in virtual time: the engine steps, this loop measures and records.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use csat_netem::config::TraceLevel;
use csat_netem::counters::Counters;
use csat_proto::agent::Agent;
use csat_proto::ids::{AgentId, TargetId};
use csat_world::truth::Fault;
use csat_world::world::World;
use rayon::prelude::*;
use serde::Serialize;

use crate::engine::{Engine, LifeEvent, StepTrace};
use crate::metrics::{Coverage, StepRecord, targets_in_fov};
use crate::passages::{LinkRow, passage_lines};
use crate::plug::{Mission, Tally, Watched};
use crate::record::{Outcome, RecordError, Recorder};
use crate::scenario::Loaded;
use crate::seat::Seat;
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
    let trace = scenario.netem.trace;
    let tally = Tally::default();
    Flight { mission, engine, coverage, view, trace, tally, inconsistencies: 0 }.fly(
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
    /// What is written down of the links.
    trace: TraceLevel,
    /// What lives that are over did not believe and did not say.
    tally: Tally,
    inconsistencies: u64,
}

/// A line of `events.jsonl`: an agent's report.
#[derive(Serialize)]
struct AgentLine<'a, E> {
    agent: AgentId,
    #[serde(flatten)]
    event: &'a E,
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
        for (agent, event) in &trace.lives {
            if let LifeEvent::Crashed { .. } = event {
                let seat = &self.engine.seats()[usize::from(agent.0)];
                self.tally.add(&self.mission.tally(&seat.agent));
            }
            recorder.event(&AgentLine { agent: *agent, event })?;
        }
        for line in passage_lines(step, &trace.passages, self.trace) {
            recorder.event(&line)?;
        }
        for violation in &trace.violations {
            let fault = &violation.fault;
            recorder.event(&ViolationLine { event: "violation", step, fault })?;
        }
        Ok(())
    }

    /// One row per agent that runs.
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
            .filter(|(_, ((seat, _), _))| seat.is_alive())
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
        let watched: Vec<_> = self.engine.seats().iter().map(|seat| self.watched(seat)).collect();
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

    /// What an agent watches; nothing when it does not run.
    fn watched<'a>(&self, seat: &'a Seat<M::Agent>) -> Watched<'a> {
        if seat.is_alive() { self.mission.watched(&seat.agent) } else { Watched::default() }
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
        let mut tally = self.tally;
        let alive = seats.iter().filter(|seat| seat.is_alive());
        alive.for_each(|seat| tally.add(&self.mission.tally(&seat.agent)));
        Outcome {
            steps,
            sim_s,
            interrupted,
            violations: self.engine.monitor().counts().total(),
            inconsistencies: self.inconsistencies,
            bytes_sent: self.engine.counters().bytes_sent,
            messages: messages(self.engine.counters(), tally),
            links: self.engine.links().per_link().map(LinkRow::new).collect(),
            digest: self.engine.digest(),
            view: self.view.rounded(),
        }
    }
}

fn messages(counters: &Counters, tally: Tally) -> Messages {
    let dropped = counters.dropped.iter();
    Messages {
        sent: counters.sent,
        delivered: counters.delivered,
        dropped: dropped.map(|(reason, n)| (reason.name().to_owned(), *n)).collect(),
        duplicated: counters.duplicated,
        corrupted: counters.corrupted,
        in_flight: counters.in_flight,
        rejected: tally.rejected,
        withheld: tally.withheld,
    }
}
