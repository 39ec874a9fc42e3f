//! A table with ours beside theirs, for the terminal and for the page.

use std::fmt::Write;

use serde::Serialize;

use crate::published::Published;
use crate::report::shapes::escaped;
use crate::stats::stats;

/// A table.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Table {
    /// What it is about.
    pub title: String,
    /// Where theirs is published.
    pub source: &'static str,
    /// What ours is the mean of, and what else there is to say.
    pub note: String,
    /// What a mark (*) means; empty in a table without marks.
    pub mark: &'static str,
    /// What differs from the published setting: then nothing is marked.
    pub not_published: Option<String>,
    /// The first column's head.
    pub corner: &'static str,
    /// What is compared.
    pub columns: Vec<Column>,
    /// Name and a cell per column.
    pub rows: Vec<(String, Vec<Cell>)>,
}

/// A column.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Column {
    /// Its name and unit.
    pub name: String,
    /// Digits behind the point.
    pub decimals: usize,
}

/// Ours beside theirs.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Cell {
    /// Ours; `None` where there is nothing to measure.
    pub ours: Option<Ours>,
    /// Theirs; `None` where nothing is published.
    pub theirs: Option<Theirs>,
}

/// Mean and standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Ours {
    /// The mean.
    pub mean: f64,
    /// The deviation; `None` for a single value.
    pub sd: Option<f64>,
    /// Whether some values are bounds from below, and so the mean.
    pub is_at_least: bool,
    /// The least and the greatest value, where that is told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
}

/// What was published.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Theirs {
    /// Mean and standard deviation.
    Mean(Published),
    /// A number without deviation.
    Value(f64),
    /// A bound from above.
    Below(f64),
}

impl Column {
    /// A column of two decimals.
    pub fn new(name: &str, unit: &str) -> Self {
        Self { name: format!("{name}, {unit}"), decimals: 2 }
    }
}

impl Cell {
    /// The mean of `values` beside what was published.
    pub fn new(values: &[f64], theirs: Option<Theirs>) -> Self {
        let ours = stats(values).map(|s| Ours { mean: s.mean, sd: s.sd, ..Ours::default() });
        Self { ours, theirs }
    }

    /// The same with the least and the greatest value.
    pub fn with_range(values: &[f64], theirs: Option<Theirs>) -> Self {
        let mut cell = Self::new(values, theirs);
        let least = values.iter().copied().reduce(f64::min);
        let range = least.zip(values.iter().copied().reduce(f64::max));
        cell.ours.iter_mut().for_each(|ours| ours.range = range.map(|(from, to)| [from, to]));
        cell
    }

    /// With a mean over some bounds from below.
    pub fn at_least(mut self, is_at_least: bool) -> Self {
        self.ours.iter_mut().for_each(|ours| ours.is_at_least = is_at_least);
        self
    }

    /// Whether the difference exceeds both deviations, or ours the bound.
    pub fn differs(&self) -> bool {
        let (Some(Ours { mean, sd, .. }), Some(theirs)) = (self.ours, self.theirs) else {
            return false;
        };
        match theirs {
            Theirs::Mean([published, deviation]) => {
                (mean - published).abs() > deviation.max(sd.unwrap_or(0.0))
            }
            // Two single numbers: nothing says what difference would count.
            Theirs::Value(published) => sd.is_some_and(|sd| (mean - published).abs() > sd),
            Theirs::Below(bound) => mean > bound,
        }
    }

    fn texts(&self, decimals: usize) -> [String; 2] {
        let number = |mean: f64, sd: Option<f64>| match sd {
            Some(sd) => format!("{mean:.decimals$} ± {sd:.decimals$}"),
            None => format!("{mean:.decimals$}"),
        };
        let ours = self.ours.map(|o| {
            let bound = if o.is_at_least { "≥ " } else { "" };
            let range =
                o.range.map(|[from, to]| format!(" ({from:.decimals$} to {to:.decimals$})"));
            format!("{bound}{}{}", number(o.mean, o.sd), range.unwrap_or_default())
        });
        let theirs = self.theirs.map(|theirs| match theirs {
            Theirs::Mean([mean, sd]) => number(mean, Some(sd)),
            Theirs::Value(value) => number(value, None),
            Theirs::Below(bound) => format!("< {bound}"),
        });
        [ours, theirs].map(|text| text.unwrap_or_else(|| "-".to_owned()))
    }
}

impl Table {
    /// Whether a cell is marked as another than what was published.
    fn marks(&self, cell: &Cell) -> bool {
        self.not_published.is_none() && !self.mark.is_empty() && cell.differs()
    }

    /// The note, with the meaning of marks if there may be some.
    fn full_note(&self) -> String {
        match (&self.not_published, self.mark) {
            (Some(_), _) | (None, "") => self.note.clone(),
            (None, mark) => format!("{} *: {mark}.", self.note),
        }
    }

    /// For the terminal.
    pub fn text(&self) -> String {
        let mut lines = vec![vec![String::new()], vec![self.corner.to_owned()]];
        for column in &self.columns {
            lines[0].extend([column.name.clone(), String::new()]);
            lines[1].extend(["ours".to_owned(), "theirs".to_owned()]);
        }
        for (name, cells) in &self.rows {
            let mut line = vec![name.clone()];
            for (cell, column) in cells.iter().zip(&self.columns) {
                let [ours, theirs] = cell.texts(column.decimals);
                line.extend([ours, theirs + if self.marks(cell) { " *" } else { "" }]);
            }
            lines.push(line);
        }
        let banner = self.not_published.as_ref().map(|banner| format!("{banner}\n"));
        format!(
            "{} ({})\n{}{}{}\n",
            self.title,
            self.source,
            banner.unwrap_or_default(),
            aligned(&lines),
            self.full_note()
        )
    }

