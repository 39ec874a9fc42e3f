//! A mission's metrics over time, averaged over its UAVs, and those of each ground station.

use std::collections::BTreeMap;

use csat_mission::measures::{Column, Level, Of, index_of};
use csat_mission::row::{Role, Row};

/// One step of a mission, of its UAVs or of a station.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Point {
    /// Simulated time, seconds.
    pub time_s: f64,
    /// By column: of an agent's, the mean over the agents that have a value; of the fleet's, the value.
    pub values: Vec<Option<f64>>,
}

impl Point {
    /// Of the UAVs in the rows of one step; `None` if there are none.
    pub fn of(columns: &[Column], rows: &[Row]) -> Option<Self> {
        // Those of the stations are the last ones.
        Self::mean(columns, &rows[..rows.partition_point(|row| row.role == Role::Uav)])
    }

    /// The mean of rows of one step.
    fn mean(columns: &[Column], rows: &[Row]) -> Option<Self> {
        let first = rows.first()?;
        let value = |(index, column): (usize, &Column)| match column.of {
            Of::Fleet => first.values[index],
            Of::Agent if column.is_flag => first.values[index],
            Of::Agent => mean(rows.iter().map(|row| row.values[index])),
        };
        Some(Self { time_s: first.time_s, values: columns.iter().enumerate().map(value).collect() })
    }

    /// A value by the key of its column; `None` if it is not defined.
    pub fn get(&self, columns: &[Column], key: &str) -> Option<f64> {
        self.values.get(index_of(columns, key)?).copied().flatten()
    }
}

/// The mean of the values there are.
fn mean(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let (mut count, mut sum) = (0.0, 0.0);
    for value in values.flatten() {
        count += 1.0;
        sum += value;
    }
    (count > 0.0).then(|| sum / count)
}

/// The curves of a mission.
#[derive(Debug, Clone)]
pub struct Curves {
    /// What is measured.
    pub columns: &'static [Column],
    /// Of its UAVs, mean.
    pub fleet: Series,
    /// Of each ground station, by agent.
    pub stations: BTreeMap<u16, Series>,
}

impl Curves {
    /// Before the first step.
    pub fn new(columns: &'static [Column]) -> Self {
        Self { columns, fleet: Series::new(columns), stations: BTreeMap::new() }
    }

    /// Adds the rows of one step and gives the fleet's point.
    pub fn add(&mut self, rows: &[Row]) -> Option<&Point> {
        for row in rows.iter().filter(|row| row.role == Role::Station) {
            let point = Point::mean(self.columns, std::slice::from_ref(row));
            let series = self.stations.entry(row.agent);
            series.or_insert_with(|| Series::new(self.columns)).points.extend(point);
        }
        let point = Point::of(self.columns, rows)?;
        self.fleet.points.push(point);
        self.fleet.points.last()
    }

    /// From the rows of `metrics.csv`, in order.
    pub fn from_rows(columns: &'static [Column], rows: &[Row]) -> Self {
        let mut curves = Self::new(columns);
        for step in rows.chunk_by(|a, b| a.step == b.step) {
            curves.add(step);
        }
        curves
    }
}

/// Points, step by step.
#[derive(Debug, Clone)]
pub struct Series {
    columns: &'static [Column],
    /// In order of time.
    pub points: Vec<Point>,
}

impl Series {
    /// Without points.
    pub fn new(columns: &'static [Column]) -> Self {
        Self { columns, points: Vec::new() }
    }

    /// The time of the last point, seconds; 0 without points.
    pub fn end_s(&self) -> f64 {
        self.points.last().map_or(0.0, |point| point.time_s)
    }

