//! Ours beside theirs.

use super::Tisdale;
use super::filters::{KINDS, Last};
use crate::reproduce::table::{Cell, Column, Ours, Table, Theirs};
use csat_world::navigation::NavigationModel;

/// Table II: what is uncertain, and the deviation of the target's estimate that follows, metres.
const TABLE_2: [(&str, f64); 6] = [
    ("T_X (along-track), σ 10.5 m", 10.5),
    ("T_Y (cross-track), σ 5.5 m", 5.5),
    ("h = 90 m, σ 5.5 m", 1.77),
    ("ψ = 0, σ 0.01 rad", 0.29),
    ("θ = 0.17 rad, σ 0.05 rad", 4.65),
    ("φ = 0.26 rad, σ 0.02 rad", 1.96),
];

/// The nominal values of table II: T_X, T_Y, h in metres, ψ, θ, φ in radians.
pub const NOMINAL: [f64; 6] = [0.0, 0.0, 90.0, 0.0, 0.17, 0.26];

/// (10): where the axis e_3 of an aircraft meets the ground, for T_X, T_Y, h, ψ, θ, φ.
pub fn target([t_x, t_y, h, psi, theta, phi]: [f64; 6]) -> [f64; 2] {
    let scale = h / (phi.cos() * theta.cos());
    [
        t_x + scale * (phi.cos() * theta.sin() * psi.cos() + phi.sin() * psi.sin()),
        t_y + scale * (phi.cos() * theta.sin() * psi.sin() - phi.sin() * psi.cos()),
    ]
}

/// The deviation of the target's estimate that follows from one of the deviations of table II, metres.
pub fn deviation_m(index: usize) -> f64 {
    let h = 1e-6;
    let at = |step: f64| {
        let mut parameters = NOMINAL;
        parameters[index] += step;
        target(parameters)
    };
    let ([x0, y0], [x1, y1]) = (at(-h), at(h));
    NavigationModel::default().sigma[index] * (x1 - x0).hypot(y1 - y0) / (2.0 * h)
}

/// All tables.
pub fn tables(seen: &Tisdale) -> Vec<Table> {
    vec![table_2(), detection(seen), ends(seen)]
}

fn table_2() -> Table {
    let row = |(index, (name, theirs)): (usize, &(&str, f64))| {
        let ours = Ours { mean: deviation_m(index), ..Ours::default() };
        ((*name).to_owned(), vec![Cell { ours: Some(ours), theirs: Some(Theirs::Value(*theirs)) }])
    };
    Table {
        title: "What the errors of a pose make of a target's place".to_owned(),
        source: "Tisdale et al. table II",
        note: "Partial derivatives of (10) at the nominal values, times the deviations.".to_owned(),
        mark: "",
        not_published: None,
        corner: "parameter",
        columns: vec![Column::new("σ of the place", "m")],
        rows: TABLE_2.iter().enumerate().map(row).collect(),
    }
}

fn detection(seen: &Tisdale) -> Table {
    let times: Vec<f64> = seen.flights.iter().filter_map(|flight| flight.detected_s()).collect();
    let count = seen.count();
    let late = count - times.len();
    let p_at = |time_s: f64| {
        let at = seen.shown().step_at(time_s).0 as usize;
        seen.curves[0].cumulative_detection.get(at).copied().into_iter().collect::<Vec<f64>>()
    };
    let first = Cell::new(&times, Some(Theirs::Value(super::DETECTED_S)));
    let rows = vec![
        ("first detection, s".to_owned(), vec![first]),
        ("P(D) at 70 s".to_owned(), vec![Cell::new(&p_at(70.0), None)]),
        ("P(D) at 105 s".to_owned(), vec![Cell::new(&p_at(105.0), None)]),
    ];
    Table {
        title: "The search".to_owned(),
        source: "Tisdale et al. figures 3 and 5",
        note: format!(
            "First detection: mean and deviation over the flights; {late} of {count} did not detect the target. \
             Theirs is one flight. P(D) of the flight that the figures show; the paper prints no numbers."
        ),
        mark: "",
        not_published: None,
        corner: "",
        columns: vec![Column { name: "value".to_owned(), decimals: 2 }],
        rows,
    }
}

fn ends(seen: &Tisdale) -> Table {
    let found: Vec<usize> =
        (0..seen.count()).filter(|i| seen.flights[*i].detected_at().is_some()).collect();
    let values = |kind: usize, of: fn(&Last) -> f64| -> Vec<f64> {
        found.iter().map(|flight| of(&seen.ends[*flight][kind])).collect()
    };
    let row = |(index, kind): (usize, &super::filters::Kind)| {
        let cells =
            [|last: &Last| last.error_m, |last: &Last| last.sigma_m, |last: &Last| last.distance]
                .map(|of| Cell::new(&values(index, of), None));
        (kind.name.to_owned(), cells.to_vec())
    };
    Table {
        title: "The target's place at the end".to_owned(),
        source: "Tisdale et al. figures 6 and 7, which print no numbers",
        note: format!(
            "Mean and deviation over the {} flights that detected the target. Error over sigma is the \
             Mahalanobis distance: about 1.25 in the mean for a belief that is neither too sure nor too timid.",
            found.len()
        ),
        mark: "",
        not_published: None,
        corner: "representation",
        columns: vec![
            Column::new("error", "m"),
            Column::new("sigma", "m"),
            Column { name: "error over sigma".to_owned(), decimals: 2 },
        ],
        rows: KINDS.iter().enumerate().map(row).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// To the digit before the last one that is printed.
    #[test]
    fn table_2_is_the_published_one() {
        for (index, (name, theirs)) in TABLE_2.iter().enumerate() {
            let ours = deviation_m(index);
            assert!((ours - theirs).abs() < 0.06, "{name}: {ours}, published {theirs}");
        }
    }
}
