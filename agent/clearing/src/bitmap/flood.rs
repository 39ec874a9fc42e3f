//! Connected sets of pixels.

use super::Bitmap;

impl Bitmap {
    /// Conn(seeds, mask): the pixels of `mask` that are connected with a pixel of both by pixels of `mask`.
    ///
    /// Sweeps down and up until nothing changes; within a row, whole runs fill at once.
    pub fn flood(seeds: &Self, mask: &Self) -> Self {
        let mut filled = seeds.clone().and(mask);
        for row in 0..mask.rows {
            fill_row(filled.row_mut(row), mask.row(row));
        }
        let down = |row: &u16| (*row > 0).then(|| row - 1);
        let up = |row: &u16| (row + 1 < mask.rows).then_some(row + 1);
        let mut spread = vec![0; mask.stride];
        loop {
            let mut grew = false;
            for row in 0..mask.rows {
                grew |= filled.spread_from(down(&row), row, mask, &mut spread);
            }
            for row in (0..mask.rows).rev() {
                grew |= filled.spread_from(up(&row), row, mask, &mut spread);
            }
            if !grew {
                return filled;
            }
        }
    }

    /// Lets the set spread from one row into the next, and along it. Returns whether it grew.
    fn spread_from(&mut self, from: Option<u16>, to: u16, mask: &Self, spread: &mut [u64]) -> bool {
        let Some(from) = from else { return false };
        let source = self.row(from);
        let mut carry = 0;
        for (index, spread) in spread.iter_mut().enumerate() {
            let next = source.get(index + 1).copied().unwrap_or(0);
            let word = source[index];
            *spread = word | word << 1 | carry | word >> 1 | next << 63;
            carry = word >> 63;
        }
        let allowed = mask.row(to);
        let row = self.row_mut(to);
        let mut grew = false;
        for ((word, spread), allowed) in row.iter_mut().zip(spread.iter()).zip(allowed) {
            let new = spread & allowed & !*word;
            grew |= new != 0;
            *word |= new;
        }
        if grew {
            fill_row(row, allowed);
        }
        grew
    }

    /// The connected components, by their first pixels.
    pub fn components(&self) -> Vec<Self> {
        let mut left = self.clone();
        let mut components = Vec::new();
        while let Some([row, column]) = left.first() {
            let mut seed = Self::new(self.rows, self.columns);
            seed.set(row, column);
            let component = Self::flood(&seed, &left);
            left = left.and_not(&component);
            components.push(component);
        }
        components
    }
}

/// Fills the runs of `mask` in which the row has a pixel.
fn fill_row(row: &mut [u64], mask: &[u64]) {
    let mut carry = 0;
    for (word, mask) in row.iter_mut().zip(mask) {
        *word = fill_up(*word | carry & mask, *mask);
        carry = *word >> 63;
    }
    let mut carry = 0;
    for (word, mask) in row.iter_mut().zip(mask).rev() {
        let seeds = *word | (carry << 63) & mask;
        *word = fill_up(seeds.reverse_bits(), mask.reverse_bits()).reverse_bits();
        carry = *word & 1;
    }
}

/// Fills runs of `mask` from each seed towards higher bits, by doubling steps.
fn fill_up(seeds: u64, mut mask: u64) -> u64 {
    let mut filled = seeds;
    for by in [1, 2, 4, 8, 16, 32] {
        filled |= mask & (filled << by);
        mask &= mask << by;
    }
    filled
}
