//! `--set key=value`: one assignment in TOML, quotes optional around plain words, also in tables and
//! lists.

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
    let (key, value) = argument.split_at(equals + 1);
    if value.trim().is_empty() {
        let text = format!("`{}` has no value", key.trim_end_matches('=').trim());
        mistakes.push(refuse(&text, sources));
        return Table::new();
    }
    let quoted = Quoted::new(value);
    // The same document with quotes around plain words.
    let mut scratch = Sources::default();
    let scratch_source = |text| Source { name: String::new(), text, is_file: false, folder: None };
    scratch.push(scratch_source(format!("{key}{}", quoted.text)));
    let mut quoted_errors = Vec::new();
    let mut table = tree::parse(&scratch, 0, &mut quoted_errors);
    if quoted_errors.is_empty() {
        relocate(&mut table, source, &|at: usize| {
            if at <= key.len() { at } else { key.len() + quoted.origin(at - key.len()) }
        });
        return table;
    }
    let mut key_errors = Vec::new();
    let index = scratch.push(scratch_source(format!("{key}0")));
    tree::parse(&scratch, index, &mut key_errors);
    if !key_errors.is_empty() {
        mistakes.push(refuse("this key is not TOML", sources));
        return Table::new();
    }
    mistakes.extend(errors.into_iter().map(|error| match is_torn(value) {
        true => error.help(TORN),
        false => error,
    }));
    Table::new()
}

/// What to do about a shell that has taken a value apart.
const TORN: &str = "a shell splits {a,b} and takes quotes away: put the whole argument in single \
                    quotes, such as --set 'netem.radio.loss={model=\"iid\",p=0.3}'";

/// Whether a value looks like a piece of a table: `model=iid` is what is left of `{model=iid,p=0.3}`
/// once a shell has expanded the braces.
fn is_torn(value: &str) -> bool {
    let count = |mark: char| value.matches(mark).count();
    value.contains('=') || count('{') != count('}') || count('[') != count(']')
}

/// A value with quotes around its plain words, at the top and inside of tables and lists: a shell eats
/// those of `{model="iid",p=0.3}`.
struct Quoted {
    text: String,
    /// Where quotes were put in, bytes of `text`.
    added: Vec<usize>,
}

impl Quoted {
    fn new(value: &str) -> Self {
        let mut this = Self { text: String::new(), added: Vec::new() };
        let mut quote = None;
        let mut word = String::new();
        for c in value.chars() {
            let ends_word = quote.is_none() && "{}[],=".contains(c);
            if ends_word {
                // What stands before `=` is a key.
                this.push(&std::mem::take(&mut word), c != '=');
                this.text.push(c);
                continue;
            }
            word.push(c);
            quote = match quote {
                None if matches!(c, '"' | '\'') => Some(c),
                Some(mark) if mark == c => None,
                open => open,
            };
        }
        this.push(&word, true);
        this
    }

    fn push(&mut self, word: &str, is_value: bool) {
        let plain = word.trim();
        if !is_value || !is_plain_word(plain) {
            self.text += word;
            return;
        }
        let start = self.text.len() + word.find(plain).unwrap_or(0);
        self.text += &word.replacen(plain, &format!("'{plain}'"), 1);
        self.added.extend([start, start + plain.len() + 1]);
    }

    /// Where a byte of `text` stands in the value.
    fn origin(&self, at: usize) -> usize {
        at - self.added.iter().filter(|added| **added < at).count()
    }
}

/// The TOML value of a text, plain words taken as text as with `--set`; `None` when it is none.
pub fn value(text: &str) -> Option<toml::Value> {
    let parse = |text: &str| toml::from_str::<toml::Table>(&format!("x={text}")).ok()?.remove("x");
    parse(text).or_else(|| parse(&Quoted::new(text).text))
}

/// A word that TOML does not know and that can only be meant as text.
fn is_plain_word(word: &str) -> bool {
    word.starts_with(|c: char| c.is_alphabetic() || "_./~".contains(c))
        && !word.contains(['"', '\'', '#'])
        && toml::from_str::<toml::Table>(&format!("x={word}")).is_err()
}

/// Moves all sites to the argument's own source.
fn relocate(table: &mut Table, source: usize, origin: &impl Fn(usize) -> usize) {
    let moved = |site: &Site| Site { source, span: origin(site.span.start)..origin(site.span.end) };
    table.values_mut().for_each(|node| relocate_node(node, &moved));
}

fn relocate_node(node: &mut Node, moved: &impl Fn(&Site) -> Site) {
    (node.key, node.value) = (moved(&node.key), moved(&node.value));
    match &mut node.kind {
        Kind::Leaf(_) => {}
        Kind::Array(nodes) => nodes.iter_mut().for_each(|node| relocate_node(node, moved)),
        Kind::Table(table) => table.values_mut().for_each(|node| relocate_node(node, moved)),
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

    /// As with `--set "a.b={model="iid",p=0.1}"`, of which the shell eats the inner quotes.
    #[test]
    fn plain_words_need_no_quotes_in_tables_and_lists_either() {
        let table = value("a.b={model='iid',p=0.1}").unwrap();
        for text in ["{model=iid,p=0.1}", "{ model = iid , p = 0.1 }", "{model='iid',p=0.1}"] {
            assert_eq!(value(&format!("a.b={text}")).unwrap(), table);
            assert_eq!(super::value(text), Some(table.clone()));
        }
        let list = value("a.b=['x y',true,inf,\"a,b\",{c='d'}]").unwrap();
        assert_eq!(value("a.b=[x y, true, inf, \"a,b\", {c=d}]").unwrap(), list);
    }

    #[test]
    fn what_is_wrong_is_underlined_where_the_user_wrote_it() {
        let (mut sources, mut mistakes) = (Sources::default(), Vec::new());
        let argument = "a.b={model=iid, b=é,  p = many}";
        let table = parse(&mut sources, argument, &mut mistakes);
        let node = tree::exact(&table, "a.b.p").unwrap();
        assert_eq!(&argument[node.value.span.clone()], "many");
        assert_eq!(&argument[node.key.span.clone()], "p");
        let node = tree::exact(&table, "a.b").unwrap();
        assert_eq!(&argument[node.value.span.clone()], &argument[4..]);
        assert_eq!(mistakes, []);
    }

    #[test]
    fn what_a_shell_took_apart_is_explained() {
        for torn in ["a.b=model=iid", "a.b={model=\"iid\"", "a.b=[1"] {
            let errors = value(torn).unwrap_err();
            assert!(errors[0].contains("put the whole argument in single quotes"), "{errors:?}");
        }
        assert!(!value("a.b=2 3").unwrap_err()[0].contains("single quotes"));
    }

    #[test]
    fn what_is_no_assignment_is_shown() {
        assert_eq!(
            value("a.b").unwrap_err(),
            ["error: this is not an assignment\n --> --set\n |\n | a.b\n | ^^^\n \
              = expected `key=value`, such as `agents.count=6`\n"]
        );
        for empty in ["a.b=", "a.b = ", "a.b =\t"] {
            let said = &value(empty).unwrap_err()[0];
            assert!(said.starts_with("error: `a.b` has no value\n"), "{said}");
        }
        assert!(value("a b=word").unwrap_err()[0].contains("this key is not TOML"));
        assert!(value("a.b=[1,").unwrap_err()[0].contains("not TOML"));
        assert!(value("a.b=1\nc=2").unwrap_err()[0].contains("not an assignment"));
        assert!(value("=5").is_err());
    }
}
