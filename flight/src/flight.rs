//! One mission from start to end: the engine steps, this loop measures and records.

use std::collections::{BTreeMap, BTreeSet};
use std::convert::Infallible;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use csat_mission::judge::{Broken, Fault, Judge, Violation};
use csat_mission::measures::{Measures, Values, in_order};
use csat_mission::picture::Layer;
use csat_mission::row::{Role, Row};
use csat_mission::style::Style;
use csat_netem::config::TraceLevel;
use csat_netem::counters::Counters;
use csat_netem::link::Links;
use csat_proto::camera::Pose;
use csat_proto::ids::AgentId;
use csat_proto::time::{SimTime, Step};
use csat_world::world::World;
use rayon::prelude::*;
use serde::Serialize;

use crate::passages::{LinkRow, passage_lines};
use crate::record::{Outcome, RecordError, Recorder};
use crate::scenario::missions::Offered;
use crate::scenario::{Loaded, Scenario};
use crate::summary::{Messages, NamedLiar};
use crate::view::Building;
use crate::view::UavTrack;
use crate::view::View;
use csat_mission::contact::{self, Contact};
use csat_mission::engine::{self, Engine, StepTrace};
use csat_mission::fleet::{Fleet, Flown};
use csat_mission::mission::{Detail, Mission, Report, Tally, Whole};

/// What the mission loop needs to know besides the scenario.
#[derive(Debug, Clone, Default)]
pub struct RunOptions {
    /// Set when the user wants the mission to end after the current step.
    pub interrupted: Arc<AtomicBool>,
}

/// Why a mission could not be flown to its end.
#[derive(Debug, thiserror::Error)]
pub enum FlightError<E> {
    /// It could not be written down.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// Its agents could not be reached.
    #[error("{0}")]
    Fleet(E),
}

/// One step, for an audience.
pub struct Moment<'a, M: Mission> {
    /// Simulated time, seconds.
    pub time_s: f64,
    /// The truth.
    pub world: &'a World,
    /// What happened.
    pub trace: &'a StepTrace<M>,
    /// A row per agent that runs.
    pub rows: &'a [Row],
    /// What the monitor found since the start.
    pub violations: u64,
}

/// Observes a mission while it is flown: recordings, live pictures.
pub trait Audience<M: Mission> {
    /// How much the agents are to tell of the step that is about to begin.
    fn wants(&mut self, step: Step) -> Detail;

    /// A step was flown.
    ///
    /// # Errors
    /// When it cannot be written down; the mission ends.
    fn see(&mut self, moment: &Moment<'_, M>) -> Result<(), RecordError>;
}

/// Several audiences.
impl<M: Mission> Audience<M> for Vec<&mut dyn Audience<M>> {
    fn wants(&mut self, step: Step) -> Detail {
        let wanted = self.iter_mut().map(|one| one.wants(step));
        wanted.fold(Detail::Brief, |all, one| if one == Detail::Full { one } else { all })
    }

    fn see(&mut self, moment: &Moment<'_, M>) -> Result<(), RecordError> {
        self.iter_mut().try_for_each(|one| one.see(moment))
    }
}

/// An audience, or none.
impl<M: Mission, A: Audience<M>> Audience<M> for Option<A> {
    fn wants(&mut self, step: Step) -> Detail {
        self.as_mut().map_or(Detail::Brief, |audience| audience.wants(step))
    }

    fn see(&mut self, moment: &Moment<'_, M>) -> Result<(), RecordError> {
        self.as_mut().map_or(Ok(()), |audience| audience.see(moment))
    }
}

/// No audience.
impl<M: Mission> Audience<M> for () {
    fn wants(&mut self, _: Step) -> Detail {
        Detail::Brief
    }

