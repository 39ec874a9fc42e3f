//! False messages that decode: valid facts and snapshots with changed values.

use std::ops::Range;

use csat_proto::ids::{AgentId, Incarnation, TargetId};
use csat_proto::message::{Fact, HeldFacts, Snapshot};
use csat_proto::oem::{OemCell, OemDelta, OemPatch};
use csat_proto::region::{GridPoint, Region, Ring, Shape};
use csat_proto::time::Step;
use rand::seq::{IndexedMutRandom, IndexedRandom};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A changed body of a fact; `None` if `bytes` are not a fact.
pub fn fact(bytes: &[u8], seed: u64) -> Option<Vec<u8>> {
    changed(bytes, seed, 1..4, spoil_fact)
}

/// A changed body of a snapshot; `None` if `bytes` are not a snapshot.
pub fn snapshot(bytes: &[u8], seed: u64) -> Option<Vec<u8>> {
    changed(bytes, seed, 1..4, spoil_snapshot)
}

/// A body that is read, changed so many `times`, and written again; `None` if `bytes` are no such body.
pub fn changed<T: Serialize + DeserializeOwned>(
    bytes: &[u8],
    seed: u64,
    times: Range<u32>,
    change: fn(&mut T, &mut ChaCha8Rng),
) -> Option<Vec<u8>> {
    let mut body = postcard::from_bytes(bytes).ok()?;
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for _ in 0..rng.random_range(times) {
        change(&mut body, &mut rng);
    }
    postcard::to_stdvec(&body).ok()
}

fn spoil_snapshot(snapshot: &mut Snapshot, rng: &mut ChaCha8Rng) {
    let Snapshot { fact, known } = snapshot;
    match rng.random_range(0..10) {
        0..4 => spoil_fact(fact, rng),
        4 => known.step = Step(any_up_to(fact.step.0, rng)),
        5 => {
            let j = TargetId(rng.random_range(0..12));
            let other = known.targets.choose(rng).map_or(&known.unexplored, |(_, set)| set);
            let other = (j, other.clone());
            known.targets.retain(|(i, _)| *i != j);
            if rng.random_bool(0.7) {
                known.targets.push(other);
            }
            known.targets.sort_by_key(|(i, _)| *i);
        }
        6 => std::mem::swap(&mut known.unexplored, &mut known.obstacle_margin),
        _ => {
            let sets = known.targets.iter_mut().map(|(_, set)| set);
            let mut sets: Vec<&mut Region> =
                sets.chain([&mut known.unexplored, &mut known.obstacle_margin]).collect();
            spoil_region(sets.choose_mut(rng).expect("some"), rng);
        }
    }
}

fn spoil_fact(fact: &mut Fact, rng: &mut ChaCha8Rng) {
    match rng.random_range(0..20) {
        0 => fact.step = Step(any_up_to(fact.step.0 + 1, rng)),
        1 => fact.number = any_up_to(u32::MAX, rng),
        2 => {
            let incarnation = Incarnation(any_up_to(u32::MAX, rng));
            let (origin, count) = (AgentId(rng.random_range(0..3)), any_up_to(u32::MAX, rng));
            fact.held.facts.push(HeldFacts { origin, incarnation, count });
            fact.held.facts.sort();
        }
        3 => fact.held.facts.iter_mut().for_each(|f| f.count = any_up_to(u32::MAX, rng)),
        4 => fact.held.oem.iter_mut().for_each(|hash| *hash ^= rng.random::<u16>()),
        5 => {
            let first = rng.random_range(0..500);
            let height_dm = rng.random();
            let state = *[OemCell::Unexplored, OemCell::Occupied { height_dm }, OemCell::Empty]
                .choose(rng)
                .expect("some");
            let cells = first..first + rng.random_range(0..100);
            fact.oem = OemPatch::of(cells.map(|cell| OemDelta { cell, state }));
        }
        6 => std::mem::swap(&mut fact.hidden, &mut fact.seen),
        7 | 8 => {
            let target = TargetId(rng.random_range(0..12));
            if let Some(mut seen) = fact.targets.choose(rng).cloned() {
                seen.target = target;
                fact.targets.retain(|t| t.target != target);
                fact.targets.push(seen);
                fact.targets.sort_by_key(|t| t.target);
            }
        }
        9 => std::mem::swap(&mut fact.clear_ground, &mut fact.obstacle_margin),
        _ => {
            let sets = fact.targets.iter_mut().flat_map(|t| [&mut t.location, &mut t.exclusion]);
            let mut sets: Vec<&mut Region> =
                sets.chain([&mut fact.clear_ground, &mut fact.obstacle_margin]).collect();
            spoil_region(sets.choose_mut(rng).expect("some"), rng);
        }
    }
}

