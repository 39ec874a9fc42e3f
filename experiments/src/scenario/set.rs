//! `--set key=value`: one assignment in TOML, quotes optional around plain words.

use super::mistake::Mistake;
use super::source::{Site, Source, Sources};
use super::tree::{self, Kind, Node, Table};

/// Parses one `--set` argument. Paths in it start from the current folder.
pub fn parse(sources: &mut Sources, argument: &str, mistakes: &mut Vec<Mistake>) -> Table {
    let source = sources.push(Source {
        name: "--set".to_owned(),
        text: argument.to_owned(),
        is_file: false,
        folder: Some(std::path::PathBuf::from(".")),
    });
    let whole = Site { source, span: 0..argument.len() };
    let refuse = |message: &str, sources: &Sources| {
        Mistake::new(message)
            .at(Some(sources.place(&whole)))
            .expected("`key=value`, such as `agents.count=6`")
    };
    let Some(equals) = argument.find('=').filter(|_| !argument.contains(['\n', '\r'])) else {
        mistakes.push(refuse("this is not an assignment", sources));
        return Table::new();
    };
    let mut errors = Vec::new();
    let table = tree::parse(sources, source, &mut errors);
    if errors.is_empty() {
        return table;
    }
    let (key, value) = (&argument[..equals], argument[equals + 1..].trim());
    if !is_bare_word(value) {
        mistakes.append(&mut errors);
        return Table::new();
    }
    // The same document with the word's place taken by a value that is TOML.
    let mut scratch = Sources::default();
    scratch.push(Source {
        name: String::new(),
        text: format!("{key}=0"),
        is_file: false,
        folder: None,
    });
    let mut key_errors = Vec::new();
    let mut table = tree::parse(&scratch, 0, &mut key_errors);
    if !key_errors.is_empty() {
        mistakes.push(refuse("this key is not TOML", sources));
        return Table::new();
    }
    let start = equals + 1 + argument[equals + 1..].find(value).unwrap_or(0);
    let site = Site { source, span: start..start + value.len() };
    relocate(&mut table, source, &site, value);
    table
}

/// A value that TOML does not know and that can only be meant as text.
fn is_bare_word(value: &str) -> bool {
    value.starts_with(|c: char| c.is_alphabetic() || "_./~".contains(c))
        && !value.contains(['"', '\'', '#', '[', ']', '{', '}', ',', '='])
}

/// Puts the word where the stand-in is and moves all sites to the argument's own source.
fn relocate(table: &mut Table, source: usize, value_site: &Site, word: &str) {
    for Node { key, value, kind } in table.values_mut() {
        key.source = source;
        value.source = source;
        match kind {
            Kind::Table(inner) => relocate(inner, source, value_site, word),
            _ => {
                *value = value_site.clone();
                *kind = Kind::Leaf(toml::Value::String(word.to_owned()));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(argument: &str) -> Result<toml::Value, Vec<String>> {
        let (mut sources, mut mistakes) = (Sources::default(), Vec::new());
        let table = parse(&mut sources, argument, &mut mistakes);
        if !mistakes.is_empty() {
            return Err(mistakes.iter().map(ToString::to_string).collect());
        }
        Ok(tree::exact(&table, "a.b").expect("the key").to_value())
    }

    #[test]
    fn values_are_toml_or_plain_words() {
        assert_eq!(value("a.b=6").unwrap(), toml::Value::Integer(6));
        assert_eq!(value("a.b=inf").unwrap(), toml::Value::Float(f64::INFINITY));
        assert_eq!(value("a.b = 1e-5").unwrap(), toml::Value::Float(1e-5));
        for text in ["other.geojson", "facts+repair", "none", "../my maps/x.geojson", "/tmp/x"] {
            let expected = toml::Value::String(text.to_owned());
            assert_eq!(value(&format!("a.b={text}")).unwrap(), expected);
            assert_eq!(value(&format!("a.b='{text}'")).unwrap(), expected);
        }
        assert!(value("a.b=[1, 2]").unwrap().is_array());
        assert!(value("a.b={model='iid',p=0.1}").unwrap().is_table());
    }

    #[test]
    fn what_is_no_assignment_is_shown() {
        assert_eq!(
            value("a.b").unwrap_err(),
            ["error: this is not an assignment\n --> --set\n |\n | a.b\n | ^^^\n \
              = expected `key=value`, such as `agents.count=6`\n"]
        );
        assert!(value("a b=word").unwrap_err()[0].contains("this key is not TOML"));
        assert!(value("a.b=[1,").unwrap_err()[0].contains("not TOML"));
        assert!(value("a.b=1\nc=2").unwrap_err()[0].contains("not an assignment"));
        assert!(value("=5").is_err());
    }
}
