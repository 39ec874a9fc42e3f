//! What a ground station knew and heard, in `summary.json`.

use serde::{Deserialize, Serialize};

use csat_mission::measures::Column;
use csat_mission::mission::Kind;

use crate::values::{Numbers, in_words};

/// What a ground station knew, and what it heard.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct StationSummary {
    /// Its number among the agents: stations come after the UAVs.
    pub agent: u16,
    /// East, metres.
    pub x_m: f64,
    /// North, metres.
    pub y_m: f64,
    /// Height, metres.
    pub z_m: f64,
    /// Milestones, and means over the second half of the mission.
    #[serde(flatten)]
    pub numbers: Numbers,
    /// The same means at the last step.
    #[serde(rename = "final")]
    pub last: Numbers,
    /// Messages on their way to it.
    pub sent_to: u64,
    /// Of those, how many arrived.
    pub delivered_to: u64,
}

impl StationSummary {
    /// In a line for a person; there are `targets` targets.
    pub fn describe(&self, kind: Option<&Kind>, targets: u16) -> String {
        let columns = kind.map_or(&[][..], |kind| kind.columns).iter().filter(|c| c.of_stations);
        let value = |column: &Column| {
            // What it had counted at the end says more than a mean of counts.
            let of = if column.is_count { &self.last } else { &self.numbers };
            format!("{} {}, ", column.name, in_words(column, of.get(column.key), targets))
        };
        let values: String = columns.map(value).collect();
        format!(
            "\nstation {}: {values}{} of {} messages reached it",
            self.agent, self.delivered_to, self.sent_to,
        )
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::scenario::missions::kind;

    /// A station that hears one message in six.
    pub(crate) fn sample() -> StationSummary {
        let mut numbers = Numbers::default();
        numbers.push("all_identified_s", None);
        numbers.push("identified", Some(7.0));
        numbers.push("unexplored_pct", Some(43.5));
        numbers.push("news_age_s", Some(12.25));
        let summary = StationSummary {
            agent: 4,
            last: numbers.clone(),
            numbers,
            ..StationSummary::default()
        };
        StationSummary { sent_to: 1500, delivered_to: 250, ..summary }
    }

    #[test]
    fn a_person_reads_what_a_station_knew() {
        let expected = "\nstation 4: identified 7/8, localisation error -, target radius -, unexplored 43.50 %, \
                        hidden -, age of news 12.25 s, 250 of 1500 messages reached it";
        assert_eq!(sample().describe(kind("set-membership"), 8), expected);
    }

    #[test]
    fn its_numbers_are_flat_in_the_file() {
        let json = serde_json::to_value(sample()).unwrap();
        assert_eq!(json["unexplored_pct"], 43.5);
        assert_eq!(json["final"]["news_age_s"], 12.25);
        assert_eq!(serde_json::from_value::<StationSummary>(json).unwrap(), sample());
    }
}
