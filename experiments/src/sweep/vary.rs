//! `--vary KEY=A,B,C`: what differs between the points of a sweep.
//!
//! Values are TOML (or plain words, as with `--set`), separated by commas outside of brackets and
//! quotes. `weak:{...}` calls a table, list or tuple `weak`. `a,b=(1,2),(3,4)` varies two keys
//! together.

use serde::{Deserialize, Serialize};

use crate::scenario::Mistake;
use crate::scenario::set::value;
use crate::scenario::source::Place;

/// One `--vary`: keys that vary together, and their values.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Axis {
    /// Dotted keys; one unless several vary together.
    pub keys: Vec<String>,
    /// The values, in the order given.
    pub values: Vec<Choice>,
}

/// One value of an axis.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Choice {
    /// What the user calls it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// One text per key, as `--set` takes it.
    pub texts: Vec<String>,
}

impl Axis {
    /// Parses the argument of `--vary`.
    ///
    /// # Errors
    /// What is wrong, with its place in the argument.
    pub fn parse(argument: &str) -> Result<Self, Mistake> {
        let refuse = |start: usize, text: &str, message: String| {
            Mistake::new(message)
                .at(Some(place(argument, start, text)))
                .expected("`key=a,b,c`, such as `agents.count=2,4,8`")
        };
        let Some(equals) = argument.find('=').filter(|_| !argument.contains(['\n', '\r'])) else {
            return Err(refuse(0, argument, "this varies nothing".to_owned()));
        };
        let mut keys = Vec::new();
        for key in argument[..equals].split(',') {
            let plain = dotted(key)
                .ok_or_else(|| refuse(0, &argument[..equals], format!("`{key}` is no key")))?;
            if plain == "seed" {
                let message = "`seed` does not vary like this".to_owned();
                return Err(refuse(0, key, message).help("seeds are given by `--seeds 1..5`"));
            }
            keys.push(plain);
        }
        let start = equals + 1;
        let pieces = split(&argument[start..])
            .map_err(|what| refuse(start, &argument[start..], what.to_owned()))?;
        let mut values: Vec<Choice> = Vec::new();
        for piece in pieces {
            let at = start + (piece.as_ptr() as usize - argument[start..].as_ptr() as usize);
            let choice = Choice::parse(piece, keys.len()).map_err(|m| refuse(at, piece, m))?;
            if values.iter().any(|v| v.same_as(&choice)) {
                return Err(refuse(at, piece, format!("the value `{piece}` is there twice")));
            }
            values.push(choice);
        }
        Ok(Self { keys, values })
    }

    /// Whether the axis is about the links only.
    pub fn is_netem(&self) -> bool {
        self.keys.iter().all(|key| key == "netem" || key.starts_with("netem."))
    }

    /// What the axis is called: its keys.
    pub fn title(&self) -> String {
        self.keys.join(", ")
    }
}

impl Choice {
    fn parse(piece: &str, keys: usize) -> Result<Self, String> {
        let (label, text) = match piece.split_once(':') {
            Some((label, rest))
                if is_label(label) && rest.trim_start().starts_with(['{', '[', '(']) =>
            {
                (Some(label.trim().to_owned()), rest.trim())
            }
            _ => (None, piece.trim()),
        };
        if text.is_empty() {
            return Err("a value is missing".to_owned());
        }
        if keys == 1 {
            return Ok(Self { label, texts: vec![text.to_owned()] });
        }
        let inner = text.strip_prefix('(').and_then(|t| t.strip_suffix(')'));
        let Some(inner) = inner else {
            return Err(format!("`{text}` is not {keys} values in parentheses, as in `(1,2)`"));
        };
        let texts: Vec<String> = split(inner)?.iter().map(|t| t.trim().to_owned()).collect();
        if texts.len() != keys || texts.iter().any(String::is_empty) {
            return Err(format!("`{text}` has {} values for {keys} keys", texts.len()));
        }
        Ok(Self { label, texts })
    }

