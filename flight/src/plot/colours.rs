//! Colours of the pictures.

use plotters::style::RGBColor;

/// Curves of stations: as many as the legends name.
pub const STATIONS: [RGBColor; 4] =
    [RGBColor(93, 58, 155), RGBColor(140, 81, 10), RGBColor(204, 121, 167), RGBColor(86, 180, 233)];
/// Curves of what is merely there.
pub const GREY: RGBColor = RGBColor(90, 90, 90);
/// Words.
pub const TEXT: RGBColor = RGBColor(34, 34, 34);

/// `#rrggbb`; black if it is none.
pub fn colour(hex: &str) -> RGBColor {
    let digits = u32::from_str_radix(hex.trim_start_matches('#'), 16).unwrap_or_default();
    let [_, red, green, blue] = digits.to_be_bytes();
    RGBColor(red, green, blue)
}

/// Colours for UAVs: Okabe and Ito's, without the yellow and green that sets have.
pub const UAV_COLOURS: [&str; 8] =
    ["#0072B2", "#D55E00", "#CC79A7", "#111111", "#56B4E9", "#8C510A", "#E69F00", "#5D3A9B"];

/// The colour of a UAV.
pub fn uav_colour(index: usize) -> &'static str {
    UAV_COLOURS[index % UAV_COLOURS.len()]
}
