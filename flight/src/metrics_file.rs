//! `metrics.csv`: rows of metrics as a table, written and read.

use std::path::Path;

use csat_mission::measures::{Column, Of};
use csat_mission::row::{Role, Row};

use crate::series::Curves;

/// The columns before an agent's values: who, when and where.
const HEAD: [&str; 7] = ["step", "time_s", "agent", "x_m", "y_m", "z_m", "yaw_rad"];
/// The columns between an agent's values and the fleet's.
const MIDDLE: [&str; 2] = ["bytes_sent", "violations"];
/// The last column.
const ROLE: &str = "role";

/// No value is this great.
const LIMIT: f64 = 1e15;

/// The names of all columns, in order.
pub fn header(columns: &[Column]) -> Vec<&'static str> {
    let keys = |of: Of| columns.iter().filter(move |c| c.of == of).map(|column| column.key);
    let all = HEAD.into_iter().chain(keys(Of::Agent)).chain(MIDDLE).chain(keys(Of::Fleet));
    all.chain([ROLE]).collect()
}

/// A row as text, in the order of [`header`]. A value that is not defined is empty.
pub fn record(columns: &[Column], row: &Row) -> Vec<String> {
    let value = |(column, value): (&Column, &Option<f64>)| match value {
        None => String::new(),
        Some(count) if column.is_count => format!("{count:.0}"),
        Some(value) => number(*value),
    };
    let values = |of: Of| {
        let all = columns.iter().zip(&row.values);
        all.filter(move |(column, _)| column.of == of).map(value)
    };
    let [x_m, y_m, z_m] = row.p_world.map(number);
    let head = [row.step.to_string(), number(row.time_s), row.agent.to_string(), x_m, y_m, z_m];
    let middle = [row.bytes_sent.to_string(), row.violations.to_string()];
    let role = match row.role {
        Role::Uav => "uav",
        Role::Station => "station",
    };
    let all = head.into_iter().chain([number(row.yaw_rad)]).chain(values(Of::Agent));
    all.chain(middle).chain(values(Of::Fleet)).chain([role.to_owned()]).collect()
}

/// A number so that reading it gives the same bits.
fn number(value: f64) -> String {
    format!("{value:?}")
}

/// Why a file is no `metrics.csv`.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The csv crate's reason.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// A column that every file has.
    #[error("it has no column `{0}`")]
    Column(&'static str),
    /// A value.
    #[error("line {line}, column `{column}`: got `{got}`, expected a number below 1e15")]
    Value {
        /// Where.
        line: u64,
        /// Which column.
        column: &'static str,
        /// What is there.
        got: String,
    },
}

/// The curves of a `metrics.csv`.
///
/// # Errors
/// When the file cannot be read or is no such table.
pub fn read(path: &Path, columns: &'static [Column]) -> Result<Curves, TableError> {
    Ok(Curves::from_rows(columns, &rows(path, columns)?))
}

/// The rows of a `metrics.csv`: steps, times, agents and the values of `columns`.
///
/// # Errors
/// When the file cannot be read or is no such table.
pub fn rows(path: &Path, columns: &[Column]) -> Result<Vec<Row>, TableError> {
    let mut reader = csv::Reader::from_path(path)?;
    let header = reader.headers()?.clone();
    let place = |key: &str| header.iter().position(|name| name == key);
    let required = |key| place(key).ok_or(TableError::Column(key));
    let (step, time_s, agent) = (required("step")?, required("time_s")?, required("agent")?);
    let role = place(ROLE);
    let places = columns.iter().map(|column| required(column.key));
    let places: Vec<usize> = places.collect::<Result<_, _>>()?;
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record?;
        let of = |index: usize, column: &'static str| number_at(&record, index, column);
        let known =
            |index: usize, column| of(index, column)?.ok_or_else(|| bad(&record, index, column));
        let value = |(index, column): (&usize, &Column)| of(*index, column.key);
        let is_station = role.is_some_and(|index| &record[index] == "station");
        rows.push(Row {
            step: known(step, "step")? as u32,
            time_s: known(time_s, "time_s")?,
            agent: known(agent, "agent")? as u16,
            role: if is_station { Role::Station } else { Role::Uav },
            values: places.iter().zip(columns).map(value).collect::<Result<_, _>>()?,
            ..Row::default()
        });
    }
    Ok(rows)
}

