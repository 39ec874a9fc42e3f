//! Warnings by cause: all warnings that one correction of the file would remove are reported together.

use super::report::{FeatureRef, MapWarning};

/// The most warnings of one cause that are reported one by one.
const TOLD: usize = 3;

impl MapWarning {
    /// What warnings that one correction would remove have in common.
    fn cause(&self) -> (std::mem::Discriminant<Self>, &str, &str) {
        let (key, value) = match self {
            Self::BadHeight { key, got, .. } => (*key, got.as_str()),
            Self::Overlap { what, .. } => (*what, ""),
            _ => ("", ""),
        };
        (std::mem::discriminant(self), key, value)
    }

    fn feature(&self) -> Option<&FeatureRef> {
        match self {
            Self::RingClosed { feature, .. }
            | Self::RepeatedPositions { feature, .. }
            | Self::SelfCrossing { feature, .. }
            | Self::ShortRing { feature, .. }
            | Self::ZeroArea { feature, .. }
            | Self::HoleOutside { feature, .. }
            | Self::ShortRoad { feature, .. }
            | Self::BadHeight { feature, .. }
            | Self::Floating { feature, .. }
            | Self::PartsLeave { feature, .. }
            | Self::HeightClamped { feature, .. }
            | Self::Overlap { feature, .. } => Some(feature),
            Self::LeftOut { .. }
            | Self::NoCenter { .. }
            | Self::NoBuildings
            | Self::NoRoads
            | Self::LaunchSite { .. }
            | Self::MaxHeightLowered { .. } => None,
        }
    }
}

/// The texts of the warnings: for each cause all of them if they are few, else the first one and the
/// number of the others.
pub fn by_cause(warnings: &[MapWarning]) -> Vec<String> {
    let mut groups: Vec<Vec<&MapWarning>> = Vec::new();
    for warning in warnings {
        // A warning that lists its features itself is not grouped.
        let group = warning
            .feature()
            .and_then(|_| groups.iter_mut().find(|group| group[0].cause() == warning.cause()));
        match group {
            Some(group) => group.push(warning),
            None => groups.push(vec![warning]),
        }
    }
    let told = |group: Vec<&MapWarning>| {
        if group.len() <= TOLD {
            return group.iter().map(|w| w.to_string()).collect();
        }
        let more =
            group[1..].iter().filter_map(|w| w.feature()).take(TOLD).map(ToString::to_string);
        let more: Vec<String> = more.collect();
        vec![format!("{} (and {} more like it: {}, …)", group[0], group.len() - 1, more.join(", "))]
    };
    groups.into_iter().flat_map(told).collect()
}
