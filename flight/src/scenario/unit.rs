//! The values of a scenario that are judged each on its own.

use super::model::Scenario;
use super::tree::{self, Kind, Node, Table};

/// The default scenario as plain TOML.
pub fn default_table() -> toml::Table {
    toml::Table::try_from(Scenario::default()).expect("the default scenario is TOML")
}

/// A value that is judged on its own: a leaf, an array, a table that names its `model`, or one
/// table of an array of tables.
#[derive(Debug)]
pub struct Unit<'a> {
    /// The keys on the way.
    pub path: Vec<String>,
    /// Where it is written.
    pub node: &'a Node,
    /// What takes the default's place.
    pub value: toml::Value,
    /// Whether the default's entries are dropped first.
    pub(super) replaces: bool,
    /// Its index if it is one element of an array, to be appended when accepted.
    pub(super) element: Option<usize>,
}

impl Unit<'_> {
    /// Its path, such as `agents.count` or `netem.outage[1]`.
    pub fn name(&self) -> String {
        let index = self.element.map(|index| format!("[{index}]")).unwrap_or_default();
        self.path.join(".") + &index
    }
}

/// The units of a table.
pub(super) fn collect<'a>(
    table: &'a Table,
    defaults: &toml::Table,
    path: &mut Vec<String>,
    units: &mut Vec<Unit<'a>>,
) {
    for (key, node) in table {
        path.push(key.clone());
        let default = defaults.get(key);
        let unit =
            |value, replaces, element| Unit { path: path.clone(), node, value, replaces, element };
        match &node.kind {
            Kind::Table(inner) if is_tagged(inner, default) => {
                units.push(unit(toml::Value::Table(tagged(inner, default)), true, None));
            }
            Kind::Table(inner)
                if !inner.is_empty() && !default.is_some_and(toml::Value::is_array) =>
            {
                let empty = toml::Table::new();
                let below = default.and_then(toml::Value::as_table).unwrap_or(&empty);
                collect(inner, below, path, units);
            }
            Kind::Array(elements)
                if !elements.is_empty()
                    && elements.iter().all(|e| matches!(e.kind, Kind::Table(_))) =>
            {
                for (index, element) in elements.iter().enumerate() {
                    let value = toml::Value::Array(vec![element.to_value()]);
                    units.push(Unit { node: element, ..unit(value, true, Some(index)) });
                }
            }
            _ => units.push(unit(node.to_value(), false, None)),
        }
        path.pop();
    }
}

fn is_tagged(table: &Table, default: Option<&toml::Value>) -> bool {
    table.contains_key("model") || default.is_some_and(|d| d.get("model").is_some())
}

/// A table that names its model, with what it does not say taken from a default of that model.
fn tagged(table: &Table, default: Option<&toml::Value>) -> toml::Table {
    let own = tree::to_toml(table);
    let Some(default) = default.and_then(toml::Value::as_table) else { return own };
    if own.get("model").is_some_and(|model| default.get("model") != Some(model)) {
        return own;
    }
    let mut all = default.clone();
    all.extend(own);
    all
}