/// Small, middling and large numbers, all likely.
pub(super) fn any_up_to(max: u32, rng: &mut ChaCha8Rng) -> u32 {
    let some = rng.random::<u32>() >> rng.random_range(0..32);
    if rng.random_bool(0.2) { max - some.min(max) } else { some.min(max) }
}

fn spoil_region(region: &mut Region, rng: &mut ChaCha8Rng) {
    let mut shapes = std::mem::take(region).into_shapes();
    match rng.random_range(0..12) {
        0 => {
            shapes.pop();
        }
        1 => shapes.push(vec![star(rng)]),
        2 => {
            if let Some(mut copy) = shapes.choose(rng).cloned() {
                let by = offset(rng);
                copy.iter_mut().flatten().for_each(|p| *p = moved(*p, by));
                shapes.push(copy);
            }
        }
        3 => {
            // A part of the shape itself, as a hole or beside it, with common corners.
            if let Some(shape) = shapes.choose_mut(rng) {
                let ring = &shape[0];
                let corners: Ring = ring.iter().copied().filter(|_| rng.random_bool(0.5)).collect();
                if corners.len() >= 3 {
                    shape.push(corners.into_iter().rev().collect());
                }
            }
        }
        4 => {
            if let Some(ring) = some_ring(&mut shapes, rng) {
                ring.reverse();
            }
        }
        5 => {
            if let Some(shape) = shapes.choose_mut(rng).filter(|shape| shape.len() > 1) {
                let hole = shape.pop().expect("a hole");
                shapes.push(vec![hole.into_iter().rev().collect()]);
            }
        }
        _ => {
            if let Some(ring) = some_ring(&mut shapes, rng) {
                spoil_ring(ring, rng);
            }
        }
    }
    *region = Region::from_shapes(shapes);
}

fn some_ring<'a>(shapes: &'a mut [Shape], rng: &mut ChaCha8Rng) -> Option<&'a mut Ring> {
    shapes.choose_mut(rng)?.choose_mut(rng)
}

fn spoil_ring(ring: &mut Ring, rng: &mut ChaCha8Rng) {
    let at = rng.random_range(0..ring.len());
    let (here, other) = (ring[at], ring[rng.random_range(0..ring.len())]);
    match rng.random_range(0..6) {
        0 => ring[at] = moved(here, offset(rng)),
        1 => ring.insert(at, here),
        2 => ring[at] = other,
        3 => {
            // A spike without width.
            ring.insert(at, moved(here, offset(rng)));
            ring.insert(at, here);
        }
        4 if ring.len() > 3 => {
            ring.remove(at);
        }
        _ => {
            let next = ring[(at + 1) % ring.len()];
            let middle = GridPoint::new(here.x.midpoint(next.x), here.y.midpoint(next.y));
            ring.insert(at + 1, moved(middle, [rng.random_range(-1..2), rng.random_range(-1..2)]));
        }
    }
}

/// A star of any size and number of corners.
fn star(rng: &mut ChaCha8Rng) -> Ring {
    let corners = 3 + any_up_to(300, rng);
    let reach = 1.0 + f64::from(any_up_to(1 << 24, rng));
    let centre =
        GridPoint::new(rng.random_range(-1 << 24..1 << 24), rng.random_range(-1 << 24..1 << 24));
    let depth = rng.random_range(0.0..1.0);
    let corner = |i| {
        let angle = f64::from(i) / f64::from(corners) * std::f64::consts::TAU;
        let radius = reach * if i % 2 == 0 { 1.0 } else { depth };
        moved(centre, [(radius * angle.cos()) as i32, (radius * angle.sin()) as i32])
    };
    (0..corners).map(corner).collect()
}

fn offset(rng: &mut ChaCha8Rng) -> [i32; 2] {
    [0; 2].map(|_| {
        let far = any_up_to(1 << 26, rng) as i32;
        if rng.random_bool(0.5) { far } else { -far }
    })
}

fn moved(p: GridPoint, by: [i32; 2]) -> GridPoint {
    GridPoint::new(p.x.saturating_add(by[0]), p.y.saturating_add(by[1]))
}