    fn see(&mut self, _: &Moment<'_, M>) -> Result<(), RecordError> {
        Ok(())
    }
}

/// Flies the mission of a scenario in this process and records its steps and events.
///
/// # Errors
/// When a step or an event cannot be written down.
pub fn run<M: Offered>(
    loaded: Loaded,
    options: &RunOptions,
    recorder: &mut Recorder,
    audience: &mut dyn Audience<M>,
) -> Result<Outcome, RecordError> {
    let Loaded { name, scenario, world, .. } = loaded;
    let mission = M::of(&scenario);
    let view = still_view(&name, &scenario, &world);
    let engine = Engine::new(mission.clone(), world, &scenario.netem, scenario.seed);
    let flight = Flight::new(mission, engine, &scenario, view);
    flight.fly(options, recorder, audience).map_err(|error: FlightError<Infallible>| match error {
        FlightError::Record(error) => error,
        FlightError::Fleet(never) => match never {},
    })
}

/// Flies the mission of a scenario with agents in other processes.
///
/// # Errors
/// When a step or an event cannot be written down, or agents cannot be reached.
pub fn run_fleet<M: Offered, F: Fleet<M>>(
    loaded: Loaded,
    fleet: F,
    options: &RunOptions,
    recorder: &mut Recorder,
    audience: &mut dyn Audience<M>,
) -> Result<Outcome, FlightError<F::Error>> {
    let Loaded { name, scenario, world, .. } = loaded;
    let mission = M::of(&scenario);
    let view = still_view(&name, &scenario, &world);
    let (netem, seed) = (&scenario.netem, scenario.seed);
    let engine = Engine::with_fleet(mission.clone(), world, fleet, netem, seed);
    Flight::new(mission, engine, &scenario, view).fly(options, recorder, audience)
}

/// The part of the picture that does not move.
fn still_view(name: &str, scenario: &Scenario, world: &World) -> View {
    View {
        scenario: name.to_owned(),
        seed: scenario.seed,
        size_m: scenario.map.size_m,
        obstacles: world.obstacles().iter().flat_map(Building::of).collect(),
        roads: world.roads().edges().iter().map(|edge| edge.line.clone()).collect(),
        uavs: vec![UavTrack::default(); usize::from(scenario.agents.count)],
        stations: scenario.stations.clone(),
        targets: vec![Vec::new(); world.targets().len()],
        attribution: world.map().attribution.clone(),
        ..View::default()
    }
}

/// A mission under way.
struct Flight<M: Mission, F> {
    mission: M,
    engine: Engine<M, F>,
    steps: u32,
    period_s: f64,
    measures: M::Measures,
    contact: Contact,
    view: View,
    /// What is written down of the links.
    trace: TraceLevel,
    inconsistencies: u64,
    /// The agents that were named as liars, by index.
    liars: Vec<NamedLiar>,
}

/// A line of `events.jsonl`: an agent's report.
#[derive(Serialize)]
struct AgentLine<'a, E> {
    agent: AgentId,
    #[serde(flatten)]
    event: &'a E,
    time_s: f64,
}

/// A line of `events.jsonl`: something that must never happen did.
#[derive(Debug, Serialize)]
pub struct ViolationLine<'a> {
    event: &'static str,
    step: Step,
    time_s: f64,
    #[serde(flatten)]
    fault: &'a Fault,
}

impl<'a> ViolationLine<'a> {
    /// What the monitor found, at this simulated time in seconds.
    pub fn new(violation: &'a Violation, time_s: f64) -> Self {
        Self { event: "violation", step: violation.step, time_s, fault: &violation.fault }
    }
}

impl<M: Mission, F: Fleet<M>> Flight<M, F> {
    fn new(mission: M, engine: Engine<M, F>, scenario: &Scenario, view: View) -> Self {
        let obstruction = engine::obstruction(&scenario.netem, engine.world());
        Self {
            contact: Contact::new(Links::new(&scenario.netem, scenario.seed, obstruction)),
            engine,
            steps: scenario.steps(),
            period_s: scenario.run.period_s,
            measures: mission.measures(),
            mission,
            view,
            trace: scenario.netem.trace,
            inconsistencies: 0,
            liars: Vec::new(),
        }
    }

