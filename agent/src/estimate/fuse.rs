//! Fusion with the knowledge of other agents (4.34)-(4.37), over links that delay, lose, repeat and
//! reorder.
//!
//! Intersections and unions are commutative and idempotent, so the order and the repeats of snapshots
//! do not matter to the sets, except to their last bits. A received set that equals the own set
//! before the merge is skipped. With perfect links a snapshot changes nothing that the facts had not
//! changed already, so the sender of a snapshot, which does not receive it, has the same bits as the
//! receivers.

use std::collections::BTreeMap;

use csat_proto::ids::TargetId;
use csat_proto::message::Known;
use csat_proto::region::{Region, Shape};

use super::evidence::{Ager, Evidence};
use super::sets::Sets;
use crate::mutant::{Mutant, is_on};
use crate::region::{Inner, Memo, Outer};

/// Merges the outer approximations of other agents, each of its own step, into the sets.
pub(super) fn fuse<'a>(
    sets: &mut Sets,
    known: impl Iterator<Item = &'a Known>,
    ager: &Ager,
    memo: &Memo,
) {
    let mut known = known.peekable();
    if known.peek().is_some() {
        let before = sets.clone();
        known.for_each(|known| merge(sets, &before, known, ager, memo));
    }
}

/// Merges the knowledge of another agent into `sets`, which was `before` before the first merge.
///
/// X̄ of the other agent is used only together with its L and X_j: its X̄ need not contain a target
/// that it has identified.
fn merge(sets: &mut Sets, before: &Sets, known: &Known, ager: &Ager, memo: &Memo) {
    let reach = match is_on(Mutant::LateSnapshotNotDilated) {
        true => None,
        false => {
            let mistake = Mutant::ClockSkewOfSnapshotsIgnored;
            ager.reach_unless(mistake, sets.step, known.step)
        }
    };
    let meet = |own: &Outer, before: &Outer, their: &Region| {
        if reach.is_none() && before.region() == their {
            return own.clone();
        }
        own.intersection_by(&ager.dilated(their.clone(), reach.as_ref()), memo)
    };
    let theirs: BTreeMap<TargetId, &Region> = match is_on(Mutant::UnexploredWithoutIdentified) {
        true => BTreeMap::new(),
        false => known.targets.iter().map(|(j, set)| (*j, set)).collect(),
    };
    let mut merged = BTreeMap::new();
    for &j in sets.targets.keys().chain(theirs.keys()) {
        let their_set = theirs.get(&j).copied().unwrap_or(&known.unexplored);
        let (own, before) = (sets.set_of(j), before.set_of(j));
        merged.entry(j).or_insert_with(|| meet(own, before, their_set));
    }
    sets.unexplored = meet(&sets.unexplored, &before.unexplored, &known.unexplored);
    sets.targets = merged;
}

/// The shapes of the X° of another agent that are not known bit by bit already.
pub(super) fn margin_news(sets: &Sets, known: &Known) -> Evidence {
    let obstacle_margin = news(&known.obstacle_margin, sets.margin.region());
    Evidence { clear_ground: Inner::default(), obstacle_margin, targets: Vec::new() }
}

/// The shapes of `theirs` that are not in `own`.
fn news(theirs: &Region, own: &Region) -> Inner {
    let mut sorted: Vec<&Shape> = own.shapes().iter().collect();
    let key = |shape: &&Shape| (shape[0].len(), shape[0].first().map(|p| (p.x, p.y)));
    sorted.sort_by_key(key);
    let is_new = |shape: &&Shape| {
        let start = sorted.partition_point(|own| key(own) < key(shape));
        !sorted[start..].iter().take_while(|own| key(own) == key(shape)).any(|own| own == shape)
    };
    Inner::within(Region::from_shapes(theirs.shapes().iter().filter(is_new).cloned().collect()))
}