fn number_at(
    record: &csv::StringRecord,
    index: usize,
    column: &'static str,
) -> Result<Option<f64>, TableError> {
    match &record[index] {
        "" => Ok(None),
        text => match text.parse::<f64>() {
            // Beyond this nothing that is measured is right, and nothing can be drawn.
            Ok(value) if value.abs() < LIMIT => Ok(Some(value)),
            _ => Err(bad(record, index, column)),
        },
    }
}

fn bad(record: &csv::StringRecord, index: usize, column: &'static str) -> TableError {
    let line = record.position().map_or(0, csv::Position::line);
    TableError::Value { line, column, got: record[index].to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::scratch;

    const COLUMNS: &[Column] = &[
        Column::of_agent("seen", "seen", "cars").count(),
        Column::of_fleet("share_pct", "share", "%"),
        Column::of_agent("age_s", "age", "s"),
    ];

    #[test]
    fn a_table_reads_as_it_was_written() {
        let row = |step: u32, agent: u16, role, values: [Option<f64>; 3]| Row {
            step,
            time_s: 0.1 * f64::from(step),
            agent,
            role,
            values: values.to_vec(),
            ..Row::default()
        };
        let rows = [
            row(0, 0, Role::Uav, [Some(2.0), Some(1e-7), None]),
            row(0, 1, Role::Station, [Some(1.0), Some(1e-7), Some(100.0)]),
            row(3, 0, Role::Uav, [Some(3.0), None, Some(0.1 + 0.2)]),
        ];
        let folder = scratch("table");
        let path = folder.join("metrics.csv");
        let mut writer = csv::Writer::from_path(&path).unwrap();
        writer.write_record(header(COLUMNS)).unwrap();
        rows.iter().for_each(|row| writer.write_record(record(COLUMNS, row)).unwrap());
        drop(writer);
        let text = std::fs::read_to_string(&path).unwrap();
        let first = "step,time_s,agent,x_m,y_m,z_m,yaw_rad,seen,age_s,bytes_sent,violations,share_pct,role\n\
                     0,0.0,0,0.0,0.0,0.0,0.0,2,,0,0,1e-7,uav\n";
        assert!(text.starts_with(first), "{text}");
        let curves = read(&path, COLUMNS).unwrap();
        assert_eq!(curves.fleet.points, Curves::from_rows(COLUMNS, &rows).fleet.points);
        assert_eq!(curves.stations[&1].last("age_s"), Some(100.0));
    }

    #[test]
    fn what_is_no_table_is_told() {
        let folder = scratch("no-table");
        let path = folder.join("metrics.csv");
        let told = |text: &str| {
            std::fs::write(&path, text).unwrap();
            read(&path, COLUMNS).unwrap_err().to_string()
        };
        assert_eq!(told("a,b\n1,2\n"), "it has no column `step`");
        assert_eq!(told("step,time_s,agent,seen\n"), "it has no column `share_pct`");
        let head = "step,time_s,agent,seen,share_pct,age_s\n";
        for (rows, complaint) in [
            ("0,0.0,0,1,,\n1,0.5,0,many,,\n", "line 3, column `seen`: got `many`"),
            ("0,0.0,0,1,-1e308,\n", "line 2, column `share_pct`: got `-1e308`"),
            (",0.0,0,,,\n", "line 2, column `step`: got ``"),
        ] {
            let expected = format!("{complaint}, expected a number below 1e15");
            assert_eq!(told(&format!("{head}{rows}")), expected);
        }
    }
}
