//! All pixels that a segment touches.

use super::CONTOUR_MARGIN_PX;

/// Calls `touch(row, first column, last column)` for all pixels of a `columns` x `rows` image whose
/// closed square meets the segment from `a` to `b` (c, r), widened by [`CONTOUR_MARGIN_PX`].
pub(super) fn for_touched(
    columns: usize,
    rows: usize,
    a: [f64; 2],
    b: [f64; 2],
    mut touch: impl FnMut(usize, usize, usize),
) {
    let (low, high) = if a[1] <= b[1] { (a, b) } else { (b, a) };
    let Some([first_row, last_row]) = touched(low[1], high[1], rows) else { return };
    let slope = (high[0] - low[0]) / (high[1] - low[1]);
    let at = |r: f64| {
        if r <= low[1] {
            low[0]
        } else if r >= high[1] {
            high[0]
        } else {
            let c = low[0] + (r - low[1]) * slope;
            c.clamp(low[0].min(high[0]), low[0].max(high[0]))
        }
    };
    for row in first_row..=last_row {
        let c0 = at(row as f64 - CONTOUR_MARGIN_PX);
        let c1 = at((row + 1) as f64 + CONTOUR_MARGIN_PX);
        if let Some([first, last]) = touched(c0.min(c1), c0.max(c1), columns) {
            touch(row, first, last);
        }
    }
}

/// First and last index in 0..count of the closed unit intervals that meet [low, high], widened.
fn touched(low: f64, high: f64, count: usize) -> Option<[usize; 2]> {
    // An integer bound belongs to the interval before it as well; the margin includes that interval.
    let low = (low - CONTOUR_MARGIN_PX).floor();
    let high = (high + CONTOUR_MARGIN_PX).floor();
    // NaN (from an edge at infinity) compares false and touches nothing.
    (high >= 0.0 && low < count as f64)
        .then(|| [low.max(0.0) as usize, (high as usize).min(count - 1)])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(a: [f64; 2], b: [f64; 2]) -> Vec<(usize, usize)> {
        let mut all = Vec::new();
        for_touched(4, 3, a, b, |row, first, last| all.extend((first..=last).map(|c| (row, c))));
        all
    }

    #[test]
    fn borders_count_for_both_sides() {
        assert_eq!(pixels([1.0, 0.2], [1.0, 0.8]), [(0, 0), (0, 1)]);
        assert_eq!(pixels([0.2, 1.0], [0.8, 1.0]), [(0, 0), (1, 0)]);
        assert_eq!(pixels([2.0, 1.0], [2.0, 1.0]), [(0, 1), (0, 2), (1, 1), (1, 2)]);
    }

    #[test]
    fn oblique_segments_touch_every_pixel_on_their_way() {
        assert_eq!(pixels([0.5, 0.5], [2.5, 1.6]), [(0, 0), (0, 1), (1, 1), (1, 2)]);
        assert_eq!(pixels([-9.0, 0.5], [9.0, 0.5]), [(0, 0), (0, 1), (0, 2), (0, 3)]);
        assert_eq!(pixels([4.0, 3.0], [9.0, 9.0]), [(2, 3)], "a touched image corner");
        assert_eq!(pixels([-3.0, -1.0], [-0.1, 9.0]), []);
    }
}
