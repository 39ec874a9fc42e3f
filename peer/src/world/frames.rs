//! Frames: the world makes them and sends one to each agent.

use csat_mission::fleet::Brief;
use csat_mission::mission::Mission;
use csat_mission::stages;
use csat_proto::camera::PoseEstimate;
use csat_proto::control::{FrameHeader, SaidSoFar};
use csat_proto::ids::AgentId;
use rayon::prelude::*;

use super::RemoteFleet;

impl<M: Mission> RemoteFleet<M> {
    /// A step begins: makes and sends all frames. An agent without sensor, or one that is down, gets a
    /// frame without pixels.
    pub(super) fn send_frames(&mut self, brief: &Brief) {
        self.expected.begin(brief.step, &brief.lives);
        let said = self.said();
        for (member, is_down) in self.members.iter_mut().zip(&brief.is_down_by_schedule) {
            member.frames += u64::from(!is_down);
        }
        let Self { port, roster, sensors, render_times, .. } = self;
        let (publishers, roster, said) = (port.publishers(), &*roster, &said);
        let each = sensors.par_iter_mut().zip(render_times).enumerate();
        each.for_each(|(index, (sensor, times))| {
            let agent = AgentId(index as u16);
            if roster.process(agent).is_none() {
                return;
            }
            let is_up = brief.lives[index].is_some();
            let sensor = sensor.as_mut().filter(|_| is_up);
            let (frame, rendered) =
                stages::collect(|| sensor.map(|sensor| brief.frame(sensor, agent)));
            *times = rendered;
            let mut header = header(brief, publishers.world(), agent, said);
            if let Some(frame) = &frame {
                (header.detections, header.sighting) = (frame.detections.clone(), frame.sighting);
            }
            publishers.frame(agent, &header, frame.as_ref());
        });
    }

    /// How many messages each agent has sent.
    pub(super) fn said(&self) -> Vec<SaidSoFar> {
        self.members.iter().filter_map(|member| member.said.clone()).collect()
    }
}

/// The header of an agent's frame without detections and sighting.
fn header(brief: &Brief, world: u64, agent: AgentId, said: &[SaidSoFar]) -> FrameHeader {
    let index = usize::from(agent.0);
    let (PoseEstimate { pose, error }, truth) = (brief.reported[index], brief.poses[index]);
    let is_exact = pose == truth;
    FrameHeader {
        world,
        step: brief.step,
        time: brief.now,
        next: brief.next,
        pose,
        pose_error: error,
        p_world: (!is_exact).then_some(truth.p_world),
        yaw_rad: (!is_exact).then_some(truth.yaw_rad),
        incarnation: brief.lives[index],
        detections: Vec::new(),
        sighting: None,
        said: said.to_vec(),
    }
}
