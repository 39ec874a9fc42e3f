//! Bitmaps: sets of the cells of a raster.

use rand::{Rng, RngExt};

/// A set of cells, row by row; a row begins with a new word.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Bits {
    columns: usize,
    rows: usize,
    /// Words per row.
    stride: usize,
    words: Vec<u64>,
}

impl Bits {
    /// The empty set.
    pub fn empty(columns: usize, rows: usize) -> Self {
        let stride = columns.div_ceil(64);
        Self { columns, rows, stride, words: vec![0; stride * rows] }
    }

    /// The set of all cells.
    pub fn full(columns: usize, rows: usize) -> Self {
        let mut all = Self::empty(columns, rows);
        all.words.fill(u64::MAX);
        all.trim();
        all
    }

    /// Number of columns.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The words of a row: cell c is bit c % 64 of word c / 64.
    pub fn row(&self, row: usize) -> &[u64] {
        &self.words[row * self.stride..(row + 1) * self.stride]
    }

    /// The words of a row. Bits beyond the last column have to stay 0.
    pub fn row_mut(&mut self, row: usize) -> &mut [u64] {
        &mut self.words[row * self.stride..(row + 1) * self.stride]
    }

    /// Whether a cell is in the set.
    pub fn contains(&self, column: usize, row: usize) -> bool {
        self.words[row * self.stride + column / 64] >> (column % 64) & 1 == 1
    }

    /// Adds a cell; returns whether it is new.
    pub fn insert(&mut self, column: usize, row: usize) -> bool {
        let word = &mut self.words[row * self.stride + column / 64];
        let bit = 1 << (column % 64);
        let is_new = *word & bit == 0;
        *word |= bit;
        is_new
    }

    /// Adds (or removes) the cells of a row from the first column up to but without the end.
    pub fn set_span(&mut self, row: usize, [first, end]: [usize; 2], value: bool) {
        let words = first / 64..end.div_ceil(64).max(first / 64);
        for (index, word) in words.clone().zip(&mut self.row_mut(row)[words]) {
            let mask = span_mask(index, first, end);
            *word = if value { *word | mask } else { *word & !mask };
        }
    }

    /// Number of cells.
    pub fn count(&self) -> usize {
        self.words.iter().map(|word| word.count_ones() as usize).sum()
    }

    /// Number of cells in both sets, which are of the same raster.
    pub fn count_common(&self, other: &Self) -> usize {
        let pairs = self.words.iter().zip(&other.words);
        pairs.map(|(a, b)| (a & b).count_ones() as usize).sum()
    }

    /// The cells, column and row, by increasing row and then column.
    pub fn cells(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        (0..self.rows).flat_map(|row| {
            let words = self.row(row).iter().enumerate();
            words.flat_map(move |(index, &word)| ones(word).map(move |bit| [64 * index + bit, row]))
        })
    }

    /// Applies an operation word by word.
    pub fn combine(&mut self, other: &Self, operation: impl Fn(u64, u64) -> u64) {
        for (word, other) in self.words.iter_mut().zip(&other.words) {
            *word = operation(*word, *other);
        }
    }

    /// The cells of this set that are not in the other one.
    pub fn without(mut self, other: &Self) -> Self {
        self.combine(other, |a, b| a & !b);
        self
    }

    /// The cells of either set.
    pub fn or(mut self, other: &Self) -> Self {
        self.combine(other, |a, b| a | b);
        self
    }

    /// The cells within Chebyshev distance `radius` of the set.
    pub fn dilated(&self, radius: usize) -> Self {
        self.smeared([radius, radius])
    }

    /// The cells of which no cell of the raster within Chebyshev distance 1 is outside the set.
    pub fn eroded(&self) -> Self {
        let outside = Self::full(self.columns, self.rows).without(self);
        Self::full(self.columns, self.rows).without(&outside.dilated(1))
    }

    /// Each cell becomes a square: `back` cells towards column 0 and row 0, `on` in the other directions.
    pub fn smeared(&self, [back, on]: [usize; 2]) -> Self {
        let mut wide = self.clone();
        for row in 0..self.rows {
            smear_row(wide.row_mut(row), [back, on]);
        }
        wide.trim();
        let mut square = wide.clone();
        for row in 0..self.rows {
            let from = row.saturating_sub(on)..(row + back + 1).min(self.rows);
            for source in from.filter(|source| *source != row) {
                for (word, other) in square.row_mut(row).iter_mut().zip(wide.row(source)) {
                    *word |= other;
                }
            }
        }
        square
    }

    /// Keeps each cell with probability `share`, 0..1. The distances between cells that stay are drawn, so that
    /// the cost is proportional to their number.
    pub fn thin(mut self, share: f64, rng: &mut impl Rng) -> Self {
        let log_miss = (-share).ln_1p();
        let mut skip = geometric(log_miss, rng);
        for word in &mut self.words {
            let (mut rest, mut kept) = (*word, 0);
            while skip < u64::from(rest.count_ones()) {
                (0..skip).for_each(|_| rest &= rest - 1);
                kept |= rest & rest.wrapping_neg();
                rest &= rest - 1;
                skip = geometric(log_miss, rng);
            }
            skip -= u64::from(rest.count_ones());
            *word = kept;
        }
        self
    }

    /// Empties the bits beyond the last column.
    fn trim(&mut self) {
        let mask = span_mask(self.columns / 64, 0, self.columns);
        if !self.columns.is_multiple_of(64) {
            self.words.chunks_exact_mut(self.stride).for_each(|row| row[self.stride - 1] &= mask);
        }
    }
}

