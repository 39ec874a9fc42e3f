//! What one frame shows and proves, and what sets guarantee.

use csat_experiments::plot::canvas::{Panel, group, label, text};
use csat_experiments::plot::{town, uav_colour};
use csat_experiments::set_membership::layers as known;
use csat_mission::picture::Shapes;
use csat_proto::frame::{Detection, Frame, Label};
use svg::node::element::{Group, Path, Rectangle};

use super::flight::{Recorded, nearest_detection, shapes};
use super::sheet::{GAP_PX, Sheet, Style};

/// The colours of labels.
const LABELS: [(Label, &str, &str); 4] = [
    (Label::Ground, "#DCD6C2", "Ground"),
    (Label::Obstacle, town::BUILDING, "Obstacle"),
    (Label::Target, known::TARGET_SET, "Target"),
    (Label::Unknown, "#1B1B1B", "Unknown"),
];
/// C, the clear ground.
pub const CLEAR: Style = Style::fill("#9ED3F0", 0.75).outlined("#2F7FA8", 0.8);
/// Buildings, for explanations.
pub const BUILDING: Style = Style::fill(town::BUILDING, 1.0).outlined("#4A4A4A", 0.6);
/// X°, the obstacle margin.
pub const MARGIN: Style = Style::fill("url(#hatch-obstacles)", 1.0).outlined("#000000", 0.7);
/// A set of an identified target.
pub const TARGET: Style = Style::fill(known::TARGET_SET, 0.6).outlined("#00573F", 1.0);
/// X̲.
const EXCLUSION: Style = Style::fill("#5D3A9B", 0.12).outlined("#5D3A9B", 1.6);
/// A car.
pub const CAR: Style = Style::fill("#000000", 1.0).outlined("#ffffff", 1.0);

/// An area in a style.
pub fn area(panel: &Panel, shapes: &Shapes, style: Style) -> Path {
    style.on(panel.area(shapes))
}

/// Where a UAV looks from and to.
pub fn looks(panel: &Panel, recorded: &Recorded) -> Group {
    let colour = uav_colour(recorded.viewer);
    let outline = Style::line(colour, 1.4).dashed("6 4").on(panel.area_of([&recorded.footprint()]));
    let [x, y, _] = recorded.pose().p_world;
    let [px, py] = panel.pixel([x, y]);
    let (s, c) = recorded.pose().yaw_rad.sin_cos();
    let tip = |a: f64, b: f64| format!("{:.1} {:.1}", px + a * c - b * s, py - a * s - b * c);
    let arrow =
        format!("M{}L{}L{}L{}Z", tip(13.0, 0.0), tip(-8.0, 7.0), tip(-4.0, 0.0), tip(-8.0, -7.0));
    let arrow = Path::new().set("d", arrow).set("fill", colour).set("stroke", "#ffffff");
    let name = format!("U{}", recorded.viewer);
    group("uav").add(outline).add(arrow).add(label(px, py - 14.0, 13.0, colour, name))
}

