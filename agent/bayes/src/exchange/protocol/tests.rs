use std::collections::BTreeSet;

use csat_proto::agent::FIRST_ANSWER;
use csat_proto::grid_pose::GridPose;
use csat_proto::time::SimTime;

use super::*;
use crate::exchange::fixture::{POSE, config, factor};
use crate::tiles::Tile;

struct Peer {
    config: AgentConfig,
    exchange: Exchange,
    set: FactorSet,
    /// What was sent.
    sent: Vec<Transmit>,
}

impl Peer {
    fn of(config: AgentConfig) -> Self {
        let (exchange, set) = (Exchange::new(&config), FactorSet::new());
        Self { config, exchange, set, sent: Vec::new() }
    }

    /// States a factor, unless it is a station, and says what there is to say; what is worth most was stated at
    /// a step that is a multiple of ten.
    fn step(&mut self, step: u32, plan: &Plan) -> Vec<Transmit> {
        if !self.config.is_station() {
            let sighting = step.is_multiple_of(10).then_some([10.0, 20.0]);
            self.set.insert(self.exchange.state(Step(step), &POSE, sighting));
        }
        let mut worth = |factor: &Factor| if factor.sighting.is_some() { 1.0 } else { 0.1 };
        self.exchange.say(&self.stamp(step), &self.set, plan, None, &mut worth);
        let sent: Vec<Transmit> = std::iter::from_fn(|| self.exchange.poll_transmit()).collect();
        self.sent.extend(sent.clone());
        sent
    }

    fn stamp(&self, step: u32) -> Stamp {
        let now = SimTime::from_seconds(f64::from(step) * self.config.period_s);
        Stamp { now, step: Step(step), pose: POSE }
    }

    fn hear(&mut self, step: u32, bytes: &[u8]) -> Result<Received, Rejection> {
        let received = self.exchange.receive(Step(step), bytes)?;
        received.factors.iter().for_each(|factor| {
            self.set.insert(*factor);
        });
        Ok(received)
    }

    /// The ids of the factors that it holds of steps before `limit`.
    fn holds(&self, limit: u32) -> BTreeSet<FactorId> {
        let early = self.set.iter().filter(|factor| factor.step < Step(limit));
        early.map(|factor| factor.id).collect()
    }

    fn bytes(&self) -> usize {
        self.sent.iter().map(|sent| sent.bytes.len()).sum()
    }
}

fn peers(ids: &[u16], adapt: impl Fn(&mut AgentConfig)) -> Vec<Peer> {
    let peer = |id: &u16| {
        let mut config = config(*id);
        adapt(&mut config);
        Peer::of(config)
    };
    ids.iter().map(peer).collect()
}

/// Some steps of these agents; `arrives` is asked with step, sender and receiver, by position.
fn fly(
    peers: &mut [Peer],
    steps: std::ops::Range<u32>,
    mut arrives: impl FnMut(u32, usize, usize) -> bool,
) {
    for step in steps {
        let plan = Plan::default();
        let sent: Vec<Vec<Transmit>> =
            peers.iter_mut().map(|peer| peer.step(step, &plan)).collect();
        let count = peers.len();
        for (from, to) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
            if from != to && arrives(step, from, to) {
                for transmit in &sent[from] {
                    peers[to].hear(step, &transmit.bytes).expect("it is believed");
                }
            }
        }
    }
}

/// A share of 30 % of all messages.
fn few(step: u32, from: usize, to: usize) -> bool {
    xxhash_rust::xxh3::xxh3_64(&[step as u8, (step >> 8) as u8, from as u8, to as u8]) % 10 < 3
}

fn decoded(transmit: &Transmit) -> Message {
    postcard::from_bytes(&Envelope::decode(&transmit.bytes).unwrap().body).unwrap()
}

#[test]
fn what_is_lost_is_repaired() {
    let mut pair = peers(&[0, 1], |_| {});
    fly(&mut pair, 0..200, few);
    assert!(pair[0].set.len() > 360, "{} of 400 in spite of losses", pair[0].set.len());
    fly(&mut pair, 200..212, |_, _, _| true);
    assert_eq!(pair[0].holds(212), pair[1].holds(212));
    assert_eq!((pair[0].set.len(), pair[0].set.held()), (424, pair[1].set.held()));
    let repeats: usize = pair.iter().flat_map(|p| &p.sent).map(|m| decoded(m).factors.len()).sum();
    assert!(repeats < 4 * 424, "{repeats} factors were sent");
}