    /// For the page.
    pub fn html(&self) -> String {
        let banner = self.not_published.as_deref().map(banner);
        let mut page = format!(
            "<h3>{}</h3>\n{}<p>{}. {}</p>\n<div class=\"wide\"><table>\n<thead><tr><th></th>",
            escaped(&self.title),
            banner.unwrap_or_default(),
            escaped(self.source),
            escaped(&self.full_note())
        );
        for column in &self.columns {
            let _ = write!(page, "<th colspan=\"2\">{}</th>", escaped(&column.name));
        }
        let _ = write!(page, "</tr>\n<tr><th class=\"left\">{}</th>", escaped(self.corner));
        page += &"<th>ours</th><th>theirs</th>".repeat(self.columns.len());
        page += "</tr></thead>\n<tbody>\n";
        for (name, cells) in &self.rows {
            let _ = write!(page, "<tr><td class=\"left\">{}</td>", escaped(name));
            for (cell, column) in cells.iter().zip(&self.columns) {
                let [ours, theirs] = cell.texts(column.decimals).map(|text| escaped(&text));
                let (class, mark) =
                    if self.marks(cell) { (" class=\"differs\"", " *") } else { ("", "") };
                let _ = write!(page, "<td{class}>{ours}</td><td{class}>{theirs}{mark}</td>");
            }
            page += "</tr>\n";
        }
        page + "</tbody>\n</table></div>\n"
    }
}

/// Lines of cells, the first one of each to the left. The first line's cells stand over two columns.
fn aligned(lines: &[Vec<String>]) -> String {
    let count = lines.iter().map(Vec::len).max().unwrap_or(0);
    let width = |text: &String| text.chars().count();
    let mut widths: Vec<usize> = (0..count)
        .map(|c| lines[1..].iter().filter_map(|l| l.get(c)).map(width).max().unwrap_or(0))
        .collect();
    for (c, over) in lines[0].iter().enumerate().skip(1).step_by(2) {
        widths[c] = widths[c].max(width(over).saturating_sub(widths[c + 1] + 2));
    }
    let mut text = String::new();
    for (index, line) in lines.iter().enumerate() {
        let mut shown = String::new();
        let mut start = 0;
        for (column, (cell, w)) in line.iter().zip(&widths).enumerate() {
            // A head stands over two columns: its second cell is empty and adds nothing.
            if index > 0 || column % 2 == 1 {
                let gap = start - width(&shown);
                shown += &" ".repeat(gap);
                shown += cell;
            }
            start += w + 2;
        }
        text += &format!("  {}\n", shown.trim_end());
    }
    text
}

/// Words (plain text) that stand out.
fn banner(text: &str) -> String {
    format!("<div class=\"alarm\"><p><strong>{}</strong></p></div>\n", escaped(text))
}

/// The banner of a page of these tables, which say what differs from the published setting.
pub fn banner_of(tables: &[Table]) -> String {
    let not_published = tables.iter().find_map(|table| table.not_published.as_deref());
    not_published.map(banner).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(values: &[f64], theirs: Theirs) -> Cell {
        Cell::new(values, Some(theirs))
    }

    #[test]
    fn a_difference_counts_when_it_exceeds_both_deviations() {
        assert!(!cell(&[9.0, 11.0], Theirs::Mean([12.0, 2.5])).differs());
        assert!(!cell(&[5.0, 15.0], Theirs::Mean([12.0, 0.5])).differs());
        assert!(cell(&[9.9, 10.1], Theirs::Mean([12.0, 1.5])).differs());
        assert!(cell(&[9.9, 10.1], Theirs::Value(11.0)).differs());
        assert!(!cell(&[9.0], Theirs::Value(11.0)).differs());
        assert!(cell(&[3.0], Theirs::Below(2.0)).differs());
        assert!(!cell(&[1.0], Theirs::Below(2.0)).differs());
        assert!(!Cell::new(&[], Some(Theirs::Value(1.0))).differs());
        assert_eq!(Cell::with_range(&[2.0, 4.0], None).texts(0), ["3 ± 1 (2 to 4)", "-"]);
        assert_eq!(Cell::with_range(&[], None), Cell::default());
    }

    #[test]
    fn columns_stand_under_their_heads() {
        let table = Table {
            title: "Ground".to_owned(),
            source: "table 1",
            note: "Means.".to_owned(),
            mark: "differs",
            not_published: None,
            corner: "criterion",
            columns: vec![Column::new("unexplored", "% of the region"), Column::new("b", "m")],
            rows: vec![
                ("a < b".to_owned(), vec![cell(&[2.0, 4.0], Theirs::Mean([9.0, 0.5])); 2]),
                ("c".to_owned(), vec![Cell::default(); 2]),
            ],
        };
        let text = table.text();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "Ground (table 1)");
        assert_eq!(
            lines[3],
            "  a < b      3.00 ± 1.41   9.00 ± 0.50 *  3.00 ± 1.41  9.00 ± 0.50 *"
        );
        assert_eq!(lines[1].find("b, m"), lines[2].rfind("ours"));
        assert_eq!(lines.last(), Some(&"Means. *: differs."));
        assert!(table.html().contains("<td class=\"left\">a &lt; b</td>"));
        assert!(table.html().contains("class=\"differs\""));
        let other = Table { not_published: Some("Not so: 4 s < 300 s.".to_owned()), ..table };
        let (text, html) = (other.text(), other.html());
        assert_eq!(text.lines().nth(1), Some("Not so: 4 s < 300 s."));
        assert!(!text.contains('*') && !html.contains("differs") && !html.contains('*'), "{text}");
        assert!(html.contains("Not so: 4 s &lt; 300 s."), "{html}");
    }
}
