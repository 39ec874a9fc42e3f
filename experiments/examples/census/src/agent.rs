//! The agent: a state machine that is told what arrives and asked what to do.

use std::collections::{BTreeMap, VecDeque};

use csat_mission::mission::{Detail, Report, Tally};
use csat_proto::agent::{Agent, FIRST_ANSWER, Transmit};
use csat_proto::camera::{CameraModel, Pose};
use csat_proto::command::Command;
use csat_proto::envelope::{Envelope, decode_whole};
use csat_proto::frame::Frame;
use csat_proto::ids::{AgentId, ChannelId, Incarnation, MAX_TARGETS, RunId, TargetId};
use csat_proto::model::Ground;
use csat_proto::radio::Reception;
use csat_proto::raster::{Grid, Raster};
use csat_proto::time::{SimTime, Step};
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_64;

use crate::Settings;

/// Side of the cells in which an agent counts its looks, metres.
const CELL_M: f64 = 10.0;

/// A car that was counted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sighting {
    /// The agent whose camera identified it.
    pub by: AgentId,
    /// The step of that frame.
    pub step: Step,
    /// The ground below the middle of its box, `world`, metres.
    pub location: [f64; 2],
}

/// How often an agent looked at each cell of the ground.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Looks {
    /// The cells.
    pub grid: Grid,
    /// Frames whose footprint has the cell's centre in it, row by row.
    pub frames: Vec<u16>,
}

/// All that an agent tells its observers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Count {
    /// Whose.
    pub agent: AgentId,
    /// The step that it is of.
    pub step: Step,
    /// The pose of the last frame.
    pub pose: Pose,
    /// Whether the agent has looked at anything yet.
    pub has_looked: bool,
    /// The cars that the agent knows of.
    pub sightings: BTreeMap<TargetId, Sighting>,
    /// Its looks, where [`Detail::Full`] was asked for.
    pub looks: Option<Looks>,
    /// What it did not believe.
    pub tally: Tally,
}

impl Report for Count {
    fn step(&self) -> Step {
        self.step
    }

    fn pose(&self) -> &Pose {
        &self.pose
    }

    /// It plans nothing ahead.
    fn planned(&self) -> &[Pose] {
        &[]
    }

    fn tally(&self) -> &Tally {
        &self.tally
    }
}

/// Who an agent is.
#[derive(Debug, Clone, Copy)]
pub struct Identity {
    /// The run.
    pub run: RunId,
    /// Its number.
    pub id: AgentId,
    /// Its life.
    pub incarnation: Incarnation,
}

/// The agent.
pub struct Counter {
    identity: Identity,
    ground: Ground,
    /// `None` for a ground station.
    camera: Option<CameraModel>,
    settings: Settings,
    /// By how much its course differs from the middle one, radians.
    offset_rad: f64,
    count: Count,
    looks: Looks,
    /// Numbers of the next message to all, and of the next answer.
    next: [u64; 2],
    outbox: VecDeque<Transmit>,
    command: Option<Command>,
}

impl Counter {
    /// An agent that has counted nothing.
    pub fn new(
        identity: Identity,
        ground: Ground,
        camera: Option<CameraModel>,
        settings: Settings,
        offset_rad: f64,
    ) -> Self {
        let grid = Grid::covering(&ground, CELL_M);
        let count = Count {
            agent: identity.id,
            step: Step(0),
            pose: Pose::default(),
            has_looked: false,
            sightings: BTreeMap::new(),
            looks: None,
            tally: Tally::default(),
        };
        Self {
            identity,
            ground,
            camera,
            settings,
            offset_rad,
            count,
            looks: Looks { grid, frames: vec![0; grid.cells()] },
            next: [0, FIRST_ANSWER],
            outbox: VecDeque::new(),
            command: None,
        }
    }

    /// What its observers get to know.
    pub fn report(&self, detail: Detail) -> Count {
        let looks = (detail == Detail::Full).then(|| self.looks.clone());
        Count { looks, ..self.count.clone() }
    }

    /// Counts the cars of a frame; gives whether there was a new one.
    fn count(&mut self, frame: &Frame, camera: &CameraModel) -> bool {
        let (by, step) = (self.identity.id, frame.step);
        let view = camera.at(&frame.pose);
        let before = self.count.sightings.len();
        for detection in &frame.detections {
            let middle = |[first, last]: [u16; 2]| f64::from(first.midpoint(last)) + 0.5;
            let [column, row] = [detection.pixels.columns, detection.pixels.rows].map(middle);
            // Above the horizon there is no ground.
            if let Some(location) = view.ground_point(column, row) {
                let sighting = Sighting { by, step, location };
                self.count.sightings.entry(detection.target).or_insert(sighting);
            }
        }
        let mut seen = Raster::empty(self.looks.grid);
        seen.fill_rings(&[view.footprint()]);
        for (column, row) in seen.iter() {
            let frames = &mut self.looks.frames[self.looks.grid.index(column, row)];
            *frames = frames.saturating_add(1);
        }
        self.count.sightings.len() > before
    }