#[test]
fn in_mode_facts_what_is_lost_stays_lost() {
    let mut pair = peers(&[0, 1], |config| config.exchange.mode = ExchangeMode::Facts);
    fly(&mut pair, 0..200, few);
    fly(&mut pair, 200..220, |_, _, _| true);
    assert!((240..320).contains(&pair[0].set.len()), "{}", pair[0].set.len());
    let mut silent = peers(&[0, 1], |config| config.exchange.mode = ExchangeMode::None);
    fly(&mut silent, 0..20, |_, _, _| true);
    assert_eq!((silent[0].set.len(), silent[0].sent.len()), (20, 0));
}

#[test]
fn agents_relay_along_a_line() {
    // The agent in the middle is a ground station.
    let mut line = peers(&[0, 4, 2], |_| {});
    fly(&mut line, 0..60, |_, from, to| from.abs_diff(to) == 1);
    let all = line[1].holds(50);
    assert_eq!(all.len(), 100);
    assert_eq!((line[0].holds(50), line[2].holds(50)), (all.clone(), all));
    assert!(line[1].sent.len() <= 32, "a station says nothing without need");
    let mut line = peers(&[0, 1, 2, 3], |_| {});
    fly(&mut line, 0..100, |step, from, to| from.abs_diff(to) == 1 && few(step, from, to));
    fly(&mut line, 100..130, |_, from, to| from.abs_diff(to) == 1);
    assert!((1..4).all(|i| line[i].holds(115) == line[0].holds(115)));
}

#[test]
fn one_agent_repairs_a_loss_and_once() {
    let mut fleet = peers(&[0, 1, 2, 3], |_| {});
    fly(&mut fleet, 0..40, |step, from, to| step != 7 || (from, to) != (0, 2));
    assert!(fleet.iter().all(|peer| peer.holds(40).len() == 160));
    let sent: Vec<FactorId> =
        fleet.iter().flat_map(|p| &p.sent).flat_map(|m| decoded(m).factors).map(|f| f.id).collect();
    assert_eq!(sent.len(), 161);
    assert_eq!(sent.iter().filter(|id| **id == factor(0, 0, 7).id).count(), 2);
}

#[test]
fn a_new_incarnation_learns_what_it_knew() {
    let mut pair = peers(&[0, 1], |_| {});
    fly(&mut pair, 0..300, |_, _, _| true);
    let late = pair[1].sent.last().unwrap().clone();
    pair[1] = Peer::of(AgentConfig { incarnation: Incarnation(1), ..config(1) });
    fly(&mut pair, 300..340, |_, _, _| true);
    assert_eq!(pair[1].holds(340), pair[0].holds(340));
    assert_eq!(pair[0].set.len(), 680);
    assert_eq!(pair[0].hear(340, &late.bytes), Err(Rejection::Incarnation { got: 0, known: 1 }));
    let most = pair[0].sent.iter().map(|sent| decoded(sent).factors.len()).max();
    assert_eq!(most, Some(MAX_SAID));
    assert_eq!(pair[0].exchange.withheld(), 0);
}

#[test]
fn helpers_of_a_restarted_agent_do_not_repeat_each_other() {
    let mut fleet = peers(&[0, 1, 2, 3], |_| {});
    fly(&mut fleet, 0..300, |_, _, _| true);
    fleet[3] = Peer::of(AgentConfig { incarnation: Incarnation(1), ..config(3) });
    fly(&mut fleet, 300..360, |_, _, _| true);
    assert_eq!(fleet[3].holds(360), fleet[0].holds(360));
    let said = fleet.iter().flat_map(|p| &p.sent).flat_map(|m| decoded(m).factors);
    let again = said.filter(|factor| factor.step < Step(300)).count() - 900;
    assert!((1200..1300).contains(&again), "{again} for 1200 that were missing");
}

#[test]
fn sequences_have_no_gaps_and_plans_travel_with_every_message() {
    let mut peer = Peer::of(config(0));
    let poses = vec![(&POSE).into(); 100];
    let plan = Plan { first: Step(3), period: 2, poses };
    (0..10).for_each(|step| assert_eq!(peer.step(step, &plan).len(), 1));
    assert!(peer.sent.iter().map(|sent| sent.sequence).eq(0..10));
    let said = decoded(&peer.sent[9]);
    assert_eq!(said.plan, plan.first_poses(MAX_PLAN));
    let mut other = Peer::of(config(1));
    let received = other.hear(9, &peer.sent[9].bytes).unwrap();
    let pose = GridPose::from(POSE).into();
    assert_eq!((received.from, received.step, received.pose), (AgentId(0), Step(9), pose));
    assert_eq!(received.plan, said.plan);
    let far = Pose { p_world: [1e5, 0.0, 50.0], ..POSE };
    let first = peer.exchange.state(Step(10), &far, None);
    assert_eq!((first.id.number, peer.exchange.stated()), (10, 11));
    peer.step(11, &plan);
    assert_eq!(decoded(&peer.sent[10]).factors.len(), 1, "others would refuse the message");
}

