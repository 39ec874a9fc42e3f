//! The paper's table I and what its §VIII-B says besides.

use super::flown::Flown;
use super::quantity::{ERROR, EXPLORED, HIDDEN, Quantity, UNEXPLORED};
use super::table::{Cell, Column, Table, Theirs};
use crate::published::reference;

/// The tables; `names` and `runs` by column of table I.
pub fn tables(names: &[String], runs: &[Vec<Flown>]) -> Vec<Table> {
    let published = reference().paper.table1;
    let ground = [published.previous, published.kappa0, published.kappa1];
    let rows = names.iter().zip(runs).zip(ground).map(|((name, flown), theirs)| {
        let cells = vec![
            at_the_end(flown, &UNEXPLORED, Theirs::Mean(theirs.unexplored_pct)),
            at_the_end(flown, &HIDDEN, Theirs::Mean(theirs.hidden_pct)),
        ];
        (name.clone(), cells)
    });
    let last = names.iter().zip(runs).next_back().map(|(name, flown)| {
        let cells = vec![
            at_the_end(flown, &ERROR, Theirs::Mean(published.localization_error_m)),
            at_the_end(flown, &EXPLORED, Theirs::Value(published.explored_at_300s_pct)),
        ];
        (name.clone(), cells)
    });
    vec![
        table(
            "Ground still to be searched",
            "paper, table I",
            &[UNEXPLORED, HIDDEN],
            rows.collect(),
        ),
        table(
            "Accuracy and exploration",
            "paper, §VIII-B",
            &[ERROR, EXPLORED],
            last.into_iter().collect(),
        ),
    ]
}

fn table(
    title: &str,
    source: &'static str,
    quantities: &[Quantity],
    rows: Vec<(String, Vec<Cell>)>,
) -> Table {
    Table {
        title: title.to_owned(),
        source,
        note: "Mean ± standard deviation over missions, at their end.".to_owned(),
        mark: "differs by more than both deviations",
        not_published: None,
        corner: "criterion",
        columns: quantities.iter().map(|q| Column::new(q.short, q.unit)).collect(),
        rows,
    }
}

fn at_the_end(flown: &[Flown], quantity: &Quantity, theirs: Theirs) -> Cell {
    let last = flown.iter().filter_map(|run| quantity.defined(run.series.last(quantity.column)));
    Cell::new(&last.collect::<Vec<_>>(), Some(theirs))
}
