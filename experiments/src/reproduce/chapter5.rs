//! Thesis §5.4: tables 5.3-5.6 and figures 5.9-5.14.

use super::flown::Flown;
use super::quantity::{
    DETECTED, ERROR, EXPLORED, FOOTPRINT, HIDDEN, IDENTIFIED, IN_FOOTPRINT, OEM_IOU, Quantity,
    RADIUS, SEEN, UNEXPLORED,
};
use super::table::{Cell, Column, Table, Theirs};
use crate::published::{Chapter5, Row, SPAN_S, reference};
use crate::report::axis::XAxis;
use crate::report::curves::{Curve, Curves, Moment, Published};
use crate::report::page;
use crate::timing::Spread;

/// All instants of the second half of all missions, one beside the other: only so do the thesis's
/// deviations come about, which are several times those between runs.
const POOLED: &str =
    "Mean ± standard deviation over all instants of the second half of all missions";

/// All curves.
const CURVES: [Quantity; 11] = [
    IDENTIFIED,
    IN_FOOTPRINT,
    DETECTED,
    ERROR,
    RADIUS,
    UNEXPLORED,
    HIDDEN,
    FOOTPRINT,
    SEEN,
    EXPLORED,
    OEM_IOU,
];
/// Every so many steps of a curve are drawn.
const DRAWN_STEPS: usize = 4;
/// The most ticks of the time axis.
const TICKS: f64 = 6.0;

/// The tables; `names` and `runs` by criterion, in the order of the thesis's tables.
pub fn tables(names: &[String], runs: &[Vec<Flown>]) -> Vec<Table> {
    let make =
        |title, source, quantities: &[Quantity]| means(title, source, quantities, names, runs);
    let mut seen = make("Ground in view", "thesis table 5.5", &[FOOTPRINT, SEEN]);
    seen.columns.push(Column::new("occlusion", "% of the footprint"));
    for ((_, cells), row) in seen.rows.iter_mut().zip(reference().chapter5.rows()) {
        cells.push(occlusion(cells, &row));
    }
    vec![
        make("Identified targets", "thesis table 5.3", &[ERROR, RADIUS]),
        make("Ground still to be searched", "thesis table 5.4", &[UNEXPLORED, HIDDEN]),
        seen,
        make("Explored ground", "thesis table 5.6", &[EXPLORED]),
        make("Quality of the occupancy-elevation map", "thesis §5.4.4", &[OEM_IOU]),
        identification(names, runs),
        computing(names, runs),
    ]
}

fn means(
    title: &str,
    source: &'static str,
    quantities: &[Quantity],
    names: &[String],
    runs: &[Vec<Flown>],
) -> Table {
    let cell = |flown: &[Flown], row: &Row, quantity: &Quantity| {
        let values = flown.iter().flat_map(|run| run.series.half(quantity.column));
        let values: Vec<f64> = values.filter_map(|value| quantity.defined(value)).collect();
        Cell::new(&values, (quantity.published)(row).map(Theirs::Mean))
    };
    let rows = names.iter().zip(runs).zip(reference().chapter5.rows());
    Table {
        title: title.to_owned(),
        source,
        note: format!("{POOLED}."),
        mark: "differs by more than both deviations",
        not_published: None,
        corner: "criterion",
        columns: quantities.iter().map(|q| Column::new(q.short, q.unit)).collect(),
        rows: rows
            .map(|((name, flown), row)| {
                (name.clone(), quantities.iter().map(|q| cell(flown, &row, q)).collect())
            })
            .collect(),
    }
}

/// (mean Φ^FoV - mean Φ^g) / mean Φ^FoV, from the cells of both.
fn occlusion(cells: &[Cell], row: &Row) -> Cell {
    let [Some(footprint), Some(seen)] = [cells[0].ours, cells[1].ours] else {
        return Cell::default();
    };
    let ratio = 100.0 * (1.0 - seen.mean / footprint.mean);
    Cell::new(&[ratio], Some(Theirs::Value(row.occlusion_ratio_pct)))
}

fn all_identified_s(run: &Flown) -> Option<f64> {
    run.summary.numbers.get("all_identified_s")
}

/// §5.4.3: when the fleet has identified all targets.
fn identification(names: &[String], runs: &[Vec<Flown>]) -> Table {
    let Chapter5 { timing, .. } = reference().chapter5;
    let by_s = timing.all_identified_by_s;
    let others = Some(Theirs::Below(by_s.others));
    let published = [others, others, others, None, Some(Theirs::Below(by_s.str3_kappa1))];
    let row = |((name, flown), theirs): ((&String, &Vec<Flown>), Option<Theirs>)| {
        let times = flown.iter().map(|r| all_identified_s(r).unwrap_or(r.summary.sim_s));
        let found = flown.iter().filter(|r| all_identified_s(r).is_some()).count();
        let is_at_least = found < flown.len();
        let cell = Cell::new(&times.collect::<Vec<_>>(), theirs).at_least(is_at_least);
        (format!("{name} (all found in {found} of {})", flown.len()), vec![cell])
    };
    Table {
        title: "When the fleet has identified all targets".to_owned(),
        source: "thesis §5.4.3, figure 5.9",
        note: "Mean ± standard deviation over missions; one that never found all counts with its \
               length (≥). In the thesis, (5.27) (str3-kappa0) found all in 2 of 10."
            .to_owned(),
        mark: "exceeds the bound",
        not_published: None,
        corner: "criterion",
        columns: vec![Column::new("all identified", "s")],
        rows: names.iter().zip(runs).zip(published).map(row).collect(),
    }
}

