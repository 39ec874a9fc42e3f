//! Detections: the identified targets and their boxes.

use std::collections::BTreeMap;

use csat_proto::camera::CameraModel;
use csat_proto::frame::{Detection, Label, PixelBox};
use csat_proto::ids::TargetId;
use rand::RngExt;

use super::noise::{NoisePurpose, Stream};

/// Pixels of one target.
#[derive(Debug, Clone, Copy)]
struct PixelTally {
    count: u32,
    pixels: PixelBox,
}

/// The detections of a frame, by increasing target index.
///
/// A target is identified when at least `min_pixels` (and one) of its pixels are labelled Target.
/// Its box is the smallest around them, displaced by a random offset of up to `box_error_px` in
/// each direction and clipped to the image. An offset that would leave no Target pixel of the target in
/// the box, against (3.53), is halved until one is left.
pub(super) fn detections(
    model: &CameraModel,
    labels: &[Label],
    target_of: impl Fn(usize) -> Option<TargetId>,
    stream: Stream,
) -> Vec<Detection> {
    let columns = usize::from(model.columns);
    let mut rng = stream.rng(NoisePurpose::Boxes);
    let error = i32::from(model.box_error_px);
    let mut found = Vec::new();
    for (target, PixelTally { count, pixels }) in tally(labels, columns, &target_of) {
        // Each target has a block of the stream, so that the visibility of one does not affect the
        // box of another.
        rng.set_word_pos(u128::from(target.0) * 16);
        let offset = [rng.random_range(-error..=error), rng.random_range(-error..=error)];
        if count >= model.min_pixels {
            let meets = |candidate: &PixelBox| {
                meets(candidate, columns, |pixel| {
                    labels[pixel] == Label::Target && target_of(pixel) == Some(target)
                })
            };
            let pixels = displaced(pixels, offset, [model.columns, model.rows], meets);
            found.push(Detection { target, pixels });
        }
    }
    found
}

fn tally(
    labels: &[Label],
    columns: usize,
    target_of: impl Fn(usize) -> Option<TargetId>,
) -> BTreeMap<TargetId, PixelTally> {
    let mut tallies: BTreeMap<TargetId, PixelTally> = BTreeMap::new();
    for (row, line) in labels.chunks_exact(columns.max(1)).enumerate() {
        for (column, label) in line.iter().enumerate() {
            if *label != Label::Target {
                continue;
            }
            let Some(target) = target_of(row * columns + column) else { continue };
            let (c, r) = (column as u16, row as u16);
            let fresh = PixelTally { count: 0, pixels: PixelBox { columns: [c, c], rows: [r, r] } };
            let PixelTally { count, pixels } = tallies.entry(target).or_insert(fresh);
            *count += 1;
            pixels.columns = [pixels.columns[0].min(c), pixels.columns[1].max(c)];
            pixels.rows = [pixels.rows[0].min(r), pixels.rows[1].max(r)];
        }
    }
    tallies
}

fn meets(pixels: &PixelBox, columns: usize, is_target: impl Fn(usize) -> bool) -> bool {
    let [first, last] = pixels.columns.map(usize::from);
    let [low, high] = pixels.rows.map(usize::from);
    (low..=high).any(|row| (first..=last).any(|column| is_target(row * columns + column)))
}

/// `pixels` moved by `offset` or, where that breaks `meets`, by a half, a quarter, ... of it.
fn displaced(
    pixels: PixelBox,
    mut offset: [i32; 2],
    size: [u16; 2],
    meets: impl Fn(&PixelBox) -> bool,
) -> PixelBox {
    while offset != [0, 0] {
        let columns = shifted(pixels.columns, offset[0], size[0]);
        let rows = shifted(pixels.rows, offset[1], size[1]);
        if let (Some(columns), Some(rows)) = (columns, rows) {
            let candidate = PixelBox { columns, rows };
            if meets(&candidate) {
                return candidate;
            }
        }
        offset = offset.map(|pixels| pixels / 2);
    }
    pixels
}

/// An interval of pixels moved and clipped to 0..size; `None` when it leaves the image.
fn shifted([first, last]: [u16; 2], by: i32, size: u16) -> Option<[u16; 2]> {
    let first = (i32::from(first) + by).max(0);
    let last = (i32::from(last) + by).min(i32::from(size) - 1);
    (first <= last).then_some([first as u16, last as u16])
}
