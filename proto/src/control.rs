//! The protocol between a world and the processes of its agents (docs/simulator.md).
//!
//! All of it is JSON except the pixels of a frame ([`crate::frame_wire`]) and the report for the
//! monitor, so that a simulator in any language can be the world. None of it passes through `netem`,
//! and the agents themselves do not see it.

use serde::{Deserialize, Serialize};

use crate::camera::{CameraModel, Pose, PoseError};
use crate::command::Command;
use crate::frame::{Detection, Label, PixelBox};
use crate::ids::{AgentId, Incarnation, MAX_TARGETS, RunId, TargetId};
use crate::time::{SimTime, Step};

/// The version of this protocol; processes with another version are refused.
pub const PROTOCOL: u32 = 4;

/// The most messages that an agent sends on a radio per step, averaged over its incarnation: greater
/// sequence numbers are forged.
const MAX_MESSAGES_PER_STEP: u64 = 4096;

/// A sequence number greater than that of every message sent by the end of `step`.
pub fn number_limit(step: Step) -> u64 {
    (u64::from(step.0) + 2) * MAX_MESSAGES_PER_STEP
}

/// The request of an agent's process to take part: the payload of its query.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Join {
    /// Its [`PROTOCOL`].
    pub protocol: u32,
    /// Its program and version, for users to read.
    pub program: String,
    /// Which agent.
    pub agent: AgentId,
    /// A number that identifies the process.
    pub process: u64,
}

/// The world's reply.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Welcome {
    /// Its [`PROTOCOL`].
    pub protocol: u32,
    /// The run.
    pub run: RunId,
    /// A number that identifies the world; its frames and orders carry it.
    pub world: u64,
    /// The scenario's name.
    pub name: String,
    /// The scenario in full, TOML.
    pub scenario: String,
    /// The GeoJSON of the imported town, if the scenario has a `map.file`; only the links need it.
    pub map: Option<String>,
    /// How time passes.
    pub pace: Pace,
}

/// How time passes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Pace {
    /// All processes wait for each other: the same result as in one process.
    Lockstep,
    /// No process waits for another: this many simulated seconds pass per second.
    Realtime(f64),
}

/// Which other processes an agent's process has heard; it sends this again when it changes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ready {
    /// Which process.
    pub process: u64,
    /// The agents whose probes it has heard, with their processes.
    pub heard: Vec<(AgentId, u64)>,
}

/// A probe on the path of the messages: it shows that messages of the process arrive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Probe {
    /// Its sender.
    pub process: u64,
    /// Whether its sender wants an answer.
    pub answer: bool,
}

/// The attachment of a frame: all of it except the pixels. The frame of a ground station has no
/// pixels and means that a step begins.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrameHeader {
    /// The world that sent it.
    pub world: u64,
    /// k.
    pub step: Step,
    /// The instant of the frame.
    pub time: SimTime,
    /// The instant of the next frame.
    pub next: SimTime,
    /// The pose estimate of the agent, which is the pose of the frame.
    pub pose: Pose,
    /// The box about it that contains the true pose; left out where it is exact.
    #[serde(default, skip_serializing_if = "PoseError::is_none")]
    pub pose_error: PoseError,
    /// The true position of its antenna, `world`, metres, for the links and not for the agent; `None`
    /// where the pose is exact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_world: Option<[f64; 3]>,
    /// Its true yaw, radians, for the bearings of senders; `None` where the pose is exact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub yaw_rad: Option<f64>,
    /// The agent's incarnation; `None` while it is down, and then there are no pixels.
    pub incarnation: Option<Incarnation>,
    /// The identified targets, by increasing index.
    pub detections: Vec<Detection>,
    /// What a detector without labels reports: image point (c, r), pixels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sighting: Option<[f64; 2]>,
    /// What all agents sent before this step: a process that joins now does not wait for these
    /// messages.
    pub said: Vec<SaidSoFar>,
}