/// The camera's image, upright, and the same view from above.
pub fn frame(recorded: &Recorded) -> String {
    let mut sheet = Sheet::new(980.0);
    let camera = recorded.config().camera;
    let (columns, rows) = (f64::from(camera.columns), f64::from(camera.rows));
    let top = GAP_PX / 2.0 + 26.0;
    let title = format!("What UAV {} reports, {} x {} pixels", recorded.viewer, columns, rows);
    sheet.add(text(GAP_PX, 24.0, 14.0, title).set("font-weight", "bold"), 0.0);
    // Rows and columns count from the ground up and from the right, as on the sensor (3.16).
    let upright = format!("translate({} {}) rotate(180)", GAP_PX + columns, top + rows);
    let mut image = Group::new().set("transform", upright).set("shape-rendering", "crispEdges");
    for (wanted, colour, _) in LABELS {
        let runs = runs(&recorded.frame, usize::from(camera.columns), wanted);
        image = image.add(Path::new().set("d", runs).set("fill", colour));
    }
    let boxes = recorded.frame.detections.iter().map(detection_box);
    sheet.add(boxes.fold(image, |image, one| image.add(one)), top + rows);
    for detection in &recorded.frame.detections {
        let [c, r] = [f64::from(detection.pixels.columns[0]), f64::from(detection.pixels.rows[1])];
        let (x, y) = (GAP_PX + columns - c + 10.0, top + rows - r - 6.0);
        sheet.add(label(x, y, 13.0, "#00573F", detection.target.0.to_string()), 0.0);
    }
    let (centre, [side, _]) = scene(recorded);
    let width = 980.0 - 3.0 * GAP_PX - columns;
    let size = [side * width / rows, side];
    let left = 2.0 * GAP_PX + columns;
    sheet.window_at(left, width, "What is there, from above", (centre, size), |panel| {
        group("truth")
            .add(town::ground(panel, &recorded.view))
            .add(town::buildings(panel, &recorded.view))
            .add(town::cars(panel, &recorded.view, 0))
            .add(looks(panel, recorded))
    });
    let mut key: Vec<(Style, &str)> =
        LABELS.iter().map(|&(_, colour, name)| (Style::fill(colour, 1.0), name)).collect();
    key.push((Style::line("#00573F", 1.5), "box of an identified car"));
    key.push((Style::line(uav_colour(recorded.viewer), 1.4).dashed("6 4"), "footprint"));
    key.push((CAR, "a car"));
    sheet.key(&key);
    sheet.finish()
}

fn detection_box(detection: &Detection) -> Rectangle {
    let [c0, c1] = detection.pixels.columns.map(f64::from);
    let [r0, r1] = detection.pixels.rows.map(f64::from);
    Rectangle::new()
        .set("x", c0 - 2.0)
        .set("y", r0 - 2.0)
        .set("width", c1 - c0 + 5.0)
        .set("height", r1 - r0 + 5.0)
        .set("fill", "none")
        .set("stroke", "#00573F")
        .set("stroke-width", 1.5)
}

/// The runs of a label in each row, as path data. Runs that stand below equal ones make one box.
fn runs(frame: &Frame, columns: usize, wanted: Label) -> String {
    let mut open: Vec<(usize, usize, usize)> = Vec::new();
    let mut data = String::new();
    let mut close = |(first, end, row): (usize, usize, usize), below: usize| {
        data += &format!("M{first} {row}h{}v{}h-{}z", end - first, below - row, end - first);
    };
    let rows = frame.labels.len() / columns;
    for row in 0..=rows {
        let line = frame.labels.get(row * columns..(row + 1) * columns).unwrap_or(&[]);
        let mut found: Vec<(usize, usize)> = Vec::new();
        for (column, _) in line.iter().enumerate().filter(|(_, l)| **l == wanted) {
            match found.last_mut() {
                Some((_, end)) if *end == column => *end += 1,
                _ => found.push((column, column + 1)),
            }
        }
        let goes_on = |&(first, end, _): &(usize, usize, usize)| found.contains(&(first, end));
        let (kept, closed): (Vec<_>, Vec<_>) = open.into_iter().partition(goes_on);
        closed.into_iter().for_each(|run| close(run, row));
        open = kept;
        for (first, end) in found {
            if !open.iter().any(|run| (run.0, run.1) == (first, end)) {
                open.push((first, end, row));
            }
        }
    }
    data
}

/// The middle and the size of the box around points, with a margin, metres.
pub fn around(points: &[[f64; 2]], margin_m: f64) -> ([f64; 2], [f64; 2]) {
    let bound = |axis: usize| {
        let values = points.iter().map(|p| p[axis]);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        (low - margin_m, values.fold(f64::NEG_INFINITY, f64::max) + margin_m)
    };
    let ((x0, x1), (y0, y1)) = (bound(0), bound(1));
    ([(x0 + x1) / 2.0, (y0 + y1) / 2.0], [x1 - x0, y1 - y0])
}

/// The square that holds the viewer and its footprint.
pub fn scene(recorded: &Recorded) -> ([f64; 2], [f64; 2]) {
    let [x, y, _] = recorded.pose().p_world;
    let mut points = recorded.footprint();
    points.push([x, y]);
    let (centre, size) = around(&points, 14.0);
    (centre, [size[0].max(size[1]); 2])
}