#[test]
fn a_budget_is_kept_and_the_worthiest_are_said_first() {
    for budget in [80.0, 200.0, 500.0, 2000.0] {
        let mut pair = peers(&[0, 1], |config| config.exchange.budget_bytes_s = budget);
        fly(&mut pair, 0..120, |_, _, _| true);
        let (bytes, withheld) = (pair[0].bytes() as f64, pair[0].exchange.withheld());
        assert!(bytes <= 60.0 * budget + 2.0 * budget, "{bytes} at {budget} B/s");
        assert!(bytes >= (45.0 * budget).min(120.0 * 70.0), "{bytes} at {budget} B/s");
        assert_eq!(withheld > 0, budget < 100.0, "{withheld} at {budget} B/s");
        let of_other = pair[1].set.iter().filter(|factor| factor.id.source == AgentId(0));
        let (worthy, other): (Vec<Factor>, Vec<Factor>) =
            of_other.copied().partition(|f| f.sighting.is_some());
        assert!(worthy.len() >= 11, "{} of 12 at {budget} B/s", worthy.len());
        assert_eq!(other.len() < 100, budget < 100.0, "{} at {budget} B/s", other.len());
        let mut pair = peers(&[0, 1], |config| {
            config.exchange.budget_bytes_s = budget;
            config.exchange.mode = ExchangeMode::Facts;
        });
        fly(&mut pair, 0..120, |_, _, _| true);
        let missing = 240 - pair[1].set.len() as u64;
        assert_eq!(missing, pair[0].exchange.withheld());
        assert!(pair[0].bytes() as f64 <= 62.0 * budget);
    }
}

#[test]
fn with_a_tiny_budget_little_is_said_but_not_nothing() {
    for mode in [ExchangeMode::Facts, ExchangeMode::FactsRepair] {
        let mut pair = peers(&[0, 1], |config| {
            config.exchange.budget_bytes_s = 20.0;
            config.exchange.mode = mode;
        });
        fly(&mut pair, 0..120, |_, _, _| true);
        let said = pair[1].set.iter().filter(|factor| factor.id.source == AgentId(0)).count();
        assert!(said >= 5 && pair[0].bytes() as f64 <= 60.0 * 20.0 + 200.0, "{said} in {mode:?}");
    }
}

#[test]
fn plans_take_a_part_of_a_budget() {
    let mut config = config(0);
    config.exchange.budget_bytes_s = 400.0;
    let mut peer = Peer::of(config);
    let plan = Plan { first: Step(0), period: 2, poses: vec![(&POSE).into(); 20] };
    (0..120).for_each(|step| assert!(peer.step(step, &plan).len() <= 1));
    let said: Vec<Message> = peer.sent.iter().map(decoded).collect();
    let with_plan: Vec<_> = said.iter().filter(|said| !said.plan.poses.is_empty()).collect();
    assert!((50..=60).contains(&with_plan.len()), "{}", with_plan.len());
    assert!(with_plan.iter().all(|said| said.plan.poses.len() == 4 && said.held.is_some()));
    let factors: usize = said.iter().map(|said| said.factors.len()).sum();
    assert!(factors >= 110, "{factors}");
}

#[test]
fn a_forged_factor_that_others_relay_does_not_silence_them() {
    let mut fleet = peers(&[0, 1, 2], |_| {});
    fly(&mut fleet[1..], 0..10, |_, _, _| true);
    fly(&mut fleet, 10..50, |_, _, _| true);
    // Agent 0 missed ten frames and has not stated its factor 45 yet, but agent 1 was told of one.
    let forged = Factor { sighting: Some([3.0, 4.0]), ..factor(0, 0, 45) };
    fleet[1].set.insert(forged);
    fly(&mut fleet, 50..54, |_, _, _| true);
    assert_eq!(fleet[2].set.get(forged.id), Some(&forged), "agent 1 relays it");
    assert!(!fleet[0].set.holds(forged.id) && fleet[0].holds(54).len() == 44 + 2 * 54);
    let relayed = |sent: &&Transmit| decoded(sent).factors.contains(&forged);
    let bytes = fleet[1].sent.iter().find(relayed).unwrap().bytes.clone();
    let received = fleet[0].hear(54, &bytes).unwrap();
    let forgery = Rejection::Forged { incarnation: 0, number: 45, stated: 44 };
    assert_eq!((received.factors.len(), received.dropped), (1, vec![forgery]));
    fly(&mut fleet, 54..60, |_, _, _| true);
    let own = fleet[0].set.get(forged.id).unwrap();
    assert_eq!((own.step, own.sighting), (Step(55), None));
}

