//! What distinguishes two scenarios, key by key.

use std::collections::BTreeMap;

use serde::Serialize;

/// A key whose values differ.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// Its dotted name, such as `netem.outage[1].agent`.
    pub key: String,
    /// Its value in the first scenario, in TOML; `None` where that has no such key.
    pub a: Option<String>,
    /// Its value in the second one.
    pub b: Option<String>,
}

/// The keys in which two scenarios in full (TOML) differ, in the order of the alphabet. A text that is no
/// TOML has no keys.
pub fn differences(a: &str, b: &str) -> Vec<Difference> {
    let [a, mut b] = [a, b].map(flat);
    let mut all: Vec<Difference> = Vec::new();
    for (key, value) in a {
        let there = b.remove(&key);
        all.push(Difference { key, a: Some(value), b: there });
    }
    all.extend(b.into_iter().map(|(key, value)| Difference { key, a: None, b: Some(value) }));
    all.retain(|difference| difference.a != difference.b);
    all.sort_by(|x, y| x.key.cmp(&y.key));
    all
}

/// Whether `key` is `outer` or a part of it.
pub fn is_within(key: &str, outer: &str) -> bool {
    key.strip_prefix(outer).is_some_and(|rest| rest.is_empty() || rest.starts_with(['.', '[']))
}

/// Every value by its dotted key.
fn flat(text: &str) -> BTreeMap<String, String> {
    let mut into = BTreeMap::new();
    let table: toml::Table = toml::from_str(text).unwrap_or_default();
    table.iter().for_each(|(key, value)| flatten(key, value, &mut into));
    into
}

fn flatten(key: &str, value: &toml::Value, into: &mut BTreeMap<String, String>) {
    let is_list_of_tables = |values: &[toml::Value]| values.iter().any(toml::Value::is_table);
    match value {
        toml::Value::Table(table) => {
            table.iter().for_each(|(name, value)| flatten(&format!("{key}.{name}"), value, into));
        }
        toml::Value::Array(values) if is_list_of_tables(values) => {
            values.iter().enumerate().for_each(|(i, v)| flatten(&format!("{key}[{i}]"), v, into));
        }
        value => {
            into.insert(key.to_owned(), value.to_string());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_compared_one_by_one() {
        let a = "x = 1\nsame = [1, 2]\n[t]\nword = 'a'\n[[t.list]]\nn = 1\n[[t.list]]\nn = 2\n";
        let b = "x = 1.5\nsame = [1, 2]\nnew = true\n[t]\nword = 'a'\n[[t.list]]\nn = 3\n";
        let lines: Vec<String> =
            differences(a, b).iter().map(|d| format!("{} {:?} {:?}", d.key, d.a, d.b)).collect();
        assert_eq!(
            lines,
            [
                "new None Some(\"true\")",
                "t.list[0].n Some(\"1\") Some(\"3\")",
                "t.list[1].n Some(\"2\") None",
                "x Some(\"1\") Some(\"1.5\")",
            ]
        );
        assert_eq!(differences(a, a), []);
    }

    #[test]
    fn parts_of_a_key_are_within_it() {
        for (key, outer) in [("a.b", "a"), ("a.b", "a.b"), ("a[1].b", "a")] {
            assert!(is_within(key, outer), "{key}");
        }
        assert!(!is_within("ab", "a") && !is_within("a", "a.b"));
    }
}