    /// Flies all steps, from 0 on.
    fn fly(
        mut self,
        options: &RunOptions,
        recorder: &mut Recorder,
        audience: &mut dyn Audience<M>,
    ) -> Result<Outcome, FlightError<F::Error>> {
        let mut flown = 0;
        for step in 0..=self.steps {
            let detail = audience.wants(Step(step));
            let trace = self.engine.try_step(detail).map_err(FlightError::Fleet)?;
            let time_s = f64::from(step) * self.period_s;
            self.record_events(&trace, time_s, recorder)?;
            let rows = self.measure(&trace, time_s);
            let violations = self.engine.checked().total().violations;
            recorder.step(&rows, violations)?;
            self.draw_tracks(&trace.flown);
            let world = self.engine.world();
            audience.see(&Moment { time_s, world, trace: &trace, rows: &rows, violations })?;
            flown = step;
            if options.interrupted.load(Ordering::SeqCst) {
                break;
            }
        }
        let interrupted = flown < self.steps;
        Ok(self.outcome(flown, interrupted))
    }

    fn record_events(
        &mut self,
        trace: &StepTrace<M>,
        time_s: f64,
        recorder: &mut Recorder,
    ) -> Result<(), RecordError> {
        let step = trace.step.0;
        for (agent, event) in &trace.events {
            // What follows from false frames says nothing of others.
            let is_honest = !self.engine.is_false(*agent);
            let is_inconsistency = is_honest && self.mission.is_inconsistency(event);
            self.inconsistencies += u64::from(is_inconsistency);
            if let Some(liar) = self.mission.liar_in(event).filter(|_| is_honest) {
                NamedLiar::note(&mut self.liars, liar.0, agent.0, time_s);
            }
            recorder.event(&AgentLine { agent: *agent, event, time_s })?;
        }
        for (agent, event) in &trace.lives {
            recorder.event(&AgentLine { agent: *agent, event, time_s })?;
        }
        for line in passage_lines(step, &trace.passages, self.trace) {
            recorder.event(&line)?;
        }
        for violation in &trace.violations {
            recorder.event(&ViolationLine::new(violation, time_s))?;
        }
        Ok(())
    }

    /// One row per agent that runs, those of the UAVs first.
    fn measure(&mut self, trace: &StepTrace<M>, time_s: f64) -> Vec<Row> {
        let targets = self.engine.world().targets();
        let targets: Vec<[f64; 2]> = targets.iter().map(|target| target.location).collect();
        let uavs = usize::from(self.engine.world().config().fleet.count);
        let of_uavs = trace.flown.iter().filter(|flown| usize::from(flown.agent.0) < uavs);
        let reports: Vec<&M::Report> = of_uavs.filter_map(|flown| flown.report.as_ref()).collect();
        let truths = self.truths(&trace.flown);
        for flown in trace.flown.iter().filter(|flown| usize::from(flown.agent.0) < uavs) {
            let Some(report) = &flown.report else { continue };
            let pose =
                self.engine.poses_at(report.step()).map(|all| all[usize::from(flown.agent.0)]);
            if let (Some(pose), Some(targets)) = (pose, truths.get(&report.step())) {
                self.measures.observe(report, &pose, targets);
            }
        }
        let judge = self.engine.judge();
        let mut fleet = self.measures.fleet(&reports, &targets);
        fleet.extend(judge.fleet());
        let poses = self.engine.world().poses();
        fleet.extend(in_contact(&mut self.contact, trace, &poses[..uavs], self.period_s));
        let broken = |id: AgentId| {
            let faults = trace.violations.iter().map(|violation| &violation.fault);
            faults
                .filter(|f| matches!(f, Fault::Mission(Broken { agent, .. }) if *agent == id))
                .count()
        };
        let (mission, measures, step) = (&self.mission, &self.measures, trace.step.0);
        let row = |flown: &Flown<M>| {
            let report = flown.report.as_ref()?;
            let targets = truths.get(&report.step())?;
            let pose = &poses[usize::from(flown.agent.0)];
            let of_judge = judge.agent(flown.agent);
            let values = measures.agent(report, targets).into_iter().chain(of_judge);
            let values = values.chain(fleet.iter().copied());
            Some(Row {
                step,
                time_s,
                agent: flown.agent.0,
                role: if mission.camera(flown.agent).is_some() { Role::Uav } else { Role::Station },
                p_world: pose.p_world,
                yaw_rad: pose.yaw_rad,
                bytes_sent: flown.bytes_sent,
                violations: broken(flown.agent) as u32,
                values: in_order(Whole::<M>::KIND.columns, values),
                times: flown.times,
            })
        };
        trace.flown.par_iter().filter_map(row).collect()
    }

