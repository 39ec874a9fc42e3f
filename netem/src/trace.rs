//! Recorded losses.

use std::sync::Arc;

/// A recording: whether each of a number of messages in a row was lost.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Trace(Arc<[bool]>);

/// Why a text is not a recording.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum TraceError {
    /// A character that is not 0, 1, white space or part of a comment.
    #[error("line {line}, column {column}: expected 0, 1, white space or a # comment, got {got:?}")]
    Character {
        /// Line, from 1.
        line: usize,
        /// Column in characters, from 1.
        column: usize,
        /// Its offset in the text, bytes.
        offset: usize,
        /// The character.
        got: char,
    },
    /// The text contains no 0 and no 1.
    #[error("expected at least one 0 or 1, got none")]
    Empty,
}

impl Trace {
    /// Reads a recording: `1` for lost and `0` for received; white space, and `#` to the end of the
    /// line, are skipped.
    ///
    /// # Errors
    /// The first character that is not allowed, or an empty recording.
    pub fn parse(text: &str) -> Result<Self, TraceError> {
        let mut lost = Vec::new();
        let (mut line, mut line_start, mut in_comment) = (1, 0, false);
        for (offset, got) in text.char_indices() {
            match got {
                '\n' => {
                    line += 1;
                    line_start = offset + 1;
                    in_comment = false;
                }
                _ if in_comment => {}
                '#' => in_comment = true,
                '0' | '1' => lost.push(got == '1'),
                _ if got.is_whitespace() => {}
                _ => {
                    let column = text[line_start..offset].chars().count() + 1;
                    return Err(TraceError::Character { line, column, offset, got });
                }
            }
        }
        if lost.is_empty() { Err(TraceError::Empty) } else { Ok(Self(lost.into())) }
    }

    /// Whether the message of this number is lost on a link that begins at `offset`; both numbers wrap
    /// around at the end of the recording.
    pub fn lost(&self, offset: u64, sequence: u64) -> bool {
        let length = self.0.len() as u64;
        self.0[((offset % length + sequence % length) % length) as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recordings_are_zeros_and_ones() {
        let trace = Trace::parse("# measured 12x\n01 0\r\n\t1 # 11\n1").unwrap();
        let lost: Vec<bool> = (0..6).map(|i| trace.lost(0, i)).collect();
        assert_eq!(lost, [false, true, false, true, true, false]);
        assert_eq!([1, 2, 3].map(|offset| trace.lost(offset, 5)), [true, false, true]);
        // 2^64 - 1 is a multiple of 5.
        assert!(!trace.lost(u64::MAX, u64::MAX) && trace.lost(u64::MAX, 1));
    }

    #[test]
    fn what_is_no_recording_is_refused_with_its_place() {
        let error = Trace::parse("01\n# é\né01").unwrap_err();
        assert_eq!(error, TraceError::Character { line: 3, column: 1, offset: 8, got: 'é' });
        let error = Trace::parse("0\n10 2").unwrap_err();
        assert_eq!(
            error.to_string(),
            "line 2, column 4: expected 0, 1, white space or a # comment, got '2'"
        );
        for empty in ["", " \n", "# 01"] {
            assert_eq!(Trace::parse(empty), Err(TraceError::Empty));
        }
    }
}