/// The positions of the ones of a word.
pub(crate) fn ones(mut word: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let bit = (word != 0).then(|| word.trailing_zeros() as usize)?;
        word &= word - 1;
        Some(bit)
    })
}

/// The runs of ones of a word: first and end.
pub(crate) fn runs(mut word: u64) -> impl Iterator<Item = [usize; 2]> {
    std::iter::from_fn(move || {
        let first = (word != 0).then(|| word.trailing_zeros() as usize)?;
        let end = first + (word >> first).trailing_ones() as usize;
        word &= !span_mask(0, first, end);
        Some([first, end])
    })
}

/// The bits of word `index` of a row that are columns from `first` up to but without `end`.
fn span_mask(index: usize, first: usize, end: usize) -> u64 {
    let below = |column: usize| match column.saturating_sub(64 * index) {
        count @ 0..64 => (1 << count) - 1,
        _ => u64::MAX,
    };
    below(end) & !below(first)
}

/// Widens the ones of a row to both sides.
fn smear_row(row: &mut [u64], [back, on]: [usize; 2]) {
    for _ in 0..on {
        let mut carry = 0;
        for word in row.iter_mut() {
            let next = *word >> 63;
            *word |= *word << 1 | carry;
            carry = next;
        }
    }
    // Widened by `on` already, ones go on towards column 0.
    for _ in 0..back {
        let mut carry = 0;
        for word in row.iter_mut().rev() {
            let next = *word << 63;
            *word |= *word >> 1 | carry;
            carry = next;
        }
    }
}

/// The number of failures before the first success of trials, by the logarithm of the probability that one fails.
fn geometric(log_miss: f64, rng: &mut impl Rng) -> u64 {
    // In (0, 1]. If trials never fail, the quotient is 0.
    let u = 1.0 - rng.random::<f64>();
    if log_miss < 0.0 { (u.ln() / log_miss) as u64 } else { u64::MAX }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    fn set(columns: usize, rows: usize, cells: &[(usize, usize)]) -> Bits {
        let mut bits = Bits::empty(columns, rows);
        for &(column, row) in cells {
            bits.insert(column % columns, row % rows);
        }
        bits
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn sets_are_what_their_definitions_say(
            columns in 1..140usize, rows in 1..12usize, back in 0..4usize, on in 0..4usize,
            cells in prop::collection::vec((0..140usize, 0..12usize), 0..60),
        ) {
            let bits = set(columns, rows, &cells);
            prop_assert_eq!(bits.cells().count(), bits.count());
            prop_assert!(bits.cells().all(|[c, r]| bits.contains(c, r)));
            let square = bits.smeared([back, on]);
            let (dilated, eroded) = (bits.dilated(back), bits.eroded());
            prop_assert_eq!(square.count(), square.cells().filter(|[c, _]| *c < columns).count());
            for (c, r) in (0..columns).flat_map(|c| (0..rows).map(move |r| (c, r))) {
                let reaches = |from: usize, to: usize| from <= to + back && to <= from + on;
                let expected = bits.cells().any(|[i, j]| reaches(i, c) && reaches(j, r));
                prop_assert_eq!(square.contains(c, r), expected);
                let near = bits.cells().any(|[i, j]| i.abs_diff(c).max(j.abs_diff(r)) <= back);
                prop_assert_eq!(dilated.contains(c, r), near);
                let around = (c.saturating_sub(1)..(c + 2).min(columns))
                    .flat_map(|i| (r.saturating_sub(1)..(r + 2).min(rows)).map(move |j| (i, j)));
                prop_assert_eq!(eroded.contains(c, r), { around }.all(|(i, j)| bits.contains(i, j)));
            }
        }

        #[test]
        fn spans_and_their_removal(columns in 1..200usize, a in 0..200usize, b in 0..200usize) {
            let (a, b) = (a.min(columns), b.min(columns));
            let mut bits = Bits::empty(columns, 2);
            bits.set_span(1, [a, b], true);
            let expected: Vec<[usize; 2]> = (a..b).map(|c| [c, 1]).collect();
            prop_assert_eq!(bits.cells().collect::<Vec<_>>(), expected);
            let mut rest = Bits::full(columns, 2);
            prop_assert_eq!(rest.count_common(&bits), bits.count());
            rest.set_span(1, [a, b], false);
            prop_assert_eq!(rest, Bits::full(columns, 2).without(&bits));
        }
    }

    #[test]
    fn runs_of_ones() {
        let all = |word| runs(word).collect::<Vec<_>>();
        assert_eq!(all(0b01101), [[0, 1], [2, 4]]);
        assert_eq!((all(0), all(u64::MAX), all(1 << 63)), (vec![], vec![[0, 64]], vec![[63, 64]]));
    }

    #[test]
    fn a_share_of_the_cells_stays() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let all = set(300, 300, &(0..90_000).map(|i| (i % 300, i / 300)).collect::<Vec<_>>());
        for share in [0.001, 0.05, 0.5, 0.95] {
            let odd = all.clone().without(&Bits::full(300, 300).thin(0.5, &mut rng));
            let (kept, of) = (odd.clone().thin(share, &mut rng), odd.count() as f64);
            assert_eq!(kept.count_common(&odd), kept.count());
            let deviation = (of * share * (1.0 - share)).sqrt();
            let error = kept.count() as f64 - of * share;
            assert!(error.abs() < 4.0 * deviation, "{share}: {error}, {deviation}");
        }
        assert_eq!(all.clone().thin(1.0, &mut rng), all);
        assert_eq!(all.thin(0.0, &mut rng).count(), 0);
    }
}
