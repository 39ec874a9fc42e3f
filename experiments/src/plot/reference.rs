//! The thesis's own numbers, to be shown beside ours.

use serde::Deserialize;

/// Mean and standard deviation over ten runs and t = 150..300 s.
pub type Published = [f64; 2];

/// Thesis tables 5.3-5.6 and §5.4.4 for one criterion; lengths in metres.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Row {
    /// Table 5.3.
    pub localization_error_m: Published,
    /// Table 5.3.
    pub target_radius_m: Published,
    /// Table 5.4.
    pub unexplored_pct: Published,
    /// Table 5.4.
    pub hidden_pct: Published,
    /// Table 5.5.
    pub footprint_pct: Published,
    /// Table 5.5.
    pub ground_seen_pct: Published,
    /// Table 5.6.
    pub explored_pct: Published,
    /// Section 5.4.4.
    pub oem_iou_pct: Published,
}

/// The span of the published means, seconds.
pub const SPAN_S: [f64; 2] = [150.0, 300.0];

#[derive(Deserialize)]
struct Reference {
    chapter5: Chapter5,
}

#[derive(Deserialize)]
struct Chapter5 {
    #[serde(rename = "str3-kappa1")]
    str3_kappa1: Row,
}

/// The row of `str3`, κ = 1 (5.32): the thesis's best.
pub fn str3_kappa1() -> Row {
    let text = include_str!("../../reference/thesis.toml");
    let reference: Reference = toml::from_str(text).expect("the embedded table is read by a test");
    reference.chapter5.str3_kappa1
}
