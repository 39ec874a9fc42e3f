//! Hostile talk to agents of the road clearing: beats, formations, requests and masks.

use std::f64::consts::FRAC_PI_2;
use std::sync::OnceLock;

use csat_clearing::agent::ClearingAgent;
use csat_clearing::bitmap::Bitmap;
use csat_clearing::exchange::message::{Duty, Mask, Message, Request};
use csat_clearing::exchange::validate;
use csat_flight::clearing::Clearing;
use csat_flight::scenario::missions::Offered;
use csat_mission::mission::Mission;
use csat_proto::agent::Agent;
use csat_proto::camera::Pose;
use csat_proto::command::Command;
use csat_proto::envelope::Envelope;
use csat_proto::frame::{Frame, Label};
use csat_proto::ids::{AgentId, ChannelId, Incarnation};
use csat_proto::radio::Reception;
use csat_proto::time::{SimTime, Step};
use rand::RngExt;
use rand::seq::{IndexedMutRandom, IndexedRandom};
use rand_chacha::ChaCha8Rng;

use super::spoil::{any_up_to, changed};
use crate::missions::shipped;

const UAVS: u16 = 3;
/// Steps before the talk: UAV 0 comes to the crossing, and asks its wings.
const STEPS: u32 = 500;
/// Steps after the talk.
const AHEAD: u32 = 4;
/// Half of the width of the roads, metres.
const ROAD_M: f64 = 3.0;

/// A fleet above two roads that cross at the origin, with perfect sight and perfect links.
#[derive(Clone)]
struct Fleet {
    agents: Vec<ClearingAgent>,
    places_m: Vec<[f64; 2]>,
    step: u32,
}

/// What is said in a step: by whom, on which radio.
type Said = Vec<(usize, ChannelId, Vec<u8>)>;

impl Fleet {
    fn new() -> Self {
        let mut scenario = shipped("clearing");
        scenario.agents.count = UAVS;
        let mission = Clearing::of(&scenario);
        let agents = (0..UAVS).map(|id| mission.agent(AgentId(id), Incarnation(0))).collect();
        // The start line is where UAV 0 is: a point.
        let places_m = (0..UAVS).map(|id| [-110.0 - 4.0 * f64::from(id), 0.0]).collect();
        Self { agents, places_m, step: 0 }
    }

    fn now(&self) -> SimTime {
        SimTime::from_seconds(f64::from(self.step) * self.agents[0].config().period_s)
    }

    /// A step in which each agent hears all; gives what was said.
    fn fly(&mut self) -> Said {
        self.step += 1;
        let now = self.now();
        let mut said = Vec::new();
        for index in 0..self.agents.len() {
            let frame = self.frame(index);
            self.agents[index].handle_frame(now, &frame);
            while let Some(sent) = self.agents[index].poll_transmit() {
                said.push((index, sent.channel, sent.bytes));
            }
        }
        for (from, channel, bytes) in &said {
            for to in (0..self.agents.len()).filter(|to| to != from) {
                let reception = self.reception(*from, to, *channel, bytes);
                self.agents[to].handle_message(now, &reception);
            }
        }
        for index in 0..self.agents.len() {
            self.end_step(index);
        }
        said
    }

    /// An agent decides, and is displaced.
    fn end_step(&mut self, index: usize) {
        let now = self.now();
        let agent = &mut self.agents[index];
        agent.handle_timeout(now);
        while let Some(command) = agent.poll_command() {
            let Command::Displace { by_m } = command else { panic!("{command:?}") };
            self.places_m[index].iter_mut().zip(by_m).for_each(|(place, by)| *place += by);
        }
        while agent.poll_event().is_some() {}
    }

