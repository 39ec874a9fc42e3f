//! A set of pixels of an image, as rows of 64-bit words: pixel (row, column) is bit `column % 64` of word
//! `column / 64` of its row. Neighbours are the eight around a pixel, and distances are Chebyshev distances.

use csat_proto::frame::Label;

mod flood;
mod shift;

/// The pixels of a rectangle, bounds inclusive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rect {
    /// First and last row.
    pub rows: [u16; 2],
    /// First and last column.
    pub columns: [u16; 2],
}

impl Rect {
    /// The middle, row and column, rounded down.
    pub fn middle(&self) -> [u16; 2] {
        [self.rows, self.columns].map(|[first, last]| first.midpoint(last))
    }
}

/// See the module. Bits beyond the last column are never set.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bitmap {
    rows: u16,
    columns: u16,
    /// Words per row.
    stride: usize,
    words: Vec<u64>,
}

impl Bitmap {
    /// No pixel of an image of this size.
    pub fn new(rows: u16, columns: u16) -> Self {
        let stride = usize::from(columns).div_ceil(64);
        Self { rows, columns, stride, words: vec![0; usize::from(rows) * stride] }
    }

    /// The pixels that have this label, of labels in rows.
    pub fn from_labels(rows: u16, columns: u16, labels: &[Label], wanted: Label) -> Self {
        let mut bitmap = Self::new(rows, columns);
        let stride = bitmap.stride;
        for (row, labels) in labels.chunks_exact(usize::from(columns)).enumerate() {
            for (index, labels) in labels.chunks(64).enumerate() {
                let bit = |(bit, label): (usize, &Label)| u64::from(*label == wanted) << bit;
                let word = labels.iter().enumerate().map(bit).fold(0, |word, bit| word | bit);
                bitmap.words[row * stride + index] = word;
            }
        }
        bitmap
    }

    /// The pixels that are at least this far from the edge of an image: all of them for 0.
    pub fn inside(rows: u16, columns: u16, margin: u16) -> Self {
        let mut bitmap = Self::new(rows, columns);
        let last = |size: u16| size.checked_sub(margin + 1).filter(|last| *last >= margin);
        if let (Some(row), Some(column)) = (last(rows), last(columns)) {
            bitmap.fill(&Rect { rows: [margin, row], columns: [margin, column] });
        }
        bitmap
    }

    /// Adds a rectangle of the image.
    pub fn fill(&mut self, rect: &Rect) {
        let [first, last] = rect.columns.map(usize::from);
        for row in rect.rows[0]..=rect.rows[1] {
            for (index, word) in self.row_mut(row).iter_mut().enumerate() {
                let from = first.max(index * 64);
                let to = last.min(index * 64 + 63);
                if from <= to {
                    *word |= (u64::MAX >> (63 - (to - from))) << (from % 64);
                }
            }
        }
    }

    /// Rows of the image.
    pub fn rows(&self) -> u16 {
        self.rows
    }

    /// Columns of the image.
    pub fn columns(&self) -> u16 {
        self.columns
    }

    fn row(&self, row: u16) -> &[u64] {
        let start = usize::from(row) * self.stride;
        &self.words[start..start + self.stride]
    }

    fn row_mut(&mut self, row: u16) -> &mut [u64] {
        let start = usize::from(row) * self.stride;
        &mut self.words[start..start + self.stride]
    }

    /// Whether a pixel of the image is in the set.
    pub fn get(&self, row: u16, column: u16) -> bool {
        self.row(row)[usize::from(column) / 64] >> (column % 64) & 1 == 1
    }

    /// Adds a pixel of the image.
    pub fn set(&mut self, row: u16, column: u16) {
        self.row_mut(row)[usize::from(column) / 64] |= 1 << (column % 64);
    }

    /// Whether there is no pixel.
    pub fn is_empty(&self) -> bool {
        self.words.iter().all(|word| *word == 0)
    }

    /// The number of pixels.
    pub fn count(&self) -> u32 {
        self.words.iter().map(|word| word.count_ones()).sum()
    }

    /// The pixels, row by row, as row and column.
    pub fn pixels(&self) -> impl Iterator<Item = [u16; 2]> {
        (0..self.rows).flat_map(move |row| {
            let words = self.row(row).iter().enumerate();
            words
                .flat_map(move |(index, word)| ones(*word).map(move |bit| (index, bit)))
                .map(move |(index, bit)| [row, u16::try_from(index * 64 + bit).unwrap_or(u16::MAX)])
        })
    }

    /// The first pixel, row by row.
    pub fn first(&self) -> Option<[u16; 2]> {
        self.pixels().next()
    }

    fn with(mut self, other: &Self, combine: impl Fn(u64, u64) -> u64) -> Self {
        debug_assert_eq!((self.rows, self.columns), (other.rows, other.columns));
        for (word, other) in self.words.iter_mut().zip(&other.words) {
            *word = combine(*word, *other);
        }
        self
    }

