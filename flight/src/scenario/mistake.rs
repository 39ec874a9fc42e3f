//! What is wrong with a scenario, said so that it can be put right.

use std::fmt;

use super::source::Place;
use csat_mission::words::counted;

/// One mistake (or warning) with its place and what was expected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mistake {
    /// What is wrong.
    pub message: String,
    /// Where it was written; `None` when it was written nowhere, as a missing file.
    pub place: Option<Box<Place>>,
    /// What would have been right.
    pub expected: Option<String>,
    /// A guess at what was meant, or what to do.
    pub help: Option<String>,
}

impl Mistake {
    /// A mistake without a place.
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), place: None, expected: None, help: None }
    }

    /// At this place.
    pub fn at(mut self, place: Option<Place>) -> Self {
        self.place = place.map(Box::new);
        self
    }

    /// With what was expected.
    pub fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = Some(expected.into());
        self
    }

    /// With a hint.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The full text, beginning with `severity`.
    pub fn render(&self, severity: &str) -> String {
        let mut text = format!("{severity}: {}\n", self.message);
        let mut notes: Vec<String> = Vec::new();
        notes.extend(self.expected.iter().map(|e| format!("expected {e}")));
        notes.extend(self.help.clone());
        match &self.place {
            Some(place) => render_place(place, &notes, &mut text),
            None => notes.iter().for_each(|note| text += &format!("  = {note}\n")),
        }
        text
    }
}

/// So many characters of a line are shown, and so many of them before the place.
const SHOWN: usize = 120;
const SHOWN_BEFORE: usize = 60;

fn render_place(place: &Place, notes: &[String], text: &mut String) {
    let number = if place.is_file { place.line.to_string() } else { String::new() };
    let gutter = " ".repeat(number.len());
    let position =
        if place.is_file { format!(":{}:{}", place.line, place.column) } else { String::new() };
    let (excerpt, column) = shown(&place.excerpt, place.column);
    // Tabs stay tabs under the line so that the caret stands below its character.
    let before = excerpt.chars().take(column - 1);
    let indent: String = before.map(|c| if c == '\t' { '\t' } else { ' ' }).collect();
    let carets = "^".repeat(place.width.min(SHOWN + 2 - column.min(SHOWN)));
    *text += &format!("{gutter} --> {}{position}\n", place.source);
    *text += &format!("{gutter} |\n{number} | {excerpt}\n");
    *text += &format!("{gutter} | {indent}{carets}\n");
    for note in notes {
        *text += &format!("{gutter} = {note}\n");
    }
}

/// A line, or what is around the column of one that is too long to be read, and the column in it.
fn shown(line: &str, column: usize) -> (String, usize) {
    let count = line.chars().count();
    if count <= SHOWN {
        return (line.to_owned(), column);
    }
    let first = (column - 1).saturating_sub(SHOWN_BEFORE).min(count - SHOWN);
    let middle: String = line.chars().skip(first).take(SHOWN).collect();
    let [before, after] = [first > 0, first + SHOWN < count].map(|cut| if cut { "…" } else { "" });
    (format!("{before}{middle}{after}"), column - first + before.chars().count())
}

impl fmt::Display for Mistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render("error"))
    }
}

/// Everything that is wrong with a scenario.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}: nothing was run", self.describe())]
pub struct Mistakes {
    /// What has to be put right.
    pub mistakes: Vec<Mistake>,
    /// What is allowed but may explain the mistakes, such as buildings that were left out of a map.
    pub warnings: Vec<Mistake>,
}

impl From<Vec<Mistake>> for Mistakes {
    fn from(mistakes: Vec<Mistake>) -> Self {
        Self { mistakes, warnings: Vec::new() }
    }
}

impl Mistakes {
    /// Everything in full, and how many mistakes it is.
    pub fn describe(&self) -> String {
        let mistakes = self.mistakes.iter().map(|m| m.render("error"));
        let warnings = self.warnings.iter().map(|w| w.render("warning"));
        let all: String = mistakes.chain(warnings).map(|text| text + "\n").collect();
        all + &counted(self.mistakes.len(), "mistake")
    }
}

/// The question whether the candidate most like `word` was meant, when one is alike enough.
pub fn did_you_mean<'a>(
    word: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<String> {
    similar(word, candidates).map(|candidate| format!("did you mean `{candidate}`?"))
}

/// The candidate most like `word`, when one is alike enough to be worth a question.
pub fn similar<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let mut likely: Vec<(f64, &str)> = candidates
        .into_iter()
        .map(|candidate| (strsim::jaro_winkler(word, candidate), candidate))
        .filter(|(likeness, _)| *likeness > 0.8)
        .collect();
    likely.sort_by(|a, b| b.0.total_cmp(&a.0));
    match likely[..] {
        [(best, one), (second, other), ..] if best == second && one != other => None,
        [(_, candidate), ..] => Some(candidate),
        [] => None,
    }
}

/// Names in backquotes, separated by commas.
pub fn quoted_list(names: impl Iterator<Item = &'static str>) -> String {
    names.map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of one long line is shown around the place only, with the caret below it.
    #[test]
    fn of_a_long_line_the_surroundings_are_shown() {
        for at in [0, 10, 60, 61, 300, 880, 999] {
            let text: String = (0..1000).map(|i| if i == at { '!' } else { 'é' }).collect();
            let start = text.find('!').unwrap();
            let place = Place::in_file("t.geojson", &text, start..text.len());
            let shown = Mistake::new("broken").at(Some(place)).render("error");
            let lines: Vec<&str> = shown.lines().collect();
            assert_eq!(lines[1], format!("  --> t.geojson:1:{}", at + 1));
            let column = |line: &str, c| line.chars().position(|x| x == c);
            assert_eq!(column(lines[3], '!'), column(lines[4], '^'), "{shown}");
            assert!(lines.iter().all(|line| line.chars().count() < 130), "{shown}");
            assert_eq!(lines[3].contains("é…"), at < 900, "{shown}");
            assert_eq!(lines[3].contains("| …"), at > 60, "{shown}");
        }
    }
}
