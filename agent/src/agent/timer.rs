//! Why an agent asks to be called at a time.

/// Why an agent asks for [`Agent::handle_timeout`](csat_proto::agent::Agent::handle_timeout).
///
/// Facts of other agents set no timer: applying them one by one costs as much as applying all of them
/// together with the next own frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Timer {
    /// The own frame was measured and is to be applied, with all facts that arrived, once all
    /// messages of this instant have arrived.
    OwnFrame,
    /// A plan of another UAV arrived, for which a pass of guidance may have waited.
    PlanArrived,
    /// The agent stops waiting for the plans of other UAVs.
    PlanDeadline,
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use csat_proto::agent::Agent;
    use csat_proto::camera::Pose;
    use csat_proto::ids::{AgentId, ChannelId};
    use csat_proto::radio::Reception;
    use csat_proto::time::{SimTime, Step};

    use super::*;
    use crate::agent::SetMembershipAgent;
    use crate::config::AgentConfig;
    use crate::config::tests::default_config;

    fn uav(index: u16) -> SetMembershipAgent {
        SetMembershipAgent::new(&AgentConfig { id: AgentId(index), ..default_config([100.0; 2]) })
    }

    #[test]
    fn a_frame_a_plan_and_the_wait_for_a_plan_set_timers() {
        let start = SimTime(0);
        let (mut first, mut second) = (uav(0), uav(1));
        assert_eq!(second.next_timer(), None);
        let pose = Pose::level([0.0, 0.0, 52.0], FRAC_PI_2);
        for agent in [&mut first, &mut second] {
            agent.handle_step(start, Step(0), pose);
            assert_eq!(agent.next_timer(), Some((start, Timer::OwnFrame)));
            agent.handle_timeout(start);
        }
        let waits_for_a_plan = |(at, timer)| at > start && timer == Timer::PlanDeadline;
        assert!(second.next_timer().is_some_and(waits_for_a_plan));
        while let Some(transmit) = first.poll_transmit() {
            let (bytes, channel) = (transmit.bytes.into(), ChannelId(0));
            let message = Reception { channel, at: start, bearing_rad: 0.0, offset_m: None, bytes };
            second.handle_message(start, &message);
        }
        assert_eq!(second.next_timer(), Some((start, Timer::PlanArrived)));
        assert_eq!(second.poll_timeout(), Some(start));
    }
}