#[test]
fn a_belief_waits_for_its_bytes() {
    let mut config = config(0);
    config.exchange.mode = ExchangeMode::Snapshot;
    config.exchange.budget_bytes_s = 100.0;
    let mut exchange = Exchange::new(&config);
    let columns = (0..4).flat_map(|row| (0..8).map(move |column| (column, row)));
    let tile = |(column, row)| Tile { level: 0, column, row, depth: 300 };
    let belief = |count: usize| Tiles(columns.clone().map(tile).cycle().take(count).collect());
    let stamp = |step: u32| {
        let now = SimTime::from_seconds(0.5 * f64::from(step));
        Stamp { now, step: Step(step), pose: POSE }
    };
    let mut said = Vec::new();
    let plan = Plan { first: Step(0), period: 1, poses: vec![(&POSE).into()] };
    for step in 0..200 {
        let due = [(0, 500), (10, 32), (150, 32)].iter().find(|(at, _)| *at == step);
        let belief = due.map(|(_, count)| belief(*count));
        exchange.say(&stamp(step), &FactorSet::new(), &plan, belief, &mut |_| 0.0);
        said.extend(exchange.poll_transmit().map(|transmit| (step, transmit)));
    }
    // The first one waited for 500 tiles until a smaller one took its place.
    let steps: Vec<u32> = said.iter().map(|(step, _)| *step).collect();
    assert!(steps.len() == 2 && steps[0] == 10 && (151..156).contains(&steps[1]), "{steps:?}");
    assert_eq!(exchange.withheld(), 2);
    let mut other = Exchange::new(&AgentConfig { id: AgentId(1), ..config.clone() });
    let received = other.receive(Step(40), &said[0].1.bytes).unwrap();
    assert_eq!((received.belief, received.plan.poses.len()), (Some(belief(32)), 1));
    let answer = exchange.answer(&stamp(200), &FactorSet::new(), Some(belief(32))).unwrap();
    assert_eq!(other.receive(Step(200), &answer.bytes).unwrap().belief, Some(belief(32)));
}

#[test]
fn an_answer_has_all_factors() {
    let mut pair = peers(&[0, 1], |_| {});
    let [first, _] = &mut pair[..] else { unreachable!() };
    assert_eq!(first.exchange.answer(&first.stamp(0), &FactorSet::new(), None), None);
    fly(&mut pair, 0..1200, |_, _, _| true);
    let mut first = pair.swap_remove(0);
    let restarted = || Peer::of(AgentConfig { incarnation: Incarnation(1), ..config(2) });
    let stamp = first.stamp(1199);
    for number in 0..2 {
        let answer = first.exchange.answer(&stamp, &first.set, None).unwrap();
        assert_eq!(answer.sequence, FIRST_ANSWER + number);
        let mut late = restarted();
        late.hear(1200, &answer.bytes).unwrap();
        assert_eq!(late.holds(1200), first.holds(1200));
    }
    let mut many = FactorSet::new();
    (0..4).flat_map(|source| (0..20_000).map(move |n| factor(source, 0, n))).for_each(|factor| {
        many.insert(factor);
    });
    let answer = first.exchange.answer(&first.stamp(20_000), &many, None).unwrap();
    let mut late = restarted();
    late.hear(20_000, &answer.bytes).expect("it is not too long");
    assert_eq!(late.set.len(), validate::MAX_FACTORS);
    assert!(late.set.since(Step(0)).next().unwrap().step > Step(3000), "the oldest are left out");
}

#[test]
fn a_plan_that_others_would_refuse_is_not_said() {
    let mut peer = Peer::of(config(0));
    let pose = (&POSE).into();
    let far = (&Pose { p_world: [1e5, 0.0, 50.0], ..POSE }).into();
    let plan = Plan { first: Step(1), period: 1, poses: vec![pose, far, pose] };
    let said = decoded(&peer.step(0, &plan)[0]).plan;
    assert_eq!(said, plan.first_poses(1));
    let said = decoded(&peer.step(1, &Plan { first: Step(9), ..plan.clone() })[0]).plan;
    assert_eq!(said, Plan::default());
}