/// Why a frame is not believed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HeaderError {
    /// The instant is not that of the step.
    #[error("step {step} is at {got_s} s, expected {expected_s} s")]
    Time {
        /// k.
        step: Step,
        /// The instant that it states, seconds.
        got_s: f64,
        /// k·T.
        expected_s: f64,
    },
    /// A position that is impossible.
    #[error("the agent is at {p_world:?}: expected finite metres above the ground")]
    Pose {
        /// The position that it states.
        p_world: [f64; 3],
    },
    /// Half-widths of a box of poses that are impossible.
    #[error(
        "the pose has errors of up to {half_widths:?} m and rad: expected finite numbers from 0 on"
    )]
    PoseError {
        /// The half-widths that it states.
        half_widths: [f64; 6],
    },
    /// Targets out of order, or listed twice.
    #[error("detections of targets {0} and {1}: expected each target once, by increasing index")]
    Order(TargetId, TargetId),
    /// A target index that no message may carry.
    #[error("detection of target {0}: expected an index below {MAX_TARGETS}")]
    Target(TargetId),
    /// A box outside the image, or with its last pixel before its first one.
    #[error("target {target} in columns {columns:?} and rows {rows:?} of {image:?} pixels")]
    Outside {
        /// Which target.
        target: TargetId,
        /// First and last column.
        columns: [u16; 2],
        /// First and last row.
        rows: [u16; 2],
        /// Columns and rows of the image.
        image: [u16; 2],
    },
    /// A box without a pixel of its target.
    #[error("the box of target {0} has no pixel labelled Target")]
    Empty(TargetId),
    /// A true yaw that is no angle.
    #[error("the agent's true yaw is {yaw_rad} rad: expected a finite angle")]
    Yaw {
        /// The angle that it states.
        yaw_rad: f64,
    },
    /// A sighting outside the image.
    #[error("a sighting at {point:?} in an image of {image:?} pixels: expected a point inside")]
    Sighting {
        /// Column and row.
        point: [f64; 2],
        /// Columns and rows of the image.
        image: [u16; 2],
    },
    /// A sighting for an agent without detector.
    #[error("a sighting at {point:?} for an agent without detector: expected none")]
    NoDetector {
        /// Column and row.
        point: [f64; 2],
    },
    /// An image for an agent with a detector.
    #[error("{detections} detections and {bytes} bytes of pixels for a detector: expected none")]
    Labelled {
        /// Number of its detections.
        detections: usize,
        /// Length of its pixels, bytes.
        bytes: usize,
    },
    /// An image for an agent without camera.
    #[error(
        "{detections} detections and {bytes} bytes of pixels for a ground station: expected none"
    )]
    Blind {
        /// Number of its detections.
        detections: usize,
        /// Length of its pixels, bytes.
        bytes: usize,
    },
}

impl FrameHeader {
    /// Checks what the guarantee depends on: the instant of the step, a pose above the ground, and a
    /// Target pixel for each detection. `labels` are the frame's pixels.
    ///
    /// # Errors
    /// The first check that fails.
    pub fn check(
        &self,
        camera: &CameraModel,
        period_s: f64,
        labels: &[Label],
    ) -> Result<(), HeaderError> {
        self.check_step(period_s)?;
        self.check_pose()?;
        self.check_no_sighting()?;
        if let Some([a, b]) = self.detections.array_windows().find(|[a, b]| a.target >= b.target) {
            return Err(HeaderError::Order(a.target, b.target));
        }
        // They are in order, so the last one has the greatest index.
        if let Some(last) = self.detections.last().filter(|last| last.target.0 >= MAX_TARGETS) {
            return Err(HeaderError::Target(last.target));
        }
        self.detections.iter().try_for_each(|detection| check_box(detection, camera, labels))
    }

    /// The same checks for a camera with a detector, which sends at most a sighting in the image; `bytes` is
    /// the length of the pixels.
    ///
    /// # Errors
    /// The first check that fails.
    pub fn check_detector(
        &self,
        camera: &CameraModel,
        period_s: f64,
        bytes: usize,
    ) -> Result<(), HeaderError> {
        self.check_step(period_s)?;
        self.check_pose()?;
        let detections = self.detections.len();
        if detections > 0 || bytes > 0 {
            return Err(HeaderError::Labelled { detections, bytes });
        }
        let image = [camera.columns, camera.rows];
        let is_inside = |point: [f64; 2]| {
            (0..2).all(|axis| (0.0..=f64::from(image[axis])).contains(&point[axis])) // false for NaN
        };
        match self.sighting {
            Some(point) if !is_inside(point) => Err(HeaderError::Sighting { point, image }),
            _ => Ok(()),
        }
    }

