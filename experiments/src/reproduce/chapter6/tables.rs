//! The numbers that §6.6 and A.4 state, and ours.

use super::Chapter6;
use super::settings::{POSITION_M, RADII_M};
use super::sivia::Paving;
use crate::published::reference;
use crate::reproduce::chapter4::scene::{CARS_M, distance_m};
use crate::reproduce::chapter4::tables::{size_columns, sizes};
use crate::reproduce::table::{Cell, Column, Table, Theirs};

/// The tables.
pub fn tables(seen: &Chapter6) -> Vec<Table> {
    vec![footprint(seen), cars(seen), margins(seen), times(seen), rings(&seen.rings)]
}

/// §6.6.3: (6.64).
fn footprint(seen: &Chapter6) -> Table {
    let published = reference().chapter6.footprint_guaranteed_pct;
    let theirs = [published.u1, published.u2, published.u3, published.u4];
    let rows = seen.seen[1..].iter().zip(theirs).map(|(one, theirs)| {
        let cell = Cell::new(&[seen.footprint_pct(one)], Some(Theirs::Value(theirs)));
        (one.uncertainty.name.clone(), vec![cell])
    });
    Table {
        title: "Share of the footprint that is seen for certain".to_owned(),
        source: "thesis §6.6.3, (6.64)",
        note:
            "Of the footprint from the exact pose. More is better: theirs is made of boxes of 2 m."
                .to_owned(),
        mark: "",
        not_published: None,
        corner: "box of poses",
        columns: vec![Column::new("seen from all poses", "%")],
        rows: rows.collect(),
    }
}

/// §6.6.4, figure 6.7.
fn cars(seen: &Chapter6) -> Table {
    let published = reference().chapter6.target_60m_radius_m;
    let mut rows = Vec::new();
    for one in &seen.seen {
        for car in 0..CARS_M.len() {
            let mut cells = sizes(&one.looks, car);
            if car == 0 {
                cells[1].theirs = match one.uncertainty.name.as_str() {
                    "exact" => Some(Theirs::Value(published.exact)),
                    "u1" => Some(Theirs::Mean(published.u1)),
                    _ => None,
                };
            }
            rows.push((format!("{}, {:.0} m", one.uncertainty.name, distance_m(car)), cells));
        }
    }
    Table {
        title: "One look at five cars".to_owned(),
        source: "thesis §6.6.4, figure 6.7",
        note: "Mean ± standard deviation over the looks.".to_owned(),
        mark: "differs by more than the deviation",
        not_published: None,
        corner: "box of poses, distance",
        columns: size_columns(),
        rows,
    }
}

/// §6.6.5, figure 6.9.
fn margins(seen: &Chapter6) -> Table {
    let rows = POSITION_M.iter().zip(&seen.margins).map(|(half_m, margins)| {
        let cells = margins.iter().map(|region| Cell::new(&[region.area_m2()], None));
        (format!("±{half_m} m"), cells.collect())
    });
    Table {
        title: "Ground too near to an obstacle for any car, in one look at buildings".to_owned(),
        source: "thesis §6.6.5, figure 6.9",
        note: "Area of S°. Theirs is drawn, not printed, and its scene is not published."
            .to_owned(),
        mark: "",
        not_published: None,
        corner: "error of x and y; else u1",
        columns: RADII_M.map(|r| Column::new(&format!("r_s^to = {r} m"), "m²")).to_vec(),
        rows: rows.collect(),
    }
}

/// §6.6.4: what it takes.
fn times(seen: &Chapter6) -> Table {
    let published = reference().chapter6.one_target_s;
    let rows = seen.seen.iter().map(|one| {
        let is_published = one.uncertainty.name == "u4";
        let theirs = is_published.then_some(Theirs::Mean(published.thick_sivia));
        let cells = vec![Cell::new(&[one.target_s], theirs), Cell::new(&[one.frame_s], None)];
        (one.uncertainty.name.clone(), cells)
    });
    let column = |name: &str| Column { decimals: 4, ..Column::new(name, "s") };
    Table {
        title: "Time on this machine".to_owned(),
        source: "thesis §6.6.4: MATLAB on an Intel Core i7-10875H",
        note: format!(
            "The least of a few. Theirs is Thick SIVIA; inversion alone, which makes larger sets, takes {} s.",
            published.inverse_only
        ),
        mark: "",
        not_published: None,
        corner: "box of poses",
        columns: vec![column("set of the car at 60 m"), column("all sets of the frame")],
        rows: rows.collect(),
    }
}

/// A.3 and A.4: counts of boxes.
fn rings([exact, sivia, outer, inner]: &[Paving; 4]) -> Table {
    let theirs: [(&str, &Paving, [Option<f64>; 3]); 4] = [
        ("SIVIA, p = 0 (A.6)", exact, [Some(304.0), None, Some(920.0)]),
        ("SIVIA, p in [-0.5, 0.5]² (A.7)", sivia, [Some(236.0), None, Some(8672.0)]),
        ("Thick SIVIA for X^∃ (A.9)", outer, [None, Some(272.0), Some(912.0)]),
        ("Thick SIVIA for X^∀ (A.10)", inner, [Some(236.0), Some(1752.0), Some(1752.0)]),
    ];
    let rows = theirs.map(|(name, paving, theirs)| {
        let ours =
            [&paving.inside, &paving.penumbra, &paving.border].map(|cells| cells.len() as f64);
        let cell =
            |(ours, theirs): (f64, Option<f64>)| Cell::new(&[ours], theirs.map(Theirs::Value));
        (name.to_owned(), ours.into_iter().zip(theirs).map(cell).collect())
    });
    let column = |name: &str| Column { decimals: 0, ..Column::new(name, "boxes") };
    Table {
        title: "Set inversion of the example (A.21)".to_owned(),
        source: "thesis figures A.6, A.7 and A.10",
        note: "Boxes are bisected down to a side of 0.1. Theirs of the border are halves: 920 = 2 · 460. What is printed of \
               A.10 has the same number twice."
            .to_owned(),
        mark: "",
        not_published: None,
        corner: "algorithm",
        columns: vec![column("inside"), column("penumbra"), column("border")],
        rows: rows.to_vec(),
    }
}
