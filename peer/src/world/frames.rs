//! Frames: the world renders them and sends one to each agent.

use csat_mission::fleet::Brief;
use csat_mission::mission::Mission;
use csat_mission::stages;
use csat_proto::control::{FrameHeader, SaidSoFar};
use csat_proto::ids::AgentId;
use rayon::prelude::*;

use super::RemoteFleet;

impl<M: Mission> RemoteFleet<M> {
    /// A step begins: renders and sends all frames. An agent without camera, or one that is down, gets a
    /// frame without pixels.
    pub(super) fn send_frames(&mut self, brief: &Brief) {
        self.expected.begin(brief.step, &brief.lives);
        let said = self.said();
        for (member, is_down) in self.members.iter_mut().zip(&brief.is_down_by_schedule) {
            member.frames += u64::from(!is_down);
        }
        let Self { port, roster, renderers, render_times, .. } = self;
        let (publishers, roster, said) = (port.publishers(), &*roster, &said);
        let each = renderers.par_iter_mut().zip(render_times).enumerate();
        each.for_each(|(index, (renderer, times))| {
            let agent = AgentId(index as u16);
            if roster.process(agent).is_none() {
                return;
            }
            let is_up = brief.lives[index].is_some();
            let camera = renderer.as_mut().filter(|_| is_up);
            let (frame, rendered) =
                stages::collect(|| camera.map(|renderer| brief.frame(renderer, agent)));
            *times = rendered;
            let mut header = header(brief, publishers.world(), agent, said);
            header.detections = frame.as_ref().map(|f| f.detections.clone()).unwrap_or_default();
            publishers.frame(agent, &header, frame.as_ref());
        });
    }

    /// How many messages each agent has sent.
    pub(super) fn said(&self) -> Vec<SaidSoFar> {
        self.members.iter().filter_map(|member| member.said.clone()).collect()
    }
}

/// The header of an agent's frame without detections.
fn header(brief: &Brief, world: u64, agent: AgentId, said: &[SaidSoFar]) -> FrameHeader {
    let index = usize::from(agent.0);
    FrameHeader {
        world,
        step: brief.step,
        time: brief.now,
        next: brief.next,
        pose: brief.poses[index],
        p_world: None,
        incarnation: brief.lives[index],
        detections: Vec::new(),
        said: said.to_vec(),
    }
}
