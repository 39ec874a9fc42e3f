//! Shifts, dilations and erosions of sets of pixels.

use super::Bitmap;

impl Bitmap {
    /// The set, moved down and to the right by so many pixels. What leaves the image is gone.
    pub fn shifted(&self, [down, right]: [i32; 2]) -> Self {
        let mut moved = Self::new(self.rows, self.columns);
        let rows = i32::from(self.rows);
        for to in down.max(0)..rows.min(rows.saturating_add(down)) {
            let from = self.row((to - down) as u16);
            shift_row(from, moved.row_mut(to as u16), right);
        }
        moved.cut();
        moved
    }

    /// Clears the bits beyond the last column.
    fn cut(&mut self) {
        let used = self.columns % 64;
        if used == 0 {
            return;
        }
        for row in 0..self.rows {
            if let Some(word) = self.row_mut(row).last_mut() {
                *word &= (1 << used) - 1;
            }
        }
    }

    /// The pixels of the image within this distance of the set.
    pub fn dilated(&self, radius: u16) -> Self {
        let mut wide = self.clone();
        let mut moved = vec![0; self.stride];
        for row in 0..self.rows {
            widen_row(wide.row_mut(row), &mut moved, radius);
        }
        wide.cut();
        wide.heightened(radius)
    }

    /// The same with vertical distances only: windows of doubling height.
    fn heightened(self, radius: u16) -> Self {
        let mut high = self;
        let mut reach = 0;
        while reach < radius {
            let by = (reach + 1).min(radius - reach);
            high = high.stacked(by);
            reach += by;
        }
        high
    }

    /// The union of the set and of itself moved up and down by `by` rows.
    fn stacked(&self, by: u16) -> Self {
        let mut union = self.clone();
        let offset = usize::from(by) * self.stride;
        if offset >= self.words.len() {
            return union;
        }
        let kept = self.words.len() - offset;
        for index in 0..kept {
            union.words[index] |= self.words[index + offset];
            union.words[index + offset] |= self.words[index];
        }
        union
    }

    /// The pixels whose neighbourhood of this radius, as far as it is in the image, is in the set.
    pub fn eroded(&self, radius: u16) -> Self {
        self.complement().dilated(radius).complement()
    }
}

/// Writes a row, moved to the right by so many pixels.
fn shift_row(from: &[u64], to: &mut [u64], right: i32) {
    let (words, bits) = (right.div_euclid(64), right.rem_euclid(64) as u32);
    let word = |index: i64| {
        usize::try_from(index).ok().and_then(|index| from.get(index)).copied().unwrap_or(0)
    };
    for (index, to) in to.iter_mut().enumerate() {
        let source = index as i64 - i64::from(words);
        let carried = word(source - 1).checked_shr(64 - bits).unwrap_or(0);
        *to = word(source) << bits | carried;
    }
}

/// Adds the pixels of a row within this distance of it: windows of doubling width.
fn widen_row(row: &mut [u64], moved: &mut [u64], radius: u16) {
    let mut reach = 0;
    while reach < radius {
        let by = (reach + 1).min(radius - reach).min(63);
        let mut carry = 0;
        for (word, moved) in row.iter().zip(moved.iter_mut()) {
            *moved = word | word << by | carry;
            carry = word >> (64 - by);
        }
        let mut carry = 0;
        for (word, moved) in row.iter_mut().zip(moved.iter()).rev() {
            let own = *word;
            *word = moved | own >> by | carry;
            carry = own << (64 - by);
        }
        reach += by;
    }
}
