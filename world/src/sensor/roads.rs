//! A camera that looks straight down and segments roads.
//!
//! Row 0 of its image is north, column 0 is west. The middle of pixel (row, column) is a point of the ground, and the
//! pixel is labelled Road if the cell of the raster there belongs to the roads, else Ground. Then come errors.
//!
//! # Why the bound holds
//!
//! Let E be the pixels whose middles are on a road, D any set of pixels that are lost, and K = E \ D. Labelled are
//! at least K and those pixels of E that have no pixel of K within Chebyshev distance `gap_px`. So a pixel of E
//! has a labelled pixel within that distance: one of K, or itself. Ragged edges and speckle only add labels. ∎

use csat_proto::camera::{CameraModel, Pose};
use csat_proto::frame::Label;
use csat_proto::model::RoadSensor;

use crate::bits::{Bits, ones, runs};
use crate::camera::noise::{NoisePurpose, Stream};
use crate::road_area::RoadArea;

/// The labels of a frame from a level pose.
pub(super) fn labels(
    camera: &CameraModel,
    sensor: &RoadSensor,
    pose: &Pose,
    roads: Option<&RoadArea>,
    stream: Stream,
) -> Vec<Label> {
    let size = [usize::from(camera.columns), usize::from(camera.rows)];
    let exact = match roads {
        Some(roads) => exact(camera, pose, roads),
        None => Bits::empty(size[0], size[1]),
    };
    let seen = with_errors(exact, sensor, stream);
    let mut labels = vec![Label::Ground; camera.pixels()];
    for row in 0..size[1] {
        let line = &mut labels[row * size[0]..(row + 1) * size[0]];
        for (index, word) in seen.row(row).iter().enumerate() {
            ones(*word).for_each(|bit| line[64 * index + bit] = Label::Road);
        }
    }
    labels
}

/// E: the pixels whose middles are on a road.
fn exact(camera: &CameraModel, pose: &Pose, roads: &RoadArea) -> Bits {
    let [x, y, height_m] = pose.p_world;
    let pixel_m = height_m / camera.focal_px();
    // From the middle of an image of `size` pixels to the middle of a pixel, metres.
    let offset_m = |index: usize, size: u16| (index as f64 + 0.5 - f64::from(size) / 2.0) * pixel_m;
    let columns = usize::from(camera.columns);
    let firsts = first_pixels(roads.columns(), columns, |column| {
        roads.index_at(0, x + offset_m(column, camera.columns))
    });
    let mut seen = Bits::empty(columns, camera.rows.into());
    for row in 0..usize::from(camera.rows) {
        let Some(source) = roads.index_at(1, y - offset_m(row, camera.rows)) else { continue };
        for (index, word) in roads.bits.row(source).iter().enumerate() {
            for run in runs(*word) {
                seen.set_span(row, run.map(|bit| firsts[64 * index + bit]), true);
            }
        }
    }
    seen
}

/// By column of the raster, and for the one after its last: the first pixel of a row that is there or further
/// east. The pixels of the columns from a to b are therefore those from the first one of a to that of b + 1.
fn first_pixels(
    columns: usize,
    pixels: usize,
    column_at: impl Fn(usize) -> Option<usize>,
) -> Vec<usize> {
    let outside = (0..pixels).take_while(|pixel| column_at(*pixel).is_none()).count();
    let mut firsts = vec![0; columns + 1];
    for column in (0..pixels).filter_map(column_at) {
        firsts[column + 1] += 1;
    }
    firsts[0] = outside;
    for column in 0..columns {
        firsts[column + 1] += firsts[column];
    }
    firsts
}

/// The pixels labelled Road in place of E.
fn with_errors(exact: Bits, sensor: &RoadSensor, stream: Stream) -> Bits {
    let mut rng = stream.rng(NoisePurpose::Segmentation);
    let RoadSensor { gap_px, gap_share, edge_share, speckle_share } = *sensor;
    let gap = usize::from(gap_px);
    let kept = if gap == 0 {
        exact.clone()
    } else {
        // A square of 2 gap_px pixels is the largest hole that the bound allows.
        let side = 2 * gap;
        let centres = exact.clone().thin(gap_share / (side * side) as f64, &mut rng);
        let gaps = centres.smeared([gap - 1, gap]);
        let edge = exact.clone().without(&exact.eroded()).thin(edge_share, &mut rng);
        let kept = exact.clone().without(&gaps).without(&edge);
        let unseen = exact.clone().without(&kept.dilated(gap));
        kept.or(&unseen)
    };
    let outside = exact.dilated(1).without(&exact).thin(edge_share, &mut rng);
    let all = Bits::full(exact.columns(), exact.rows());
    kept.or(&outside).or(&all.thin(speckle_share, &mut rng))
}

/// The scenario keys that are impossible for such a camera: key, got, expected. UAVs fly between two heights,
/// metres; the raster has cells of `cell_m`.
pub fn mistakes(
    camera: &CameraModel,
    sensor: &RoadSensor,
    heights_m: [f64; 2],
    cell_m: f64,
) -> Vec<(&'static str, String, String)> {
    let mut mistakes = Vec::new();
    let mut expect = |holds: bool, key, got: String, expected: String| {
        if !holds {
            mistakes.push((key, got, expected));
        }
    };
    let tilt = camera.tilt_deg;
    expect(tilt == 90.0, "camera.tilt_deg", tilt.to_string(), "90: it looks straight down".into());
    let size = [camera.columns, camera.rows];
    let expected = "as many rows as columns, and at least 8".into();
    expect(size[0] == size[1] && size[0] >= 8, "camera.rows", format!("{size:?}"), expected);
    for (key, share) in [
        ("segmentation.gap_share", sensor.gap_share),
        ("segmentation.edge_share", sensor.edge_share),
        ("segmentation.speckle_share", sensor.speckle_share),
    ] {
        let expected = "a share from 0 to 1".into();
        expect((0.0..=1.0).contains(&share), key, share.to_string(), expected);
    }
    let gap_ok = sensor.gap_px > 0 || sensor.gap_share == 0.0;
    let expected = format!("at least 1 with segmentation.gap_share = {}", sensor.gap_share);
    expect(gap_ok, "segmentation.gap_px", sensor.gap_px.to_string(), expected);
    let most = camera.columns / 4;
    let expected = format!("at most a quarter of the image, {most} pixels");
    expect(sensor.gap_px <= most, "segmentation.gap_px", sensor.gap_px.to_string(), expected);
    let highest_m = heights_m[0].max(heights_m[1]);
    let pixel_m = highest_m / camera.focal_px();
    let expected = format!(
        "pixels of at most {cell_m} m of ground, so that no cell is missed: condition (1) of Gagliardi et al."
    );
    let got = format!("{highest_m} m for the highest UAV, pixels of {pixel_m:.3} m");
    expect(pixel_m > 0.0 && pixel_m <= cell_m, "agents.altitude_m", got, expected);
    mistakes
}

#[cfg(test)]
mod tests;
