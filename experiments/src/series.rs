//! A mission's metrics over time, averaged over its UAVs, and those of each ground station.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use csat_mission::row::Role;
use csat_mission::row::StepRecord;

/// The metrics that the summary and the plots speak of. Per cent are of the ground area.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Means {
    /// φ(X̄), per cent.
    pub unexplored_pct: f64,
    /// φ(X̄ ∩ X^h), per cent.
    pub hidden_pct: f64,
    /// (5.42), per cent.
    pub explored_pct: f64,
    /// (5.40), per cent.
    pub footprint_pct: f64,
    /// (5.41), per cent.
    pub ground_seen_pct: f64,
    /// (5.36), metres.
    pub localization_error_m: Option<f64>,
    /// (5.38), metres.
    pub target_radius_m: Option<f64>,
    /// (5.45), per cent.
    pub oem_iou_pct: Option<f64>,
}

/// One step of a mission, of its UAVs or of a station.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Point {
    /// Simulated time, seconds.
    pub time_s: f64,
    /// Mean of card(L_i).
    pub identified: f64,
    /// card(∪ L_i).
    pub identified_union: u16,
    /// Targets in the footprint of at least one UAV.
    pub targets_in_fov: u16,
    /// Targets that at least one CVS identified in this step.
    pub targets_detected: u16,
    /// How old news of UAVs are, mean, seconds.
    pub news_age_s: Option<f64>,
    /// The rest, averaged over the agents that have a value.
    pub means: Means,
}

impl Point {
    /// Of the UAVs in the rows of one step; `None` if there are none.
    pub fn of(rows: &[StepRecord]) -> Option<Self> {
        // Those of the stations are the last ones.
        Self::mean(&rows[..rows.partition_point(|row| row.role == Role::Uav)])
    }

    /// The mean of rows of one step.
    fn mean(rows: &[StepRecord]) -> Option<Self> {
        let first = rows.first()?;
        let mean =
            |value: fn(&StepRecord) -> f64| rows.iter().map(value).sum::<f64>() / rows.len() as f64;
        Some(Self {
            time_s: first.time_s,
            identified: mean(|r| f64::from(r.identified)),
            identified_union: first.identified_union,
            targets_in_fov: first.targets_in_fov,
            targets_detected: first.targets_detected,
            news_age_s: some_mean(rows.iter().map(|r| r.news_age_s)),
            means: Means {
                unexplored_pct: mean(|r| r.unexplored_pct),
                hidden_pct: mean(|r| r.hidden_pct),
                explored_pct: mean(|r| r.explored_pct),
                footprint_pct: mean(|r| r.footprint_pct),
                ground_seen_pct: mean(|r| r.ground_seen_pct),
                localization_error_m: some_mean(rows.iter().map(|r| r.localization_error_m)),
                target_radius_m: some_mean(rows.iter().map(|r| r.target_radius_m)),
                oem_iou_pct: some_mean(rows.iter().map(|r| r.oem_iou_pct)),
            },
        })
    }
}

/// The mean of the values there are.
fn some_mean(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let (mut count, mut sum) = (0.0, 0.0);
    for value in values.flatten() {
        count += 1.0;
        sum += value;
    }
    (count > 0.0).then(|| sum / count)
}

/// The curves of a mission.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Curves {
    /// Of its UAVs, mean.
    pub fleet: Series,
    /// Of each ground station, by agent.
    pub stations: BTreeMap<u16, Series>,
}

impl Curves {
    /// Adds the rows of one step and gives the fleet's point.
    pub fn add(&mut self, rows: &[StepRecord]) -> Option<Point> {
        for row in rows.iter().filter(|row| row.role == Role::Station) {
            let point = Point::mean(std::slice::from_ref(row));
            self.stations.entry(row.agent).or_default().0.extend(point);
        }
        let point = Point::of(rows);
        self.fleet.0.extend(point);
        point
    }

    /// From a `metrics.csv`.
    ///
    /// # Errors
    /// When it cannot be read or is none.
    pub fn read(path: &Path) -> Result<Self, csv::Error> {
        let rows: Result<Vec<StepRecord>, csv::Error> =
            csv::Reader::from_path(path)?.deserialize().collect();
        Ok(Self::from_rows(&rows?))
    }

    /// From the rows of `metrics.csv`, in order.
    pub fn from_rows(rows: &[StepRecord]) -> Self {
        let mut curves = Self::default();
        for step in rows.chunk_by(|a, b| a.step == b.step) {
            curves.add(step);
        }
        curves
    }
}

/// Points, step by step.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series(pub Vec<Point>);

