//! Serde's errors in the words of an author of scenarios.

use super::mission::tables_of;
use super::missions;
use super::mistake::{Mistake, did_you_mean};
use super::read::Form;
use super::source::Site;
use super::tree::{self, Node, Table};
use super::unit::Unit;
use super::validate;

/// What deserialising one unit came to.
#[derive(Debug, Default)]
pub struct Failure {
    /// Serde's message.
    pub message: String,
    /// The key inside the unit that is to blame, when the unit is a table.
    pub culprit: Option<String>,
    /// Where the element to blame is in the value, if that is a list.
    pub indexes: Vec<usize>,
    /// Keys that a table of this model must have and does not.
    pub missing: Vec<String>,
}

/// The place and the text of the mistake in `unit`; `is_own` tells whether it is in one of the mission's own
/// tables.
pub fn explain(
    tree: &Table,
    defaults: &toml::Table,
    unit: &Unit<'_>,
    failure: &Failure,
    is_own: bool,
) -> (Site, Mistake) {
    let message = failure.message.as_str();
    let named = quoted(message).next().unwrap_or_default();
    if message.starts_with("unknown field") {
        return unknown_key(tree, defaults, unit, named, message);
    }
    let culprit = failure.culprit.as_deref();
    let inner = culprit.and_then(|key| unit.node.child(key));
    let mut node = inner.unwrap_or(unit.node);
    let mut path = unit.name();
    if let (Some(key), Some(_)) = (culprit, inner) {
        path = format!("{path}.{key}");
    }
    for index in &failure.indexes {
        if let Some(element) = node.element(*index) {
            (node, path) = (element, format!("{path}[{index}]"));
        }
    }
    if message.starts_with("unknown variant") {
        return unknown_variant(unit, node, &path, named, message);
    }
    if !failure.missing.is_empty() {
        let keys: Vec<String> = failure.missing.iter().map(|key| format!("`{key}`")).collect();
        let plural = if keys.len() == 1 { "" } else { "s" };
        let text = format!("`{path}` lacks the key{plural} {}", keys.join(", "));
        return (node.value.clone(), Mistake::new(text));
    }
    let (what, expected) = match message.rsplit_once(", expected ") {
        Some((what, expected)) => (what, Some(plain_type(expected))),
        None => (message, None),
    };
    let what = what.strip_prefix("invalid type: ").unwrap_or(what);
    let what = what.strip_prefix("invalid value: ").unwrap_or(what);
    let what = match what {
        "map" => "a table".to_owned(),
        "sequence" => "a list".to_owned(),
        other => match other.strip_prefix("invalid length ") {
            Some(length) => format!("a list of {length}"),
            None => plain_value(other),
        },
    };
    let whole = validate::whole_number(&path).filter(|_| !is_own);
    let expected = whole.map(str::to_owned).or(expected);
    let expected = match path.rsplit('.').next() {
        Some("loss") if path.starts_with("netem.") && !path.contains("jammer") => {
            Some(LOSS.to_owned())
        }
        Some("delay") if path.starts_with("netem.") => Some(DELAY.to_owned()),
        _ => expected,
    };
    let expected = match (what.as_str(), expected.as_deref()) {
        ("a table", Some("a list")) => {
            Some(format!("a list of tables, `{path} = [{{ … }}]` or `[[{path}]]`"))
        }
        _ => expected,
    };
    let mut mistake = Mistake::new(format!("`{path}` cannot be {what}"));
    if let Some(expected) = expected {
        mistake = mistake.expected(expected);
    }
    (node.value.clone(), mistake)
}

const LOSS: &str = "a table such as `{ model = \"iid\", p = 0.3 }`, or a number, the probability that \
                    a message is lost";
const DELAY: &str =
    "a table such as `{ model = \"constant\", mean_s = 0.5 }`, or a number, seconds";

