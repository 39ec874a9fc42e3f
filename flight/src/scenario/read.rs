//! From a tree of nodes to a [`Scenario`], with every mistake of type or name found on its own.
//!
//! Serde stops at the first error. So every value that the user wrote is applied *alone* onto the
//! defaults and deserialised: each wrong one gives its own error, at its own place.

use serde::Deserialize;

use super::explain::{Failure, explain};
use super::missions::{self, Listed};
use super::mistake::Mistake;
use super::model::{OF_SET_MEMBERSHIP, SET_MEMBERSHIP, Scenario};
use super::source::{Site, Sources};
use super::tree::Table;
use super::unit::{Unit, collect, default_table};

/// Reads a scenario. Values with mistakes are left at their defaults, so that the rest can still
/// be judged.
pub fn read(
    sources: &Sources,
    tree: &Table,
    mission: &dyn Listed,
    mistakes: &mut Vec<Mistake>,
) -> Scenario {
    let form = Form { mission };
    let defaults = form.defaults();
    let mut units = Vec::new();
    collect(tree, &defaults, &mut Vec::new(), &mut units);
    let mut accepted = defaults.clone();
    let mut seen: Vec<(Site, String)> = Vec::new();
    let mut left_out: Vec<&[String]> = Vec::new();
    for unit in &units {
        let failures = judge(&form, &defaults, unit);
        if failures.is_empty() {
            apply_accepted(&mut accepted, unit);
        } else if unit.element.is_some() {
            left_out.push(&unit.path);
        }
        for failure in failures {
            let (site, mistake) = explain(tree, &defaults, unit, &failure, form.has(unit));
            // A table of an unknown name is one mistake, however much it holds.
            if !seen.iter().any(|(s, m)| *s == site && *m == mistake.message) {
                seen.push((site.clone(), mistake.message.clone()));
                mistakes.push(mistake.at(Some(sources.place(&site))));
            }
        }
    }
    // An array without one of its elements would have the others at wrong indexes.
    for path in left_out {
        if let Some(toml::Value::Array(elements)) = lookup_mut(&mut accepted, path) {
            elements.clear();
        }
    }
    form.scenario(accepted).unwrap_or_else(|error| {
        mistakes.push(Mistake::new(format!("these values do not fit together: {error}")));
        Scenario::default()
    })
}

impl Scenario {
    /// The inverse of [`Self::to_toml`]. It judges nothing but types and names.
    ///
    /// # Errors
    /// When the text is no scenario.
    pub fn from_toml(text: &str) -> Result<Self, toml::de::Error> {
        let mut table: toml::Table = toml::from_str(text)?;
        let mission = table.get("mission").and_then(toml::Value::as_str).unwrap_or_default();
        let known = missions::find(mission).map(Listed::tables).unwrap_or_default();
        let own = known.keys().filter_map(|key| table.remove_entry(key)).collect();
        Ok(Self { own, ..table.try_into()? })
    }
}

/// Everything wrong with one unit.
fn judge(form: &Form<'_>, defaults: &toml::Table, unit: &Unit<'_>) -> Vec<Failure> {
    if let Some(index) = list_for_a_table(form, defaults, unit) {
        let message = LIST_FOR_A_TABLE.to_owned();
        return vec![Failure { message, indexes: vec![index], ..Failure::default() }];
    }
    let mut failures = Vec::new();
    let mut value = unit.value.clone();
    while let Some(failure) = attempt(form, defaults, unit, &value) {
        if let Some(key) = missing(&failure) {
            // A key with a mistake was taken out: the table does not lack it.
            let is_judged = failures.iter().any(|f: &Failure| f.culprit.as_ref() == Some(&key));
            if !is_judged {
                let missing = all_missing(form, defaults, unit, &value, key);
                failures.push(Failure { missing, ..failure });
            }
            break;
        }
        // In a table that is judged as a whole, the key to blame is the one without which this
        // error is gone. Taken out, it lets the next error show.
        let without = |key: &str| {
            let mut rest = value.clone();
            let bad = entries(&mut rest)?.remove(key)?;
            Some((bad, rest))
        };
        let culprit = entries(&mut value.clone()).and_then(|table| {
            table.keys().filter(|key| *key != "model").find_map(|key| {
                let (bad, rest) = without(key)?;
                let next = attempt(form, defaults, unit, &rest);
                let changed = next.is_none_or(|n| n.message != failure.message);
                changed.then(|| (key.clone(), bad, rest))
            })
        });
        match culprit {
            Some((key, bad, rest)) => {
                let with = |part| {
                    let mut whole = value.clone();
                    entries(&mut whole)?.insert(key.clone(), part);
                    attempt(form, defaults, unit, &whole)
                };
                let failure = closer(failure, &bad, &with);
                failures.push(Failure { culprit: Some(key), ..failure });
                value = rest;
            }
            None => {
                let with = |part| attempt(form, defaults, unit, &part);
                failures.push(match unit.element {
                    Some(_) => failure,
                    None => closer(failure, &value, &with),
                });
                break;
            }
        }
    }
    failures
}