    fn check_pose(&self) -> Result<(), HeaderError> {
        let (p_world, half_widths) = (self.pose.p_world, self.pose_error.half_widths());
        let is_above_ground = p_world[2] > 0.0;
        let is_box = half_widths.iter().all(|half| half.is_finite() && *half >= 0.0);
        match (is_above_ground, is_box) {
            (false, _) => Err(HeaderError::Pose { p_world }),
            (true, false) => Err(HeaderError::PoseError { half_widths }),
            (true, true) => Ok(()),
        }
    }

    fn check_no_sighting(&self) -> Result<(), HeaderError> {
        self.sighting.map_or(Ok(()), |point| Err(HeaderError::NoDetector { point }))
    }

    /// The same checks for a ground station, which may stand on the ground and has no camera; `bytes`
    /// is the length of the pixels.
    ///
    /// # Errors
    /// The first check that fails.
    pub fn check_blind(&self, period_s: f64, bytes: usize) -> Result<(), HeaderError> {
        self.check_step(period_s)?;
        let detections = self.detections.len();
        if detections > 0 || bytes > 0 {
            return Err(HeaderError::Blind { detections, bytes });
        }
        self.check_no_sighting()
    }

    /// Checks that time advances, and that the agent is on or above the ground.
    fn check_step(&self, period_s: f64) -> Result<(), HeaderError> {
        let step = self.step;
        for (step, time) in [(step, self.time), (Step(step.0.saturating_add(1)), self.next)] {
            let expected = SimTime::from_seconds(f64::from(step.0) * period_s);
            if time.0.abs_diff(expected.0) > 1 {
                let (got_s, expected_s) = (time.seconds(), expected.seconds());
                return Err(HeaderError::Time { step, got_s, expected_s });
            }
        }
        let Pose { p_world, yaw_rad, pitch_rad, roll_rad } = self.pose;
        let angles = [yaw_rad, pitch_rad, roll_rad];
        if !(p_world.iter().chain(&angles).all(|x| x.is_finite()) && p_world[2] >= 0.0) {
            return Err(HeaderError::Pose { p_world });
        }
        if let Some(yaw_rad) = self.yaw_rad.filter(|yaw_rad| !yaw_rad.is_finite()) {
            return Err(HeaderError::Yaw { yaw_rad });
        }
        match self.p_world {
            Some(p_world) if !p_world.iter().all(|x| x.is_finite()) => {
                Err(HeaderError::Pose { p_world })
            }
            _ => Ok(()),
        }
    }
}

fn check_box(
    detection: &Detection,
    camera: &CameraModel,
    labels: &[Label],
) -> Result<(), HeaderError> {
    let &Detection { target, pixels: PixelBox { columns, rows } } = detection;
    let image = [camera.columns, camera.rows];
    let is_in = |[first, last]: [u16; 2], end: u16| first <= last && last < end;
    if !(is_in(columns, image[0]) && is_in(rows, image[1])) {
        return Err(HeaderError::Outside { target, columns, rows, image });
    }
    let row = |row: u16| {
        let start = usize::from(row) * usize::from(camera.columns);
        labels.get(start + usize::from(columns[0])..=start + usize::from(columns[1]))
    };
    let mut pixels = (rows[0]..=rows[1]).filter_map(row).flatten();
    if pixels.any(|label| *label == Label::Target) {
        Ok(())
    } else {
        Err(HeaderError::Empty(target))
    }
}

/// What the world sends to all processes, on `clock`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Announcement {
    /// The world that sent it.
    pub world: u64,
    /// What the processes are to do.
    #[serde(flatten)]
    pub order: Order,
}

