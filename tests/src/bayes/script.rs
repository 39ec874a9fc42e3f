//! Two aircraft that fly a script, and their messages.

use csat_bayes::agent::BayesAgent;
use csat_bayes::config::BeliefKind;
use csat_flight::bayes::Bayes;
use csat_flight::scenario::Scenario;
use csat_flight::scenario::missions::Offered;
use csat_mission::mission::Mission;
use csat_proto::agent::Agent;
use csat_proto::camera::Pose;
use csat_proto::frame::Frame as SensorFrame;
use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use csat_proto::model::Driving;
use csat_proto::radio::Reception;
use csat_proto::time::{SimTime, Step};

use super::equations::{Frame, image_of};
use super::missions::Tables;
use crate::missions::{shipped, with_tables};

/// Where the target is, `world`, metres.
pub const TARGET: [f64; 2] = [28.0, 13.0];

/// What the aircraft hear of what is said in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Heard {
    /// All of it.
    All,
    /// Nothing of it; it is kept.
    Nothing,
    /// All of it, and before that all that was kept.
    AllSoFar,
}

/// A mission over 200 m of ground.
pub struct Script {
    /// It.
    pub scenario: Scenario,
    /// Its own tables.
    pub tables: Tables,
    /// The aircraft.
    pub agents: Vec<BayesAgent>,
    step: u32,
    /// Messages that nobody heard yet, with their senders.
    kept: Vec<(usize, Vec<u8>)>,
    /// All messages so far, with their senders.
    pub said: Vec<(usize, Vec<u8>)>,
}

impl Script {
    /// For a target that stands.
    pub fn new(kind: BeliefKind, cell_m: f64) -> Self {
        Self::of(false, |tables| (tables.belief.kind, tables.belief.cell_m) = (kind, cell_m))
    }

    /// For a target that walks.
    pub fn walking(kind: BeliefKind, cell_m: f64) -> Self {
        Self::of(true, |tables| (tables.belief.kind, tables.belief.cell_m) = (kind, cell_m))
    }

    /// For a target that stands or walks, with changes to the mission's own tables.
    pub fn of(walks: bool, adapt: impl FnOnce(&mut Tables)) -> Self {
        let mut scenario = shipped("tisdale");
        if walks {
            scenario.targets.driving = Driving::RandomWalk;
            scenario.targets.walk_m_sqrt_s = 2.0;
        }
        scenario.map.size_m = [200.0; 2];
        let mut tables = Tables::default();
        adapt(&mut tables);
        // Attitudes are nearly as bad as positions.
        tables.pose.sigma = [6.0, 5.0, 4.0, 0.01, 0.05, 0.05];
        tables.detector.p_false = 0.01;
        let scenario = with_tables(scenario, &tables);
        let agents = [0, 1].map(|id| newcomer(&scenario, id)).into();
        Self { scenario, tables, agents, step: 0, kept: Vec::new(), said: Vec::new() }
    }

    /// The time of the last step.
    pub fn now(&self) -> SimTime {
        SimTime::from_seconds(f64::from(self.step.saturating_sub(1)) * self.scenario.run.period_s)
    }

    /// The standard deviation of the target's displacement per step and axis, metres.
    pub fn walk_m(&self) -> f64 {
        self.scenario.targets.walk_m_sqrt_s * self.scenario.run.period_s.sqrt()
    }

    /// The next step: both aircraft get a frame and say what they have to say. Gives the frames.
    pub fn step(&mut self, heard: Heard) -> [Frame; 2] {
        let frames = [0, 1].map(|index| self.frame(index));
        self.fly(&frames, heard);
        frames
    }

    /// The next step, with both aircraft far from the region.
    pub fn step_away(&mut self) {
        let pose = Pose::level([900.0, 900.0, 90.0], 0.0);
        self.fly(&[Frame { pose, sighting: None }; 2], Heard::All);
    }

    fn fly(&mut self, frames: &[Frame; 2], heard: Heard) {
        let now = SimTime::from_seconds(f64::from(self.step) * self.scenario.run.period_s);
        for (index, frame) in frames.iter().enumerate() {
            let frame = SensorFrame::of_detector(Step(self.step), frame.pose, frame.sighting);
            let agent = &mut self.agents[index];
            agent.handle_frame(now, &frame);
            while let Some(transmit) = agent.poll_transmit() {
                self.kept.push((index, transmit.bytes.clone()));
                self.said.push((index, transmit.bytes));
            }
        }
        let said = match heard {
            Heard::Nothing => Vec::new(),
            Heard::All | Heard::AllSoFar => std::mem::take(&mut self.kept),
        };
        for (index, agent) in self.agents.iter_mut().enumerate() {
            let others = said.iter().filter(|(from, _)| *from != index);
            others.for_each(|(_, bytes)| agent.handle_message(now, &reception(now, bytes)));
            while agent.poll_timeout().is_some_and(|due| due <= now) {
                agent.handle_timeout(now);
            }
            while agent.poll_command().is_some() || agent.poll_event().is_some() {}
        }
        self.step += 1;
    }

    /// Aircraft 0 flies east past the target and banks, aircraft 1 flies north; both detect it at some of the steps
    /// where it is in their images, and aircraft 1 takes something else for it once.
    fn frame(&self, index: usize) -> Frame {
        let along = 9.0 * f64::from(self.step);
        let [x, y] = TARGET;
        let (p_world, yaw_rad, roll_rad) = match index {
            0 => ([along - 60.0, y - 17.0, 92.0], 0.0, if self.step > 8 { 0.3 } else { 0.0 }),
            _ => ([x + 14.0, along - 85.0, 88.0], std::f64::consts::FRAC_PI_2, -0.1),
        };
        let pose = Pose { p_world, yaw_rad, pitch_rad: -0.07, roll_rad };
        let camera = &self.scenario.camera;
        // The true pose is another one.
        let true_pose = Pose { p_world: [p_world[0] - 2.0, p_world[1] + 3.0, p_world[2]], ..pose };
        let size = [f64::from(camera.columns), f64::from(camera.rows)];
        let is_inside = |z: &[f64; 2]| (0..2).all(|i| (0.0..size[i]).contains(&z[i]));
        let image = image_of(camera, &true_pose, TARGET).filter(is_inside);
        let sighting = match (index, self.step) {
            (1, 2) => Some([100.0, 400.0]),
            (0, step) if step.is_multiple_of(2) => image,
            (1, step) if step.is_multiple_of(3) => image,
            _ => None,
        };
        Frame { pose, sighting }
    }
}

/// An aircraft that knows nothing.
pub fn newcomer(scenario: &Scenario, id: u16) -> BayesAgent {
    Bayes::of(scenario).agent(AgentId(id), Incarnation(0))
}

/// A message as it is heard.
pub fn reception(now: SimTime, bytes: &[u8]) -> Reception {
    Reception {
        channel: ChannelId(0),
        at: now,
        bearing_rad: 0.0,
        offset_m: None,
        bytes: bytes.into(),
    }
}
