//! What a cleaner knows of the road in its image, and nothing beyond it.
//!
//! Of the pixels in sight, `road` contains all that can be road. Each of them is in one of three sets: `mine`, which
//! this cleaner has cleared; `foreign`, which is known to be cleared as well; and `unknown`. The **frontier** is what
//! of `mine` has unknown road within [reach](Radii::reach).
//!
//! **Proposition.** Let 𝒱 be all cells of road that were ever in `mine` of some cleaner. If every frontier stays in
//! the image of its cleaner, no evader is ever in 𝒱 without being seen.
//!
//! *Proof.* By induction over steps. What grows into `mine` is in the image of the cleaner, so nobody hides there now.
//! An evader can enter 𝒱 between two steps only from a cell b outside 𝒱 into a cell a of 𝒱 beside it, both outside
//! all images. Some cleaner took a, with b within reach of it. Then b was unknown to it: the three sets are all
//! that can be road, and `mine` and `foreign` only hold cells of 𝒱. So a was in its frontier, and it stays there, in
//! the image, as long as b is unknown; b leaves `unknown` only when it belongs to 𝒱. ∎
//!
//! "Belongs to 𝒱" never becomes false. So what others say of it may come late, twice or never, in any order, and a
//! handover needs no handshake: who hears that the road beyond its frontier is cleared needs no frontier there.
//!
//! So nobody needs to remember that it has cleared a place which is no frontier: near the edge of the image, where the
//! frontier must not be, such places of `mine` become `foreign`. Beside `foreign` the unknown may be anything, for
//! another cleaner may guard just this place.
//!
//! A frontier that comes nearer to the edge than the [rim](Radii::rim) is not held any more, because unknown road
//! beside it may be out of sight. [`Masks::advance`] says so.

use csat_proto::frame::Label;

use crate::bitmap::{Bitmap, Rect};
use crate::config::{AgentConfig, Rules};
use crate::mutant::{Mutant, is_on};
use crate::radii::Radii;
use crate::registration::Moved;

/// The parts of an image, and by which rules its masks change.
#[derive(Debug, Clone)]
pub struct Sight {
    /// Rows, and columns, of the image.
    pub size: u16,
    /// The distances.
    pub radii: Radii,
    /// ΔM, pixels.
    pub margin: u16,
    /// See [`Rules`].
    pub rules: Rules,
    /// Where it is known what can be road.
    decided: Bitmap,
    /// The outermost pixels of it.
    edge: Bitmap,
    /// What is farther from the edge than the rim.
    held: Bitmap,
    /// Where frontiers are driven.
    driven: Bitmap,
    /// M: where cleared ground grows.
    grown: Bitmap,
}

impl Sight {
    /// That of an agent.
    pub fn new(config: &AgentConfig) -> Self {
        let (size, radii) = (config.camera.columns, config.radii());
        let margin =
            if is_on(Mutant::NoMargin) { radii.blind() } else { config.clearing.margin_px };
        let inside = |margin| Bitmap::inside(size, size, margin);
        Self {
            size,
            radii,
            margin,
            rules: config.clearing.rules,
            edge: inside(radii.blind()).and_not(&inside(radii.blind().saturating_add(1))),
            decided: inside(radii.blind()),
            driven: inside(config.clearing.guard_px),
            held: inside(if is_on(Mutant::NoMargin) { radii.blind() } else { radii.rim() }),
            grown: inside(margin),
        }
    }

    /// All pixels that can be road, as far as it is decided.
    pub fn road(&self, labels: &[Label]) -> Bitmap {
        let labelled = Bitmap::from_labels(self.size, self.size, labels, Label::Road);
        let radius = if is_on(Mutant::NoGaps) { 0 } else { self.radii.out };
        labelled.dilated(radius).and(&self.decided)
    }

    /// No pixels.
    pub fn nothing(&self) -> Bitmap {
        Bitmap::new(self.size, self.size)
    }
}

