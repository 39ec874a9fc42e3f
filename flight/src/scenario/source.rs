//! Where a value of a scenario was written: a file, or an argument of the command line.

use std::ops::Range;

/// A text that values come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// What people call it: a path, `--set`, `--seed`.
    pub name: String,
    /// The text itself.
    pub text: String,
    /// Whether it is a file, so that line numbers mean something.
    pub is_file: bool,
    /// Folder that relative paths in it start from; `None` in a shipped scenario.
    pub folder: Option<std::path::PathBuf>,
}

/// A stretch of a [`Source`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Site {
    /// Index into [`Sources`].
    pub source: usize,
    /// Bytes of the source's text.
    pub span: Range<usize>,
}

/// All texts of one scenario, in the order in which later ones override earlier ones.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Sources(Vec<Source>);

impl Sources {
    /// Adds a source and gives its index.
    pub fn push(&mut self, source: Source) -> usize {
        self.0.push(source);
        self.0.len() - 1
    }

    /// The source of a site.
    pub fn get(&self, index: usize) -> &Source {
        &self.0[index]
    }

    /// Resolves a site to what a person needs to find it.
    pub fn place(&self, site: &Site) -> Place {
        let source = self.get(site.source);
        Place {
            is_file: source.is_file,
            ..Place::in_file(&source.name, &source.text, site.span.clone())
        }
    }
}

/// A person may save a file in any encoding: never cut inside a character.
fn floor_boundary(text: &str, index: usize) -> usize {
    let mut index = index.min(text.len());
    while !text.is_char_boundary(index) {
        index -= 1;
    }
    index
}

/// A place to point at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Name of the source.
    pub source: String,
    /// Whether line and column are worth printing.
    pub is_file: bool,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The line.
    pub excerpt: String,
    /// Number of characters to underline.
    pub width: usize,
}

impl Place {
    /// A stretch of the text of a file, in bytes.
    pub fn in_file(name: &str, text: &str, span: Range<usize>) -> Self {
        let start = floor_boundary(text, span.start);
        let end = floor_boundary(text, span.end).max(start);
        let line_start = text[..start].rfind('\n').map_or(0, |at| at + 1);
        let line_end = text[line_start..].find('\n').map_or(text.len(), |at| line_start + at);
        let underlined = &text[start..end.min(line_end).max(start)];
        Self {
            source: name.to_owned(),
            is_file: true,
            line: text[..start].matches('\n').count() + 1,
            column: text[line_start..start].chars().count() + 1,
            excerpt: text[line_start..line_end].trim_end_matches('\r').to_owned(),
            width: underlined.chars().count().max(1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_lines_and_characters() {
        let mut sources = Sources::default();
        let text = "a = 1\nµ = 'é'; b = 2\r\n".to_owned();
        let at = text.find('b').unwrap();
        let index =
            sources.push(Source { name: "x.toml".into(), text, is_file: true, folder: None });
        let place = sources.place(&Site { source: index, span: at..at + 5 });
        assert_eq!((place.line, place.column, place.width), (2, 10, 5));
        assert_eq!(place.excerpt, "µ = 'é'; b = 2");
        let past_the_end = sources.place(&Site { source: index, span: 999..9999 });
        assert_eq!((past_the_end.line, past_the_end.width), (3, 1));
    }
}