/// What one frame proves, and the same around a car.
pub fn sensing(recorded: &Recorded) -> String {
    let mut sheet = Sheet::new(980.0);
    let width = sheet.share(2);
    let measured = &recorded.measured;
    let draw = |panel: &Panel| {
        let mut all = group("measured")
            .add(town::ground(panel, &recorded.view))
            .add(area(panel, &shapes(measured.clear_ground.region()), CLEAR))
            .add(town::buildings(panel, &recorded.view))
            .add(area(panel, &shapes(measured.obstacle_margin.region()), MARGIN));
        for seen in &measured.targets {
            all = all.add(area(panel, &shapes(seen.exclusion.region()), EXCLUSION)).add(area(
                panel,
                &shapes(seen.location.region()),
                TARGET,
            ));
        }
        all.add(town::cars(panel, &recorded.view, 0)).add(looks(panel, recorded))
    };
    sheet.window((0, width), "What one frame proves", scene(recorded), draw);
    let (target, place) = nearest_detection(recorded).expect("the viewer sees a car");
    let title = format!("The same around car {}", target.0);
    sheet.window((1, width), &title, (place, [30.0; 2]), draw);
    sheet.key(&[
        (CLEAR, "C, clear ground: no car (inner)"),
        (MARGIN, "S°, too near to a wall: no car, ever (inner)"),
        (TARGET, "where the car is (outer)"),
        (EXCLUSION, "no other car (inner)"),
        (CAR, "a car in truth"),
        (BUILDING, "building in truth"),
    ]);
    sheet.finish()
}

/// An outer and an inner set, each as it is and simplified its own safe way.
pub fn outer_and_inner(recorded: &Recorded) -> String {
    const TOLERANCE_M: f64 = 4.0;
    let mut sheet = Sheet::new(980.0);
    let width = sheet.share(2);
    let knowledge = recorded.agent().knowledge();
    let unexplored = &knowledge.unexplored;
    let (_, place) = nearest_detection(recorded).expect("the viewer sees a car");
    let pieces = |region: &csat_proto::region::Region| shapes(region);
    let biggest = |shapes: &Shapes, most: f64| {
        let sized = shapes.iter().filter_map(|shape| {
            let (centre, size) = around(&shape[0], 0.0);
            let side = size[0].max(size[1]);
            (side < most).then_some((shape[0].len(), centre, side))
        });
        sized.max_by_key(|(corners, ..)| *corners).map_or((place, 60.0), |(_, c, side)| (c, side))
    };
    let exact = Style::line("#222222", 1.6);
    let outer = pieces(unexplored.region());
    let (centre, side) = biggest(&outer, 130.0);
    let simple = pieces(unexplored.clone().simplified(TOLERANCE_M).region());
    let title = format!("Outer: {} may only grow", "X̄");
    sheet.window((0, width), &title, (centre, [side + 24.0; 2]), |panel| {
        group("outer")
            .add(area(panel, &simple, Style::fill(known::UNEXPLORED, 0.85)))
            .add(town::buildings(panel, &recorded.view))
            .add(area(panel, &simple, Style::line("#B79F00", 1.6)))
            .add(area(panel, &outer, exact))
    });
    let inner = pieces(knowledge.margin.region());
    let (centre, side) = biggest(&inner, 90.0);
    let simple = pieces(knowledge.margin.clone().simplified(TOLERANCE_M / 2.0).region());
    sheet.window((1, width), "Inner: X° may only shrink", (centre, [side + 16.0; 2]), |panel| {
        group("inner")
            .add(town::buildings(panel, &recorded.view))
            .add(area(panel, &simple, Style::fill("#CC79A7", 0.55).outlined("#A0447A", 1.6)))
            .add(area(panel, &inner, exact))
    });
    sheet.key(&[
        (exact, "the set as it is"),
        (
            Style::fill(known::UNEXPLORED, 0.85).outlined("#B79F00", 1.6),
            "X̄ simplified by up to 4 m: contains it",
        ),
        (
            Style::fill("#CC79A7", 0.55).outlined("#A0447A", 1.6),
            "X° simplified by up to 2 m: within it",
        ),
        (BUILDING, "building"),
    ]);
    sheet.finish()
}
