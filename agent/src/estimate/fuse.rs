//! Fusion of what others knew (4.34)-(4.37), over links that delay, lose, repeat and reorder.
//!
//! Intersections and unions commute and repeat for free, so the order of snapshots and repeats do not
//! matter to what the sets are; to their last bits it does. A set that equals the own one as it was
//! before anything was merged is passed over: with perfect links a snapshot changes nothing that the
//! facts had not changed already, and whoever told a snapshot, and so does not hear it, ends with the
//! same bits as those who heard it and had known as much.

use std::collections::BTreeMap;

use csat_proto::ids::TargetId;
use csat_proto::message::Known;
use csat_proto::region::{Region, Shape};

use super::evidence::{Ager, Evidence};
use super::state::Knowledge;
use crate::mutant::{Mutant, is_on};
use crate::region::{Inner, Outer};

/// Merges the outer sets that others knew, each at its own step, into those known now.
pub(super) fn fuse<'a>(
    knowledge: &mut Knowledge,
    known: impl Iterator<Item = &'a Known>,
    ager: &Ager,
) {
    let mut known = known.peekable();
    if known.peek().is_some() {
        let before = knowledge.clone();
        known.for_each(|known| merge(knowledge, &before, known, ager));
    }
}

/// Merges what one of them knew into what has become of `before`.
///
/// X̄ of the other is only taken together with its L and X_j: a target it knows of is not in its X̄.
fn merge(knowledge: &mut Knowledge, before: &Knowledge, known: &Known, ager: &Ager) {
    let reach = match is_on(Mutant::LateSnapshotNotDilated) {
        true => None,
        false => {
            let mistake = Mutant::ClockSkewOfSnapshotsIgnored;
            ager.reach_unless(mistake, knowledge.step, known.step)
        }
    };
    let meet = |own: &Outer, before: &Outer, their: &Region| {
        if reach.is_none() && before.region() == their {
            return own.clone();
        }
        own.intersection(&ager.dilated(their.clone(), reach.as_ref()))
    };
    let theirs: BTreeMap<TargetId, &Region> = match is_on(Mutant::UnexploredWithoutIdentified) {
        true => BTreeMap::new(),
        false => known.targets.iter().map(|(j, set)| (*j, set)).collect(),
    };
    let mut merged = BTreeMap::new();
    for &j in knowledge.targets.keys().chain(theirs.keys()) {
        let their_set = theirs.get(&j).copied().unwrap_or(&known.unexplored);
        let (own, before) = (knowledge.set_of(j), before.set_of(j));
        merged.entry(j).or_insert_with(|| meet(own, before, their_set));
    }
    knowledge.unexplored = meet(&knowledge.unexplored, &before.unexplored, &known.unexplored);
    knowledge.targets = merged;
}

/// What others know of X° that is not known to the last bit already.
pub(super) fn margin_news(knowledge: &Knowledge, known: &Known) -> Evidence {
    let obstacle_margin = news(&known.obstacle_margin, knowledge.margin.region());
    Evidence { clear_ground: Inner::default(), obstacle_margin, targets: Vec::new() }
}

/// The shapes of `theirs` that are not among `own`.
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