    fn frame(&self, index: usize) -> Frame {
        let [x, y] = self.places_m[index];
        let config = self.agents[index].config();
        let size = config.camera.columns;
        let from_middle =
            |pixel: u16| (f64::from(pixel) + 0.5 - f64::from(size) / 2.0) * config.pixel_m();
        let is_road = |row: u16, column: u16| {
            let [east, north] = [x + from_middle(column), y - from_middle(row)];
            north.abs() <= ROAD_M || east.abs() <= ROAD_M
        };
        let label = |row, column| if is_road(row, column) { Label::Road } else { Label::Ground };
        let labels =
            (0..size).flat_map(|row| (0..size).map(move |column| label(row, column))).collect();
        let pose = Pose::level([x, y, config.fleet.altitude_m], -FRAC_PI_2);
        let (depth, detections) = Default::default();
        Frame { labels, depth, detections, ..Frame::of_detector(Step(self.step), pose, None) }
    }

    fn reception(&self, from: usize, to: usize, channel: ChannelId, bytes: &[u8]) -> Reception {
        let offset = [0, 1].map(|axis| self.places_m[from][axis] - self.places_m[to][axis]);
        Reception {
            channel,
            at: self.now(),
            bearing_rad: offset[1].atan2(offset[0]) + FRAC_PI_2,
            offset_m: (channel == self.agents[to].config().hbsr).then_some(offset),
            bytes: bytes.into(),
        }
    }
}

/// A fleet in the middle of its mission.
struct Moment {
    fleet: Fleet,
    /// What agents said until then, decoded; one of each length.
    heard: Vec<Message>,
    /// The newest message of UAV 1, without its body.
    envelope: Envelope,
}

impl Moment {
    fn shared() -> &'static Self {
        static SHARED: OnceLock<Moment> = OnceLock::new();
        SHARED.get_or_init(|| {
            let mut fleet = Fleet::new();
            let (mut heard, mut newest) = (std::collections::BTreeMap::new(), None);
            for _ in 0..STEPS {
                for (from, _, bytes) in fleet.fly() {
                    let envelope = Envelope::decode(&bytes).expect("an agent's own message");
                    let message = postcard::from_bytes(&envelope.body).expect("an honest body");
                    heard.insert(envelope.body.len(), message);
                    newest = Some(envelope).filter(|_| from == 1).or(newest);
                }
            }
            let envelope = newest.map(|newest| Envelope { body: Vec::new(), ..newest });
            let envelope = envelope.expect("UAV 1 says something");
            Self { fleet, heard: heard.into_values().collect(), envelope }
        })
    }
}

/// The body of a message that UAV 1 seems to send on either radio; the others fly on afterwards.
///
/// # Panics
/// When a property does not hold.
pub fn clearing(body: &[u8]) {
    let moment = Moment::shared();
    let bytes = Envelope { body: body.to_vec(), ..moment.envelope.clone() }.encode();
    let config = moment.fleet.agents[0].config();
    for channel in [config.hbsr, config.lblr] {
        let mut fleet = moment.fleet.clone();
        for to in [0, 2] {
            hear(&mut fleet, to, channel, &bytes);
        }
        for _ in 0..AHEAD {
            let said = fleet.fly();
            fleet.agents.iter().for_each(check_masks);
            check_honest(&fleet, &said);
        }
    }
}

/// Either the message is dropped, counts once and changes nothing, or it is believed.
fn hear(fleet: &mut Fleet, to: usize, channel: ChannelId, bytes: &[u8]) {
    let reception = fleet.reception(1, to, channel, bytes);
    let now = fleet.now();
    let agent = &mut fleet.agents[to];
    let total = |agent: &ClearingAgent| agent.rejected().values().sum::<u64>();
    let (before, dropped) = (agent.digest(), total(agent));
    agent.handle_message(now, &reception);
    if total(agent) > dropped {
        assert_eq!(total(agent), dropped + 1, "dropped once: {:?}", agent.rejected());
        assert_eq!(agent.digest(), before, "dropped, but something changed");
    }
    check_masks(agent);
}

