//! False talk that decodes: honest messages with changed values.

use std::f32::consts::FRAC_PI_2;

use csat_bayes::exchange::held::{Held, HeldNumbers, MAX_INCARNATIONS};
use csat_bayes::exchange::intervals::Intervals;
use csat_bayes::exchange::message::Message;
use csat_bayes::factor::{Factor, FactorId, ReportedPose};
use csat_bayes::tiles::{MAX_LEVEL, Tile};
use csat_proto::ids::{AgentId, Incarnation};
use csat_proto::time::Step;
use rand::seq::{IndexedMutRandom, IndexedRandom};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{Said, joined, split};
use crate::fuzz::spoil::any_up_to;

/// Coordinates from the ends of their ranges, metres.
const PLACES: [f32; 12] = [
    0.0,
    -0.0,
    f32::MIN_POSITIVE,
    1e-45,
    0.5,
    2100.0,
    -2100.0,
    9999.0,
    1e30,
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
];
/// Angles from the ends of their ranges, radians.
const ANGLES: [f32; 10] =
    [0.0, 0.8, 1.3, -1.5, FRAC_PI_2, -FRAC_PI_2, 3.0, f32::MAX, f32::NAN, f32::INFINITY];
/// Columns and rows from the ends of their ranges, pixels.
const PIXELS: [f32; 8] = [0.0, -0.0, 320.0, 480.0, 640.0, 641.0, 1e-45, f32::NAN];

/// Changed talk; `None` if `bytes` do not begin with a message.
pub fn talk(bytes: &[u8], seed: u64) -> Option<Vec<u8>> {
    let (mut said, _) = split(bytes);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for _ in 0..rng.random_range(1..5) {
        let again = said.choose(&mut rng)?.clone();
        match rng.random_range(0..12) {
            0 => said.push(again),
            1 => said.reverse(),
            _ => spoil(said.choose_mut(&mut rng)?, &mut rng),
        }
    }
    Some(joined(&said))
}

fn spoil(said: &mut Said, rng: &mut ChaCha8Rng) {
    let Said { src, incarnation, step, message } = said;
    match rng.random_range(0..24) {
        0 => *src = AgentId(rng.random_range(0..4)),
        1 => *incarnation = Incarnation(any_up_to(u32::MAX, rng)),
        2 => *step = Step(any_up_to(step.0 + 2, rng)),
        3 => message.factors.reverse(),
        4 => message.factors.clear(),
        5 | 6 => spoil_held(message, *step, rng),
        7 | 8 => spoil_plan(message, rng),
        9..12 => spoil_belief(message, rng),
        _ => spoil_factors(&mut message.factors, rng),
    }
}

fn spoil_factors(factors: &mut Vec<Factor>, rng: &mut ChaCha8Rng) {
    let Some(mut factor) = factors.choose(rng).copied() else { return };
    let id = factor.id;
    match rng.random_range(0..12) {
        0 => factor.id.source = AgentId(rng.random_range(0..3)),
        1 => factor.id.incarnation = Incarnation(rng.random_range(0..3)),
        2 => factor.id.incarnation = Incarnation(any_up_to(u32::MAX, rng)),
        3 => factor.id.number = any_up_to(factor.step.0 + 1, rng),
        4 => factor.id.number = any_up_to(u32::MAX, rng),
        5 => factor.step = Step(any_up_to(factor.step.0 + 2, rng)),
        6 | 7 => factor.sighting = Some([0; 2].map(|_| one_of(&PIXELS, rng))),
        8 => factor.sighting = None,
        _ => spoil_pose(&mut factor.pose, rng),
    }
    // Said again of the same frame, said instead, or said first.
    match rng.random_range(0..3) {
        0 => factors.push(factor),
        1 => factors.insert(0, factor),
        _ => factors.iter_mut().filter(|f| f.id == id).for_each(|f| *f = factor),
    }
}

fn spoil_pose(pose: &mut ReportedPose, rng: &mut ChaCha8Rng) {
    let axis = rng.random_range(0..3);
    match rng.random_range(0..3) {
        0 => pose.p_world[axis] = one_of(&PLACES, rng),
        1 => pose.angles_rad[axis] = one_of(&ANGLES, rng),
        _ => pose.p_world[axis] += rng.random_range(-200.0..200.0),
    }
}

