//! What a camera and its computer-vision system (CVS) report (docs/concepts/frame.md).

use serde::{Deserialize, Serialize};

use crate::camera::{Pose, PoseError};
use crate::ids::TargetId;
use crate::time::Step;

/// The class of a pixel (Assumption 4 unless the scenario selects another).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[repr(u8)]
pub enum Label {
    /// Unclassified: silhouettes, sky, anything beyond d_max.
    Unknown = 0,
    /// Every ray through the pixel meets the ground.
    Ground = 1,
    /// Every ray through the pixel meets one obstacle.
    Obstacle = 2,
    /// Every ray through the pixel meets one target.
    Target = 3,
    /// The middle of the pixel is on a road, as far as the segmentation can tell: what a camera that segments
    /// roads says instead of Ground.
    Road = 4,
}

/// An axis-aligned box of pixels, bounds inclusive, 0-based.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct PixelBox {
    /// First and last column.
    pub columns: [u16; 2],
    /// First and last row.
    pub rows: [u16; 2],
}

/// An identified target and the box that meets its pixels (3.53).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Detection {
    /// j, the target's index.
    pub target: TargetId,
    /// The box; at least one Target pixel of j lies in it.
    pub pixels: PixelBox,
}

/// What UAV i gets from its CVS at step k.
///
/// `labels` and `depth` are row-major, `rows * columns` long: the 0-based pixel (row, column) is at
/// `row * columns + column` and covers the image square [column, column+1] x [row, row+1].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// k.
    pub step: Step,
    /// The pose that the frame was taken from, as estimated by the agent.
    pub pose: Pose,
    /// The box about it that contains the true pose, as far as the agent's navigation can tell. Nothing where
    /// nobody bounds the error.
    pub pose_error: PoseError,
    /// One label per pixel.
    pub labels: Vec<Label>,
    /// One noisy depth D = ρ(1+w) per pixel, in steps of d_max/65535; meaningless where Unknown.
    pub depth: Vec<u16>,
    /// The identified targets, by increasing index.
    pub detections: Vec<Detection>,
    /// Where a detector without labels found a target, or took something else for one: image point (c, r),
    /// pixels. Such a frame has no labels, depths and identified targets.
    pub sighting: Option<[f64; 2]>,
}

impl Frame {
    /// A frame of a detector without labels.
    pub fn of_detector(step: Step, pose: Pose, sighting: Option<[f64; 2]>) -> Self {
        let (labels, depth, detections) = Default::default();
        let pose_error = PoseError::NONE;
        Self { step, pose, pose_error, labels, depth, detections, sighting }
    }
}
