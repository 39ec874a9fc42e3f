//! A rule that csat does not have, as docs/extending.md explains it: agents that fly low hear no other
//! agent.

use csat_netem::fate::{Reason, Sent};
use csat_netem::rule::{Case, Departure, LinkState, Rule, judge};
use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use csat_proto::time::SimTime;

/// Hills: an agent below an altitude is not heard and does not hear.
pub struct Hills {
    /// That altitude, metres.
    altitude_m: f64,
}

impl Hills {
    /// `None` when the channel knows no hills: rules that can do nothing are not asked.
    pub fn new(altitude_m: Option<f64>) -> Option<Self> {
        altitude_m.map(|altitude_m| Self { altitude_m })
    }
}

impl Rule for Hills {
    fn judge(&self, case: &mut Case<'_>) -> Result<(), Reason> {
        if self.cuts(case.sent, 0) { Err(Reason::Propagation) } else { Ok(()) }
    }

    fn cuts(&self, probe: &Sent, _seed: u64) -> bool {
        probe.src_p_world[2].min(probe.dst_p_world[2]) < self.altitude_m
    }
}

/// What the rule makes of a message between UAVs at these altitudes, metres.
fn verdict(altitudes_m: [f64; 2]) -> Result<(), Reason> {
    let sent = Sent {
        src: AgentId(0),
        dst: AgentId(1),
        incarnation: Incarnation(0),
        channel: ChannelId(0),
        sequence: 0,
        time: SimTime::from_seconds(1.0),
        bytes: 1500,
        src_p_world: [0.0, 0.0, altitudes_m[0]],
        dst_p_world: [120.0, 0.0, altitudes_m[1]],
    };
    let mut link = LinkState::new(1, &sent);
    let mut case = Case::new(&sent, &mut link, Departure::After(0.0));
    let rules: Vec<Box<dyn Rule>> =
        Hills::new(Some(55.0)).into_iter().map(|rule| Box::new(rule) as Box<dyn Rule>).collect();
    judge(&rules, &mut case)
}

fn main() {
    assert_eq!(verdict([58.0, 61.0]), Ok(()));
    assert_eq!(verdict([58.0, 52.0]), Err(Reason::Propagation));
    println!("above the hills: {:?}, below: {:?}", verdict([58.0, 61.0]), verdict([58.0, 52.0]));
}
