//! What is wrong with a scenario, said so that it can be put right.

use std::fmt;

use super::source::Place;
use crate::words::counted;

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

fn render_place(place: &Place, notes: &[String], text: &mut String) {
    let number = if place.is_file { place.line.to_string() } else { String::new() };
    let gutter = " ".repeat(number.len());
    let position =
        if place.is_file { format!(":{}:{}", place.line, place.column) } else { String::new() };
    // Tabs stay tabs under the line so that the caret stands below its character.
    let indent: String = place
        .excerpt
        .chars()
        .take(place.column - 1)
        .map(|c| if c == '\t' { '\t' } else { ' ' })
        .collect();
    let carets = "^".repeat(place.width);
    *text += &format!("{gutter} --> {}{position}\n", place.source);
    *text += &format!("{gutter} |\n{number} | {}\n", place.excerpt);
    *text += &format!("{gutter} | {indent}{carets}\n");
    for note in notes {
        *text += &format!("{gutter} = {note}\n");
    }
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

/// The candidate most like `word`, when one is alike enough to be worth a question.
pub fn did_you_mean<'a>(
    word: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<String> {
    let mut likely: Vec<(f64, &str)> = candidates
        .into_iter()
        .map(|candidate| (strsim::jaro_winkler(word, candidate), candidate))
        .filter(|(likeness, _)| *likeness > 0.8)
        .collect();
    likely.sort_by(|a, b| b.0.total_cmp(&a.0));
    match likely[..] {
        [(best, _), (second, _), ..] if best == second => None,
        [(_, candidate), ..] => Some(format!("did you mean `{candidate}`?")),
        [] => None,
    }
}