/// What can be road is cleared, known to be cleared, or unknown; the frontier is a part of what is cleared.
fn check_masks(agent: &ClearingAgent) {
    let Some(masks) = agent.masks() else { return };
    let parts = [masks.mine(), masks.foreign(), masks.unknown()];
    let total: u32 = parts.iter().map(|part| part.count()).sum();
    let all = parts
        .into_iter()
        .fold(Bitmap::new(masks.road().rows(), masks.road().columns()), Bitmap::or);
    assert_eq!(&all, masks.road(), "the parts are not the whole");
    assert_eq!(total, all.count(), "the parts overlap");
    assert!(masks.frontier().clone().and_not(masks.mine()).is_empty());
}

/// After any message, the messages of an agent are still accepted; otherwise a false message could silence it.
fn check_honest(fleet: &Fleet, said: &Said) {
    for (from, channel, bytes) in said {
        let to = (from + 1) % fleet.agents.len();
        let reception = fleet.reception(*from, to, *channel, bytes);
        let verdict =
            validate::check(fleet.agents[to].config(), fleet.agents[to].step(), &reception);
        assert!(verdict.is_ok(), "what it says is not believed any more: {:?}", verdict.err());
    }
}

/// A changed body; `None` if `bytes` are none.
pub fn talk(bytes: &[u8], seed: u64) -> Option<Vec<u8>> {
    changed(bytes, seed, 1..5, spoil)
}

fn spoil(message: &mut Message, rng: &mut ChaCha8Rng) {
    let mut id = || AgentId(rng.random_range(0..UAVS + 1));
    let (one, other) = (id(), id());
    let beat = &mut message.beat;
    match (rng.random_range(0..14), &mut message.formation) {
        (0, _) => {
            beat.duty = *[Duty::Cleaner, Duty::Follower, Duty::Helper].choose(rng).expect("some")
        }
        (1, _) => beat.leader = Some(one).filter(|_| rng.random_bool(0.8)),
        (2, _) => beat.has_frontier = !beat.has_frontier,
        (3, _) => beat.has_lost = true,
        (4, _) => beat.followers = any_up_to(u16::MAX.into(), rng) as u16,
        (5, Some(formation)) => formation.wings = [Some(one), Some(other)],
        (6, Some(formation)) => formation.tails = vec![one, other],
        (7, Some(formation)) => formation.parent = Some(one),
        (8, Some(formation)) => formation.heading = [rng.random(), rng.random()],
        (9, Some(formation)) => {
            let mut edges = || [any_up_to(300, rng) as u16, any_up_to(300, rng) as u16];
            let (rows, columns) = (edges(), edges());
            formation.requests.push(Request { to: one, rows, columns });
        }
        (10, formation) => *formation = None,
        _ => spoil_mask(&mut message.safe, rng),
    }
}

fn spoil_mask(safe: &mut Option<Mask>, rng: &mut ChaCha8Rng) {
    match safe {
        Some(Mask::Runs(runs)) => match rng.random_range(0..4) {
            0 => runs.push(any_up_to(u32::MAX, rng)),
            1 => runs.reverse(),
            2 => drop(runs.pop()),
            _ => runs.choose_mut(rng).into_iter().for_each(|run| *run = any_up_to(1 << 17, rng)),
        },
        Some(Mask::Bitmap(bytes)) => match bytes.choose_mut(rng) {
            Some(byte) if rng.random_bool(0.9) => *byte = rng.random(),
            _ => bytes.truncate(7),
        },
        None => {
            let bytes = if rng.random_bool(0.7) { 256 * 32 } else { 9 };
            *safe = Some(Mask::Bitmap(vec![rng.random(); bytes]));
        }
    }
}

/// Honest bodies, by file name.
pub fn seeds() -> Vec<(&'static str, String, Vec<u8>)> {
    let heard = Moment::shared().heard.iter().enumerate();
    // Of the many lengths of masks a few are enough.
    let few = heard.filter(|(i, _)| i.is_multiple_of(1 + Moment::shared().heard.len() / 12));
    few.map(|(i, message)| {
        let body = postcard::to_stdvec(message).expect("it serialises");
        ("clearing", format!("honest-{i}"), body)
    })
    .collect()
}
