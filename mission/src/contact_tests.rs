use super::*;
use csat_netem::config::{ChannelConfig, NetemConfig, OutageConfig, OutageKind, PartitionConfig};
use csat_netem::fate::{Delivery, Fate, Reason, Sent};
use csat_proto::ids::{ChannelId, Incarnation};
use csat_proto::time::Step;

fn seconds(time_s: f64) -> SimTime {
    SimTime::from_seconds(time_s)
}

/// A message from one UAV to another, sent and arriving at these seconds.
fn passage(src: u16, dst: u16, sent_s: f64, arrives_s: Result<f64, Reason>) -> Passage {
    let sent = Sent {
        src: AgentId(src),
        dst: AgentId(dst),
        incarnation: Incarnation(0),
        channel: ChannelId(0),
        sequence: 0,
        time: seconds(sent_s),
        bytes: 10,
        src_p_world: [0.0; 3],
        dst_p_world: [0.0; 3],
    };
    let at = |at_s| Delivery { at: seconds(at_s), corrupted: false };
    Passage { sent, bytes: [].into(), fate: Fate { first: arrives_s.map(at), duplicate: None } }
}

/// UAVs in a row, so many metres east of the middle.
fn row(east_m: &[f64]) -> Vec<Pose> {
    let pose = |&x: &f64| Pose { p_world: [x, 0.0, 50.0], ..Pose::default() };
    east_m.iter().map(pose).collect()
}

fn value(values: &Values, key: &str) -> Option<f64> {
    values.iter().find(|(name, _)| *name == key).expect(key).1
}

/// Steps of a second, in which these UAVs run.
struct Flight {
    contact: Contact,
    poses: Vec<Pose>,
    alive: Vec<bool>,
}

impl Flight {
    fn new(netem: &NetemConfig, east_m: &[f64]) -> Self {
        let contact = Contact::new(Links::new(netem, 1, None));
        Self { contact, poses: row(east_m), alive: vec![true; east_m.len()] }
    }

    fn step(&mut self, step: u32, passages: &[Passage]) -> Values {
        self.step_with(step, passages, &[])
    }

    fn step_with(
        &mut self,
        step: u32,
        passages: &[Passage],
        lives: &[(AgentId, LifeEvent)],
    ) -> Values {
        let now_s = f64::from(step);
        let (now, next) = (seconds(now_s), seconds(now_s + 1.0));
        let Self { contact, poses, alive } = self;
        contact.measure(&Moment { now, next, poses, alive, lives, passages })
    }
}

/// `contact_pct` and `components` of UAVs in a row.
fn network(netem: &NetemConfig, east_m: &[f64], alive: &[bool]) -> [Option<f64>; 2] {
    let mut flight = Flight::new(netem, east_m);
    flight.alive = alive.to_vec();
    let values = flight.step(1, &[]);
    [CONTACT, COMPONENTS].map(|key| value(&values, key))
}

fn range(range_m: f64) -> NetemConfig {
    NetemConfig { radio: ChannelConfig { range_m, ..Default::default() }, ..Default::default() }
}

#[test]
fn the_age_of_what_was_heard_by_hand() {
    let mut flight = Flight::new(&NetemConfig::default(), &[0.0, 1.0]);
    let age_s = |values: &Values| value(values, STALENESS).unwrap();
    assert_eq!(age_s(&flight.step(0, &[])), 0.0, "it is the start");
    assert_eq!(age_s(&flight.step(1, &[])), 1.0, "nothing was heard since the start");
    // Heard at once one way, under way for 1.5 s the other way.
    let sent = [passage(0, 1, 2.0, Ok(2.0)), passage(1, 0, 2.0, Ok(3.5))];
    assert_eq!(age_s(&flight.step(2, &sent)), (0.0 + 2.0) / 2.0);
    // It arrives before the next step.
    assert_eq!(age_s(&flight.step(3, &[])), (1.0 + 1.0) / 2.0);
    // An older message that comes late is no news, and a lost or damaged one is not heard.
    let mut damaged = passage(1, 0, 4.0, Ok(4.0));
    damaged.fate.first = Ok(Delivery { at: seconds(4.0), corrupted: true });
    let others = [passage(0, 1, 1.0, Ok(4.0)), passage(1, 0, 4.0, Err(Reason::Range)), damaged];
    assert_eq!(age_s(&flight.step(4, &others)), (2.0 + 2.0) / 2.0);
    // A copy may arrive where the message is damaged.
    let mut copied = passage(1, 0, 5.0, Ok(5.0));
    copied.fate.duplicate = copied.fate.first.map(Ok).ok();
    copied.fate.first = Ok(Delivery { at: seconds(5.0), corrupted: true });
    assert_eq!(age_s(&flight.step(5, &[copied])), (3.0 + 0.0) / 2.0);
    // What a step says later than its frames is not older than nothing.
    assert_eq!(age_s(&flight.step(6, &[passage(0, 1, 6.5, Ok(6.6))])), (0.0 + 1.0) / 2.0);
}

