//! What the fleet saw, and what was hidden to it, in the last steps.

use std::collections::VecDeque;
use std::sync::Arc;

use csat_proto::raster::{Grid, Raster};
use csat_proto::time::Step;

/// The views of the last steps, each of all agents of which something was heard.
#[derive(Debug, Clone, Default)]
pub(super) struct Views {
    recent: VecDeque<Arc<FleetView>>,
    /// Views of earlier steps were dropped.
    from: Step,
}

/// The ground that was hidden to the fleet and the ground that it saw, at one step. Copies of knowledge
/// share it until one of them changes it.
#[derive(Debug, Clone)]
struct FleetView {
    step: Step,
    hidden: SparseRaster,
    seen: SparseRaster,
}

impl Views {
    /// Notes the ground that was hidden to an agent and the ground that it saw at `step`, and changes
    /// `known`, X^h, by it (5.43), (5.44).
    ///
    /// Ground becomes hidden unless an agent saw it at that step or later. Views may arrive late, in
    /// any order and more than once. A view of a step whose views were dropped is skipped, because it
    /// is not known any more whether its ground was seen since.
    pub(super) fn note(&mut self, known: &mut Raster, step: Step, hidden: &Raster, seen: &Raster) {
        if step < self.from {
            return;
        }
        // A frame shows little of a large town.
        let (hidden, seen) = (hidden.words(), seen.words());
        let is_used = |&word: &usize| hidden[word] | seen[word] != 0;
        let used: Vec<usize> = (0..hidden.len()).filter(is_used).collect();
        let view = Arc::make_mut(self.at(step, known.grid()));
        for &word in &used {
            view.hidden.add(word, hidden[word]);
            view.seen.add(word, seen[word]);
        }
        let since: Vec<&FleetView> =
            self.recent.iter().map(Arc::as_ref).filter(|view| view.step >= step).collect();
        for word in used {
            let (mut newly_hidden, mut newly_seen) = (hidden[word], seen[word]);
            for view in &since {
                newly_hidden &= !view.seen.word(word);
                // Ground seen at `step` is no longer hidden, except where a later view hid it again.
                if view.step > step {
                    newly_seen &= !view.hidden.word(word);
                }
            }
            let known = &mut known.words_mut()[word];
            *known = *known & !newly_seen | newly_hidden;
        }
    }

    /// The view of a step, empty at first.
    fn at(&mut self, step: Step, grid: &Grid) -> &mut Arc<FleetView> {
        let index = self.recent.iter().position(|view| view.step == step).unwrap_or_else(|| {
            let empty = SparseRaster::empty(grid);
            let view = FleetView { step, hidden: empty.clone(), seen: empty };
            self.recent.push_back(Arc::new(view));
            self.recent.len() - 1
        });
        &mut self.recent[index]
    }

    /// Drops views before `oldest`.
    pub(super) fn forget_before(&mut self, oldest: Step) {
        self.recent.retain(|view| view.step >= oldest);
        self.from = oldest;
    }

    /// The union of the ground that was hidden to an agent in these steps (5.30).
    pub(super) fn hidden(&self, grid: Grid) -> Raster {
        let mut union = Raster::empty(grid);
        for view in &self.recent {
            view.hidden.add_to(&mut union);
        }
        union
    }
}

/// Rows and columns of a tile, cells: one word in each row.
const TILE: usize = 64;

/// A raster of which most tiles are empty and take no memory.
#[derive(Debug, Clone)]
struct SparseRaster {
    words_per_row: usize,
    /// Row by row.
    tiles: Vec<Option<Box<[u64; TILE]>>>,
}

impl SparseRaster {
    fn empty(grid: &Grid) -> Self {
        let words_per_row = (grid.columns as usize).div_ceil(TILE);
        let tiles = vec![None; words_per_row * (grid.rows as usize).div_ceil(TILE)];
        Self { words_per_row, tiles }
    }

    /// The tile of a word of [`Raster::words`], and its row there.
    fn place(&self, word: usize) -> (usize, usize) {
        let (row, column) = (word / self.words_per_row, word % self.words_per_row);
        (row / TILE * self.words_per_row + column, row % TILE)
    }

    fn word(&self, word: usize) -> u64 {
        let (tile, row) = self.place(word);
        self.tiles[tile].as_ref().map_or(0, |words| words[row])
    }

    fn add(&mut self, word: usize, bits: u64) {
        if bits != 0 {
            let (tile, row) = self.place(word);
            self.tiles[tile].get_or_insert_with(|| Box::new([0; TILE]))[row] |= bits;
        }
    }

    fn add_to(&self, raster: &mut Raster) {
        for (tile, words) in self.tiles.iter().enumerate() {
            let (first, column) = (tile / self.words_per_row * TILE, tile % self.words_per_row);
            for (row, bits) in (first..).zip(words.iter().flat_map(|words| words.iter())) {
                if *bits != 0 {
                    raster.row_mut(row as u32)[column] |= bits;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use csat_proto::model::Ground;

    use super::*;

    /// A view may arrive when it is not known any more what was seen since.
    #[test]
    fn ground_seen_since_is_not_hidden_by_a_view_that_comes_late() {
        let grid = Grid::covering(&Ground { size_m: [500.0; 2] }, 2.0);
        let nothing = Raster::empty(grid);
        let mut cell = nothing.clone();
        cell.set(3, 4);
        for window in [6, 12] {
            let (mut views, mut known) = (Views::default(), nothing.clone());
            views.note(&mut known, Step(10), &nothing, &cell);
            views.forget_before(Step(20 - window));
            views.note(&mut known, Step(9), &cell, &nothing);
            assert!(!known.get(3, 4), "the last {window} steps are remembered");
            views.note(&mut known, Step(15), &cell, &nothing);
            assert!(known.get(3, 4));
        }
    }

    /// Cells in corners of tiles, also of tiles that the border cuts.
    #[test]
    fn what_is_hidden_is_the_union_of_all_views() {
        let grid = Grid::covering(&Ground { size_m: [390.0, 270.0] }, 2.0);
        let nothing = Raster::empty(grid);
        let (mut views, mut known) = (Views::default(), nothing.clone());
        let mut expected = nothing.clone();
        let cells = [(0, 0), (63, 63), (64, 64), (127, 0), (128, 134), (194, 134), (194, 0)];
        for (step, (column, row)) in (0..).zip(cells) {
            let mut hidden = nothing.clone();
            hidden.set(column, row);
            expected.set(column, row);
            views.note(&mut known, Step(step / 2), &hidden, &nothing);
        }
        assert_eq!(views.hidden(grid), expected);
        assert_eq!(known, expected);
        views.forget_before(Step(3));
        assert_eq!(views.hidden(grid).iter().collect::<Vec<_>>(), [(194, 0)]);
        let mut seen = nothing.clone();
        seen.set(194, 134);
        views.note(&mut known, Step(4), &nothing, &seen);
        assert!(!known.get(194, 134));
        views.note(&mut known, Step(3), &expected, &nothing);
        assert!(!known.get(194, 134), "it was seen since");
    }
}
