//! Every key of a scenario, as docs/scenario.md lists them.
//!
//! The document is inside the program and is the only list there is; tests compare it with what the
//! program reads. What a value may be is asked of the program itself: each key is given a value that
//! cannot be, and what was expected instead is what is allowed.

use csat_world::map::{self, MapError};
use serde::Serialize;

use super::explain::expected_type;
use super::missions;
use super::model::SET_MEMBERSHIP;
use super::read::Form;
use super::validate;

const REFERENCE: &str = include_str!("../../../docs/scenario.md");

/// A table of the document.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Section {
    /// `Top level`, `[run]`, `[[netem.outage]]` or `loss = { model = "iid" }`.
    pub heading: &'static str,
    /// The mission whose own table it is; `None` for a field of [`Scenario`](super::Scenario).
    pub mission: Option<&'static str>,
    /// Its rows.
    pub rows: Vec<Row>,
}

/// A row of such a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// The key without its table.
    pub key: &'static str,
    /// Its default as TOML, or `none`, `required`, `as below`.
    pub default: &'static str,
    /// What it means, in Markdown.
    pub meaning: &'static str,
}

/// The tables of docs/scenario.md. The heading of a mission's own table names the mission: `[belief]` of
/// `bayes`.
pub fn sections() -> Vec<Section> {
    let mut sections: Vec<Section> = Vec::new();
    for line in REFERENCE.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            let (heading, mission) = match heading.split_once("` of `") {
                Some((heading, mission)) => (heading, Some(mission.trim_matches('`'))),
                None => (heading, None),
            };
            let heading = heading.trim_matches('`');
            sections.push(Section { heading, mission, rows: Vec::new() });
        }
        let cells: Vec<&str> =
            line.split(" | ").map(|cell| cell.trim_matches(['|', ' '])).collect();
        if let [key, default, meaning] = cells[..]
            && key.starts_with('`')
            && let Some(section) = sections.last_mut()
        {
            let bare = |cell: &'static str| cell.trim_matches('`');
            section.rows.push(Row { key: bare(key), default: bare(default), meaning });
        }
    }
    sections
}

/// A key of a scenario.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Key {
    /// Its path, such as `agents.count`; `netem.outage[].agent` is in each table of an array.
    pub key: String,
    /// The model that has it, if only one of several has.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
    /// The mission that has it, if it is in one of a mission's own tables.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mission: Option<&'static str>,
    /// Its default as TOML; absent when it may be left out without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub default: Option<String>,
    /// Whether its table cannot do without it.
    pub required: bool,
    /// Its unit, which its name ends in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<&'static str>,
    /// What it may be, as far as that does not depend on others.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub allowed: Option<String>,
    /// What it means.
    pub meaning: String,
}

/// All keys whose path begins with `prefix`, in the order of the document.
pub fn keys(prefix: &str) -> Vec<Key> {
    let sections = known_sections();
    let all =
        sections.iter().flat_map(|section| section.rows.iter().map(move |row| (section, row)));
    let paths = all.map(|(section, row)| (path(section.heading, row.key), section, row));
    let mut keys: Vec<Key> = paths
        .filter(|(path, ..)| path.starts_with(prefix))
        .map(|(path, section, row)| Key::new(path, section, row))
        .collect();
    keys.iter_mut().for_each(|key| key.allowed = allowed(key));
    keys
}

/// The tables of scenarios of this program: those of missions that it does not fly are left out.
fn known_sections() -> Vec<Section> {
    let is_known =
        |section: &Section| section.mission.is_none_or(|name| missions::find(name).is_some());
    sections().into_iter().filter(is_known).collect()
}

/// The paths of all keys.
pub fn paths() -> impl Iterator<Item = String> {
    let of =
        |section: Section| section.rows.into_iter().map(move |row| path(section.heading, row.key));
    known_sections().into_iter().flat_map(of)
}

/// The path of a key in the table of that heading.
fn path(heading: &str, key: &str) -> String {
    if heading == "Top level" {
        return key.to_owned();
    }
    if let Some((radio_key, _)) = heading.split_once(" = ") {
        return format!("netem.radio.{radio_key}.{key}");
    }
    match heading.strip_prefix("[[") {
        Some(array) => format!("{}[].{key}", array.trim_end_matches(']')),
        None => format!("{}.{key}", heading.trim_matches(['[', ']'])),
    }
}

impl Key {
    fn new(path: String, section: &Section, row: &Row) -> Self {
        let default = match row.default {
            "none" | "required" | "as below" => None,
            default => Some(default.to_owned()),
        };
        Self {
            unit: unit(row.key),
            model: section.heading.split('"').nth(1).map(str::to_owned),
            mission: section.mission,
            default,
            required: row.default == "required",
            allowed: None,
            meaning: plain(row.meaning),
            key: path,
        }
    }

    /// In two lines for people: what it is, and what it means.
    pub fn describe(&self) -> String {
        let mut line = self.key.clone();
        match (&self.default, self.required) {
            (Some(default), _) => line += &format!(" = {default}"),
            (None, true) => line += "   (required)",
            (None, false) => {}
        }
        let model = self.model.as_ref().map(|model| format!("of model \"{model}\""));
        let mission = self.mission.map(|mission| format!("of mission \"{mission}\""));
        let unit = self.unit.map(str::to_owned);
        let notes = [mission, model, unit, self.allowed.clone()];
        let notes: Vec<String> = notes.into_iter().flatten().collect();
        if !notes.is_empty() {
            line += &format!("   [{}]", notes.join("; "));
        }
        format!("{line}\n    {}\n", self.meaning)
    }
}

/// The unit that a key's name ends in.
fn unit(key: &str) -> Option<&'static str> {
    let words: Vec<&str> = key.split('_').collect();
    Some(match words[..] {
        [.., "bytes", "s"] => "bytes/s",
        [_, .., "m", "s"] => "m/s",
        [_, .., "m"] => "m",
        [_, .., "s"] => "s",
        [_, .., "deg"] => "degrees",
        [_, .., "px"] => "pixels",
        [_, .., "bytes"] => "bytes",
        [_, .., "db"] => "dB",
        [_, .., "dbm"] => "dBm",
        _ => return None,
    })
}

/// Markdown without its marks: `[planner.md](planner.md)` is docs/planner.md.
fn plain(markdown: &str) -> String {
    let mut text = markdown.replace(['`', '*'], "");
    while let Some(middle) = text.find("](")
        && let Some(start) = text[..middle].rfind('[')
        && let Some(length) = text[middle..].find(')')
    {
        let target = format!("docs/{}", &text[middle + 2..middle + length]);
        text.replace_range(start..=middle + length, &target);
    }
    text
}

