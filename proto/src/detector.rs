//! A detector that looks for one kind of target in each image (Tisdale et al. 2008, §III.B and table I).

use serde::{Deserialize, Serialize};

/// `[detector]`: how well targets are detected, and how often something else is taken for one.
///
/// Resolution r is the number of image pixels per square metre of ground, px/m²
/// ([`CameraView::resolution_px_m2`](crate::camera::CameraView::resolution_px_m2)). The second parameters of
/// table I are variances, (px/m²)². docs/concepts/bayes.md says why they are read so.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DetectorModel {
    /// p(D | V): the share of visible targets that were detected in the calibration.
    pub p_detection: f64,
    /// P_false: the probability of a detection that is none, per frame; its place is uniform in the image.
    pub p_false: f64,
    /// Mean and variance of the resolution of targets that were detected: p(r | D) is normal.
    pub detected_resolution: [f64; 2],
    /// The same of visible targets that were missed: p(r | not D).
    pub missed_resolution: [f64; 2],
}

impl Default for DetectorModel {
    fn default() -> Self {
        Self {
            p_detection: 0.96,
            p_false: 0.004,
            detected_resolution: [60.0, 40.06],
            missed_resolution: [60.0, 62.03],
        }
    }
}

/// Pixels per square metre; the square of a greater number may exceed what a number can be.
const MAX_RESOLUTION: f64 = 1e150;

impl DetectorModel {
    /// p(D | V, r): the probability that a visible target is detected where the image has that resolution,
    /// px/m² (6).
    pub fn p_detected(&self, resolution_px_m2: f64) -> f64 {
        let [detected, missed] = [self.detected_resolution, self.missed_resolution];
        let exponent = |[mean, variance]: [f64; 2]| {
            let d = resolution_px_m2.min(MAX_RESOLUTION) - mean;
            d * d / (2.0 * variance)
        };
        let prior = (1.0 - self.p_detection) / self.p_detection;
        let densities = (detected[1] / missed[1]).sqrt();
        // The exponent may exceed what `exp` can give: then the ratio is infinite and the result 0.
        1.0 / (1.0 + prior * densities * (exponent(detected) - exponent(missed)).exp())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bayes_rule_by_hand() {
        let model = DetectorModel::default();
        let normal = |r: f64, [mean, variance]: [f64; 2]| {
            (-(r - mean).powi(2) / (2.0 * variance)).exp()
                / (std::f64::consts::TAU * variance).sqrt()
        };
        for r in [35.0, 50.0, 60.0, 71.5] {
            let d = 0.96 * normal(r, [60.0, 40.06]);
            let expected = d / (d + 0.04 * normal(r, [60.0, 62.03]));
            assert!((model.p_detected(r) - expected).abs() < 1e-12, "{r}");
        }
        assert!((model.p_detected(60.0) - 0.9676).abs() < 1e-4);
        assert_eq!((model.p_detected(1e9), model.p_detected(f64::INFINITY)), (0.0, 0.0));
        let sure = DetectorModel { p_detection: 1.0, ..model };
        assert_eq!(sure.p_detected(60.0), 1.0);
    }
}
