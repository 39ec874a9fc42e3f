//! A comparison for people.

use super::{Comparison, Kind, Number, Part};
use crate::report::axis::short;
use crate::report::shapes::rounded;
use crate::scenario::missions;
use crate::sweep::metric::metrics_of;
use csat_mission::words::counted;

impl Comparison {
    /// In lines for the terminal.
    pub fn text(&self) -> String {
        let mut text = format!("a: {}\nb: {}\n", self.a, self.b);
        text += &self.builds();
        text += &self.scenarios();
        text += &self.digests();
        self.notes.iter().for_each(|note| text += &format!("note: {note}\n"));
        let mut hidden = 0;
        for part in &self.parts {
            let (shown, left): (Vec<&Number>, Vec<&Number>) =
                part.numbers.iter().partition(|number| self.shows(number));
            hidden += left.len();
            text += &self.part(part, &shown);
        }
        if hidden > 0 {
            let which = match self.kind {
                Kind::Sweep => "are not shown",
                Kind::Run | Kind::Tables => "are equal",
            };
            text += &format!("{} {which}: --json has all\n", counted(hidden, "further number"));
        }
        text
    }

    /// Of a sweep only what its report shows, too.
    fn shows(&self, number: &Number) -> bool {
        let kinds = missions::all().iter().map(|mission| mission.kind());
        let is_first = metrics_of(kinds).iter().any(|metric| metric.key == number.key);
        is_first || (self.kind != Kind::Sweep && number.differs())
    }

    fn builds(&self) -> String {
        let lines = |builds: &[String]| builds.join("; ");
        if self.kind == Kind::Tables {
            String::new()
        } else if self.builds_a == self.builds_b {
            format!("csat: {}\n", lines(&self.builds_a))
        } else {
            format!(
                "csat differs:\n  a  {}\n  b  {}\n",
                lines(&self.builds_a),
                lines(&self.builds_b)
            )
        }
    }

    fn scenarios(&self) -> String {
        if self.kind == Kind::Tables {
            return String::new();
        }
        if self.scenario.is_empty() {
            return "scenario: the same\n".to_owned();
        }
        let value = |value: &Option<String>| value.clone().unwrap_or_else(|| "-".to_owned());
        let mut rows = vec![["key", "a", "b"].map(str::to_owned).to_vec()];
        rows.extend(self.scenario.iter().map(|d| vec![d.key.clone(), value(&d.a), value(&d.b)]));
        let verb = if self.scenario.len() == 1 { "differs" } else { "differ" };
        format!("scenario: {} {verb}\n{}", counted(self.scenario.len(), "key"), aligned(&rows))
    }

    fn digests(&self) -> String {
        let Some(digests) = self.digests else { return String::new() };
        match (self.kind, digests.equal, digests.different) {
            (Kind::Run, 1, _) => "digest: equal, the same to the last bit\n".to_owned(),
            (Kind::Run, ..) => "digest: different\n".to_owned(),
            (_, 0, 0) => "digests: no run in common\n".to_owned(),
            (_, equal, different) => {
                let all = counted(equal + different, "run");
                format!("digests: {equal} equal of {all} in common\n")
            }
        }
    }

    fn part(&self, part: &Part, shown: &[&Number]) -> String {
        let mut head = vec!["", "a", "b", "b - a"];
        if self.kind == Kind::Sweep {
            head.extend(["seeds", "lower", "higher"]);
        }
        let mut rows = vec![head.into_iter().map(str::to_owned).collect::<Vec<_>>()];
        rows.extend(shown.iter().map(|number| self.row(number)));
        let name = match (part.name.is_empty(), shown.is_empty()) {
            (true, _) => String::new(),
            (false, true) => format!("\n{}: all numbers are equal\n", part.name),
            (false, false) => format!("\n{}\n", part.name),
        };
        if shown.is_empty() { name } else { name + &aligned(&rows) }
    }

    fn row(&self, number: &Number) -> Vec<String> {
        let show = |value: Option<f64>| value.map_or("-".to_owned(), |v| short(rounded(v)));
        let sign = |d: f64| if d > 0.0 { "+" } else { "" };
        let reach = number.ci95_half_width.map(|h| format!(" ± {}", short(rounded(h))));
        let difference = number.difference.map_or("-".to_owned(), |d| {
            format!("{}{}{}", sign(d), short(rounded(d)), reach.unwrap_or_default())
        });
        let mut row = vec![number.key.clone(), show(number.a), show(number.b), difference];
        if self.kind == Kind::Sweep {
            row.extend([number.n, number.lower, number.higher].map(|n| n.to_string()));
        }
        row
    }
}

/// Rows of cells of one width, the first ones to the left, the others to the right.
fn aligned(rows: &[Vec<String>]) -> String {
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|t| t.chars().count()).max();
    let widths: Vec<usize> = (0..count).map(|c| width(c).unwrap_or(0)).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate().map(|(c, (text, &width))| match c {
            0 => format!("{text:width$}"),
            _ => format!("{text:>width$}"),
        });
        format!("  {}\n", cells.collect::<Vec<_>>().join("  ").trim_end())
    };
    rows.iter().map(line).collect()
}