/// What the program expects of a key, found out by giving it what cannot be.
fn allowed(key: &Key) -> Option<String> {
    // Another mission's key of the same name has other limits.
    if let (None, Some(expected)) = (key.mission, validate::whole_number(&key.key)) {
        return Some(expected.to_owned());
    }
    // Tables of arrays and of models stand for themselves only when they are whole.
    if key.model.is_some() || key.key.contains("[]") {
        return None;
    }
    let form = Form { mission: missions::find(key.mission.unwrap_or(SET_MEMBERSHIP))? };
    let defaults = form.defaults();
    let nan = toml::Value::Float(f64::NAN);
    let impossible = match lookup(&defaults, &key.key)? {
        toml::Value::String(_) => vec![toml::Value::String("\u{0}".to_owned())],
        toml::Value::Boolean(_) => return Some("true or false".to_owned()),
        // Some of them is out of bounds, or else of the type.
        toml::Value::Integer(_) => [0, 1, 65_535, -1].map(toml::Value::Integer).to_vec(),
        toml::Value::Float(_) => vec![nan],
        toml::Value::Array(list) => vec![toml::Value::Array(vec![nan; list.len()])],
        _ => return None,
    };
    impossible.into_iter().find_map(|value| expected(&form, &defaults, &key.key, value))
}

