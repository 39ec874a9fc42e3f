//! What a ground station knew and heard, in `summary.json`.

use serde::{Deserialize, Serialize};

use crate::series::{Point, Series};

/// What a ground station knew, and what it heard.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct StationSummary {
    /// Its number among the agents: stations come after the UAVs.
    pub agent: u16,
    /// East, metres.
    pub x_m: f64,
    /// North, metres.
    pub y_m: f64,
    /// Height, metres.
    pub z_m: f64,
    /// When it knew of all targets, seconds; null if never.
    pub all_identified_s: Option<f64>,
    /// Means over the second half of the mission.
    #[serde(flatten)]
    pub means: StationMeans,
    /// The same at the last step.
    #[serde(rename = "final")]
    pub last: StationMeans,
    /// Messages on their way to it.
    pub sent_to: u64,
    /// Of those, how many arrived.
    pub delivered_to: u64,
}

/// The metrics of a station.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct StationMeans {
    /// card(L_i).
    pub identified: f64,
    /// φ(X̄_i), per cent of the ground.
    pub unexplored_pct: f64,
    /// φ(X̄_i ∩ X^h_i), per cent of the ground.
    pub hidden_pct: f64,
    /// (5.36), metres.
    pub localization_error_m: Option<f64>,
    /// (5.38), metres.
    pub target_radius_m: Option<f64>,
    /// How old its news of the UAVs are, mean over them, seconds.
    pub news_age_s: Option<f64>,
}

impl StationSummary {
    /// In a line for a person; there are `targets` targets.
    pub fn describe(&self, targets: u16) -> String {
        let age = self.means.news_age_s.map_or("-".to_owned(), |age_s| format!("{age_s:.1} s"));
        format!(
            "\nstation {}: unexplored {:.2} %, knows {}/{targets} cars, news {age} old; {} of {} messages \
             reached it",
            self.agent,
            self.means.unexplored_pct,
            self.last.identified,
            self.delivered_to,
            self.sent_to,
        )
    }
}

impl StationMeans {
    /// At one step.
    pub fn of(point: &Point) -> Self {
        Self {
            identified: point.identified,
            unexplored_pct: point.means.unexplored_pct,
            hidden_pct: point.means.hidden_pct,
            localization_error_m: point.means.localization_error_m,
            target_radius_m: point.means.target_radius_m,
            news_age_s: point.news_age_s,
        }
    }

    /// Over the second half of a mission.
    pub fn of_half(series: &Series) -> Self {
        let mean = |value| series.half_mean(value);
        let means = series.second_half();
        Self {
            identified: mean(|point| Some(point.identified)).unwrap_or_default(),
            unexplored_pct: means.unexplored_pct,
            hidden_pct: means.hidden_pct,
            localization_error_m: means.localization_error_m,
            target_radius_m: means.target_radius_m,
            news_age_s: mean(|point| point.news_age_s),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A station that hears one message in six.
    pub(crate) fn sample() -> StationSummary {
        let means = StationMeans {
            identified: 7.0,
            unexplored_pct: 43.5,
            news_age_s: Some(12.25),
            ..StationMeans::default()
        };
        let summary = StationSummary { agent: 4, means, last: means, ..StationSummary::default() };
        StationSummary { sent_to: 1500, delivered_to: 250, ..summary }
    }

    #[test]
    fn a_person_reads_what_a_station_knew() {
        let expected = "\nstation 4: unexplored 43.50 %, knows 7/8 cars, news 12.2 s old; 250 of 1500 \
                        messages reached it";
        assert_eq!(sample().describe(8), expected);
    }

    #[test]
    fn its_numbers_are_flat_in_the_file() {
        let json = serde_json::to_value(sample()).unwrap();
        assert_eq!(json["unexplored_pct"], 43.5);
        assert_eq!(json["final"]["news_age_s"], 12.25);
        assert_eq!(serde_json::from_value::<StationSummary>(json).unwrap(), sample());
    }
}
