//! A parsed scenario in which every key and value remembers where it was written.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::IntoDeserializer;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::mistake::Mistake;
use super::source::{Site, Sources};

/// A value and its places.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// Where its key stands; for an element of an array, where the element stands.
    pub key: Site,
    /// Where its value stands.
    pub value: Site,
    /// The value.
    pub kind: Kind,
}

/// What a [`Node`] holds.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// A number, text, truth value or date.
    Leaf(toml::Value),
    /// The elements of an array.
    Array(Vec<Node>),
    /// The entries of a table.
    Table(Table),
}

/// A table of nodes.
pub type Table = BTreeMap<String, Node>;

/// Parses a TOML document; every syntax error becomes a mistake and the rest is kept.
pub fn parse(sources: &Sources, source: usize, mistakes: &mut Vec<Mistake>) -> Table {
    let (table, errors) = DeTable::parse_recoverable(&sources.get(source).text);
    for error in errors {
        let span = error.span().unwrap_or(0..0);
        let place = sources.place(&Site { source, span });
        mistakes.push(Mistake::new(format!("not TOML: {}", error.message())).at(Some(place)));
    }
    table_of(source, table.into_inner())
}

fn table_of(source: usize, table: DeTable<'_>) -> Table {
    table
        .into_iter()
        .map(|(key, value)| {
            let site = Site { source, span: key.span() };
            (key.into_inner().into_owned(), node_of(site, source, value))
        })
        .collect()
}

fn node_of(key: Site, source: usize, value: Spanned<DeValue<'_>>) -> Node {
    let site = Site { source, span: value.span() };
    let kind = match value.into_inner() {
        DeValue::Table(table) => Kind::Table(table_of(source, table)),
        DeValue::Array(array) => Kind::Array(
            array
                .into_iter()
                .map(|v| node_of(Site { source, span: v.span() }, source, v))
                .collect(),
        ),
        // A number too large for 64 bits is kept as text: then its type is the mistake reported.
        leaf => Kind::Leaf(leaf_value(leaf)),
    };
    Node { key, value: site, kind }
}

fn leaf_value(leaf: DeValue<'_>) -> toml::Value {
    let text = match &leaf {
        DeValue::Integer(integer) => integer.as_str().to_owned(),
        DeValue::Float(float) => float.as_str().to_owned(),
        _ => String::new(),
    };
    toml::Value::deserialize(Spanned::new(0..0, leaf).into_deserializer())
        .unwrap_or(toml::Value::String(text))
}

impl Node {
    /// The plain TOML value.
    pub fn to_value(&self) -> toml::Value {
        match &self.kind {
            Kind::Leaf(value) => value.clone(),
            Kind::Array(nodes) => toml::Value::Array(nodes.iter().map(Node::to_value).collect()),
            Kind::Table(table) => toml::Value::Table(to_toml(table)),
        }
    }

    /// The entry `key`, looking into the only element of an array on the way.
    pub fn child(&self, key: &str) -> Option<&Node> {
        match &self.kind {
            Kind::Table(table) => table.get(key),
            Kind::Array(nodes) => nodes.iter().find_map(|n| n.child(key)),
            Kind::Leaf(_) => None,
        }
    }

    fn part(&self, part: Part<'_>) -> Option<&Node> {
        match part {
            Part::Key(key) => self.child(key),
            Part::Index(index) => self.element(index),
        }
    }

    /// The element of an array.
    pub fn element(&self, index: usize) -> Option<&Node> {
        match &self.kind {
            Kind::Array(nodes) => nodes.get(index),
            _ => None,
        }
    }

    /// Any node below with this key.
    pub fn find_key(&self, key: &str) -> Option<&Node> {
        self.child(key).or_else(|| match &self.kind {
            Kind::Table(table) => table.values().find_map(|n| n.find_key(key)),
            Kind::Array(nodes) => nodes.iter().find_map(|n| n.find_key(key)),
            Kind::Leaf(_) => None,
        })
    }
}