/// See the module.
#[derive(Debug, Clone)]
pub struct Masks {
    road: Bitmap,
    mine: Bitmap,
    foreign: Bitmap,
    unknown: Bitmap,
    frontier: Bitmap,
}

impl Masks {
    /// Nothing is cleared.
    pub fn new(sight: &Sight, road: Bitmap) -> Self {
        let nothing = sight.nothing();
        Self {
            unknown: road.clone(),
            mine: nothing.clone(),
            foreign: nothing.clone(),
            frontier: nothing,
            road,
        }
    }

    /// All that can be road.
    pub fn road(&self) -> &Bitmap {
        &self.road
    }

    /// What this agent has cleared.
    pub fn mine(&self) -> &Bitmap {
        &self.mine
    }

    /// What else is known to be cleared.
    pub fn foreign(&self) -> &Bitmap {
        &self.foreign
    }

    /// What may not be cleared.
    pub fn unknown(&self) -> &Bitmap {
        &self.unknown
    }

    /// What of [`Self::mine`] has unknown road within [reach](Radii::reach). With [`Rules::Paper`] less: what (9) keeps.
    pub fn frontier(&self) -> &Bitmap {
        &self.frontier
    }

    /// Takes the next image: `seen` is the road in it. Returns whether the frontier is still held.
    #[must_use]
    pub fn advance(&mut self, sight: &Sight, moved: Moved, seen: &Bitmap) -> bool {
        let shift = |mask: &Bitmap| mask.shifted(moved.by).and(&sight.decided);
        let entering = sight.decided.clone().and_not(&sight.decided.shifted(moved.by));
        let before = [&self.road, &self.mine, &self.foreign, &self.frontier].map(shift);
        let [road, mine, foreign, frontier] = before;
        let is_in_sight = frontier.count() == self.frontier.count();
        self.road = road.or(&entering).and(seen);
        self.mine = mine.and(&self.road);
        self.foreign = foreign.and(&self.road);
        self.frontier = frontier;
        if is_on(Mutant::EnteringCleared) {
            let cleared = self.mine.clone().or(&self.foreign).dilated(1);
            self.foreign = Bitmap::flood(&cleared, &entering.and(&self.road)).or(&self.foreign);
        }
        self.update_unknown();
        self.forget(sight);
        if moved.is_drifted {
            self.drift(sight, seen);
        }
        is_in_sight && self.frontier.clone().and_not(&sight.held).is_empty()
    }

    /// Near the edge, what is no frontier is no longer the own.
    fn forget(&mut self, sight: &Sight) {
        let outer = self.mine.clone().and_not(&sight.driven);
        if outer.is_empty() {
            return;
        }
        let left = outer.and_not(&self.unknown.dilated(sight.radii.reach));
        self.mine = self.mine.clone().and_not(&left);
        self.foreign = self.foreign.clone().or(&left);
    }

    fn update_unknown(&mut self) {
        self.unknown = self.road.clone().and_not(&self.mine).and_not(&self.foreign);
    }

    /// Takes the lattice up anew, a pixel from where it was, at most. What is within a pixel of `unknown`, or comes
    /// into sight, may be unknown. What is within a pixel of the frontier is declared to be cleared now: it is in the
    /// image. So frontier and unknown road keep their distance.
    fn drift(&mut self, sight: &Sight, seen: &Bitmap) {
        self.road = self.road.dilated(1).or(&sight.edge).and(seen);
        let near = self.mine.clone().and(&self.unknown.dilated(sight.radii.reach + 1));
        let moved = near.dilated(1).and(&self.road).and(&sight.held);
        self.mine = self.mine.clone().or(&moved);
        let unknown = self.unknown.dilated(1).or(&sight.edge);
        self.unknown = unknown.and(&self.road).and_not(&self.mine);
        self.foreign = self.road.clone().and_not(&self.mine).and_not(&self.unknown);
        self.frontier = self.frontier.dilated(1);
    }