impl Series {
    /// The points of the second half of the flown time: t = 150..300 s of the thesis's missions.
    pub fn half(&self) -> impl Iterator<Item = &Point> {
        let half_s = self.0.last().map_or(0.0, |p| p.time_s / 2.0);
        self.0.iter().filter(move |p| p.time_s >= half_s)
    }

    /// Means over the second half of the flown time: what thesis tables 5.3-5.6 give for
    /// t = 150..300 s.
    pub fn second_half(&self) -> Means {
        let half: Vec<Means> = self.half().map(|p| p.means).collect();
        let mean = |value: fn(&Means) -> f64| {
            some_mean(half.iter().map(|m| Some(value(m)))).unwrap_or_default()
        };
        Means {
            unexplored_pct: mean(|m| m.unexplored_pct),
            hidden_pct: mean(|m| m.hidden_pct),
            explored_pct: mean(|m| m.explored_pct),
            footprint_pct: mean(|m| m.footprint_pct),
            ground_seen_pct: mean(|m| m.ground_seen_pct),
            localization_error_m: some_mean(half.iter().map(|m| m.localization_error_m)),
            target_radius_m: some_mean(half.iter().map(|m| m.target_radius_m)),
            oem_iou_pct: some_mean(half.iter().map(|m| m.oem_iou_pct)),
        }
    }

    /// The mean of a value over the second half of the flown time.
    pub fn half_mean(&self, value: fn(&Point) -> Option<f64>) -> Option<f64> {
        some_mean(self.half().map(value))
    }

    /// When a station had identified all of `targets` targets; never where there are none.
    pub fn identified_s(&self, targets: u16) -> Option<f64> {
        let all = self.0.iter().find(|p| targets > 0 && p.identified >= f64::from(targets));
        all.map(|p| p.time_s)
    }

    /// When the fleet had identified all of `targets` targets; never where there are none.
    pub fn all_identified_s(&self, targets: u16) -> Option<f64> {
        let mut points = self.0.iter().filter(|_| targets > 0);
        points.find(|p| p.identified_union >= targets).map(|p| p.time_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(step: u32, agent: u16, unexplored_pct: f64, error: Option<f64>) -> StepRecord {
        StepRecord {
            step,
            time_s: f64::from(step) * 0.5,
            agent,
            unexplored_pct,
            localization_error_m: error,
            identified_union: step as u16,
            ..StepRecord::default()
        }
    }

    #[test]
    fn second_half_by_hand() {
        let rows = [
            row(0, 0, 100.0, None),
            row(0, 1, 100.0, None),
            row(1, 0, 80.0, None),
            row(1, 1, 90.0, Some(9.0)),
            row(2, 0, 40.0, Some(1.0)),
            row(2, 1, 20.0, Some(3.0)),
            row(3, 0, 10.0, None),
            row(3, 1, 30.0, Some(4.0)),
        ];
        let series = Curves::from_rows(&rows).fleet;
        assert_eq!(series.0.len(), 4);
        // Steps 2 and 3 are at 1.0 s and 1.5 s; half of the last time is 0.75 s.
        let means = series.second_half();
        assert_eq!(means.unexplored_pct, 25.0);
        assert_eq!(means.localization_error_m, Some(3.0));
        assert_eq!(means.oem_iou_pct, None);
        assert_eq!(series.all_identified_s(2), Some(1.0));
        assert_eq!(series.all_identified_s(4), None);
        assert_eq!(series.all_identified_s(0), None, "no time at which none were found");
        assert_eq!(Series::default().second_half(), Means::default());
    }

    #[test]
    fn a_station_has_a_curve_of_its_own() {
        let station = |step, unexplored_pct| StepRecord {
            role: Role::Station,
            news_age_s: Some(unexplored_pct / 10.0),
            ..row(step, 2, unexplored_pct, None)
        };
        // In real time an agent may miss a step.
        let rows = [
            row(0, 0, 60.0, None),
            row(0, 1, 80.0, None),
            station(0, 100.0),
            station(1, 90.0),
            row(2, 0, 40.0, None),
        ];
        let curves = Curves::from_rows(&rows);
        let unexplored = |series: &Series| -> Vec<f64> {
            series.0.iter().map(|point| point.means.unexplored_pct).collect()
        };
        assert_eq!(unexplored(&curves.fleet), [70.0, 40.0]);
        assert_eq!(curves.stations.keys().collect::<Vec<_>>(), [&2]);
        assert_eq!(unexplored(&curves.stations[&2]), [100.0, 90.0]);
        assert_eq!(curves.stations[&2].half_mean(|point| point.news_age_s), Some(9.0));
        assert_eq!(curves.fleet.half_mean(|point| point.news_age_s), None);
    }
}