/// What the program expects instead of a value; `None` if it takes it, or cannot tell.
fn expected(
    form: &Form<'_>,
    defaults: &toml::Table,
    key: &str,
    value: toml::Value,
) -> Option<String> {
    let mut table = defaults.clone();
    *lookup_mut(&mut table, key)? = value;
    let scenario = match form.scenario(table) {
        Ok(scenario) => scenario,
        Err(error) => return expected_type(error.message()),
    };
    let of_town = map::mistakes(&scenario.map, &scenario.world_config().map_rules());
    let of_town = of_town.into_iter().find_map(|error| match error {
        MapError::Config { key: blamed, expected, .. } if blamed == key => Some(expected),
        _ => None,
    });
    of_town.or_else(|| {
        let issues = validate::validate(&scenario, form.mission.judge_scenario(&scenario));
        let own = issues.iter().find(|i| !i.is_warning && i.keys.first().is_some_and(|k| k == key));
        let mistake = &own?.mistake;
        // `netem` says it all in one sentence.
        let in_message = || mistake.message.split("expected ").nth(1)?.split(", got ").next();
        let expected = mistake.expected.as_deref().or_else(in_message)?;
        Some(expected.replace('`', ""))
    })
}

fn lookup<'a>(table: &'a toml::Table, path: &str) -> Option<&'a toml::Value> {
    match path.split_once('.') {
        Some((first, rest)) => lookup(table.get(first)?.as_table()?, rest),
        None => table.get(path),
    }
}

fn lookup_mut<'a>(table: &'a mut toml::Table, path: &str) -> Option<&'a mut toml::Value> {
    match path.split_once('.') {
        Some((first, rest)) => lookup_mut(table.get_mut(first)?.as_table_mut()?, rest),
        None => table.get_mut(path),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn only(path: &str) -> Key {
        let is_it = |key: &Key| key.key == path && key.mission.is_none();
        let found = keys(path).into_iter().filter(is_it);
        let found: Vec<Key> = found.collect();
        assert_eq!(found.len(), 1, "{path}: {found:?}");
        found.into_iter().next().unwrap()
    }

    #[test]
    fn keys_have_default_unit_meaning_and_what_is_allowed() {
        let speed = only("agents.speed_m_s");
        assert_eq!((speed.default.as_deref(), speed.unit), (Some("5.0"), Some("m/s")));
        assert_eq!(speed.allowed.as_deref(), Some("above 0 and up to 300 m/s"));
        assert_eq!(
            speed.describe(),
            "agents.speed_m_s = 5.0   [m/s; above 0 and up to 300 m/s]\n    v^u, their constant \
             horizontal speed, up to 300\n"
        );
        let criterion = only("guidance.criterion");
        assert!(criterion.allowed.unwrap().contains("lawnmower"));
        assert!(criterion.meaning.contains("(docs/planner.md)"), "{}", criterion.meaning);
        assert_eq!(
            only("camera.columns").allowed.as_deref(),
            Some("a whole number from 1 to 65535")
        );
        assert_eq!(only("netem.radio.light_delay").allowed.as_deref(), Some("true or false"));
        assert!(only("netem.radio.corruption").allowed.unwrap().contains("probability"));
        assert_eq!(only("map.size_m").allowed.as_deref(), Some("two lengths from 20 to 4000 m"));
        let vertices = only("estimator.disc_vertices").allowed;
        assert_eq!(vertices.as_deref(), Some("an even number from 4 to 256"));
        assert_eq!(only("netem.radio.rate.bytes_s").unit, Some("bytes/s"));
        assert_eq!(only("name").default, None);
    }

    #[test]
    fn keys_of_models_and_arrays_say_where_they_are() {
        let loss = keys("netem.radio.loss.p");
        let models: Vec<_> = loss.iter().filter_map(|key| key.model.as_deref()).collect();
        assert_eq!(models[..2], ["iid", "gilbert-elliott"]);
        assert!(loss[0].required && loss[0].default.is_none());
        assert_eq!(only("netem.outage[].from_s").unit, Some("s"));
        assert_eq!(keys("no.such"), []);
        let liar = keys("faults.liar");
        assert!(liar.iter().all(|key| key.mission == Some("set-membership")), "{liar:?}");
        assert!(liar.iter().any(|key| key.describe().contains("of mission \"set-membership\"")));
        assert_eq!(keys("").len(), paths().count());
    }
}