fn spoil_plan(message: &mut Message, rng: &mut ChaCha8Rng) {
    let plan = &mut message.plan;
    match (rng.random_range(0..4), plan.poses.choose_mut(rng)) {
        (0, _) => plan.first = Step(any_up_to(u32::MAX, rng)),
        (1, _) => plan.period = any_up_to(u32::MAX, rng),
        (_, Some(pose)) => spoil_pose(pose, rng),
        (_, None) => plan.poses.extend(message.factors.iter().map(|factor| factor.pose)),
    }
}

fn spoil_held(message: &mut Message, step: Step, rng: &mut ChaCha8Rng) {
    let source = AgentId(rng.random_range(0..3));
    let incarnation = Incarnation(any_up_to(4, rng));
    let count = any_up_to(step.0 + 3, rng);
    let every = rng.random_range(1..3);
    let mut numbers = Intervals::EMPTY;
    (0..count).step_by(every).for_each(|number| {
        numbers.insert(number);
    });
    let mut told = HeldNumbers::of(source, incarnation, &numbers);
    told.rest = told.rest.or(rng.random_bool(0.2).then_some(7));
    let Held(all) = message.held.get_or_insert_default();
    all.retain(|held| (held.source, held.incarnation) != (source, incarnation));
    all.push(told);
    all.sort_by_key(|held| (held.source, held.incarnation));
}

fn spoil_belief(message: &mut Message, rng: &mut ChaCha8Rng) {
    let Some(tiles) = message.belief.as_mut().map(|belief| &mut belief.0) else { return };
    let Some(at) = (0..tiles.len()).collect::<Vec<_>>().choose(rng).copied() else { return };
    let tile = tiles[at];
    match rng.random_range(0..7) {
        0 => tiles[at].depth = any_up_to(u16::MAX.into(), rng) as u16,
        1 => tiles[at].level = any_up_to(255, rng) as u8,
        2 => tiles[at].column = any_up_to(u32::MAX, rng),
        3 => drop(tiles.remove(at)),
        4 => tiles.iter_mut().for_each(|tile| tile.depth = u16::MAX),
        5 => tiles.iter_mut().for_each(|tile| tile.depth = rng.random()),
        _ if tile.level < MAX_LEVEL => {
            let part = |i: u32| Tile {
                level: tile.level + 1,
                column: (2 * tile.column).wrapping_add(i % 2),
                row: (2 * tile.row).wrapping_add(i / 2),
                depth: any_up_to(u16::MAX.into(), rng) as u16,
            };
            let parts: Vec<Tile> = (0..4).map(part).collect();
            drop(tiles.splice(at..=at, parts));
        }
        _ => tiles[at].depth = 0,
    }
}

fn one_of(values: &[f32], rng: &mut ChaCha8Rng) -> f32 {
    values.choose(rng).copied().unwrap_or_default()
}

/// Talk that takes as much of what an agent has room for as others believe, by name.
pub fn worst(heard: &[Said]) -> Vec<(&'static str, Vec<Said>)> {
    let Some(last) = heard.last() else { return Vec::new() };
    let Some(&factor) = last.message.factors.last() else { return Vec::new() };
    let of = |factors: Vec<Factor>| {
        let message = Message { factors, ..Message::default() };
        vec![Said { message, ..last.clone() }]
    };
    let named = |source, incarnation, number| {
        let id =
            FactorId { source: AgentId(source), incarnation: Incarnation(incarnation), number };
        Factor { id, step: last.step, ..factor }
    };
    let twice = lives().flat_map(|life| [(life, 0), (life, 1)]);
    let own = twice.map(|(life, number)| named(0, life, number)).collect();
    let others = lives().map(|life| named(1, life, 0)).collect();
    vec![("own-lives", of(own)), ("many-lives", of(others))]
}

/// More incarnations than there is room for.
fn lives() -> std::ops::Range<u32> {
    0..MAX_INCARNATIONS as u32 + 2
}