/// §5.4.5: what an update takes.
fn computing(names: &[String], runs: &[Vec<Flown>]) -> Table {
    let Chapter5 { timing: t, .. } = reference().chapter5;
    let (e, m) = (t.estimator_s, t.mpc_s);
    let estimator = [e.str1, e.str2, e.str2, e.str3, e.str3];
    let mpc = [m.str1, m.str2, m.str2, m.str3, m.str3];
    let cell = |flown: &[Flown], stages: fn(&Flown) -> Vec<Spread>, theirs: f64| {
        let seconds = |run| 1e-3 * stages(run).iter().map(|spread| spread.median).sum::<f64>();
        Cell::new(&flown.iter().map(seconds).collect::<Vec<_>>(), Some(Theirs::Value(theirs)))
    };
    let row = |(((name, flown), estimator), mpc): (((&String, &Vec<Flown>), f64), f64)| {
        let update = |run: &Flown| {
            let timing = run.summary.timing_ms;
            vec![timing.sense, timing.estimate, timing.fuse]
        };
        let cells = vec![
            cell(flown, update, estimator),
            cell(flown, |run| vec![run.summary.timing_ms.guidance], mpc),
        ];
        (name.clone(), cells)
    };
    let column = |name| Column { decimals: 4, ..Column::new(name, "s") };
    Table {
        title: "Computing time per UAV and update".to_owned(),
        source: "thesis §5.4.5, figure 5.15, MATLAB on an Intel Core i7-10875H",
        note:
            "Ours: median of each mission, mean ± standard deviation over missions, on one thread \
               of this machine as busy as it was."
                .to_owned(),
        mark: "differs by more than the deviation",
        not_published: None,
        corner: "criterion",
        columns: vec![column("estimator"), column("controller")],
        rows: names.iter().zip(runs).zip(estimator).zip(mpc).map(row).collect(),
    }
}

/// The figures, as markup: a line per criterion.
pub fn figures(names: &[String], runs: &[Vec<Flown>]) -> String {
    let lengths = runs.iter().flatten().filter_map(|run| Some(run.series.points.last()?.time_s));
    let end_s = lengths.fold(1.0, f64::max);
    let step_s = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0].into_iter().find(|s| end_s / s <= TICKS);
    let step_s = step_s.unwrap_or(end_s / TICKS);
    let ticks: Vec<f64> =
        (0..).map(|k| f64::from(k) * step_s).take_while(|t| *t <= end_s).collect();
    let x = XAxis::between("time [s]", [0.0, end_s], &ticks);
    let figures = page::figures(CURVES.iter().filter_map(|quantity| {
        let lines = names.iter().zip(runs).zip(reference().chapter5.rows());
        let lines = lines.map(|((name, flown), row)| curve(quantity, name, flown, &row));
        let (title, unit, top) = (quantity.title, quantity.unit, quantity.top);
        let curves = Curves { title, unit, x: &x, span: [0.0, end_s], top, lines: lines.collect() };
        let note =
            format!("Thesis {}. Band: one standard deviation over missions.", quantity.figure);
        (!curves.is_empty()).then(|| page::figure(&curves.svg(), &note))
    }));
    format!("<h2>Figures</h2>\n{figures}")
}

/// The mean over missions at each instant that all of them have.
fn curve(quantity: &Quantity, name: &str, flown: &[Flown], row: &Row) -> Curve {
    let runs: Vec<Vec<(f64, Option<f64>)>> =
        flown.iter().map(|run| run.series.of(quantity.column).collect()).collect();
    let steps = runs.iter().map(Vec::len).min().unwrap_or(0);
    let points = (0..steps).step_by(DRAWN_STEPS).filter_map(|step| {
        let values = runs.iter().filter_map(|run| quantity.defined(run[step].1));
        Moment::of(runs[0][step].0, &values.collect::<Vec<_>>())
    });
    let published = (quantity.published)(row).map(|[mean, _]| Published { span: SPAN_S, mean });
    let reaches = flown.iter().all(|run| run.summary.sim_s >= SPAN_S[1]);
    Curve {
        name: name.to_owned(),
        points: points.collect(),
        published: published.filter(|_| reaches),
    }
}