/// The plain TOML table.
pub fn to_toml(table: &Table) -> toml::Table {
    table.iter().map(|(key, node)| (key.clone(), node.to_value())).collect()
}

/// Lays `over` on `base`: tables entry by entry, everything else replaced. A table that says which
/// `model` it is replaces one of another model, whose parameters mean nothing to it.
pub fn merge(base: &mut Table, over: Table) {
    for (key, node) in over {
        match (base.get_mut(&key), node) {
            (
                Some(Node { kind: Kind::Table(below), key: key_site, value }),
                Node { kind: Kind::Table(above), key: new_key, value: new_value },
            ) if !changes_model(below, &above) => {
                (*key_site, *value) = (new_key, new_value);
                merge(below, above);
            }
            (_, node) => {
                base.insert(key, node);
            }
        }
    }
}

fn changes_model(below: &Table, above: &Table) -> bool {
    match (below.get("model"), above.get("model")) {
        (Some(old), Some(new)) => old.to_value() != new.to_value(),
        _ => false,
    }
}

/// The deepest node on the way to a dotted path, such as `netem.outage[1].agent`.
pub fn deepest<'a>(table: &'a Table, path: &str) -> Option<&'a Node> {
    let mut parts = parts(path);
    let Part::Key(first) = parts.next()? else { return None };
    let mut node = table.get(first)?;
    for part in parts {
        match node.part(part) {
            Some(child) => node = child,
            None => break,
        }
    }
    Some(node)
}

/// The node at exactly a dotted path.
pub fn exact<'a>(table: &'a Table, path: &str) -> Option<&'a Node> {
    let mut parts = parts(path);
    let Part::Key(first) = parts.next()? else { return None };
    parts.try_fold(table.get(first)?, |node, part| node.part(part))
}

/// A step on a dotted path: a key, or the index of an element.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part<'a> {
    Key(&'a str),
    Index(usize),
}

/// `a.b[1][2].c` is a, b, 1, 2, c.
fn parts(path: &str) -> impl Iterator<Item = Part<'_>> {
    path.split('.').flat_map(|step| {
        let (key, indexes) = step.split_once('[').unwrap_or((step, ""));
        // What is no number is no element.
        let index =
            |text: &str| Part::Index(text.trim_end_matches(']').parse().unwrap_or(usize::MAX));
        let indexes = indexes.split('[').filter(|text| !text.is_empty()).map(index);
        std::iter::once(Part::Key(key)).chain(indexes.collect::<Vec<_>>())
    })
}

#[cfg(test)]
mod tests {
    use super::super::source::Source;
    use super::*;

    #[test]
    fn elements_of_arrays_have_paths() {
        let text = "[[a.b]]\nx = 1\n[[a.b]]\nx = 2\ny = [[3], [4, 5]]\n".to_owned();
        let mut sources = Sources::default();
        sources.push(Source { name: "x.toml".into(), text, is_file: true, folder: None });
        let table = parse(&sources, 0, &mut Vec::new());
        let value = |path: &str| exact(&table, path).map(|node| node.to_value().to_string());
        assert_eq!(value("a.b[0].x").as_deref(), Some("1"));
        assert_eq!(value("a.b[1].x").as_deref(), Some("2"));
        assert_eq!(value("a.b[1].y[1][1]").as_deref(), Some("5"));
        for nowhere in ["a.b[2].x", "a.b[0].y", "a.b[x].x", "a[0]", "[0]", "a.b[1].x[0]"] {
            assert_eq!(value(nowhere), None, "{nowhere}");
        }
        let line = |path: &str| sources.place(&deepest(&table, path).unwrap().value).line;
        assert_eq!([line("a.b[1].z"), line("a.b[1].y[1][7]"), line("a.b[0].x")], [3, 5, 2]);
    }
}
