//! The numbers that §4.7 states, and ours.

use super::Chapter4;
use super::figures::Covered;
use super::look::{Looks, SEPARATIONS_M, Seen};
use super::scene::{CARS_M, distance_m};
use crate::published::{Reference, reference};
use crate::reproduce::table::{Cell, Column, Table, Theirs};

/// The tables.
pub fn tables(seen: &Chapter4) -> Vec<Table> {
    let mut tables = vec![accuracy(seen.plain()), exclusion(seen), oem(&seen.oem_iou_pct)];
    for (family, looks) in &seen.families {
        let rows = family.settings.iter().zip(looks).flat_map(|(setting, looks)| {
            let name = &setting.name;
            let row = move |car| (format!("{name}, {:.0} m", distance_m(car)), sizes(looks, car));
            (0..CARS_M.len()).map(row)
        });
        tables.push(Table {
            title: family.title.to_owned(),
            source: family.figure,
            note: "Theirs is drawn, not printed.".to_owned(),
            mark: "",
            not_published: None,
            corner: "setting, distance",
            columns: size_columns(),
            rows: rows.collect(),
        });
    }
    tables
}

/// The columns of [`sizes`].
pub fn size_columns() -> Vec<Column> {
    vec![
        Column::new("measured radius", "m"),
        Column::new("set radius", "m"),
        Column::new("point error", "m"),
    ]
}

/// The sizes of what looks say of a car.
pub fn sizes(looks: &Looks, car: usize) -> Vec<Cell> {
    let values: [fn(&Seen) -> f64; 3] =
        [|s| s.measured_radius_m, |s| s.set_radius_m, |s| s.error_m];
    values.map(|value| Cell::new(&looks.values(car, value), None)).to_vec()
}

/// §4.7.2: a point error of less than 2 m; the set of the nearest car is also in chapter 6.
fn accuracy(looks: &Looks) -> Table {
    let Reference { chapter4, chapter6, .. } = reference();
    let rows = (0..CARS_M.len()).map(|car| {
        let mut cells = sizes(looks, car);
        if car == 0 {
            cells[1].theirs = Some(Theirs::Value(chapter6.target_60m_radius_m.exact));
        }
        cells[2].theirs = Some(Theirs::Below(chapter4.point_error_below_m));
        (format!("{:.0} m", distance_m(car)), cells)
    });
    Table {
        title: "One look at five cars".to_owned(),
        source: "thesis §4.7.2 and figure 4.11; set radius: chapter 6",
        note: "Mean ± standard deviation over the looks.".to_owned(),
        mark: "exceeds the bound, or differs by more than the deviation",
        not_published: None,
        corner: "distance",
        columns: size_columns(),
        rows: rows.collect(),
    }
}

/// §4.7.3: how much of the shadow of a car the least distance between cars clears.
fn exclusion(seen: &Chapter4) -> Table {
    let covers = reference().chapter4.exclusion_covers_shadow;
    let (headings, looks) = &seen.families[0];
    let ways: [(&str, Covered); 2] = [
        ("measured set", |seen| seen.covered_pct),
        ("set estimate", |seen| seen.covered_by_set_pct),
    ];
    let mut rows = Vec::new();
    for ((way, covered), (heading, looks)) in
        ways.iter().flat_map(|way| headings.settings.iter().zip(looks).map(move |look| (way, look)))
    {
        for car in 0..CARS_M.len() {
            let distance_m = distance_m(car).round();
            let cells = SEPARATIONS_M.iter().enumerate().map(|(i, separation_m)| {
                let is_published =
                    *separation_m == covers.r_s_tt_m && distance_m <= covers.up_to_distance_m;
                let theirs = is_published.then_some(Theirs::Value(100.0));
                Cell::new(&looks.values(car, |seen| covered(seen)[i]), theirs)
            });
            rows.push((format!("{way}, {}, {distance_m} m", heading.name), cells.collect()));
        }
    }
    Table {
        title: "Exclusion over shadow".to_owned(),
        source: "thesis §4.7.3, figure 4.19",
        note:
            "Share of the ground behind a car's Target pixels that has no other car in it, by the \
               exclusion (4.17) round its measured set, and by the one round its set estimate."
                .to_owned(),
        mark: "differs by more than the deviation",
        not_published: None,
        corner: "round, heading, distance",
        columns: SEPARATIONS_M.map(|s| Column::new(&format!("cars {s} m apart"), "%")).to_vec(),
        rows,
    }
}

/// §4.7.6.
fn oem(iou_pct: &[f64]) -> Table {
    let theirs = Theirs::Value(reference().chapter4.oem_iou_pct);
    Table {
        title: "Occupancy-elevation map of one look at buildings".to_owned(),
        source: "thesis §4.7.6, figure 4.27",
        note:
            "Their scene is not published: ours has three buildings about where the text has them."
                .to_owned(),
        mark: "differs by more than the deviation",
        not_published: None,
        corner: "scene",
        columns: vec![Column::new("hidden ground, intersection over union", "%")],
        rows: vec![("three buildings".to_owned(), vec![Cell::new(iou_pct, Some(theirs))])],
    }
}
