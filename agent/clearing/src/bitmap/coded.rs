//! Bitmaps as data: size and runs.

use serde::{Deserialize, Serialize};

use super::Bitmap;

/// See [`Bitmap::runs`].
#[derive(Serialize, Deserialize)]
pub(super) struct Coded {
    rows: u16,
    columns: u16,
    runs: Vec<u32>,
}

impl From<Bitmap> for Coded {
    fn from(bitmap: Bitmap) -> Self {
        Self { rows: bitmap.rows, columns: bitmap.columns, runs: bitmap.runs() }
    }
}

impl TryFrom<Coded> for Bitmap {
    type Error = &'static str;

    fn try_from(Coded { rows, columns, runs }: Coded) -> Result<Self, Self::Error> {
        Self::from_runs(rows, columns, &runs).ok_or("runs that do not cover the image")
    }
}