    /// The pixels of either.
    pub fn or(self, other: &Self) -> Self {
        self.with(other, |a, b| a | b)
    }

    /// The pixels of both.
    pub fn and(self, other: &Self) -> Self {
        self.with(other, |a, b| a & b)
    }

    /// The pixels that the other one does not have.
    pub fn and_not(self, other: &Self) -> Self {
        self.with(other, |a, b| a & !b)
    }

    /// Whether some pixel is in both.
    pub fn meets(&self, other: &Self) -> bool {
        self.words.iter().zip(&other.words).any(|(a, b)| a & b != 0)
    }

    /// The pixels of the image that are not in the set.
    pub fn complement(&self) -> Self {
        Self::inside(self.rows, self.columns, 0).and_not(self)
    }

    /// The smallest rectangle with all pixels; `None` if there is no pixel.
    pub fn bounds(&self) -> Option<Rect> {
        let is_used = |row: &u16| self.row(*row).iter().any(|word| *word != 0);
        let first = (0..self.rows).find(is_used)?;
        let last = (0..self.rows).rfind(is_used)?;
        let mut joined = vec![0; self.stride];
        for row in first..=last {
            joined.iter_mut().zip(self.row(row)).for_each(|(joined, word)| *joined |= word);
        }
        let columns = Self { rows: 1, columns: self.columns, stride: self.stride, words: joined };
        let [_, left] = columns.first()?;
        let [_, right] = columns.pixels().last()?;
        Some(Rect { rows: [first, last], columns: [left, right] })
    }

    /// The lengths of runs of equal pixels, row by row in one line, the first of pixels that are not in the set.
    pub fn runs(&self) -> Vec<u32> {
        let mut runs = Vec::new();
        let mut end = 0;
        let mut is_set = false;
        let width = u32::from(self.columns);
        for row in 0..self.rows {
            let start = u32::from(row) * width;
            for column in self.changes(row, is_set) {
                runs.push(start + u32::from(column) - end);
                end = start + u32::from(column);
                is_set = !is_set;
            }
        }
        runs.push(u32::from(self.rows) * width - end);
        runs
    }

    /// The columns of a row that differ from the pixel before; before the first one comes `before`.
    fn changes(&self, row: u16, before: bool) -> Vec<u16> {
        let mut changes = Vec::new();
        let mut carry = u64::from(before);
        for (index, word) in self.row(row).iter().enumerate() {
            let changed = word ^ (word << 1 | carry);
            carry = word >> 63;
            let columns = ones(changed).map(|bit| (index * 64 + bit) as u16);
            changes.extend(columns.filter(|column| *column < self.columns));
        }
        changes
    }

    /// The inverse of [`Self::runs`]; `None` if the runs do not have the length of the image.
    pub fn from_runs(rows: u16, columns: u16, runs: &[u32]) -> Option<Self> {
        let mut bitmap = Self::new(rows, columns);
        let total = u32::from(rows) * u32::from(columns);
        let (mut end, mut is_set) = (0_u32, false);
        for run in runs {
            let start = end;
            end = end.checked_add(*run).filter(|end| *end <= total)?;
            if is_set {
                bitmap.fill_line(start, end);
            }
            is_set = !is_set;
        }
        (end == total).then_some(bitmap)
    }

    /// Adds the pixels from `start` to before `end`, counted row by row.
    fn fill_line(&mut self, mut start: u32, end: u32) {
        let width = u32::from(self.columns);
        while start < end {
            let row = start / width;
            let stop = end.min((row + 1) * width);
            let columns = [(start - row * width) as u16, (stop - 1 - row * width) as u16];
            self.fill(&Rect { rows: [row as u16; 2], columns });
            start = stop;
        }
    }

    /// The words of all rows, as bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        self.words.iter().flat_map(|word| word.to_le_bytes()).collect()
    }

    /// The inverse of [`Self::to_bytes`]; `None` if they are not as many as the image needs, or set pixels
    /// outside the image.
    pub fn from_bytes(rows: u16, columns: u16, bytes: &[u8]) -> Option<Self> {
        let mut bitmap = Self::new(rows, columns);
        if bytes.len() != bitmap.words.len() * 8 {
            return None;
        }
        for (word, bytes) in bitmap.words.iter_mut().zip(bytes.as_chunks::<8>().0) {
            *word = u64::from_le_bytes(*bytes);
        }
        let stays = bitmap.clone().and(&Self::inside(rows, columns, 0));
        (stays == bitmap).then_some(bitmap)
    }
}

/// The positions of the bits of a word that are set.
fn ones(mut word: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (word != 0).then(|| {
            let bit = word.trailing_zeros() as usize;
            word &= word - 1;
            bit
        })
    })
}

#[cfg(test)]
mod tests;