#[test]
fn who_is_restarted_has_heard_nothing_and_who_is_down_does_not_count() {
    let mut flight = Flight::new(&NetemConfig::default(), &[0.0, 1.0, 2.0]);
    let all: Vec<Passage> = [(0, 1), (1, 0), (0, 2), (2, 0), (1, 2), (2, 1)]
        .map(|(src, dst)| passage(src, dst, 1.0, Ok(1.0)))
        .into();
    assert_eq!(value(&flight.step(1, &all), STALENESS), Some(0.0));
    flight.alive[2] = false;
    // Two pairs are left; what comes to the third UAV is lost on it.
    let to_the_dead = [passage(0, 2, 3.0, Ok(3.0))];
    assert_eq!(value(&flight.step(3, &to_the_dead), STALENESS), Some(2.0));
    flight.alive[2] = true;
    let restarted = LifeEvent::Restarted { step: Step(4), incarnation: Incarnation(1) };
    let values = flight.step_with(4, &[], &[(AgentId(2), restarted)]);
    // Its own two pairs as receiver are as old as the mission.
    assert_eq!(value(&values, STALENESS), Some((4.0 * 3.0 + 2.0 * 4.0) / 6.0));
}

#[test]
fn one_uav_has_no_pair_and_a_station_is_none() {
    let mut alone = Flight::new(&NetemConfig::default(), &[0.0]);
    let values = alone.step(1, &[passage(1, 0, 1.0, Ok(1.0)), passage(0, 1, 1.0, Ok(1.0))]);
    assert_eq!((value(&values, STALENESS), value(&values, CONTACT)), (None, None));
    assert_eq!(value(&values, COMPONENTS), Some(1.0));
    assert_eq!(network(&NetemConfig::default(), &[0.0], &[false]), [None, None]);
}

#[test]
fn links_and_groups_by_hand() {
    let all = [true; 4];
    assert_eq!(
        network(&NetemConfig::default(), &[0.0, 1e3, 2e3, 3e3], &all),
        [Some(100.0), Some(1.0)]
    );
    // A chain: three pairs of six, and news travel along it.
    assert_eq!(network(&range(10.0), &[0.0, 10.0, 20.0, 30.0], &all), [Some(50.0), Some(1.0)]);
    // Two and two.
    assert_eq!(
        network(&range(10.0), &[0.0, 10.0, 50.0, 60.0], &all),
        [Some(100.0 / 3.0), Some(2.0)]
    );
    assert_eq!(network(&range(10.0), &[0.0, 20.0, 40.0, 60.0], &all), [Some(0.0), Some(4.0)]);
    // The chain without its second UAV: one pair of three.
    let without = [true, false, true, true];
    assert_eq!(
        network(&range(10.0), &[0.0, 10.0, 20.0, 30.0], &without),
        [Some(100.0 / 3.0), Some(2.0)]
    );
}

#[test]
fn one_way_links_connect_nobody_unless_they_go_round() {
    let one_way =
        |groups| PartitionConfig { from_s: 0.0, until_s: f64::INFINITY, groups, one_way: true };
    // Nothing gets from 0 and 1 to 2.
    let netem = NetemConfig {
        partition: vec![one_way(vec![vec![0, 1], vec![2]])],
        ..NetemConfig::default()
    };
    let contact_pct = Some(100.0 * 4.0 / 6.0);
    assert_eq!(network(&netem, &[0.0, 1.0, 2.0], &[true; 3]), [contact_pct, Some(2.0)]);
    // Of three UAVs each hears one other: 0 from 2, 1 from 0, 2 from 1.
    let ring = [[0, 2], [1, 0], [2, 1]].map(|pair| one_way(pair.map(|uav| vec![uav]).into()));
    let netem = NetemConfig { partition: ring.into(), ..NetemConfig::default() };
    assert_eq!(network(&netem, &[0.0, 1.0, 2.0], &[true; 3]), [Some(50.0), Some(1.0)]);
}

/// A radio that is off cuts the links of a UAV that runs; a crash takes the UAV away.
#[test]
fn an_outage_is_a_group_of_its_own_and_a_crash_is_none() {
    let outage = |kind| OutageConfig { agent: 1, from_s: 0.0, until_s: 9.0, kind };
    let netem = |kind| NetemConfig { outage: vec![outage(kind)], ..NetemConfig::default() };
    let east_m = [0.0, 1.0, 2.0];
    let radio = network(&netem(OutageKind::Radio), &east_m, &[true; 3]);
    assert_eq!(radio, [Some(100.0 / 3.0), Some(2.0)]);
    let crash = network(&netem(OutageKind::Crash), &east_m, &[true, false, true]);
    assert_eq!(crash, [Some(100.0), Some(1.0)]);
}
