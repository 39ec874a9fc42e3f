//! `loss = 0.3` and `delay = 0.5`: a number in place of a model.

use super::source::Site;
use super::tree::{Kind, Node, Table};

/// What a number means for a key of a radio: the model and its parameter.
const MEANINGS: [(&str, &str, &str); 2] = [("loss", "iid", "p"), ("delay", "constant", "mean_s")];

/// Puts the model in place of each such number, at the number's own place.
pub fn expand(table: &mut Table) {
    let Some(Node { kind: Kind::Table(netem), .. }) = table.get_mut("netem") else { return };
    for radio in netem.values_mut() {
        let Kind::Table(radio) = &mut radio.kind else { continue };
        for (key, model, parameter) in MEANINGS {
            if let Some(node) = radio.get_mut(key)
                && let Kind::Leaf(value @ (toml::Value::Integer(_) | toml::Value::Float(_))) =
                    &node.kind
            {
                let at = |value| leaf(&node.value, value);
                let model = at(toml::Value::String(model.to_owned()));
                let entries = [("model", model), (parameter, at(value.clone()))];
                node.kind = Kind::Table(entries.map(|(key, n)| (key.to_owned(), n)).into());
            }
        }
    }
}

fn leaf(site: &Site, value: toml::Value) -> Node {
    Node { key: site.clone(), value: site.clone(), kind: Kind::Leaf(value) }
}
