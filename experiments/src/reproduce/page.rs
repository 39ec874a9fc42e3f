//! `report.html` of a reproduction that was flown.

use super::flown::Flown;
use super::table::{Table, banner_of};
use crate::report::page::document;
use crate::sweep::report::{alarms, head, scenario};
use crate::sweep::results::Results;

/// The page; `again` is the command that makes it again, `figures` is markup.
pub fn html(
    title: &str,
    results: &Results,
    again: &str,
    runs: &[Vec<Flown>],
    tables: &[Table],
    figures: &str,
) -> String {
    let body = banner_of(tables)
        + &head(results, again)
        + &format!("<p>{}</p>\n", complaints(runs))
        + &alarms(results)
        + "<h2>Ours beside theirs</h2>\n"
        + &tables.iter().map(Table::html).collect::<String>()
        + figures
        + &scenario(&results.manifest);
    document(title, &body)
}

/// What the monitor and the agents complained of, over all missions.
pub fn complaints(runs: &[Vec<Flown>]) -> String {
    let all = || runs.iter().flatten().map(|run| &run.summary);
    let violations: u64 = all().map(|s| s.violations).sum();
    let checks: u64 = all().map(|s| s.checks).sum();
    let inconsistencies: u64 = all().map(|s| s.inconsistencies).sum();
    format!(
        "{} missions: {violations} violations of {checks} checks, {inconsistencies} inconsistencies",
        all().count()
    )
}
