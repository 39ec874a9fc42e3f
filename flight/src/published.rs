//! The published numbers, to be shown beside ours: `reference/thesis.toml`, embedded.

use serde::Deserialize;

/// Mean and standard deviation.
pub type Published = [f64; 2];

/// The span of the means of thesis chapter 5, seconds.
pub const SPAN_S: [f64; 2] = [150.0, 300.0];

/// Everything there is. Areas are per cent of the ground, lengths metres.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Reference {
    /// Thesis §5.4.
    pub chapter5: Chapter5,
    /// The paper.
    pub paper: Paper,
    /// Thesis §4.7.
    pub chapter4: Chapter4,
    /// Thesis chapter 6.
    pub chapter6: Chapter6,
}

/// Thesis §5.4: means over t = 150..300 s of ten runs.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Chapter5 {
    /// (5.16).
    pub str1: Row,
    /// (5.21) without H^CVS.
    #[serde(rename = "str2-no-hidden")]
    pub str2_no_hidden: Row,
    /// (5.21).
    pub str2: Row,
    /// (5.27).
    #[serde(rename = "str3-kappa0")]
    pub str3_kappa0: Row,
    /// (5.32): the thesis's best.
    #[serde(rename = "str3-kappa1")]
    pub str3_kappa1: Row,
    /// §5.4.3 and §5.4.5.
    pub timing: Timing,
}

impl Chapter5 {
    /// The criteria, in the order of the thesis's tables.
    pub fn rows(&self) -> [Row; 5] {
        [self.str1, self.str2_no_hidden, self.str2, self.str3_kappa0, self.str3_kappa1]
    }
}

/// Thesis tables 5.3-5.6 and §5.4.4 for one criterion.
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
    /// Table 5.5.
    pub occlusion_ratio_pct: f64,
    /// Table 5.6.
    pub explored_pct: Published,
    /// Section 5.4.4, where it is given.
    pub oem_iou_pct: Option<Published>,
}

/// Seconds per UAV and update in MATLAB, and until all targets were identified.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Timing {
    /// The estimator, communication included.
    pub estimator_s: ByCriterion,
    /// The predictive controller.
    pub mpc_s: ByCriterion,
    /// When all were identified at the latest, of the mean over ten runs.
    pub all_identified_by_s: Identified,
}

/// A number for each kind of criterion.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct ByCriterion {
    /// (5.16).
    pub str1: f64,
    /// (5.21).
    pub str2: f64,
    /// (5.27) and (5.32).
    pub str3: f64,
}

/// Section 5.4.3, seconds.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Identified {
    /// (5.32).
    #[serde(rename = "str3-kappa1")]
    pub str3_kappa1: f64,
    /// All others but (5.27), which never found all in eight runs of ten.
    pub others: f64,
}

/// The paper's table I: t = 300 s, r_s = 3 m.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Paper {
    /// Table I.
    pub table1: Table1,
}

/// The columns of table I and what §VIII-B says of the last one.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Table1 {
    /// Its reference \[3\]: the map is not exploited.
    pub previous: Ground,
    /// κ = 0.
    pub kappa0: Ground,
    /// κ = 1.
    pub kappa1: Ground,
    /// Of κ = 1.
    pub localization_error_m: Published,
    /// Of κ = 1.
    pub explored_at_300s_pct: f64,
}

/// One column of table I.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Ground {
    /// φ(X̄), per cent.
    pub unexplored_pct: Published,
    /// φ(X̄ ∩ H), per cent.
    pub hidden_pct: Published,
}

/// Thesis §4.7: one look at five cars.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Chapter4 {
    /// Distances of the cars.
    pub distance_m: [f64; 5],
    /// Section 4.7.2.
    pub point_error_below_m: f64,
    /// Section 4.7.6.
    pub oem_iou_pct: f64,
    /// Figure 4.19.
    pub exclusion_covers_shadow: Covered,
}

/// From which separation and up to which distance exclusion covers the shadow entirely.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Covered {
    /// r_s^tt, metres.
    pub r_s_tt_m: f64,
    /// Metres.
    pub up_to_distance_m: f64,
}

/// Thesis chapter 6: the same look from poses that are known to a box.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Chapter6 {
    /// (6.64).
    pub footprint_guaranteed_pct: Shares,
    /// Half-widths: x, y, z, metres; roll, pitch, yaw, degrees.
    pub u1: [f64; 6],
    /// The same.
    pub u2: [f64; 6],
    /// The same.
    pub u3: [f64; 6],
    /// The same.
    pub u4: [f64; 6],
    /// The car at x = 60 m.
    pub target_60m_radius_m: Radius,
    /// What a set of that car takes under u4.
    pub one_target_s: OneTarget,
}

/// Per cent, by box of poses.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Shares {
    /// Of u1.
    pub u1: f64,
    /// Of u2.
    pub u2: f64,
    /// Of u3.
    pub u3: f64,
    /// Of u4.
    pub u4: f64,
}

/// Radius of the disc of equal area, metres.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct Radius {
    /// With the exact pose.
    pub exact: f64,
    /// Under u1.
    pub u1: Published,
}

/// Seconds in MATLAB.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct OneTarget {
    /// A box about the inverse image.
    pub inverse_only: f64,
    /// Thick SIVIA.
    pub thick_sivia: Published,
}

/// All published numbers.
pub fn reference() -> Reference {
    let text = include_str!("../../experiments/reference/thesis.toml");
    toml::from_str(text).expect("the embedded table is read by a test")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_embedded_numbers_are_the_published_ones() {
        let Reference { chapter5, paper, chapter4, .. } = reference();
        assert_eq!(chapter5.str3_kappa1.unexplored_pct, [22.06, 2.35]);
        assert_eq!(chapter5.str3_kappa1.oem_iou_pct, Some([74.38, 9.25]));
        assert_eq!(chapter5.str1.oem_iou_pct, None);
        assert_eq!(paper.table1.kappa1.hidden_pct, [11.2, 1.8]);
        assert_eq!(chapter4.distance_m[4], 186.0);
    }

    /// (Φ^FoV - Φ^g) / Φ^FoV of table 5.5 follows from its other columns.
    #[test]
    fn occlusion_follows_from_what_is_seen() {
        for row in reference().chapter5.rows() {
            let ([footprint, _], [seen, _]) = (row.footprint_pct, row.ground_seen_pct);
            let ratio = 100.0 * (1.0 - seen / footprint);
            assert!((ratio - row.occlusion_ratio_pct).abs() < 0.1, "{ratio} in {row:?}");
        }
    }
}
