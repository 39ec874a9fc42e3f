//! How much is said on which keys.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;
use serde_json::{Value, json};

/// How many keys are counted by themselves.
const MAX_KEYS: usize = 10_000;
/// Where the rest is counted.
const OTHERS: &str = "(other keys)";

/// Messages and their bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Traffic {
    /// How many.
    pub messages: u64,
    /// How long all their bodies are.
    pub bytes: u64,
}

impl Traffic {
    /// One more message.
    pub fn add(&mut self, bytes: usize) {
        *self += Self { messages: 1, bytes: bytes as u64 };
    }

    /// Both per second.
    pub fn per_second(self, seconds: f64) -> (f64, f64) {
        (self.messages as f64 / seconds, self.bytes as f64 / seconds)
    }
}

impl std::ops::AddAssign for Traffic {
    fn add_assign(&mut self, other: Self) {
        self.messages += other.messages;
        self.bytes += other.bytes;
    }
}

impl std::iter::Sum for Traffic {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), |mut sum, one| {
            sum += one;
            sum
        })
    }
}

/// What was said, by key, in all and lately.
#[derive(Debug, Default)]
pub struct Rates {
    total: BTreeMap<String, Traffic>,
    lately: BTreeMap<String, Traffic>,
}

impl Rates {
    /// One more message.
    pub fn add(&mut self, key: &str, bytes: usize) {
        let is_known = self.total.contains_key(key);
        let key = if is_known || self.total.len() < MAX_KEYS { key } else { OTHERS };
        for counts in [&mut self.total, &mut self.lately] {
            match counts.get_mut(key) {
                Some(count) => count.add(bytes),
                None => counts.entry(key.to_owned()).or_default().add(bytes),
            }
        }
    }

    /// What was said since this was last asked, which took so long; keys that were silent say 0.
    pub fn take_lately(&mut self) -> BTreeMap<String, Traffic> {
        let silent = self.total.keys().map(|key| (key.clone(), Traffic::default()));
        let mut lately: BTreeMap<_, _> = silent.collect();
        lately.append(&mut self.lately);
        lately
    }

    /// What was said in all.
    pub fn total(&self) -> &BTreeMap<String, Traffic> {
        &self.total
    }
}

/// A table of rates with at most so many keys, the busiest ones, and their sum.
pub fn table(counts: &BTreeMap<String, Traffic>, seconds: f64, max_rows: usize) -> String {
    let mut text = format!("{:>12}  {:>12}  key\n", "messages/s", "bytes/s");
    let mut row = |traffic: Traffic, key: &str| {
        let (messages, bytes) = traffic.per_second(seconds);
        let _ = writeln!(text, "{messages:>12.1}  {:>12}  {key}", size(bytes));
    };
    let mut rows: Vec<_> = counts.iter().collect();
    rows.sort_by_key(|(key, traffic)| (std::cmp::Reverse(traffic.bytes), *key));
    rows.truncate(max_rows);
    rows.sort_by_key(|(key, _)| *key);
    for (key, traffic) in &rows {
        row(**traffic, &key.replace(char::is_control, " "));
    }
    let hidden = counts.len() - rows.len();
    let hidden = if hidden == 0 { String::new() } else { format!(", {hidden} of them not shown") };
    let keys = if counts.len() == 1 { "key" } else { "keys" };
    row(counts.values().copied().sum(), &format!("= {} {keys}{hidden}", counts.len()));
    text
}

/// The same as JSON.
pub fn table_json(counts: &BTreeMap<String, Traffic>, seconds: f64) -> Value {
    let row = |traffic: Traffic| {
        let (messages, bytes) = traffic.per_second(seconds);
        json!({ "messages_per_s": messages, "bytes_per_s": bytes })
    };
    let keys: BTreeMap<_, _> = counts.iter().map(|(key, traffic)| (key, row(*traffic))).collect();
    let sum: Traffic = counts.values().copied().sum();
    json!({ "seconds": seconds, "keys": keys, "sum": row(sum) })
}

/// A number of bytes for people.
pub fn size(bytes: f64) -> String {
    match bytes {
        b if b < 1e3 => format!("{b:.0} B"),
        b if b < 1e6 => format!("{:.1} kB", b / 1e3),
        b => format!("{:.1} MB", b / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_those_since_the_last_table() {
        let mut rates = Rates::default();
        rates.add("b", 1000);
        rates.add("a", 10);
        rates.add("a", 20);
        let first = rates.take_lately();
        assert_eq!(
            table(&first, 2.0, 9),
            "  messages/s       bytes/s  key\n         1.0          15 B  a\n         0.5         \
             500 B  b\n         1.5         515 B  = 2 keys\n"
        );
        rates.add("b", 5);
        let next = rates.take_lately();
        assert_eq!((next["a"].messages, next["b"].bytes), (0, 5));
        assert_eq!(rates.total()["b"], Traffic { messages: 2, bytes: 1005 });
    }

    #[test]
    fn a_short_table_shows_the_busiest_keys_and_says_so() {
        let mut rates = Rates::default();
        (1..=5).for_each(|i| rates.add(&format!("k{i}"), 3_000_000 * i));
        let text = table(rates.total(), 1.0, 2);
        assert!(!text.contains("k3") && text.contains("12.0 MB  k4\n"), "{text}");
        assert!(text.ends_with("45.0 MB  = 5 keys, 3 of them not shown\n"), "{text}");
        let json = table_json(rates.total(), 2.0);
        assert_eq!(json["keys"]["k1"], json!({"messages_per_s": 0.5, "bytes_per_s": 1.5e6}));
        assert_eq!(json["sum"]["messages_per_s"], 2.5);
    }

    #[test]
    fn too_many_keys_are_counted_together() {
        let mut rates = Rates::default();
        (0..MAX_KEYS + 3).for_each(|i| rates.add(&i.to_string(), 1));
        assert_eq!(rates.total()[OTHERS].messages, 3);
        assert_eq!(size(1234.0), "1.2 kB");
    }
}
