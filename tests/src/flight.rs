//! A small world around a [`Pair`]: cars drive, UAVs fly by command or by script, cameras take
//! frames, and the knowledge is checked against the truth.

use csat_agent::agent::Event;
use csat_experiments::scenario::Scenario;
use csat_experiments::set_membership::SetMembership;
use csat_mission::mission::Mission;
use csat_proto::command::Command;
use csat_proto::frame::Frame;
use csat_proto::ids::{AgentId, Incarnation};
use csat_world::camera::Renderer;
use csat_world::world::World;

use crate::missions::world_of;
use crate::pair::Pair;
use crate::truth;

/// The heading of UAV `agent` from step `step` on by a script, radians.
pub type Script = fn(step: u32, agent: u16) -> f64;

/// A pair in its world.
pub struct Flight {
    /// The true world.
    pub world: World,
    /// The agents.
    pub pair: Pair,
    /// `None` if the UAVs follow the commands of their agents.
    pub script: Option<Script>,
    renderers: Vec<Renderer>,
    seed: u64,
    started: bool,
}

impl Flight {
    /// The fleet of a scenario, at the start.
    ///
    /// # Panics
    /// When the scenario has no world.
    pub fn new(scenario: &Scenario) -> Self {
        let world = world_of(scenario).unwrap_or_else(|e| panic!("seed {}: {e}", scenario.seed));
        Self::in_world(scenario, world)
    }

    /// The fleet of a scenario in a given world.
    pub fn in_world(scenario: &Scenario, world: World) -> Self {
        let mission = SetMembership::new(scenario);
        let agents =
            (0..scenario.agents.count).map(|i| mission.agent(AgentId(i), Incarnation(0))).collect();
        Self {
            renderers: vec![Renderer::new(scenario.camera); world.poses().len()],
            pair: Pair::new(agents),
            script: None,
            world,
            seed: scenario.seed,
            started: false,
        }
    }

    /// The fleet of a scenario, steered by a script, so that the knowledge of agents does not change
    /// their paths.
    pub fn scripted(scenario: &Scenario, script: Script) -> Self {
        Self { script: Some(script), ..Self::new(scenario) }
    }

    /// One step; the first call is step 0.
    pub fn step(&mut self) {
        let frames = self.look();
        self.pair.step(&frames);
        self.obey();
    }

    /// Lets a period pass (except at the first call) and takes the frame of every UAV.
    pub fn look(&mut self) -> Vec<Frame> {
        if self.started {
            self.world.advance();
        }
        self.started = true;
        let (scene, step, poses) = (self.world.scene(), self.world.step(), self.world.poses());
        let ids = (0..).map(AgentId);
        let cameras = self.renderers.iter_mut().zip(&poses).zip(ids);
        cameras
            .map(|((renderer, pose), id)| renderer.frame(&scene, pose, step, self.seed, id))
            .collect()
    }

    /// Passes the commands of the agents or of the script to the UAVs.
    pub fn obey(&mut self) {
        let mut commands = std::mem::take(&mut self.pair.commands);
        if let Some(script) = self.script {
            let step = self.world.step().0;
            let command = |i| (AgentId(i), Command::Yaw { yaw_rad: script(step, i) });
            commands = (0..self.renderers.len() as u16).map(command).collect();
        }
        for (id, command) in commands {
            self.world.command(id, command).expect("a UAV of the fleet");
        }
    }

    /// # Panics
    /// When an agent has excluded the location of a target.
    pub fn check_guarantee(&self) {
        for (i, agent) in self.pair.agents.iter().enumerate() {
            let broken = truth::broken(agent.knowledge(), self.world.targets());
            let step = self.world.step();
            assert!(broken.is_empty(), "seed {} step {step} UAV {i}: {broken:?}", self.seed);
        }
    }

    /// # Panics
    /// When a set became empty.
    pub fn check_consistency(&self) {
        let bad = |(_, e): &&(AgentId, Event)| matches!(e, Event::Inconsistent { .. });
        let found: Vec<_> = self.pair.events.iter().filter(bad).collect();
        assert!(found.is_empty(), "seed {}: {found:?}", self.seed);
    }
}