/// What the agents' processes are to do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "order", rename_all = "kebab-case")]
pub enum Order {
    /// Lockstep: wait for the messages of `said`, deliver those that are due, and send what the agent
    /// has to send.
    Turn {
        /// k.
        step: Step,
        /// Counts the turns of a step, from 1.
        round: u32,
        /// Simulated time.
        now: SimTime,
        /// What all agents sent so far.
        said: Vec<SaidSoFar>,
    },
    /// The step is over: report.
    Close {
        /// k.
        step: Step,
        /// Whether the report includes maps.
        full: bool,
    },
    /// The last step of the mission is over: report everything once more, including what an agent
    /// that is down knew.
    Show {
        /// k.
        step: Step,
    },
    /// The mission is over.
    End {
        /// Why.
        reason: String,
    },
}

/// The sequence numbers that an agent's messages have reached.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SaidSoFar {
    /// The agent.
    pub agent: AgentId,
    /// Its incarnation.
    pub incarnation: Incarnation,
    /// By channel, the number of its next message.
    pub next: Vec<u64>,
}

impl SaidSoFar {
    /// Whether an agent can have sent that many messages by the end of `step`.
    pub fn is_possible(&self, step: Step) -> bool {
        self.next.iter().all(|next| *next <= number_limit(step))
    }
}

