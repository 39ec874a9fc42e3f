//! Lengths and storeys as OpenStreetMap writes them.
//!
//! # References
//! OpenStreetMap wiki: *Map features/Units*, *Key:height*, *Key:building:levels*.

use serde_json::Value;

/// Metres in a foot and in an inch.
const FOOT_M: f64 = 0.3048;
const INCH_M: f64 = 0.0254;

/// What [`metres`] reads, for messages.
pub(super) const LENGTHS: &str = "a length such as 12.5, 12.5 m, 40 ft or 40'6\"";
/// What [`storeys`] reads, for messages.
pub(super) const STOREYS: &str = "a number of storeys such as 3 or 3.5";

/// A length in metres, 0 or more: a number of metres, or one with a unit (`12 m`, `40 ft`, `40'6"`,
/// `0.1 km`). For a list (`12;15`) the longest one.
pub(super) fn metres(value: &Value) -> Option<f64> {
    longest(value, length)
}

/// A number of storeys, 0 or more. For a list (`2;3`) the greatest one.
pub(super) fn storeys(value: &Value) -> Option<f64> {
    longest(value, number)
}

fn longest(value: &Value, read: fn(&str) -> Option<f64>) -> Option<f64> {
    if let Some(number) = value.as_f64() {
        return Some(number).filter(|x| *x >= 0.0);
    }
    let numbers: Option<Vec<f64>> =
        value.as_str()?.split(';').map(|text| read(text.trim())).collect();
    numbers?.into_iter().reduce(f64::max)
}

fn length(text: &str) -> Option<f64> {
    let mut text = text.to_lowercase();
    for (spelling, sign) in [
        ("feet", "'"),
        ("foot", "'"),
        ("ft", "'"),
        ("inches", "\""),
        ("inch", "\""),
        ("in", "\""),
        ("′", "'"),
        ("’", "'"),
        ("″", "\""),
        ("”", "\""),
        ("''", "\""),
    ] {
        text = text.replace(spelling, sign);
    }
    if let Some((feet, inches)) = text.split_once('\'') {
        let inches = inches.trim();
        let inches = if inches.is_empty() { 0.0 } else { number(inches.trim_end_matches('"'))? };
        return Some(number(feet)? * FOOT_M + inches * INCH_M);
    }
    let end = text.find(|c: char| !c.is_ascii_digit() && !".,+".contains(c)).unwrap_or(text.len());
    let (value, unit) = text.split_at(end);
    let unit_m = match unit.trim() {
        "" | "m" | "metre" | "metres" | "meter" | "meters" => 1.0,
        "km" | "kilometre" | "kilometres" | "kilometer" | "kilometers" => 1e3,
        "cm" => 1e-2,
        "mm" => 1e-3,
        "mi" | "mile" | "miles" => 1609.344,
        "nmi" => 1852.0,
        "\"" => INCH_M,
        _ => return None,
    };
    Some(number(value)? * unit_m)
}

/// A decimal number without sign or exponent. OpenStreetMap's decimal separator is the point. A comma
/// before one or two digits is a decimal separator as well; before three digits it may separate
/// thousands.
fn number(text: &str) -> Option<f64> {
    let text = text.trim();
    let text = text.strip_prefix('+').unwrap_or(text);
    let text = match text.split_once(',') {
        Some((whole, decimals)) if (1..=2).contains(&decimals.len()) => {
            format!("{whole}.{decimals}")
        }
        _ => text.to_owned(),
    };
    let is_plain = text.chars().all(|c| c.is_ascii_digit() || c == '.');
    // A number that overflows is not a height.
    text.parse().ok().filter(|x: &f64| is_plain && x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn near(got: Option<f64>, expected_m: f64) -> bool {
        got.is_some_and(|got| (got - expected_m).abs() < 1e-9)
    }

    /// The table of docs/maps.md: every spelling is tested, and every one that is tested is there.
    #[test]
    fn every_spelling_of_the_documentation() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/maps.md");
        let text = std::fs::read_to_string(path).unwrap();
        let table = |heading: &str| {
            let lines = text.lines().skip_while(|line| *line != heading).skip(2);
            let rows = lines.skip_while(|line| !line.starts_with('|')).skip(2);
            let rows = rows.take_while(|line| line.starts_with('|'));
            let cells = rows.map(|row| row.trim_matches('|').split(" | ").map(str::trim).collect());
            cells.collect::<Vec<Vec<&str>>>()
        };
        let lengths = table("### Lengths");
        assert!(lengths.len() >= 10, "{lengths:?}");
        for row in &lengths {
            for spelling in row[0].split(", ") {
                let got = metres(&json!(spelling.trim_matches('`')));
                match row[1] {
                    "not read" => assert_eq!(got, None, "{spelling}"),
                    m => assert!(near(got, m.parse().unwrap()), "{spelling}: {got:?}, not {m}"),
                }
            }
        }
        let counts = table("### Storeys");
        assert!(counts.len() >= 3, "{counts:?}");
        for row in &counts {
            for spelling in row[0].split(", ") {
                let got = storeys(&json!(spelling.trim_matches('`')));
                match row[1] {
                    "not read" => assert_eq!(got, None, "{spelling}"),
                    n => assert!(near(got, n.parse().unwrap()), "{spelling}: {got:?}, not {n}"),
                }
            }
        }
    }

    #[test]
    fn numbers_of_json_are_metres() {
        assert!(near(metres(&json!(7)), 7.0) && near(metres(&json!(7.5)), 7.5));
        for bad in [json!(-1), json!(true), json!([12]), json!({}), json!(null)] {
            assert_eq!(metres(&bad), None, "{bad}");
            assert_eq!(storeys(&bad), None, "{bad}");
        }
        assert_eq!(metres(&json!("9".repeat(400))), None);
    }
}
