//! All agents in this process, in virtual time, as fast as it goes.

use std::convert::Infallible;
use std::sync::Arc;

use csat_netem::config::NetemConfig;
use csat_netem::counters::{Counters, LinkCounters};
use csat_netem::link::{LinkId, Links};
use csat_netem::propagation::Obstruction;
use csat_proto::ids::AgentId;
use csat_proto::time::SimTime;
use csat_world::sensor::Sensor;
use rayon::prelude::*;

use crate::fleet::{Brief, Fleet, Flown, Frames, has_misidentified, sensors};
use crate::mission::Mission;
use crate::node::{Node, Said};

/// The agents of a mission in this process.
pub struct LocalFleet<M: Mission> {
    mission: M,
    nodes: Vec<Node<M>>,
    /// By index; `None` for agents without one.
    sensors: Vec<Option<Sensor>>,
    /// By index, how many frames an agent was shown, or steps told of.
    shown: Vec<u64>,
}

impl<M: Mission> LocalFleet<M> {
    /// A fleet of `count` agents in their first lives, over links that follow `netem` with fates of
    /// `seed` among what may stand in the way.
    pub fn new(
        mission: M,
        count: usize,
        netem: &NetemConfig,
        seed: u64,
        obstruction: Option<Arc<dyn Obstruction>>,
    ) -> Self {
        let node = |index: usize| {
            let links = Links::new(netem, seed, obstruction.clone());
            Node::new(&mission, AgentId(index as u16), links)
        };
        Self {
            nodes: (0..count).map(node).collect(),
            sensors: sensors(&mission, count),
            shown: vec![0; count],
            mission,
        }
    }

    /// The agents, by index.
    pub fn nodes(&self) -> &[Node<M>] {
        &self.nodes
    }

    /// What the links do from now on; what is under way stays under way.
    pub fn reconfigure_links(&mut self, netem: &NetemConfig) {
        for node in &mut self.nodes {
            node.links_mut().reconfigure(netem);
        }
    }

    /// Makes every frame and hands it to its agent; those without sensor are told of the step.
    fn look(&mut self, brief: &Brief) {
        for (shown, life) in self.shown.iter_mut().zip(&brief.lives) {
            *shown += u64::from(life.is_some());
        }
        let Self { mission, nodes, sensors, .. } = self;
        let mission = &*mission;
        let each = nodes.par_iter_mut().zip(sensors).zip(&brief.poses).zip(&brief.lives);
        each.enumerate().for_each(|(index, (((node, sensor), pose), life))| {
            node.begin(mission, *life, pose);
            match sensor {
                Some(sensor) => {
                    node.look(brief.now, || brief.frame(sensor, AgentId(index as u16)));
                }
                None => node.step(brief.now, brief.step),
            }
        });
    }

    /// Lets messages and timeouts take their turns until nothing is left before `next`.
    fn settle(&mut self, now: SimTime, next: SimTime) {
        let mut now = now;
        loop {
            self.talk(now);
            let Some(due) = self.nodes.iter().filter_map(Node::next_due).min() else { break };
            if due >= next {
                break;
            }
            now = now.max(due);
            self.nodes.par_iter_mut().for_each(|node| node.run(now));
        }
    }

    /// Each agent receives what all other agents have to send.
    fn talk(&mut self, now: SimTime) {
        let said: Vec<Said> = self.nodes.iter_mut().flat_map(|node| node.say(now)).collect();
        self.nodes.par_iter_mut().enumerate().for_each(|(dst, node)| {
            let others = said.iter().filter(|said| usize::from(said.src.0) != dst);
            others.for_each(|said| node.hear(said));
        });
    }
}

impl<M: Mission> Fleet<M> for LocalFleet<M> {
    type Error = Infallible;

    fn attendance(&mut self) -> Vec<Option<u64>> {
        vec![Some(0); self.nodes.len()]
    }

    fn fly(&mut self, brief: &Brief) -> Result<Vec<Flown<M>>, Infallible> {
        self.look(brief);
        self.settle(brief.now, brief.next);
        let (mission, nodes) = (&self.mission, self.nodes.par_iter_mut());
        Ok(nodes.map(|node| node.finish(mission, brief.detail)).collect())
    }

    fn show(&mut self) -> Vec<Option<M::Report>> {
        self.nodes.iter_mut().map(|node| Some(node.show(&self.mission))).collect()
    }

    fn counters(&self) -> Counters {
        let mut all = Counters::default();
        self.nodes.iter().for_each(|node| all.add(node.links().counters()));
        all
    }

    fn per_link(&self) -> Vec<(LinkId, LinkCounters)> {
        let links = self.nodes.iter().flat_map(|node| node.links().per_link());
        let mut links: Vec<_> = links.map(|(id, counters)| (id, counters.clone())).collect();
        links.sort_by_key(|(id, _)| *id);
        links
    }

    fn frames(&self) -> Vec<Frames> {
        // In virtual time no agent misses a frame.
        let frames = |&shown| Frames { shown, ..Frames::default() };
        self.shown.iter().map(frames).collect()
    }

    fn has_misidentified(&self) -> Vec<bool> {
        has_misidentified(&self.sensors)
    }
}
