//! What a world and the processes of its agents say to each other (docs/simulator.md).
//!
//! All of it is JSON but the pixels of a frame ([`crate::frame_wire`]) and the report for the
//! monitor, so that a simulator in any language can take the world's side. None of it passes through
//! `netem`, and none of it is told to the agents themselves.

use serde::{Deserialize, Serialize};

use crate::camera::{CameraModel, Pose};
use crate::command::YawCommand;
use crate::frame::{Detection, Label, PixelBox};
use crate::ids::{AgentId, Incarnation, MAX_TARGETS, RunId, TargetId};
use crate::time::{SimTime, Step};

/// The version of this protocol: processes of another one are refused.
pub const PROTOCOL: u32 = 3;

/// The most messages that an agent says on a radio in a step, on the average over its life: numbers beyond
/// that are forged.
const MAX_MESSAGES_PER_STEP: u64 = 4096;

/// A number that no message said by the end of `step` can have reached.
pub fn number_limit(step: Step) -> u64 {
    (u64::from(step.0) + 2) * MAX_MESSAGES_PER_STEP
}

/// An agent's process wants to take part: the payload of its query.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Join {
    /// Its [`PROTOCOL`].
    pub protocol: u32,
    /// Its program and version, for people.
    pub program: String,
    /// Which agent.
    pub agent: AgentId,
    /// A number that no other process has.
    pub process: u64,
}

/// The world's reply.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Welcome {
    /// Its [`PROTOCOL`].
    pub protocol: u32,
    /// The run.
    pub run: RunId,
    /// A number that no other world has: its frames and orders bear it.
    pub world: u64,
    /// The scenario's name.
    pub name: String,
    /// The scenario in full, TOML.
    pub scenario: String,
    /// The GeoJSON of its imported town, if the scenario's `map.file` is one; only the links need it.
    pub map: Option<String>,
    /// How time passes.
    pub pace: Pace,
}

/// How time passes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Pace {
    /// Everybody waits for everybody: the same result as in one process.
    Lockstep,
    /// Nobody waits: this many simulated seconds pass in a second.
    Realtime(f64),
}

/// An agent's process has heard others: sent again when that changes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Ready {
    /// Which process.
    pub process: u64,
    /// Whose probes it has heard, with their processes.
    pub heard: Vec<(AgentId, u64)>,
}

/// A sign of life on the way that messages take.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Probe {
    /// Whose.
    pub process: u64,
    /// Whether it wants to be answered.
    pub answer: bool,
}

/// The attachment of a frame: all but its pixels. A ground station's has no pixels and means that a step
/// begins.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrameHeader {
    /// Which world's.
    pub world: u64,
    /// k.
    pub step: Step,
    /// The instant of the frame.
    pub time: SimTime,
    /// The instant of the next one.
    pub next: SimTime,
    /// Where the agent is, as far as it knows: its pose estimate, and that of the frame.
    pub pose: Pose,
    /// Where its antenna truly is, `world`, metres, for the links and not for the agent; `None` where the
    /// pose is exact.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_world: Option<[f64; 3]>,
    /// The agent's life, `None` while it is down: then there are no pixels.
    pub incarnation: Option<Incarnation>,
    /// The identified targets, by increasing index.
    pub detections: Vec<Detection>,
    /// What everybody said before this step: whoever joins now need not wait for that.
    pub said: Vec<SaidSoFar>,
}

/// Why a frame is not believed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum HeaderError {
    /// Its instant is not that of its step.
    #[error("step {step} is at {got_s} s, expected {expected_s} s")]
    Time {
        /// k.
        step: Step,
        /// What it says.
        got_s: f64,
        /// k·T.
        expected_s: f64,
    },
    /// Nobody can be there.
    #[error("the agent is at {p_world:?}: expected finite metres above the ground")]
    Pose {
        /// Where it says.
        p_world: [f64; 3],
    },
    /// Targets out of order, or twice.
    #[error("detections of targets {0} and {1}: expected each target once, by increasing index")]
    Order(TargetId, TargetId),
    /// A target that nobody could tell others of.
    #[error("detection of target {0}: expected an index below {MAX_TARGETS}")]
    Target(TargetId),
    /// A box outside the image, or the wrong way round.
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
    /// A box without what it is around.
    #[error("the box of target {0} has no pixel labelled Target")]
    Empty(TargetId),
    /// An agent without camera is told of an image.
    #[error(
        "{detections} detections and {bytes} bytes of pixels for a ground station: expected none"
    )]
    Blind {
        /// How many targets it is said to detect.
        detections: usize,
        /// How long the pixels are.
        bytes: usize,
    },
}

