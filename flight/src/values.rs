//! Numbers by key, in order: a mission's own part of a summary; and one of them in words.

use std::collections::BTreeMap;

use csat_mission::measures::Column;
use serde::de::{MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use serde_json::Value;

/// Numbers by key, in order; one that is not defined is `null`.
#[derive(Debug, Clone, Default)]
pub struct Numbers(Vec<(String, Value)>);

impl Numbers {
    /// Adds a number.
    pub fn push(&mut self, key: &str, value: Option<f64>) {
        self.0.push((key.to_owned(), value.map_or(Value::Null, Value::from)));
    }

    /// Adds a value of a column: a count without decimals, yes or no as `true` or `false`.
    pub fn push_of(&mut self, column: &Column, key: &str, value: Option<f64>) {
        let value = value.map_or(Value::Null, |value| match column {
            Column { is_flag: true, .. } => Value::from(value >= 0.5),
            Column { is_count: true, .. } => Value::from(value as u64),
            _ => Value::from(value),
        });
        self.0.push((key.to_owned(), value));
    }

    /// A number by its key; `None` if it is not there or not defined.
    pub fn get(&self, key: &str) -> Option<f64> {
        number(&self.0.iter().find(|(name, _)| name == key)?.1)
    }

    /// Changes a number, or adds it.
    pub fn set(&mut self, key: &str, value: Option<f64>) {
        self.0.retain(|(name, _)| name != key);
        self.push(key, value);
    }
}

/// The order is for people: it decides nothing.
impl PartialEq for Numbers {
    fn eq(&self, other: &Self) -> bool {
        let sorted = |numbers: &Self| numbers.0.iter().cloned().collect::<BTreeMap<_, _>>();
        sorted(self) == sorted(other)
    }
}

impl Serialize for Numbers {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        self.0.iter().try_for_each(|(key, value)| map.serialize_entry(key, value))?;
        map.end()
    }
}

/// Takes numbers and nulls; what else there is belongs to another version of csat.
impl<'de> Deserialize<'de> for Numbers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Numbers;

            fn expecting(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                formatter.write_str("numbers by key")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Numbers, A::Error> {
                let mut numbers = Numbers::default();
                while let Some((key, value)) = map.next_entry::<String, Value>()? {
                    if value.is_number() || value.is_null() || value.is_boolean() {
                        numbers.0.push((key, value));
                    }
                }
                Ok(numbers)
            }
        }
        deserializer.deserialize_map(Reader)
    }
}

/// A value of a summary as a number: yes is 1, no is 0.
pub fn number(value: &Value) -> Option<f64> {
    value.as_f64().or_else(|| value.as_bool().map(|yes| f64::from(u8::from(yes))))
}

/// A value with its unit, for people: a count of targets as a share of all.
pub fn in_words(column: &Column, value: Option<f64>, targets: u16) -> String {
    match (value, column.unit) {
        (None, _) => "-".to_owned(),
        (Some(value), _) if column.is_flag => (if value >= 0.5 { "yes" } else { "no" }).to_owned(),
        (Some(value), "") if column.is_count => short(value),
        (Some(value), "") => format!("{value:.3}"),
        (Some(value), "targets") => format!("{}/{targets}", short(value)),
        (Some(value), unit) if column.is_count => format!("{} {unit}", short(value)),
        (Some(value), unit) => format!("{value:.2} {unit}"),
    }
}

/// A count, or a mean of counts.
fn short(value: f64) -> String {
    if value.fract() == 0.0 { format!("{value}") } else { format!("{value:.2}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_order_and_what_is_not_defined_is_null() {
        let mut numbers = Numbers::default();
        numbers.push_of(&Column::of_fleet("z", "z", "").count(), "z", Some(8.0));
        numbers.push_of(&Column::of_agent("y", "y", "").flag(), "y", Some(1.0));
        numbers.push("a", Some(1.5));
        numbers.push("m", None);
        let text = serde_json::to_string(&numbers).unwrap();
        assert_eq!(text, r#"{"z":8,"y":true,"a":1.5,"m":null}"#);
        let back: Numbers = serde_json::from_str(&text).unwrap();
        assert_eq!(back.get("y"), Some(1.0));
        assert_eq!((back.get("z"), back.get("m"), back.get("none")), (Some(8.0), None, None));
        assert_eq!(back, numbers);
        let other: Numbers = serde_json::from_str(r#"{"a":1,"b":"text","c":[1]}"#).unwrap();
        assert_eq!(other.get("a"), Some(1.0));
    }
}