    /// Leaves the start on a course of its own, and turns back where the border is near and ahead.
    fn steer(&mut self, is_first: bool) {
        let Pose { p_world: [x, y, _], yaw_rad, .. } = self.count.pose;
        let ahead = [yaw_rad.cos(), yaw_rad.sin()];
        let mut ends = [x, y].into_iter().zip(self.ground.size_m).zip(ahead);
        let is_near = |((p, size), v): ((f64, f64), f64)| {
            p.abs() > size / 2.0 - self.settings.margin_m && p * v > 0.0
        };
        let is_leaving = ends.any(is_near);
        let middle_rad = (-y).atan2(-x);
        let course_rad = match (is_first, is_leaving) {
            (true, _) => yaw_rad + self.offset_rad,
            (false, true) => middle_rad + self.offset_rad / 2.0,
            (false, false) => return,
        };
        // The shorter way round.
        let turn_rad = (course_rad - yaw_rad).sin().atan2((course_rad - yaw_rad).cos());
        self.command = Some(Command::Yaw { yaw_rad: yaw_rad + turn_rad });
    }

    /// Everything that the agent counted, as a message.
    fn message(&self, now: SimTime, sequence: u64) -> Transmit {
        let Identity { run, id: src, incarnation } = self.identity;
        let Count { step, pose, ref sightings, .. } = self.count;
        let body = postcard::to_stdvec(sightings).expect("a map of numbers always serialises");
        let channel = ChannelId(0);
        let envelope = Envelope {
            run,
            src,
            incarnation,
            channel,
            sequence,
            step,
            time: now,
            pose: pose.into(),
            body,
        };
        Transmit { channel, sequence, bytes: envelope.encode() }
    }

    /// What another agent counted, or why the message is not believed.
    fn read(&self, bytes: &[u8]) -> Result<BTreeMap<TargetId, Sighting>, &'static str> {
        let envelope = Envelope::decode(bytes).map_err(|_| "envelope")?;
        if envelope.run != self.identity.run {
            return Err("run");
        }
        let sightings: BTreeMap<TargetId, Sighting> = decode_whole(&envelope.body).ok_or("body")?;
        let is_good = |(target, sighting): (&TargetId, &Sighting)| {
            target.0 < MAX_TARGETS && sighting.location.iter().all(|metres| metres.is_finite())
        };
        if sightings.iter().all(is_good) { Ok(sightings) } else { Err("sighting") }
    }
}

impl Agent for Counter {
    type Command = Command;
    type Event = ();

    fn handle_frame(&mut self, now: SimTime, frame: &Frame) {
        (self.count.step, self.count.pose) = (frame.step, frame.pose);
        let Some(camera) = self.camera else { return };
        let is_first = !std::mem::replace(&mut self.count.has_looked, true);
        if self.count(frame, &camera) && self.settings.share {
            let message = self.message(now, self.next[0]);
            self.next[0] += 1;
            self.outbox.push_back(message);
        }
        self.steer(is_first);
    }

    fn handle_step(&mut self, _: SimTime, step: Step, pose: Pose) {
        (self.count.step, self.count.pose) = (step, pose);
    }

    /// Maps of sightings merge like sets: repeats and disorder change nothing, for of two sightings of a car
    /// the earlier one stays, and of two at the same step that of the lower number.
    fn handle_message(&mut self, _: SimTime, message: &Reception) {
        match self.read(&message.bytes) {
            Ok(sightings) => {
                for (target, other) in sightings {
                    let known = self.count.sightings.entry(target).or_insert(other);
                    if (other.step, other.by) < (known.step, known.by) {
                        *known = other;
                    }
                }
            }
            Err(reason) => *self.count.tally.rejected.entry(reason.to_owned()).or_default() += 1,
        }
    }

    fn handle_timeout(&mut self, _: SimTime) {}

    fn poll_transmit(&mut self) -> Option<Transmit> {
        self.outbox.pop_front()
    }

    fn answer(&mut self, now: SimTime) -> Option<Transmit> {
        let message = self.message(now, self.next[1]);
        self.next[1] += 1;
        Some(message)
    }

    fn poll_command(&mut self) -> Option<Command> {
        self.command.take()
    }

    fn poll_event(&mut self) -> Option<()> {
        None
    }

    fn poll_timeout(&self) -> Option<SimTime> {
        None
    }

    fn digest(&self) -> u64 {
        let Count { step, pose, ref sightings, .. } = self.count;
        let known = (step, pose, sightings);
        xxh3_64(&postcard::to_stdvec(&known).expect("numbers always serialise"))
    }
}