/// An agent's answer to a frame (round 0) or a turn, on `uav/{i}/command`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Done {
    /// Which process.
    pub process: u64,
    /// k.
    pub step: Step,
    /// The round of the turn; 0 for the frame.
    pub round: u32,
    /// What the agent sent so far; `None` while it is down.
    pub said: Option<SaidSoFar>,
    /// When the process has something to do next; `None` for never.
    pub due: Option<SimTime>,
    /// Commands to the UAV.
    pub commands: Vec<Command>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header() -> FrameHeader {
        let seen = |target: u16, first: u16| Detection {
            target: TargetId(target),
            pixels: PixelBox { columns: [first, first + 1], rows: [0, 1] },
        };
        FrameHeader {
            world: 9,
            step: Step(4),
            time: SimTime::from_seconds(2.0),
            next: SimTime::from_seconds(2.5),
            pose: Pose::level([0.0, 0.0, 50.0], 0.0),
            pose_error: PoseError::NONE,
            p_world: None,
            yaw_rad: None,
            incarnation: Some(Incarnation(0)),
            detections: vec![seen(1, 0), seen(3, 2)],
            sighting: None,
            said: Vec::new(),
        }
    }

    /// Checks a frame of 4 x 2 pixels, with a Target in each box of [`header`].
    fn check(change: impl FnOnce(&mut FrameHeader, &mut [Label; 8])) -> Result<(), HeaderError> {
        let camera = CameraModel { columns: 4, rows: 2, ..CameraModel::default() };
        let mut labels = [Label::Ground; 8];
        (labels[0], labels[7]) = (Label::Target, Label::Target);
        let mut header = header();
        change(&mut header, &mut labels);
        header.check(&camera, 0.5, &labels)
    }

    #[test]
    fn what_the_guarantee_rests_on_is_checked() {
        assert_eq!(check(|_, _| ()), Ok(()));
        let error = check(|h, _| h.time = SimTime::from_seconds(6.0)).unwrap_err();
        assert_eq!(error.to_string(), "step 4 is at 6 s, expected 2 s");
        assert!(check(|h, _| h.next = SimTime::from_seconds(7.5)).is_err());
        assert!(check(|h, _| h.pose.p_world[2] = -1.0).is_err());
        assert!(check(|h, _| h.pose.yaw_rad = f64::NAN).is_err());
        let half_widths = [1.0, -1.0, 0.0, 0.0, 0.0, 0.0];
        let negative = check(|h, _| h.pose_error.p_world = [1.0, -1.0, 0.0]);
        assert_eq!(negative, Err(HeaderError::PoseError { half_widths }));
        assert!(check(|h, _| h.pose_error.yaw_rad = f64::INFINITY).is_err());
        let twice = check(|h, _| h.detections[1].target = TargetId(1));
        assert_eq!(twice, Err(HeaderError::Order(TargetId(1), TargetId(1))));
        let outside = check(|h, _| h.detections[1].pixels.columns = [3, 4]);
        assert!(matches!(outside, Err(HeaderError::Outside { .. })));
        let far = check(|h, _| h.detections[1].target = TargetId(MAX_TARGETS));
        assert_eq!(far, Err(HeaderError::Target(TargetId(MAX_TARGETS))));
        let empty = check(|_, labels| labels[7] = Label::Obstacle);
        assert_eq!(empty, Err(HeaderError::Empty(TargetId(3))));
    }

    #[test]
    fn a_detector_reports_a_point_of_its_image_and_nothing_else() {
        let camera = CameraModel { columns: 4, rows: 2, ..CameraModel::default() };
        let check = |change: fn(&mut FrameHeader), bytes| {
            let mut header = FrameHeader { detections: Vec::new(), ..header() };
            header.sighting = Some([4.0, 0.5]);
            change(&mut header);
            header.check_detector(&camera, 0.5, bytes)
        };
        assert_eq!(check(|_| (), 0), Ok(()));
        assert_eq!(check(|h| h.sighting = None, 0), Ok(()));
        let outside = check(|h| h.sighting = Some([1.0, 2.5]), 0);
        assert_eq!(
            outside.unwrap_err().to_string(),
            "a sighting at [1.0, 2.5] in an image of [4, 2] pixels: expected a point inside"
        );
        assert!(check(|h| h.sighting = Some([f64::NAN, 1.0]), 0).is_err());
        assert_eq!(check(|_| (), 4), Err(HeaderError::Labelled { detections: 0, bytes: 4 }));
        let labelled = check(|h| h.detections = header().detections, 0);
        assert_eq!(labelled, Err(HeaderError::Labelled { detections: 2, bytes: 0 }));
        assert!(check(|h| h.pose.p_world[2] = 0.0, 0).is_err());
        assert!(check(|h| h.step = Step(3), 0).is_err());
        assert!(check(|h| h.yaw_rad = Some(f64::NAN), 0).is_err());
        let labels = self::check(|h, _| h.sighting = Some([1.0, 1.0]));
        assert_eq!(labels, Err(HeaderError::NoDetector { point: [1.0, 1.0] }));
    }

    #[test]
    fn no_agent_says_more_than_it_can() {
        let said = |next| SaidSoFar { agent: AgentId(0), incarnation: Incarnation(0), next };
        assert!(said(vec![0, 4096]).is_possible(Step(0)));
        assert!(!said(vec![0, 2 * 4096 + 1]).is_possible(Step(0)));
        assert!(!said(vec![u64::MAX]).is_possible(Step(u32::MAX)));
    }

    #[test]
    fn a_station_stands_on_the_ground_and_sees_nothing() {
        let check = |change: fn(&mut FrameHeader), bytes| {
            let mut header = FrameHeader { detections: Vec::new(), ..header() };
            header.pose.p_world[2] = 0.0;
            change(&mut header);
            header.check_blind(0.5, bytes)
        };
        assert_eq!(check(|_| (), 0), Ok(()));
        assert_eq!(check(|_| (), 4), Err(HeaderError::Blind { detections: 0, bytes: 4 }));
        let seen = check(|h| h.detections = header().detections, 0);
        assert_eq!(seen, Err(HeaderError::Blind { detections: 2, bytes: 0 }));
        let p_world = [0.0, 0.0, -1.0];
        let below = check(|h| h.pose.p_world[2] = -1.0, 0);
        assert_eq!(below, Err(HeaderError::Pose { p_world }));
        assert!(check(|h| h.step = Step(3), 0).is_err());
        let nowhere = check(|h| h.p_world = Some([0.0, f64::INFINITY, 1.0]), 0);
        let p_world = [0.0, f64::INFINITY, 1.0];
        assert_eq!(nowhere, Err(HeaderError::Pose { p_world }));
        // A camera is above the ground.
        let flat = self::check(|h, _| h.pose.p_world[2] = 0.0);
        assert_eq!(flat, Err(HeaderError::Pose { p_world: [0.0, 0.0, 0.0] }));
    }
}