/// The failure of a value with the place in its lists that is to blame, and with the names that are known where serde
/// wanted a name; `with` tells what another value in its place fails with.
fn closer(
    mut failure: Failure,
    value: &toml::Value,
    with: &dyn Fn(toml::Value) -> Option<Failure>,
) -> Failure {
    let fails = |value| with(value).is_some_and(|other| other.message == failure.message);
    let mut indexes = indexes(value, &fails);
    if failure.message.starts_with("invalid length") {
        // It is the list that has this length, and not its last element.
        indexes.pop();
    }
    if let Some(length) = failure.message.strip_suffix("fewer elements in array")
        && indexes.is_empty()
        && let Some(none) = with(toml::Value::Array(Vec::new()))
        && let Some((_, expected)) = none.message.split_once(", expected ")
    {
        failure.message = format!("{length}{expected}");
    }
    // Serde lists the names only if there is text.
    let is_nameless = failure.message.contains("unit variant") && !value.is_str();
    let named = is_nameless.then(|| with(toml::Value::String(value.to_string()))).flatten();
    Failure { indexes, ..named.unwrap_or(failure) }
}

/// Where in a list, and in the lists in it, the element is that is to blame: lists that end with it fail in the same
/// way, and shorter ones do not.
fn indexes(value: &toml::Value, fails: &dyn Fn(toml::Value) -> bool) -> Vec<usize> {
    let toml::Value::Array(all) = value else { return Vec::new() };
    let first = |count: usize| toml::Value::Array(all[..count].to_vec());
    // Lists that hold the element fail, so the first one is found by halving.
    let (mut good, mut bad) = (0, all.len());
    while good < bad {
        let count = good.midpoint(bad);
        if fails(first(count)) { bad = count } else { good = count + 1 }
    }
    match bad {
        // Of the empty list it is the type that is wrong.
        0 => Vec::new(),
        count => {
            let inner = |element| {
                let mut list = all[..count - 1].to_vec();
                list.push(element);
                fails(toml::Value::Array(list))
            };
            [vec![count - 1], indexes(&all[count - 1], &inner)].concat()
        }
    }
}

/// What serde would say of a list in place of a table, if it did not take the elements for the fields, in their
/// order.
const LIST_FOR_A_TABLE: &str = "invalid type: sequence, expected a table";

/// The first list among the elements of a list of tables.
fn list_for_a_table(form: &Form<'_>, defaults: &toml::Table, unit: &Unit<'_>) -> Option<usize> {
    let index = unit.value.as_array()?.iter().position(toml::Value::is_array)?;
    let table = toml::Value::Array(vec![toml::Table::new().into()]);
    let takes_tables = match attempt(form, defaults, unit, &table) {
        Some(failure) => missing(&failure).is_some(),
        None => true,
    };
    takes_tables.then_some(index)
}

/// The key that serde misses.
fn missing(failure: &Failure) -> Option<String> {
    failure.message.strip_prefix("missing field `")?.strip_suffix('`').map(str::to_owned)
}

/// Every key that a table lacks: serde names the first one only, so that is given whatever value lets
/// serde get further.
fn all_missing(
    form: &Form<'_>,
    defaults: &toml::Table,
    unit: &Unit<'_>,
    value: &toml::Value,
    first: String,
) -> Vec<String> {
    let mut value = value.clone();
    let mut all = vec![first];
    while let Some(key) = all.last() {
        let zero = toml::Value::Float(0.0);
        let point = toml::Value::Array(vec![zero.clone(); 2]);
        let stand_ins = [zero, toml::Value::Integer(0), toml::Value::Array(Vec::new()), point];
        let next = stand_ins.into_iter().find_map(|stand_in| {
            let mut filled = value.clone();
            entries(&mut filled)?.insert(key.clone(), stand_in);
            let next = missing(&attempt(form, defaults, unit, &filled)?)?;
            Some((filled, next))
        });
        match next {
            Some((filled, next)) if !all.contains(&next) => {
                value = filled;
                all.push(next);
            }
            _ => break,
        }
    }
    all
}

