//! What an agent makes of frames, of late messages and of its map.

use csat_agent::estimate::Estimator;
use csat_agent::estimate::evidence::Ager;
use csat_agent::estimate::predict::Predictor;
use csat_agent::region::Outer;
use csat_experiments::plot::canvas::{Panel, group, label};
use csat_experiments::plot::{layers, town};
use csat_experiments::set_membership::layers as known;
use csat_mission::picture::{self, Layer};
use csat_proto::model::Ground;
use csat_proto::raster::{Grid, Raster};
use csat_proto::region::{Region, grid_point};
use csat_proto::time::Step;
use svg::node::element::Group;

use super::flight::{Recorded, nearest_detection, shapes};
use super::sensing::{BUILDING, CAR, CLEAR, TARGET, area, looks, scene};
use super::sheet::{Sheet, Style};

/// X̄.
const UNEXPLORED: Style = Style::fill(known::UNEXPLORED, 0.85).outlined("#B79F00", 0.8);
/// What a prediction adds.
const ADDED: Style = Style::fill("#D55E00", 0.8);
/// What a correction removes.
const REMOVED: Style = Style::fill("#9ED3F0", 0.9);
/// X^h.
const HIDDEN: Style = Style::fill("url(#hatch-hidden)", 1.0);

/// One step of X̄: before, predicted, corrected.
pub fn predict_and_correct(recorded: &Recorded) -> String {
    const SIDE_M: f64 = 40.0;
    let (config, step) = (recorded.config(), recorded.step());
    let before = recorded.before.unexplored.clone();
    let predicted = Predictor::new(config).predict(&mut recorded.before.clone(), Some(step));
    let predicted = predicted.unexplored.resolved();
    let mut corrected = recorded.before.clone();
    let own = recorded.agent().measured().map(|measured| (step, measured));
    Estimator::new(config).update(&mut corrected, own, Vec::new());
    let corrected = corrected.unexplored.clone();
    // X° takes back what has grown into it at every step, whatever the frame shows.
    let beyond_margin = predicted.minus([&recorded.before.margin]);
    let window = most_changed(&config.ground, beyond_margin.region(), corrected.region(), SIDE_M);
    // What is far outside of the window only makes the file larger.
    let near = Outer::containing(square(window, SIDE_M + 4.0));
    let [before, predicted, corrected] =
        [before, predicted, corrected].map(|set| shapes(set.intersection(&near).region()));
    let mut sheet = Sheet::new(980.0);
    let width = sheet.share(3);
    let base = |panel: &Panel| {
        group("town")
            .add(town::ground(panel, &recorded.view))
            .add(town::buildings(panel, &recorded.view))
    };
    let place = (window, [SIDE_M; 2]);
    sheet.window((0, width), "X̄ at step k-1", place, |panel| {
        base(panel).add(area(panel, &before, UNEXPLORED))
    });
    sheet.window((1, width), "Predicted: grown by v_max T", place, |panel| {
        base(panel).add(area(panel, &predicted, ADDED)).add(area(panel, &before, UNEXPLORED_SOLID))
    });
    sheet.window((2, width), "Corrected with the frame of step k", place, |panel| {
        base(panel).add(area(panel, &predicted, REMOVED)).add(area(
            panel,
            &corrected,
            UNEXPLORED_SOLID,
        ))
    });
    sheet.key(&[
        (UNEXPLORED, "X̄, where cars not found yet can be (outer)"),
        (ADDED, "added: 0.5 m all around"),
        (REMOVED, "removed: the frame proves no car there"),
    ]);
    sheet.finish()
}

/// The same, hiding what is under it.
const UNEXPLORED_SOLID: Style = Style::fill(known::UNEXPLORED, 1.0).outlined("#B79F00", 0.8);

/// An axis-aligned square.
fn square([x, y]: [f64; 2], side_m: f64) -> Region {
    let half = side_m / 2.0;
    let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
    let ring = corners.map(|[a, b]| grid_point([x + a, y + b])).to_vec();
    Region::from_shapes(vec![vec![ring]])
}

/// The middle of the square in which most of a set goes and most of it stays.
fn most_changed(ground: &Ground, from: &Region, to: &Region, side_m: f64) -> [f64; 2] {
    let grid = Grid::covering(ground, 1.0);
    let (from, to) = (Raster::of_region(grid, from), Raster::of_region(grid, to));
    let half = side_m / 2.0;
    let count = |set: &Raster, [x, y]: [f64; 2]| {
        let columns = grid.columns_between(x - half, x + half);
        let rows = grid.rows_between(y - half, y + half);
        let cells = rows.flat_map(|row| columns.clone().map(move |column| (column, row)));
        cells.filter(|&(column, row)| set.get(column, row)).count()
    };
    let [w, h] = ground.size_m.map(|s| s / 2.0 - half);
    let along = |most: f64| (0..=40).map(move |i| -most + f64::from(i) * most / 20.0);
    let places = along(h).flat_map(|y| along(w).map(move |x| [x, y]));
    let score = |place: &[f64; 2]| {
        let (was, is) = (count(&from, *place), count(&to, *place));
        (2 * (was - is.min(was))).min(is)
    };
    places.max_by_key(score).unwrap_or_default()
}