impl FrameHeader {
    /// Checks what the guarantee rests on and a world may get wrong: the instant of the step, a pose
    /// above the ground, and detections with a Target pixel each. `labels` are the frame's pixels.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(
        &self,
        camera: &CameraModel,
        period_s: f64,
        labels: &[Label],
    ) -> Result<(), HeaderError> {
        self.check_step(period_s)?;
        let p_world = self.pose.p_world;
        if p_world[2] <= 0.0 {
            return Err(HeaderError::Pose { p_world });
        }
        if let Some([a, b]) = self.detections.array_windows().find(|[a, b]| a.target >= b.target) {
            return Err(HeaderError::Order(a.target, b.target));
        }
        // They are in order, so that the last one has the greatest index.
        if let Some(last) = self.detections.last().filter(|last| last.target.0 >= MAX_TARGETS) {
            return Err(HeaderError::Target(last.target));
        }
        self.detections.iter().try_for_each(|detection| check_box(detection, camera, labels))
    }

    /// The same for a ground station, which may stand on the ground and sees nothing; `bytes` is how long
    /// the pixels are.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check_blind(&self, period_s: f64, bytes: usize) -> Result<(), HeaderError> {
        self.check_step(period_s)?;
        let detections = self.detections.len();
        if detections > 0 || bytes > 0 {
            return Err(HeaderError::Blind { detections, bytes });
        }
        Ok(())
    }

    /// That time goes on, and that the agent is somewhere on or above the ground.
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

/// What the world says to all, on `clock`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Announcement {
    /// Which world.
    pub world: u64,
    /// What.
    #[serde(flatten)]
    pub order: Order,
}

/// What agents' processes are to do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "order", rename_all = "kebab-case")]
pub enum Order {
    /// Lockstep: wait for what others said, let arrive what is due, and say what there is to say.
    Turn {
        /// k.
        step: Step,
        /// Counts the turns of a step, from 1.
        round: u32,
        /// Simulated time.
        now: SimTime,
        /// What everybody said so far.
        said: Vec<SaidSoFar>,
    },
    /// The step is over: report.
    Close {
        /// k.
        step: Step,
        /// Whether maps are wanted, too.
        full: bool,
    },
    /// The mission's last step is over: tell everything once more, also what an agent that is down knew.
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

/// How far an agent's messages are numbered.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SaidSoFar {
    /// Whose.
    pub agent: AgentId,
    /// Of which life.
    pub incarnation: Incarnation,
    /// By channel, the number that the next message will have.
    pub next: Vec<u64>,
}

impl SaidSoFar {
    /// Whether an agent can have said so much by the end of `step`.
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
    /// Which turn, 0 for the frame.
    pub round: u32,
    /// What it said so far; `None` while it is down.
    pub said: Option<SaidSoFar>,
    /// When something is to be done next; `None` if nothing is.
    pub due: Option<SimTime>,
    /// What the UAV is to do.
    pub commands: Vec<YawCommand>,
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
            p_world: None,
            incarnation: Some(Incarnation(0)),
            detections: vec![seen(1, 0), seen(3, 2)],
            said: Vec::new(),
        }
    }

    /// 4 x 2 pixels, with a Target in each box of [`header`].
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
        // A camera flies.
        let flat = self::check(|h, _| h.pose.p_world[2] = 0.0);
        assert_eq!(flat, Err(HeaderError::Pose { p_world: [0.0, 0.0, 0.0] }));
    }
}