/// The table of a unit that is one.
fn entries(value: &mut toml::Value) -> Option<&mut toml::Table> {
    match value {
        toml::Value::Table(table) => Some(table),
        toml::Value::Array(array) if array.len() == 1 => array[0].as_table_mut(),
        _ => None,
    }
}

fn attempt(
    form: &Form<'_>,
    defaults: &toml::Table,
    unit: &Unit<'_>,
    value: &toml::Value,
) -> Option<Failure> {
    let failure = |message| Some(Failure { message, ..Failure::default() });
    let is_table = lookup(defaults, &unit.path).is_some_and(toml::Value::is_table);
    if is_table && value.is_array() {
        return failure(LIST_FOR_A_TABLE.to_owned());
    }
    let mut candidate = defaults.clone();
    apply(&mut candidate, &unit.path, value.clone(), unit.replaces);
    let error = form.scenario(candidate).err()?;
    failure(form.in_its_names(error.message()))
}

/// What a scenario of a mission looks like: the fields that every scenario has, and the mission's own tables.
pub(super) struct Form<'a> {
    pub(super) mission: &'a dyn Listed,
}

impl Form<'_> {
    /// Whether a value is in one of the mission's own tables.
    fn has(&self, unit: &Unit<'_>) -> bool {
        unit.path.first().is_some_and(|key| self.mission.tables().contains_key(key))
    }

    /// The default scenario of the mission as plain TOML. Its own tables are there in place of others of the
    /// same name.
    pub(super) fn defaults(&self) -> toml::Table {
        let mut defaults = default_table();
        defaults.insert("mission".to_owned(), self.mission.kind().name.into());
        defaults.extend(self.mission.tables());
        defaults
    }

    /// A message of serde with the tables that a scenario of this mission has: serde lists those of every
    /// scenario.
    fn in_its_names(&self, message: &str) -> String {
        if !(message.starts_with("unknown field") && message.contains("`netem`")) {
            return message.to_owned();
        }
        let mut message = message.to_owned();
        if self.mission.kind().name != SET_MEMBERSHIP {
            OF_SET_MEMBERSHIP
                .iter()
                .for_each(|key| message = message.replace(&format!("`{key}`, "), ""));
        }
        let own = self.mission.tables();
        message + &own.keys().map(|key| format!(", `{key}`")).collect::<String>()
    }

    /// The scenario that a table is.
    pub(super) fn scenario(&self, mut table: toml::Table) -> Result<Scenario, toml::de::Error> {
        let names = self.mission.tables();
        let own: toml::Table = names.keys().filter_map(|key| table.remove_entry(key)).collect();
        self.mission.check_tables(own.clone())?;
        Ok(Scenario { own, ..Scenario::deserialize(toml::Value::Table(table))? })
    }
}

fn apply_accepted(accepted: &mut toml::Table, unit: &Unit<'_>) {
    if unit.element.is_some()
        && let Some(toml::Value::Array(present)) = lookup_mut(accepted, &unit.path)
        && let toml::Value::Array(new) = &unit.value
    {
        present.extend(new.iter().cloned());
        return;
    }
    apply(accepted, &unit.path, unit.value.clone(), unit.replaces);
}

fn lookup<'a>(table: &'a toml::Table, path: &[String]) -> Option<&'a toml::Value> {
    let (last, way) = path.split_last()?;
    way.iter().try_fold(table, |table, key| table.get(key)?.as_table())?.get(last)
}

fn lookup_mut<'a>(table: &'a mut toml::Table, path: &[String]) -> Option<&'a mut toml::Value> {
    let (last, way) = path.split_last()?;
    way.iter().try_fold(table, |table, key| table.get_mut(key)?.as_table_mut())?.get_mut(last)
}

fn apply(table: &mut toml::Table, path: &[String], value: toml::Value, replaces: bool) {
    let Some((key, rest)) = path.split_first() else { return };
    if rest.is_empty() {
        // An empty table says nothing about a table that has defaults.
        let keeps = !replaces
            && value.as_table().is_some_and(toml::Table::is_empty)
            && table.get(key).is_some_and(toml::Value::is_table);
        if !keeps {
            table.insert(key.clone(), value);
        }
        return;
    }
    let entry = table.entry(key.clone()).or_insert_with(|| toml::Value::Table(toml::Table::new()));
    if !entry.is_table() {
        *entry = toml::Value::Table(toml::Table::new());
    }
    if let toml::Value::Table(inner) = entry {
        apply(inner, rest, value, replaces);
    }
}
