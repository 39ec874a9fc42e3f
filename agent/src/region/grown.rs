//! Dilated outer approximations that are resolved together with the sets subtracted from them:
//! prediction and correction in one Boolean operation.

use std::sync::Arc;

use csat_proto::region::{GridBox, GridPoint, MAX_COORDINATE_M, Region, Ring, Shape, to_units};

use super::cells::{difference, paths};
use super::relaxed::is_box_around;
use super::simplify::{Approximation, simplified_rings};
use super::sweep::dilated_path;
use super::{Inner, Memo, Outer, Reach};

/// A dilated outer set whose raw paths are not resolved yet: X_{k|k-1} (4.24)-(4.26).
///
/// Resolving them takes as long as subtracting parts, so [`Self::minus`] does both at once. The paths
/// are filled where their winding number is positive. Simplified rings need not be resolved before
/// they are dilated: an outer simplification only adds to winding numbers of 0 and 1, so none is
/// negative, a border of the filled set runs along an edge with 0 on its right, and the sweep of that
/// edge adds the missing 1. Where two borders cross, the filled set has a reflex corner, which needs
/// no fan.
#[derive(Debug, Clone)]
pub struct Grown {
    paths: Vec<Ring>,
    bounds: Region,
    memo: Arc<Memo>,
}

impl Grown {
    /// `set` as it is, within `bounds`.
    pub fn still(set: &Outer, bounds: &Region, memo: &Arc<Memo>) -> Self {
        let paths = set.region().rings().cloned().collect();
        Self { paths, bounds: bounds.clone(), memo: Arc::clone(memo) }
    }

    /// A superset of (`set` ⊕ `reach`) ∩ `bounds`, after a simplification by at most `tolerance_m`. A
    /// long reach is swept in stages, of which the last one is not resolved yet.
    pub fn new(
        set: &Outer,
        tolerance_m: f64,
        reach: &Reach,
        bounds: &Region,
        memo: &Arc<Memo>,
    ) -> Self {
        let Some((set, last)) = set.before_last_stage(reach) else {
            return Self::still(&Outer::containing(bounds.clone()), bounds, memo);
        };
        let tolerance_m =
            if reach.is_short() { tolerance_m } else { tolerance_m.max(last.tolerance_m) };
        let simplified = |shape: &Shape| match reach.is_short() {
            true => simplified_rings(shape, Approximation::Outer, tolerance_m),
            false => simplified_rings(last.swept_rings(shape), Approximation::Outer, tolerance_m),
        };
        let rings = set.region().shapes().iter().flat_map(simplified);
        let paths = rings.map(|ring| dilated_path(&ring, &last.disc)).collect();
        Self { paths, bounds: bounds.clone(), memo: Arc::clone(memo) }
    }

    /// The set itself.
    pub fn resolved(&self) -> Outer {
        self.minus([])
    }

    /// The set minus the union of `parts`.
    pub fn minus<'a>(&self, parts: impl IntoIterator<Item = &'a Inner>) -> Outer {
        let outside = match GridBox::around(self.paths.iter().flatten()) {
            Some(extent) if !is_box_around(&self.bounds, &extent) => outside(&self.bounds),
            _ => Vec::new(),
        };
        let parts = parts.into_iter().map(|part| paths(part.region().rings()));
        let parts = std::iter::once(paths(&outside)).chain(parts).collect();
        Outer::containing(difference(paths(&self.paths), parts, Some(&self.memo)))
    }
}

/// The rings of everything outside `bounds`.
fn outside(bounds: &Region) -> Vec<Ring> {
    let far = to_units(MAX_COORDINATE_M);
    let corners = [(-far, -far), (far, -far), (far, far), (-far, far)];
    let everything = corners.iter().map(|&(x, y)| GridPoint::new(x, y)).collect();
    let reversed = |ring: &Ring| ring.iter().rev().copied().collect();
    std::iter::once(everything).chain(bounds.rings().map(reversed)).collect()
}
