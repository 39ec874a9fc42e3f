//! A mission of one's own, as docs/extending.md explains it: a census. Each UAV flies straight ahead
//! and counts the cars that its camera identifies. It says nothing and claims nothing.

use std::collections::BTreeSet;

use csat_experiments::scenario::{self, Request};
use csat_mission::engine::Engine;
use csat_mission::mission::{Detail, Mission, Report, Tally, Watched};
use csat_mission::row::StepRecord;
use csat_proto::agent::{Agent, Transmit};
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::command::YawCommand;
use csat_proto::frame::Frame;
use csat_proto::ids::{AgentId, Incarnation, TargetId};
use csat_proto::radio::Reception;
use csat_proto::time::{SimTime, Step};
use serde::{Deserialize, Serialize};

/// What an agent knows: all that its observers get to know, too.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Count {
    step: Step,
    pose: Pose,
    seen: BTreeSet<TargetId>,
    tally: Tally,
}

/// The agent: a state machine without clock, socket or file.
struct Counter(Count);

impl Agent for Counter {
    type Command = YawCommand;
    type Event = ();

    fn handle_frame(&mut self, _: SimTime, frame: &Frame) {
        (self.0.step, self.0.pose) = (frame.step, frame.pose);
        self.0.seen.extend(frame.detections.iter().map(|detection| detection.target));
    }

    fn handle_step(&mut self, _: SimTime, step: Step, pose: Pose) {
        (self.0.step, self.0.pose) = (step, pose);
    }

    fn handle_message(&mut self, _: SimTime, _: &Reception) {}
    fn handle_timeout(&mut self, _: SimTime) {}

    fn poll_transmit(&mut self) -> Option<Transmit> {
        None
    }

    fn answer(&mut self, _: SimTime) -> Option<Transmit> {
        None
    }

    fn poll_command(&mut self) -> Option<YawCommand> {
        None
    }

    fn poll_event(&mut self) -> Option<()> {
        None
    }

    fn poll_timeout(&self) -> Option<SimTime> {
        None
    }

    /// Equal digests mean equal states: a bit for each car.
    fn digest(&self) -> u64 {
        self.0.seen.iter().fold(u64::from(self.0.step.0) << 32, |bits, j| bits | 1 << (j.0 % 32))
    }
}

impl Report for Count {
    fn step(&self) -> Step {
        self.step
    }

    fn pose(&self) -> &Pose {
        &self.pose
    }

    fn planned(&self) -> &[Pose] {
        &[]
    }

    fn tally(&self) -> &Tally {
        &self.tally
    }
}

/// The mission.
#[derive(Clone)]
struct Census {
    camera: CameraModel,
}

impl Mission for Census {
    type Agent = Counter;
    type Report = Count;

    fn agent(&self, _: AgentId, _: Incarnation) -> Counter {
        Counter(Count::default())
    }

    fn camera(&self, _: AgentId) -> Option<CameraModel> {
        Some(self.camera)
    }

    fn report(&self, agent: &mut Counter, _: Detail) -> Count {
        agent.0.clone()
    }

    /// It claims nothing about places, so every place is admitted and nothing is ever violated.
    fn admits(&self, _: &Count, _: TargetId, _: [f64; 2], _: f64) -> bool {
        true
    }

    fn measure(&self, report: &Count, _: &[[f64; 2]], row: &mut StepRecord) {
        row.identified = report.seen.len() as u16;
    }

    fn watched<'a>(&self, report: &'a Count) -> Watched<'a> {
        Watched {
            footprint: self.camera.at(&report.pose).footprint(),
            identified: report.seen.iter().copied().collect(),
            ..Watched::default()
        }
    }

    fn stats(&self, report: &Count) -> Vec<(&'static str, Option<f64>)> {
        vec![("identified", Some(report.seen.len() as f64))]
    }

    fn is_inconsistency(&self, (): &()) -> bool {
        false
    }
}

fn main() {
    let request = Request { scenario: Some("city"), sets: &[], seed: Some(1) };
    let loaded = scenario::load(request).unwrap_or_else(|mistakes| panic!("{mistakes}"));
    let (scenario, world) = (loaded.scenario, loaded.world);
    let mission = Census { camera: scenario.camera };
    let mut engine = Engine::new(mission, world, &scenario.netem, scenario.seed);
    for _ in 0..120 {
        engine.step();
    }
    for (index, report) in engine.show().into_iter().flatten().enumerate() {
        println!("UAV {index} identified {} cars in a minute", report.seen.len());
    }
}