fn unknown_key(
    tree: &Table,
    defaults: &toml::Table,
    unit: &Unit<'_>,
    named: &str,
    message: &str,
) -> (Site, Mistake) {
    // The first key on the way that the defaults do not know; else one inside the unit.
    let depth = (0..unit.path.len())
        .find(|&i| unit.path[i] == named && !has_path(defaults, &unit.path[..=i]));
    let way = &unit.path[..depth.unwrap_or(unit.path.len())];
    let path = [way, &[named.to_owned()]].concat();
    let node = match depth {
        Some(_) => tree::exact(tree, &path.join(".")),
        None => unit.node.find_key(named),
    };
    let site = node.unwrap_or(unit.node).key.clone();
    let table = way.join(".");
    let table = if table.is_empty() { "a scenario".to_owned() } else { format!("[{table}]") };
    let mut candidates: Vec<&str> = quoted(message).skip(1).collect();
    candidates.dedup();
    let mut mistake = Mistake::new(format!("unknown key `{named}` in {table}"));
    if !candidates.is_empty() {
        mistake = mistake.expected(one_of(&candidates));
    }
    let guess = || did_you_mean(named, candidates);
    if let Some(help) = of_another_mission(defaults, &path).or_else(guess) {
        mistake = mistake.help(help);
    }
    (site, mistake)
}

/// Which other mission than that of `defaults` has a key in a table of this name.
fn of_another_mission(defaults: &toml::Table, path: &[String]) -> Option<String> {
    let own = defaults.get("mission").and_then(toml::Value::as_str);
    let mut others = missions::all().iter().filter(|mission| Some(mission.kind().name) != own);
    let other = others.find(|mission| {
        tables_of(**mission).contains(&path[0])
            && has_path(&Form { mission: **mission }.defaults(), path)
    })?;
    Some(format!("`{}` belongs to the mission `{}`", path.join("."), other.kind().name))
}

fn unknown_variant(
    unit: &Unit<'_>,
    node: &Node,
    path: &str,
    named: &str,
    message: &str,
) -> (Site, Mistake) {
    let candidates: Vec<&str> = quoted(message).skip(1).collect();
    let inner = unit.node.find_key("model").filter(|n| n.to_value().as_str() == Some(named));
    let path = if inner.is_some() { format!("{path}.model") } else { path.to_owned() };
    let mut mistake = Mistake::new(format!("`{path}` cannot be `{named}`"));
    mistake = mistake.expected(one_of(&candidates));
    if let Some(guess) = did_you_mean(named, candidates) {
        mistake = mistake.help(guess);
    }
    (inner.unwrap_or(node).value.clone(), mistake)
}

fn has_path(table: &toml::Table, path: &[String]) -> bool {
    let Some((key, rest)) = path.split_first() else { return true };
    match table.get(key) {
        None => false,
        Some(_) if rest.is_empty() => true,
        Some(value) => value.as_table().is_some_and(|inner| has_path(inner, rest)),
    }
}

/// The texts between backquotes.
fn quoted(message: &str) -> impl Iterator<Item = &str> {
    message.split('`').skip(1).step_by(2)
}

fn one_of(candidates: &[&str]) -> String {
    let list: Vec<String> = candidates.iter().map(|c| format!("`{c}`")).collect();
    match list.as_slice() {
        [only] => only.clone(),
        list => format!("one of {}", list.join(", ")),
    }
}

/// A value as it was written: serde says `integer `-1`` and `string "x"`.
fn plain_value(got: &str) -> String {
    let bare = ["integer ", "floating point ", "boolean "].iter();
    match bare.filter_map(|kind| got.strip_prefix(kind)).next() {
        Some(value) => value.trim_matches('`').to_owned(),
        None => got.strip_prefix("string ").unwrap_or(got).to_owned(),
    }
}

/// What a message of serde says that it expected, in words for people; the choices of an enumeration
/// as they are.
pub fn expected_type(message: &str) -> Option<String> {
    let (what, expected) = message.rsplit_once(", expected ")?;
    if what.starts_with("unknown variant") {
        return Some(expected.replace('`', ""));
    }
    Some(plain_type(expected).replace('`', ""))
}

/// What a Rust type is called by those who do not write Rust.
fn plain_type(expected: &str) -> String {
    match expected {
        "u8" => "a whole number from 0 to 255".to_owned(),
        "u16" => "a whole number from 0 to 65535".to_owned(),
        "u32" => "a whole number from 0 to 4294967295".to_owned(),
        "u64" | "usize" => "a whole number from 0 to 9223372036854775807".to_owned(),
        "f64" => "a number".to_owned(),
        "a string" => "a text in quotes".to_owned(),
        "a boolean" => "`true` or `false`".to_owned(),
        "a sequence" => "a list".to_owned(),
        "fewer elements in array" => "fewer values".to_owned(),
        other => match other.strip_prefix("an array of length ") {
            Some(length) => format!("a list of {length} values"),
            None if other.starts_with("struct ") || other.starts_with("internally tagged") => {
                "a table".to_owned()
            }
            None => other.to_owned(),
        },
    }
}