    /// What people read: the label, or else the values.
    pub fn shown(&self) -> String {
        match &self.label {
            Some(label) => label.clone(),
            None => self.texts.iter().map(|t| shown(t)).collect::<Vec<_>>().join(", "),
        }
    }

    /// The number, when the choice is one.
    pub fn number(&self) -> Option<f64> {
        match &self.texts[..] {
            [text] if self.label.is_none() => match value(text)? {
                toml::Value::Integer(integer) => Some(integer as f64),
                toml::Value::Float(float) if !float.is_nan() => Some(float),
                _ => None,
            },
            _ => None,
        }
    }

    /// Whether it is the same value, whatever it is called.
    pub fn is_same_value(&self, other: &Self) -> bool {
        let plain =
            |text: &str| value(text).unwrap_or_else(|| toml::Value::String(text.to_owned()));
        let same_text = |(a, b): (&String, &String)| plain(a) == plain(b);
        let same_number = self.number().is_some() && self.number() == other.number();
        same_number || self.texts.iter().zip(&other.texts).all(same_text)
    }

    fn same_as(&self, other: &Self) -> bool {
        let same_label = self.label.is_some() && self.label == other.label;
        same_label || self.is_same_value(other)
    }
}

fn is_label(text: &str) -> bool {
    let text = text.trim();
    text.starts_with(char::is_alphabetic)
        && text.chars().all(|c| c.is_alphanumeric() || "-_+. ".contains(c))
}

/// The key as `a.b.c`, without spaces and quotes; `None` when TOML has no such key.
pub fn dotted(key: &str) -> Option<String> {
    let table: toml::Table = toml::from_str(&format!("{key}=0")).ok()?;
    let mut path = Vec::new();
    let mut table = &table;
    loop {
        let (name, value) = table.iter().next()?;
        path.push(name.as_str());
        match value {
            toml::Value::Table(inner) => table = inner,
            _ => return Some(path.join(".")),
        }
    }
}

fn shown(text: &str) -> String {
    match value(text) {
        Some(toml::Value::String(string)) => string,
        Some(toml::Value::Table(table)) => match table.get("model") {
            Some(toml::Value::String(model)) => {
                let rest = table.iter().filter(|(key, _)| *key != "model");
                let rest = rest.map(|(key, value)| format!(" {key}={value}"));
                format!("{model}{}", rest.collect::<String>())
            }
            _ => text.to_owned(),
        },
        _ => text.to_owned(),
    }
}

/// Splits at the commas outside of brackets and quotes.
fn split(text: &str) -> Result<Vec<&str>, &'static str> {
    let (mut pieces, mut start) = (Vec::new(), 0);
    let mut open: Vec<char> = Vec::new();
    let mut quote: Option<char> = None;
    let mut escaped = false;
    for (at, c) in text.char_indices() {
        if let Some(mark) = quote {
            if escaped {
                escaped = false;
            } else if c == '\\' && mark == '"' {
                escaped = true;
            } else if c == mark {
                quote = None;
            }
            continue;
        }
        match c {
            '"' | '\'' => quote = Some(c),
            '(' => open.push(')'),
            '[' => open.push(']'),
            '{' => open.push('}'),
            ')' | ']' | '}' if open.pop() != Some(c) => {
                return Err("a bracket is closed that was not opened");
            }
            ',' if open.is_empty() => {
                pieces.push(text[start..at].trim());
                start = at + 1;
            }
            _ => {}
        }
    }
    if quote.is_some() {
        return Err("a quote is not closed");
    }
    if !open.is_empty() {
        return Err("a bracket is not closed");
    }
    pieces.push(text[start..].trim());
    Ok(pieces)
}

/// The place of a piece of an argument of `--vary`.
fn place(argument: &str, start: usize, piece: &str) -> Place {
    Place {
        source: "--vary".to_owned(),
        is_file: false,
        line: 1,
        column: argument[..start].chars().count() + 1,
        excerpt: argument.replace(['\n', '\r'], " "),
        width: piece.chars().count().max(1),
    }
}

#[cfg(test)]
#[path = "vary_tests.rs"]
mod tests;