    /// The times and values of a column.
    pub fn of<'a>(&'a self, key: &str) -> impl Iterator<Item = (f64, Option<f64>)> + use<'a> {
        let index = index_of(self.columns, key);
        let value = move |point: &Point| point.values.get(index?).copied().flatten();
        self.points.iter().map(move |point| (point.time_s, value(point)))
    }

    /// The values of a column in the second half of the flown time: t = 150..300 s of the thesis's missions.
    pub fn half<'a>(&'a self, key: &str) -> impl Iterator<Item = Option<f64>> + use<'a> {
        let half_s = self.end_s() / 2.0;
        self.of(key).filter(move |(time_s, _)| *time_s >= half_s).map(|(_, value)| value)
    }

    /// The mean of a column over the second half of the flown time: what thesis tables 5.3-5.6 give.
    pub fn half_mean(&self, key: &str) -> Option<f64> {
        mean(self.half(key))
    }

    /// The value of a column at the last step.
    pub fn last(&self, key: &str) -> Option<f64> {
        self.points.last()?.get(self.columns, key)
    }

    /// When a column reached a level for the first time, where there are `targets` targets; `None` if never.
    pub fn reached_s(&self, key: &str, level: Level, targets: u16) -> Option<f64> {
        let level = match level {
            Level::Targets if targets == 0 => return None,
            Level::Targets => f64::from(targets),
            Level::Value(value) => value,
        };
        let reached = |(_, value): &(f64, Option<f64>)| value.is_some_and(|value| value >= level);
        self.of(key).find(reached).map(|(time_s, _)| time_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_mission::measures::in_order;

    const COLUMNS: &[Column] = &[
        Column::of_agent("unexplored_pct", "unexplored", "%"),
        Column::of_agent("error_m", "error", "m"),
        Column::of_agent("age_s", "age", "s"),
        Column::of_fleet("identified", "identified", "targets"),
    ];

    fn row(step: u32, agent: u16, unexplored_pct: f64, error_m: Option<f64>) -> Row {
        let values = [
            ("unexplored_pct", Some(unexplored_pct)),
            ("error_m", error_m),
            ("identified", Some(f64::from(step))),
        ];
        let time_s = f64::from(step) * 0.5;
        Row { step, time_s, agent, values: in_order(COLUMNS, values), ..Row::default() }
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
        let series = Curves::from_rows(COLUMNS, &rows).fleet;
        assert_eq!(series.points.len(), 4);
        // Steps 2 and 3 are at 1.0 s and 1.5 s; half of the last time is 0.75 s.
        assert_eq!(series.half_mean("unexplored_pct"), Some(25.0));
        assert_eq!(series.half_mean("error_m"), Some(3.0));
        assert_eq!((series.half_mean("age_s"), series.half_mean("none")), (None, None));
        let reached_s = |targets| series.reached_s("identified", Level::Targets, targets);
        assert_eq!((reached_s(2), reached_s(4)), (Some(1.0), None));
        assert_eq!(reached_s(0), None, "no time at which none were found");
        assert_eq!(series.reached_s("error_m", Level::Value(3.5), 2), Some(0.5));
        assert_eq!(Series::new(COLUMNS).half_mean("unexplored_pct"), None, "not 0");
    }

    #[test]
    fn a_station_has_a_curve_of_its_own() {
        let station = |step, unexplored_pct| {
            let mut row = Row { role: Role::Station, ..row(step, 2, unexplored_pct, None) };
            row.values[2] = Some(unexplored_pct / 10.0);
            row
        };
        // In real time an agent may miss a step.
        let rows = [
            row(0, 0, 60.0, None),
            row(0, 1, 80.0, None),
            station(0, 100.0),
            station(1, 90.0),
            row(2, 0, 40.0, None),
        ];
        let curves = Curves::from_rows(COLUMNS, &rows);
        let unexplored = |series: &Series| -> Vec<f64> {
            series.of("unexplored_pct").filter_map(|(_, value)| value).collect()
        };
        assert_eq!(unexplored(&curves.fleet), [70.0, 40.0]);
        assert_eq!(curves.stations.keys().collect::<Vec<_>>(), [&2]);
        assert_eq!(unexplored(&curves.stations[&2]), [100.0, 90.0]);
        assert_eq!(curves.stations[&2].half_mean("age_s"), Some(9.0));
        assert_eq!(curves.fleet.half_mean("age_s"), None);
    }
}
