//! The agents of a mission, wherever they are: in this process ([`crate::local`]), or each in one of its own
//! (`csat_peer::world`).

use std::collections::BTreeMap;
use std::sync::Arc;

use csat_netem::counters::{Counters, LinkCounters};
use csat_netem::fate::{Fate, Sent};
use csat_netem::link::{Arrival, LinkId};
use csat_proto::agent::Agent;
use csat_proto::camera::{Pose, PoseEstimate};
use csat_proto::frame::Frame;
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::{SimTime, Step};
use csat_world::road_area::RoadArea;
use csat_world::scene::Scene;
use csat_world::sensor::{Sensor, Sight};
use csat_world::target::TargetTruth;
use serde::{Deserialize, Serialize};
use tracing::info_span;

use crate::mission::{Detail, Mission};
use crate::timing::StageTimes;

/// What became of a message on its way to one receiver.
#[derive(Debug, Clone, PartialEq)]
pub struct Passage {
    /// The message.
    pub sent: Sent,
    /// The encoded envelope; empty when the receiver is in another process.
    pub bytes: Arc<[u8]>,
    /// Its fate.
    pub fate: Fate,
}

/// What a fleet needs to know of the world to fly a step.
pub struct Brief {
    /// k.
    pub step: Step,
    /// The instant of the step's frames.
    pub now: SimTime,
    /// The instant of the next ones.
    pub next: SimTime,
    /// The seed of the mission.
    pub seed: u64,
    /// What cameras see.
    pub scene: Scene,
    /// What the cameras of agents that lie show instead.
    pub false_scenes: BTreeMap<AgentId, Scene>,
    /// The targets, by index.
    pub targets: Vec<TargetTruth>,
    /// The roads, where cameras segment them.
    pub roads: Option<Arc<RoadArea>>,
    /// Where the agents are, by index.
    pub poses: Vec<Pose>,
    /// Where they are told they are, by index.
    pub reported: Vec<PoseEstimate>,
    /// The life of each agent, `None` while it is down.
    pub lives: Vec<Option<Incarnation>>,
    /// Whether the scenario has it that an agent is down, by index: then it takes no process to be.
    pub is_down_by_schedule: Vec<bool>,
    /// How much the agents are to tell.
    pub detail: Detail,
}

impl Brief {
    /// The frame of a UAV.
    pub fn frame(&self, sensor: &mut Sensor, id: AgentId) -> Frame {
        let index = usize::from(id.0);
        let (pose, reported) = (&self.poses[index], &self.reported[index]);
        let Self { step, seed, targets, roads, .. } = self;
        let scene = self.false_scenes.get(&id).unwrap_or(&self.scene);
        let roads = roads.as_deref();
        let sight = Sight { step: *step, seed: *seed, scene, targets, roads };
        info_span!("render").in_scope(|| sensor.frame(&sight, id, pose, reported))
    }
}

/// The sensors of the agents, by index; `None` for agents without one.
pub fn sensors<M: Mission>(mission: &M, count: usize) -> Vec<Option<Sensor>> {
    let models = (0..count).map(|index| mission.sensor(AgentId(index as u16)));
    models.map(|model| model.map(Sensor::new)).collect()
}

/// Whether a frame of each of these sensors has taken a target for another one.
pub fn has_misidentified(sensors: &[Option<Sensor>]) -> Vec<bool> {
    let has_misidentified = |sensor: &Sensor| sensor.has_misidentified();
    sensors.iter().map(|sensor| sensor.as_ref().is_some_and(has_misidentified)).collect()
}

/// One agent's step, as told to its observers.
pub struct Flown<M: Mission> {
    /// Whose.
    pub agent: AgentId,
    /// The hash of its state; 0 while it is down.
    pub digest: u64,
    /// What it knows; `None` while it is down.
    pub report: Option<M::Report>,
    /// What it told its vehicle.
    pub commands: Vec<<M::Agent as Agent>::Command>,
    /// What it reported.
    pub events: Vec<<M::Agent as Agent>::Event>,
    /// What became of messages to it, in the order of sending.
    pub passages: Vec<Passage>,
    /// What arrived, in the order of arrival; empty when it is in another process.
    pub arrivals: Vec<Arrival>,
    /// What its stages took.
    pub times: StageTimes,
    /// Bytes it sent.
    pub bytes_sent: u64,
}

impl<M: Mission> Flown<M> {
    /// The step of an agent that told nothing.
    pub fn nothing(agent: AgentId) -> Self {
        Self {
            agent,
            digest: 0,
            report: None,
            commands: Vec::new(),
            events: Vec::new(),
            passages: Vec::new(),
            arrivals: Vec::new(),
            times: StageTimes::default(),
            bytes_sent: 0,
        }
    }
}

/// An agent's frames in all its lives, or the steps that a ground station was told of. In real time no process is waited for: one that is slow looks at
/// its newest frame only and misses those before, and one that is stopped or gone misses all.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Frames {
    /// How many its camera took, but for those while the scenario had it down.
    pub shown: u64,
    /// Of those, how many it did not look at.
    pub missed: u64,
    /// When nothing was heard of its process, from and to, seconds of simulated time.
    #[serde(default)]
    pub silent_s: Vec<[f64; 2]>,
}

/// The agents of a mission, wherever they are.
pub trait Fleet<M: Mission> {
    /// Why a step could not be flown.
    type Error;

    /// Which process drives each agent, `None` where there is none: another number is another
    /// process, whose agent knows nothing.
    fn attendance(&mut self) -> Vec<Option<u64>>;

    /// Lets all agents fly one step; by index, without those that said nothing.
    ///
    /// # Errors
    /// When the step cannot be flown.
    fn fly(&mut self, brief: &Brief) -> Result<Vec<Flown<M>>, Self::Error>;

    /// Everything each agent knows, or knew when it crashed, as far as can be told.
    fn show(&mut self) -> Vec<Option<M::Report>>;

    /// What the links did so far.
    fn counters(&self) -> Counters;

    /// What each link did so far, by sender, receiver and channel.
    fn per_link(&self) -> Vec<(LinkId, LinkCounters)>;

    /// What became of each agent's frames so far, by index.
    fn frames(&self) -> Vec<Frames>;

    /// Whether a frame of each agent so far has taken a target for another one, by index.
    fn has_misidentified(&self) -> Vec<bool>;

    /// What processes did not believe of what was said to them so far, by kind.
    fn refused(&self) -> BTreeMap<String, u64> {
        BTreeMap::new()
    }
}

impl<M: Mission, F: Fleet<M>> Fleet<M> for &mut F {
    type Error = F::Error;

    fn attendance(&mut self) -> Vec<Option<u64>> {
        (**self).attendance()
    }

    fn fly(&mut self, brief: &Brief) -> Result<Vec<Flown<M>>, Self::Error> {
        (**self).fly(brief)
    }

    fn show(&mut self) -> Vec<Option<M::Report>> {
        (**self).show()
    }

    fn counters(&self) -> Counters {
        (**self).counters()
    }

    fn per_link(&self) -> Vec<(LinkId, LinkCounters)> {
        (**self).per_link()
    }

    fn frames(&self) -> Vec<Frames> {
        (**self).frames()
    }

    fn has_misidentified(&self) -> Vec<bool> {
        (**self).has_misidentified()
    }

    fn refused(&self) -> BTreeMap<String, u64> {
        (**self).refused()
    }
}