/// What one frame hides, and what the map says of it.
pub fn hidden_and_oem(recorded: &mut Recorded) -> String {
    let predicted = {
        let viewer = recorded.viewer;
        recorded.agents[viewer].predicted_hidden()
    };
    let recorded = &*recorded;
    let (now, predicted) = (picture::cells(&recorded.measured.hidden), picture::cells(&predicted));
    let mut sheet = Sheet::new(980.0);
    let width = sheet.share(2);
    let place = scene(recorded);
    sheet.window((0, width), "What this frame does not show", place, |panel| {
        group("hidden-now")
            .add(town::ground(panel, &recorded.view))
            .add(area(panel, &shapes(recorded.measured.clear_ground.region()), CLEAR))
            .add(HIDDEN.on(panel.cells(&now)))
            .add(town::buildings(panel, &recorded.view))
            .add(looks(panel, recorded))
    });
    sheet.window((1, width), "What the map of buildings lets expect", place, |panel| {
        group("oem")
            .add(town::ground(panel, &recorded.view))
            .add(oem(panel, recorded))
            .add(HIDDEN.on(panel.cells(&predicted)))
            .add(town::outlines(panel, &recorded.view))
            .add(looks(panel, recorded))
    });
    sheet.key(&[
        (CLEAR, "C, clear ground"),
        (HIDDEN, "hidden ground: in the frame, and expected"),
        (Style::fill(known::OEM, 0.8), "Occupied, darker when higher"),
        (Style::fill("#D7E8F3", 1.0), "Empty"),
        (BUILDING, "building in truth"),
    ]);
    sheet.finish()
}

/// The viewer's map of buildings.
fn oem(panel: &Panel, recorded: &Recorded) -> Group {
    let style = known::LAYERS.iter().find(|style| style.key == "oem").expect("a layer of it");
    let layer = Layer::of(recorded.view.of_agent(0), style).expect("the report has its maps");
    layers::filled(panel, style, &layer.content)
}

/// What a message proves when it comes late.
pub fn ageing(recorded: &Recorded) -> String {
    const AGES_S: [f64; 4] = [0.0, 3.0, 8.0, 15.0];
    const SHADES: [f64; 4] = [0.25, 0.3, 0.45, 0.8];
    let config = recorded.config();
    let ager = Ager::new(config);
    let now = |age_s: f64| Step((age_s / recorded.period_s).round() as u32);
    let reach = |age_s: f64| ager.reach(now(age_s), Step(0));
    let clear = &recorded.measured.clear_ground;
    let (target, place) = nearest_detection(recorded).expect("the viewer sees a car");
    let seen = recorded.measured.targets.iter().find(|seen| seen.target == target);
    let location = &seen.expect("it is the one just found").location;
    let mut sheet = Sheet::new(980.0);
    let width = sheet.share(2);
    sheet.window((0, width), "Inner: clear ground erodes", scene(recorded), |panel| {
        let town = group("clear").add(town::ground(panel, &recorded.view));
        let eroded = AGES_S.iter().zip(SHADES).fold(town, |all, (&age_s, opacity)| {
            let set = reach(age_s).map_or_else(|| clear.clone(), |r| clear.eroded_far(&r));
            let style = Style { opacity, ..Style::fill("#2F7FA8", 1.0).outlined("#1D5A7A", 0.8) };
            all.add(area(panel, &shapes(set.region()), style))
        });
        eroded.add(town::buildings(panel, &recorded.view)).add(looks(panel, recorded))
    });
    let title = format!("Outer: the set of car {} dilates", target.0);
    sheet.window((1, width), &title, (place, [46.0; 2]), |panel| {
        let town = group("location").add(town::ground(panel, &recorded.view));
        let grown = AGES_S.iter().zip(SHADES).rev().fold(town, |all, (&age_s, opacity)| {
            let bounds = Region::rectangle(config.ground.size_m);
            let set = reach(age_s)
                .map_or_else(|| location.clone(), |r| location.dilated_far(&r, &bounds));
            let style = Style { opacity: 0.95 - opacity, ..TARGET };
            let shapes = shapes(set.region());
            let highest = shapes.iter().flatten().flatten().copied();
            let highest = highest.max_by(|a, b| a[1].total_cmp(&b[1])).unwrap_or(place);
            let [x, y] = panel.pixel(highest);
            let words = format!("{age_s} s: {:.0} m²", set.region().area_m2());
            all.add(area(panel, &shapes, style)).add(label(x, y + 15.0, 12.0, "#00573F", words))
        });
        grown.add(town::cars(panel, &recorded.view, 0))
    });
    let shade = |opacity| Style::fill("#2F7FA8", opacity);
    sheet.key(&[
        (shade(0.25), "still clear after 0 s"),
        (shade(0.48), "3 s"),
        (shade(0.71), "8 s"),
        (shade(0.93), "15 s"),
        (TARGET, "where the car can be by then"),
        (CAR, "the car in truth, at 0 s"),
    ]);
    sheet.finish()
}