    /// (8): the road within M that is connected with `seeds` is cleared from now on.
    pub fn begin(&mut self, sight: &Sight, seeds: &Bitmap) {
        let grown = self.unknown.clone().and(&sight.grown);
        self.mine = Bitmap::flood(seeds, &grown);
        self.update_unknown();
        self.frontier = self.boundary(sight);
    }

    /// The road within M that is connected with what is cleared is cleared from now on. Call after [`Self::advance`].
    pub fn grow(&mut self, sight: &Sight) {
        match sight.rules {
            Rules::Acknowledged => {
                let grown = self.unknown.clone().and(&sight.grown).or(&self.mine);
                self.mine = Bitmap::flood(&self.mine, &grown);
                self.update_unknown();
                self.frontier = self.boundary(sight);
            }
            Rules::Paper => self.grow_in_stripe(sight),
        }
    }

    /// (9): the frontier spreads within the stripe inside the border of the image, and is what of it is at the
    /// border then. What else borders on unknown road is forgotten.
    fn grow_in_stripe(&mut self, sight: &Sight) {
        let reach = sight.radii.reach;
        let stripe_px = sight.margin + 2 * reach + 2;
        let stripe =
            sight.grown.clone().and_not(&Bitmap::inside(sight.size, sight.size, stripe_px));
        let outside = self.frontier.clone().and_not(&sight.grown);
        let allowed = self.road.clone().and(&stripe).and_not(&self.foreign).or(&outside);
        let spread = Bitmap::flood(&self.frontier.dilated(reach), &allowed);
        self.mine = self.mine.clone().or(&spread.clone().and(&sight.grown));
        self.update_unknown();
        let border = Bitmap::inside(sight.size, sight.size, sight.margin + reach);
        self.frontier = self.boundary(sight).and(&spread).and_not(&border);
    }

    fn boundary(&self, sight: &Sight) -> Bitmap {
        let around = if is_on(Mutant::FourNeighbours) {
            let beside = [[1, 0], [-1, 0], [0, 1], [0, -1]].map(|by| self.unknown.shifted(by));
            beside.iter().fold(self.unknown.clone(), Bitmap::or)
        } else {
            self.unknown.dilated(sight.radii.reach)
        };
        self.mine.clone().and(&around)
    }

    /// What road in sight is cleared for all that this agent knows: no pixel within ρ can be unknown road. Ground
    /// that is no road counts as cleared.
    pub fn safe(&self, sight: &Sight) -> Bitmap {
        let rho = if is_on(Mutant::NoRho) { 0 } else { sight.radii.rho };
        let inside = Bitmap::inside(sight.size, sight.size, sight.radii.blind() + rho);
        inside.and_not(&self.unknown.dilated(rho))
    }

    /// Another agent knows these pixels to be cleared. Returns how many pixels of the frontier are given up.
    pub fn learn(&mut self, sight: &Sight, safe: &Bitmap) -> u32 {
        let news = self.unknown.clone().and(safe);
        if news.is_empty() {
            return 0;
        }
        let before = self.frontier.count();
        self.foreign = self.foreign.clone().or(&news);
        self.unknown = self.unknown.clone().and_not(&news);
        self.frontier = self.frontier.clone().and(&self.boundary(sight));
        before - self.frontier.count()
    }

    /// What this agent claims to have cleared, in the image of the present frame: wherever a cell of road touches
    /// such a pixel, its middle is in `mine` or `foreign`.
    pub fn claims(&self, sight: &Sight) -> Bitmap {
        let radius = sight.radii.claim;
        let inside = Bitmap::inside(sight.size, sight.size, sight.radii.blind() + radius);
        self.mine.clone().and(&inside).and_not(&self.unknown.dilated(radius))
    }

    /// The unknown road within M and these pixels: where an agent that is asked to takes up a frontier.
    pub fn seeds(&self, sight: &Sight, rect: &Rect) -> Bitmap {
        let mut seeds = sight.nothing();
        seeds.fill(rect);
        seeds.and(&self.unknown).and(&sight.grown)
    }
}

#[cfg(test)]
mod tests;
