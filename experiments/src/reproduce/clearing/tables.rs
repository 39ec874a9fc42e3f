//! Ours beside theirs.

use super::uavs::Uav;
use super::{Clearings, Shown};
use crate::reproduce::flown::Flown;
use crate::reproduce::table::{Cell, Column, Table, Theirs};

/// A number of a mission, if it has it.
type Number<'a> = Box<dyn Fn(&Flown, &[Uav]) -> Option<f64> + 'a>;

/// All tables.
pub(super) fn all(seen: &Clearings<'_>) -> Vec<Table> {
    seen.shown.iter().map(setting).chain([clearing(seen)]).collect()
}

/// What the paper says of its simulation.
fn setting(shown: &Shown) -> Table {
    let config = shown.mission.config();
    let [width_m, _] = shown.view.size_m;
    let rows = [
        ("UAVs", f64::from(config.fleet.count), 8.0),
        ("width of the region, m", width_m, 500.0),
        ("width of the roads, m", shown.road_width_m, 6.0),
        ("altitude, m", config.fleet.altitude_m, 70.0),
        ("field of view, °", config.camera.aperture_deg, 80.0),
        ("width of the image, pixels", f64::from(config.camera.columns), 256.0),
        ("frequency, Hz", 1.0 / config.period_s, 8.0),
        ("displacement per step, mm", 1000.0 * config.clearing.step_m, 125.0),
    ];
    let row = |(name, ours, theirs): (&str, f64, f64)| {
        (name.to_owned(), vec![Cell::new(&[ours], Some(Theirs::Value(theirs)))])
    };
    Table {
        title: "The setting".to_owned(),
        source: "Gagliardi et al. VI",
        note: "The paper's network, near Lancaster (California), is not published. The ranges of its radios and the \
               size of its margin are not given."
            .to_owned(),
        mark: "",
        not_published: None,
        corner: "",
        columns: vec![Column { name: "value".to_owned(), decimals: 0 }],
        rows: rows.into_iter().map(row).collect(),
    }
}

/// A value of the summary.
fn of_summary(key: &'static str) -> Number<'static> {
    Box::new(move |run, _| run.summary.numbers.get(key))
}

/// The numbers of UAVs that were a cleaner, or never were.
fn count(was_cleaner: bool) -> Number<'static> {
    Box::new(move |_, uavs| {
        Some(uavs.iter().filter(|uav| uav.was_cleaner == was_cleaner).count() as f64)
    })
}

/// Of the shares of those that were cleaners.
fn share(of: fn(f64, f64) -> f64) -> Number<'static> {
    Box::new(move |_, uavs| {
        uavs.iter().filter(|uav| uav.was_cleaner).map(Uav::share_pct).reduce(of)
    })
}

/// Metres per second and UAV until the network is cleared, or else until the end.
fn speed(run: &Flown, uavs: &[Uav]) -> Option<f64> {
    let end_s = run.summary.numbers.get("cleared_s").unwrap_or(run.summary.sim_s);
    let paths_m = uavs.iter().map(|uav| uav.path_m_at(end_s)).sum::<f64>();
    (end_s > 0.0).then(|| paths_m / end_s / uavs.len() as f64)
}

fn clearing(seen: &Clearings<'_>) -> Table {
    let beyond = |run: &Flown, _: &[Uav]| {
        let number = |key| run.summary.numbers.get(key);
        Some(number("cleaners_max")? - number("edge_search_at_most")?)
    };
    let rows: Vec<(&str, Number<'_>, Option<f64>)> = vec![
        ("cleared at the end, % of R_S", of_summary("cleared_pct"), Some(100.0)),
        ("time until all is cleared, s", of_summary("cleared_s"), None),
        ("UAVs that were cleaner", count(true), Some(7.0)),
        ("UAVs that never were cleaner", count(false), Some(1.0)),
        ("most cleaners at a time", of_summary("cleaners_max"), None),
        ("edge search number, at least", of_summary("edge_search_at_least"), None),
        ("edge search number, at most", of_summary("edge_search_at_most"), None),
        ("most cleaners less the edge search number", Box::new(beyond), None),
        ("node search number, at least", of_summary("node_search_at_least"), None),
        ("node search number, at most", of_summary("node_search_at_most"), None),
        ("least share of a cleaner, % of R_S", share(f64::min), None),
        ("greatest share of a cleaner, % of R_S", share(f64::max), None),
        ("mean speed until all is cleared, m/s", Box::new(speed), None),
        ("splits", of_summary("splits"), None),
        ("encounters", of_summary("encounters"), None),
        ("merges", of_summary("merges"), None),
    ];
    let row = |(name, number, theirs): (&str, Number<'_>, Option<f64>)| {
        let values = seen.runs.iter().zip(&seen.uavs).map(|(run, uavs)| number(run, uavs));
        let values: Vec<Option<f64>> = values.collect();
        let first: Vec<f64> = values.first().copied().flatten().into_iter().collect();
        let all: Vec<f64> = values.into_iter().flatten().collect();
        let cells =
            vec![Cell::new(&first, theirs.map(Theirs::Value)), Cell::with_range(&all, None)];
        (name.to_owned(), cells)
    };
    let cleared = seen.runs.iter().filter(|run| run.summary.numbers.get("cleared_s").is_some());
    let first = seen.runs.first().map_or(1, |run| run.summary.seed);
    Table {
        title: "The clearing".to_owned(),
        source: "Gagliardi et al. VI, figures 8 to 10",
        note: format!(
            "Theirs is one run, in their network; figure 10 prints no numbers. All missions: mean, deviation and range; \
             {} of {} networks were cleared. The search numbers are those of the centre lines, for searchers that see a \
             point each: a reference, no bound, as a camera sees more.",
            cleared.count(),
            seen.runs.len()
        ),
        mark: "",
        not_published: None,
        corner: "",
        columns: vec![
            Column { name: format!("seed {first}"), decimals: 1 },
            Column { name: "all missions".to_owned(), decimals: 1 },
        ],
        rows: rows.into_iter().map(row).collect(),
    }
}
