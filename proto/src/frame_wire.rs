//! The wire format of the pixels of a frame, from a world to an agent's process: labels in runs,
//! distances only where an agent reads them.
//!
//! All numbers are little-endian. First a `u32`, how many runs there are; then the runs, `u32` each:
//! the length in the upper 24 bits, the [`Label`] in the lower eight; they cover the image row by row.
//! Then a `u16` for each pixel labelled Obstacle or Target, row by row: its noisy depth in steps of
//! d_max/65535. The ground's distance follows from its plane and is not sent: there `depth` is 0.
//!
//! A frame holds quantised depths in any case, and [`CameraModel::depth_interval_m`] widens each by
//! half a step. So the wire format loses nothing, and the guarantee is the same.
//!
//! [`CameraModel::depth_interval_m`]: crate::camera::CameraModel::depth_interval_m

use crate::frame::Label;

/// The longest run, pixels.
const MAX_RUN: u32 = (1 << 24) - 1;

/// Why bytes are not the pixels of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PixelsError {
    /// Their length differs from the stated one.
    #[error("pixels of {got} bytes, expected {expected}")]
    Length {
        /// Its length.
        got: usize,
        /// The length that the first part states.
        expected: usize,
    },
    /// There is no such label.
    #[error("pixels of label {got}, expected 0 to 4")]
    Label {
        /// The label.
        got: u32,
    },
    /// The runs do not cover the image.
    #[error("runs cover {got} pixels, expected {expected}")]
    Cover {
        /// Pixels that they cover.
        got: u64,
        /// Rows times columns.
        expected: usize,
    },
}

fn is_measured(label: Label) -> bool {
    matches!(label, Label::Obstacle | Label::Target)
}

/// Packs labels and depths, both row by row.
pub fn encode(labels: &[Label], depth: &[u16]) -> Vec<u8> {
    let mut runs: Vec<u32> = Vec::new();
    for same in labels.chunk_by(|a, b| a == b) {
        for part in same.chunks(MAX_RUN as usize) {
            runs.push((part.len() as u32) << 8 | u32::from(part[0] as u8));
        }
    }
    let mut bytes = Vec::with_capacity(4 + 4 * runs.len());
    bytes.extend_from_slice(&(runs.len() as u32).to_le_bytes());
    runs.iter().for_each(|run| bytes.extend_from_slice(&run.to_le_bytes()));
    let measured = labels.iter().zip(depth).filter(|(label, _)| is_measured(**label));
    measured.for_each(|(_, depth)| bytes.extend_from_slice(&depth.to_le_bytes()));
    bytes
}

/// The inverse of [`encode`] for an image of that many pixels.
///
/// # Errors
/// When the bytes are not such an image.
pub fn decode(bytes: &[u8], pixels: usize) -> Result<(Vec<Label>, Vec<u16>), PixelsError> {
    let length = |expected: usize| PixelsError::Length { got: bytes.len(), expected };
    let (count, rest) = bytes.split_first_chunk::<4>().ok_or(length(4))?;
    let count = u32::from_le_bytes(*count) as usize;
    let runs_bytes = count.saturating_mul(4);
    let (runs, rest) =
        rest.split_at_checked(runs_bytes).ok_or(length(runs_bytes.saturating_add(4)))?;
    let runs = runs.as_chunks::<4>().0.iter().map(|run| u32::from_le_bytes(*run));
    let covered: u64 = runs.clone().map(|run| u64::from(run >> 8)).sum();
    if covered != pixels as u64 {
        return Err(PixelsError::Cover { got: covered, expected: pixels });
    }
    let mut labels = Vec::with_capacity(pixels);
    for run in runs {
        let label = match run & 0xFF {
            0 => Label::Unknown,
            1 => Label::Ground,
            2 => Label::Obstacle,
            3 => Label::Target,
            4 => Label::Road,
            got => return Err(PixelsError::Label { got }),
        };
        labels.resize(labels.len() + (run >> 8) as usize, label);
    }
    let measured = labels.iter().filter(|label| is_measured(**label)).count();
    if rest.len() != 2 * measured {
        return Err(length(4 + runs_bytes + 2 * measured));
    }
    let mut depths = rest.as_chunks::<2>().0.iter().map(|depth| u16::from_le_bytes(*depth));
    let mut depth_of = |label: &Label| match is_measured(*label) {
        true => depths.next().unwrap_or_default(),
        false => 0,
    };
    let depth = labels.iter().map(&mut depth_of).collect();
    Ok((labels, depth))
}

#[cfg(test)]
mod tests {
    use super::*;
    use Label::{Ground, Obstacle, Target, Unknown};

    const LABELS: [Label; 8] =
        [Ground, Ground, Obstacle, Target, Target, Unknown, Unknown, Obstacle];
    const DEPTH: [u16; 8] = [7, 7, 500, 65535, 0, 9, 9, 258];

    #[test]
    fn decode_inverts_encode_where_distances_matter() {
        let bytes = encode(&LABELS, &DEPTH);
        assert_eq!(bytes.len(), 4 + 5 * 4 + 4 * 2);
        let (labels, depth) = decode(&bytes, 8).unwrap();
        assert_eq!(labels, LABELS);
        assert_eq!(depth, [0, 0, 500, 65535, 0, 0, 0, 258]);
    }

    #[test]
    fn anything_else_is_refused() {
        let bytes = encode(&LABELS, &DEPTH);
        assert_eq!(decode(&bytes, 9), Err(PixelsError::Cover { got: 8, expected: 9 }));
        for length in 0..bytes.len() {
            assert!(decode(&bytes[..length], 8).is_err(), "{length}");
        }
        let long = [&bytes[..], &[0]].concat();
        assert_eq!(decode(&long, 8), Err(PixelsError::Length { got: 33, expected: 32 }));
        let mut unknown = bytes.clone();
        unknown[4] = 5;
        assert_eq!(decode(&unknown, 8), Err(PixelsError::Label { got: 5 }));
        let huge = [u32::MAX.to_le_bytes(), [0; 4]].concat();
        assert!(matches!(decode(&huge, 8), Err(PixelsError::Length { .. })));
    }
}