    /// Where targets were at the steps of these reports: one step, but in real time, where some come late.
    fn truths(&self, flown: &[Flown<M>]) -> BTreeMap<Step, Vec<[f64; 2]>> {
        let steps = flown.iter().filter_map(|f| f.report.as_ref()).map(Report::step);
        let steps: BTreeSet<Step> = steps.collect();
        let located = |step| {
            let truth = self.engine.truth_at(step)?;
            Some((step, truth.iter().map(|target| target.location).collect()))
        };
        steps.into_iter().filter_map(located).collect()
    }

    fn draw_tracks(&mut self, flown: &[Flown<M>]) {
        self.view.uavs.iter_mut().for_each(|uav| uav.footprint.clear());
        for flown in flown {
            let uav = self.view.uavs.get_mut(usize::from(flown.agent.0));
            if let (Some(report), Some(uav)) = (&flown.report, uav) {
                uav.footprint = self.mission.footprint(report);
            }
        }
        let world = self.engine.world();
        for (uav, pose) in self.view.uavs.iter_mut().zip(world.poses()) {
            uav.path.push([pose.p_world[0], pose.p_world[1]]);
            uav.yaw_rad = pose.yaw_rad;
        }
        for (path, target) in self.view.targets.iter_mut().zip(world.targets()) {
            path.push(target.location);
        }
    }

    fn outcome(mut self, steps: u32, interrupted: bool) -> Outcome {
        let sim_s = f64::from(steps) * self.period_s;
        self.view.time_s = sim_s;
        let mission = &self.mission;
        let draw = |report: Option<M::Report>| report.map(|report| mission.picture(&report));
        let drawn = self.engine.show().into_par_iter().map(draw);
        self.view.agents = drawn.map(Option::unwrap_or_default).collect();
        // A legend does not explain what no agent has.
        let is_drawn = |style: &&Style| {
            self.view.agents.iter().any(|layers| Layer::of(layers, style).is_some())
        };
        self.view.layers = M::LAYERS.iter().filter(is_drawn).cloned().collect();
        let counters = self.engine.counters();
        let links = self.engine.per_link();
        let sums =
            links.iter().fold((0, 0), |(s, d), (_, l)| (s + l.counts.sent, d + l.counts.delivered));
        debug_assert_eq!(sums, (counters.sent, counters.delivered), "links.csv and the summary");
        Outcome {
            steps,
            sim_s,
            interrupted,
            checked: self.engine.checked(),
            unchecked: self.engine.unchecked(),
            inconsistencies: self.inconsistencies,
            liars: self.liars,
            bytes_sent: counters.bytes_sent,
            messages: messages(&counters, self.engine.tally()),
            frames: self.engine.frames(),
            refused: self.engine.refused(),
            links: links.iter().map(|(id, counters)| LinkRow::new((*id, counters))).collect(),
            digest: self.engine.digest(),
            view: self.view.rounded(),
        }
    }
}

/// How well the UAVs, which are at `poses`, are in touch.
fn in_contact<M: Mission>(
    contact: &mut Contact,
    trace: &StepTrace<M>,
    poses: &[Pose],
    period_s: f64,
) -> Values {
    let at = |step: Step| SimTime::from_seconds(f64::from(step.0) * period_s);
    contact.measure(&contact::Moment {
        now: at(trace.step),
        next: at(trace.step.after(1)),
        poses,
        alive: &trace.alive,
        lives: &trace.lives,
        passages: &trace.passages,
    })
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
