use csat_proto::model::{Ground, Station};
use csat_proto::oem::OemCell;
use csat_proto::raster::{Grid, Raster};

use super::*;
use crate::metrics_file;
use crate::scenario::{self, Request};
use crate::series::{Curves, Point, Series};
use crate::testing::scratch;

use crate::set_membership::SetMembership;
use crate::set_membership::layers::LAYERS;
use crate::view::Building;
use crate::view::UavTrack;
use csat_mission::measures::{in_order, index_of};
use csat_mission::mission::{Kind, Whole};
use csat_mission::picture::{Area, Cells, Content, Heat, Layer, Mark, Properties, Ring, Shapes};
use csat_mission::row::Row;
use csat_mission::style::{Colour, Fill, Form, Style};

/// `CSAT_SHOW=folder cargo test` leaves the pictures there, to be looked at.
fn show(name: &str, svg: &str) {
    if let Ok(folder) = std::env::var("CSAT_SHOW") {
        std::fs::write(Path::new(&folder).join(name), svg).unwrap();
    }
}

fn rectangle([x, y]: [f64; 2], [width, depth]: [f64; 2]) -> Ring {
    vec![[x, y], [x + width, y], [x + width, y + depth], [x, y + depth]]
}

/// A town of blocks with streets every 95 m, as the generator makes them.
fn town() -> (Vec<Building>, Vec<Ring>) {
    let (mut buildings, mut roads) = (Vec::new(), Vec::new());
    for i in 0..6 {
        let at = -237.5 + 95.0 * f64::from(i);
        roads.push(vec![[at, -250.0], [at, 250.0]]);
        roads.push(vec![[-250.0, at], [250.0, at]]);
        for j in 0..5 {
            let corner = [-215.0 + 95.0 * f64::from(i.min(4)), -205.0 + 95.0 * f64::from(j)];
            let size = [14.0 + f64::from((i * 7 + j * 3) % 12), 12.0 + f64::from((i + j * 5) % 18)];
            let height_m = 8.0 + f64::from((i * 13 + j * 29) % 37);
            buildings.push(Building { rings: vec![rectangle(corner, size)], height_m });
        }
    }
    buildings[7].rings.push(vec![[-115.0, 0.0], [-115.0, 4.0], [-110.0, 4.0], [-110.0, 0.0]]);
    (buildings, roads)
}

fn knowledge(buildings: &[Building]) -> Vec<Layer> {
    let ground = Ground { size_m: [500.0, 500.0] };
    let mut hidden = Raster::empty(Grid::covering(&ground, 2.0));
    let grid = Grid::covering(&ground, 5.0);
    let mut oem = vec![OemCell::Unexplored; grid.cells()];
    for (column, row) in (0..grid.cells() as u32).map(|i| (i % grid.columns, i / grid.columns)) {
        if column > 20 || row > 60 {
            oem[grid.index(column, row)] = OemCell::Empty;
        }
    }
    for building in buildings.iter().skip(4) {
        let [x, y] = building.rings[0][2];
        hidden.fill_rings(&[vec![
            [x, y - 20.0],
            [x + 45.0, y + 6.0],
            [x + 45.0, y + 34.0],
            [x, y],
        ]]);
        for p in &building.rings[0] {
            let (column, row) = grid.cell_of(*p).unwrap();
            let height_dm = (building.height_m * 10.0) as u16;
            for (c, r) in [(0, 0), (1, 0), (0, 1)] {
                oem[grid.index(column + c, row + r)] = OemCell::Occupied { height_dm };
            }
        }
    }
    let margin = |b: &Building| {
        let [a, c] = [b.rings[0][0], b.rings[0][2]];
        vec![rectangle([a[0] - 2.5, a[1] - 2.5], [c[0] - a[0] + 5.0, c[1] - a[1] + 5.0])]
    };
    let unexplored = vec![
        vec![
            vec![
                [-250.0, -250.0],
                [-150.0, -250.0],
                [-120.0, -100.0],
                [-160.0, 60.0],
                [-250.0, 90.0],
            ],
            vec![[-200.0, -60.0], [-200.0, -20.0], [-170.0, -20.0], [-170.0, -60.0]],
        ],
        vec![vec![[120.0, 250.0], [180.0, 160.0], [250.0, 150.0], [250.0, 250.0]]],
    ];
    let target = |(j, x, y): (u16, f64, f64)| {
        let shapes = vec![vec![rectangle([x - 9.0, y - 14.0], [18.0, 28.0])]];
        area(shapes, ("target", j.into()))
    };
    let targets = [(0, -43.0, 120.0), (2, 52.0, -40.0), (3, 147.0, 40.0), (5, 40.0, 147.0)];
    let margin = buildings.iter().skip(6).map(margin).collect();
    vec![
        Layer::new(
            "unexplored",
            Content::Areas(vec![area(unexplored, ("share_pct", 17.3.into()))]),
        ),
        Layer::new("targets", Content::Areas(targets.map(target).to_vec())),
        Layer::new("obstacles", Content::Areas(vec![area(margin, ("kind", "obstacles".into()))])),
        Layer::new("hidden", Content::Cells(csat_mission::picture::cells(&hidden))),
        Layer::new("oem", Content::Heights(csat_mission::picture::oem(&grid, &oem))),
    ]
}

fn area(shapes: Shapes, (key, value): (&str, serde_json::Value)) -> Area {
    Area { shapes, properties: Properties::from_iter([(key.to_owned(), value)]) }
}

fn sample_view() -> View {
    let (obstacles, roads) = town();
    let turn = |i: f64, k: u32| {
        let t = f64::from(k) / 60.0;
        let radius = 60.0 + 30.0 * i;
        [
            -260.0 + 330.0 * (t * 0.9).min(1.0) + radius * (t * 6.0 + i).sin() * t.min(1.0),
            -45.0 + 30.0 * i + radius * (1.0 - (t * 5.0 + 2.0 * i).cos()) * t.min(1.0) - 40.0 * t,
        ]
    };
    let uavs = (0..4u8).map(|i| {
        let path: Vec<[f64; 2]> = (0..90).map(|k| turn(f64::from(i), k)).collect();
        let [a, b] = [path[88], path[89]];
        let yaw_rad = (b[1] - a[1]).atan2(b[0] - a[0]);
        let corner = |ahead: f64, left: f64| {
            let (s, c) = yaw_rad.sin_cos();
            [b[0] + ahead * c - left * s, b[1] + ahead * s + left * c]
        };
        let footprint = vec![
            corner(48.0, -29.0),
            corner(230.0, -98.0),
            corner(230.0, 98.0),
            corner(48.0, 29.0),
        ];
        UavTrack { path, yaw_rad, footprint }
    });
    let car = |x: f64, y: f64| (0..60).map(|k| [x, y - 30.0 + 0.5 * f64::from(k)]).collect();
    let agents = vec![knowledge(&obstacles)];
    View {
        stations: Vec::new(),
        scenario: "city".into(),
        seed: 1,
        time_s: 300.0,
        size_m: [500.0, 500.0],
        uavs: uavs.collect(),
        targets: vec![
            car(-43.0, 120.0),
            car(-237.0, -140.0),
            car(52.0, -40.0),
            car(147.0, 40.0),
            car(240.0, 200.0),
            car(40.0, 147.0),
        ],
        layers: LAYERS.to_vec(),
        agents,
        obstacles,
        roads,
        attribution: Some("© OpenStreetMap contributors, ODbL 1.0".into()),
    }
}

const KIND: Kind = Whole::<SetMembership>::KIND;

fn sample_series() -> Series {
    let wave = |t: f64, period: f64| (t / period).sin();
    let point = |k: u32| {
        let t = f64::from(k) * 0.5;
        let decay = (-t / 60.0).exp();
        let identified = (8.0 * (1.0 - (-t / 35.0).exp())).round();
        let values = [
            ("identified", Some(identified - if k.is_multiple_of(7) { 0.25 } else { 0.0 })),
            ("identified_union", Some(identified)),
            ("targets_in_fov", Some((3.0 + 2.4 * wave(t, 9.0)).trunc())),
            ("targets_detected", Some((2.0 + 1.9 * wave(t, 9.0)).trunc())),
            ("unexplored_pct", Some(20.0 + 80.0 * decay + 2.0 * wave(t, 12.0))),
            ("hidden_pct", Some(12.0 * (1.0 - decay) + 1.5 * wave(t, 12.0))),
            ("explored_pct", Some(94.0 * (1.0 - decay))),
            ("footprint_pct", Some(28.0 + 4.0 * wave(t, 7.0))),
            ("ground_seen_pct", Some(21.0 + 3.0 * wave(t, 7.0))),
            ("localization_error_m", (k > 20).then_some(1.0 + 0.4 * wave(t, 5.0).abs())),
            ("target_radius_m", (k > 20).then_some(14.0 + 4.0 * wave(t, 20.0))),
            (
                "oem_iou_pct",
                (!k.is_multiple_of(50)).then_some(75.0 * (1.0 - decay) + 6.0 * wave(t, 4.0)),
            ),
        ];
        Point { time_s: t, values: in_order(KIND.columns, values) }
    };
    let mut series = Series::new(KIND.columns);
    series.points = (0..=600).map(point).collect();
    series
}

fn of_fleet(fleet: Series) -> Curves {
    Curves { fleet, ..Curves::new(KIND.columns) }
}

fn sample_summary() -> Summary {
    Summary {
        scenario: "city".into(),
        seed: 1,
        agents: 4,
        targets: 8,
        sim_s: 300.0,
        ..crate::testing::summary()
    }
}

#[test]
fn the_map_shows_every_layer() {
    let svg = map_svg(&sample_view(), 0);
    show("map.svg", &svg);
    for class in [
        "roads",
        "buildings",
        "unexplored",
        "hidden",
        "obstacles",
        "oem",
        "targets",
        "targets-labels",
        "cars",
        "uavs",
        "footprint",
        "legend",
        "scale-bar",
        "axes",
        "grid",
        "north",
        "oem-filled",
        "heights",
    ] {
        assert!(svg.contains(&format!("class=\"{class}\"")), "{class}");
    }
    let clipped = "clip-path=\"url(#near-region)\"";
    assert_eq!(svg.matches(clipped).count(), 4, "footprints stay near the region");
    assert!(svg.contains("<clipPath id=\"near-region\">"));
    assert!(svg.contains("city, seed 1, t = 300 s"));
    assert!(svg.contains("4 of 6 cars;"));
    assert!(svg.contains("© OpenStreetMap contributors"));
    assert_eq!(svg.matches("class=\"uav\"").count(), 4);
    assert_eq!(svg.matches("class=\"car\"").count(), 6);
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
    assert_eq!(svg, map_svg(&sample_view(), 0), "equal views give equal pictures");
}

/// The sample with a second agent, which knows of other cars and has seen less.
fn view_of_two() -> View {
    let mut view = sample_view();
    let mut second = view.agents[0].clone();
    let half = vec![vec![vec![[-250.0, -250.0], [250.0, -250.0], [250.0, 0.0], [-250.0, 0.0]]]];
    for layer in &mut second {
        match (&*layer.key, &mut layer.content) {
            ("targets", Content::Areas(areas)) => areas.truncate(1),
            ("unexplored", Content::Areas(areas)) => {
                *areas = vec![area(half.clone(), ("share_pct", 50.0.into()))];
            }
            (_, Content::Heights(oem)) => oem.occupied.iter_mut().for_each(|cell| cell.2 = 77),
            _ => {}
        }
    }
    view.agents.push(second);
    view
}

#[test]
fn a_map_shows_the_agent_that_is_asked_for() {
    let view = view_of_two();
    let [first, second] = [0, 1].map(|agent| map_svg(&view, agent));
    assert!(
        first.contains("what UAV 0 knows: 4 of 6 cars") && first.contains("known to UAV 0 and")
    );
    assert!(second.contains("what UAV 1 knows: 1 of 6 cars"));
    assert!(second.contains("known to UAV 1 and not"));
    // Cars that it does not know are hollow, and the scale of heights is its own.
    let hollow = |svg: &str| {
        let cars = svg.split("class=\"car\"").skip(1);
        cars.filter(|car| car.split("/>").next().unwrap().contains("fill=\"#ffffff\"")).count()
    };
    assert_eq!((hollow(&first), hollow(&second)), (2, 5));
    assert!(second.contains("≤8 m") && !first.contains("≤8 m"));
}

#[test]
fn every_agent_has_a_map_in_the_picture_of_all() {
    let view = view_of_two();
    let svg = agents_svg(&view);
    show("map-agents.svg", &svg);
    assert!(svg.contains("UAV 0: 4 of 6 cars"));
    // Half the region is unexplored.
    assert!(svg.contains("UAV 1: 1 of 6 cars, 50.0 % unexplored"), "{svg}");
    assert_eq!(svg.matches("class=\"agent\"").count(), 2);
    assert_eq!(svg.matches("href=\"#ground\"").count(), 2);
    assert_eq!(svg.matches("id=\"ground\"").count(), 1, "the town is written once");
    assert!(svg.contains("© OpenStreetMap contributors"));
    let many = View { agents: vec![view.agents[1].clone(); 64], ..view };
    let svg = agents_svg(&many);
    show("map-agents-64.svg", &svg);
    assert_eq!(svg.matches("class=\"agent\"").count(), 64);
    assert!(!agents_svg(&View { size_m: [300.0, 100.0], ..View::default() }).contains("NaN"));
}

#[test]
fn agents_are_chosen_by_index_or_all() {
    assert_eq!("3".parse(), Ok(Whose::Agent(3)));
    assert_eq!("all".parse(), Ok(Whose::All));
    for bad in ["-1", "U1", "", "1.5"] {
        assert!(bad.parse::<Whose>().is_err(), "{bad}");
    }
    let folder = scratch("whose");
    let view = view_of_two();
    std::fs::write(folder.join("view.json"), serde_json::to_string(&view).unwrap()).unwrap();
    let path = draw_knowledge(&folder, Whose::Agent(1)).unwrap();
    assert!(path.ends_with("map-agent-1.svg"));
    assert_eq!(std::fs::read_to_string(path).unwrap(), map_svg(&view, 1));
    let path = draw_knowledge(&folder, Whose::All).unwrap();
    assert_eq!(std::fs::read_to_string(path).unwrap(), agents_svg(&view));
    let error = draw_knowledge(&folder, Whose::Agent(2)).unwrap_err().to_string();
    assert_eq!(error, "--agent: got 2, expected `all` or an agent from 0 to 1");
    assert!(!folder.join("map.svg").exists(), "the run's own picture is left alone");
}

#[test]
fn an_empty_mission_can_be_drawn() {
    let view = View { size_m: [300.0, 100.0], ..View::default() };
    assert!(!map_svg(&view, 0).contains("NaN"));
    let svg = metrics_svg(&KIND, &sample_summary(), &Curves::new(KIND.columns)).unwrap();
    assert!(!svg.contains("NaN"));
}

#[test]
fn the_metrics_show_every_panel_beside_the_thesis() {
    let svg = metrics_svg(&KIND, &sample_summary(), &of_fleet(sample_series())).unwrap();
    show("metrics.svg", &svg);
    for words in ["fig. 5.9 left", "fig. 5.10", "fig. 5.11", "fig. 5.12", "fig. 5.13", "OEM"] {
        assert!(svg.contains(words), "{words}");
    }
    assert!(svg.contains("thesis 22.06 ± 2.35"));
    assert!(!svg.contains("NaN"));
}

#[test]
fn stations_are_drawn_and_named() {
    let mut curves = of_fleet(sample_series());
    assert!(!metrics_svg(&KIND, &sample_summary(), &curves).unwrap().contains("station"));
    let mut late = sample_series();
    let unexplored = index_of(KIND.columns, "unexplored_pct").unwrap();
    for value in late.points.iter_mut().filter_map(|point| point.values[unexplored].as_mut()) {
        *value += 20.0;
    }
    curves.stations.insert(4, late);
    let svg = metrics_svg(&KIND, &sample_summary(), &curves).unwrap();
    show("metrics-station.svg", &svg);
    assert!(svg.contains("4 UAVs, 1 station, 8 targets"));
    let unexplored = curves.stations[&4].half_mean("unexplored_pct").unwrap();
    assert!(svg.contains(&format!("station 4, dashed: {unexplored:.2}")), "{unexplored}");
    assert_eq!(
        svg.matches("station 4, dashed").count(),
        4,
        "identified, error, radius, unexplored"
    );
    let station = Station { x_m: 20.0, y_m: -30.0, z_m: 2.0 };
    let view = View { stations: vec![station], ..sample_view() };
    let svg = map_svg(&view, 0);
    show("map-station.svg", &svg);
    assert!(svg.contains("class=\"station\"") && svg.contains("\nS4\n"), "its mark and its name");
    assert!(svg.contains("4 UAVs, 1 station;"));
    let all = agents_svg(&view);
    assert!(all.contains("\nS4\n") && all.contains("href=\"#stations\""), "on each agent's map");
}

/// The thesis flew its own setting for 300 s: nothing else is set beside its numbers.
#[test]
fn other_missions_are_not_set_beside_the_thesis() {
    let other = Summary { thesis_setting: false, ..sample_summary() };
    let short = Summary { sim_s: 299.5, ..sample_summary() };
    for summary in [other, short] {
        let svg = metrics_svg(&KIND, &summary, &of_fleet(sample_series())).unwrap();
        assert!(!svg.contains("thesis") && !svg.contains("22.06"), "{}", summary.sim_s);
    }
}

/// Ticks of a short axis differ, and no share is above 100 %.
#[test]
fn the_ticks_of_a_short_mission_tell_apart() {
    let mut second = sample_series();
    second.points.truncate(3);
    let svg = metrics_svg(&KIND, &sample_summary(), &of_fleet(second)).unwrap();
    let ticks: Vec<&str> =
        svg.lines().map(str::trim).filter(|l| l.parse::<f64>().is_ok()).collect();
    for pair in ticks.windows(2) {
        assert_ne!(pair[0], pair[1], "{ticks:?}");
    }
    assert!(!ticks.contains(&"120"), "{ticks:?}");
}

#[test]
fn a_run_is_drawn_again_from_its_folder() {
    let folder = scratch("redraw");
    let missing = redraw(&folder).unwrap_err().to_string();
    assert!(missing.starts_with("cannot read `"), "{missing}");
    assert!(missing.ends_with("expected the folder of a finished run"), "{missing}");
    let view = sample_view();
    std::fs::write(folder.join("view.json"), serde_json::to_string(&view).unwrap()).unwrap();
    std::fs::write(folder.join("summary.json"), sample_summary().to_json()).unwrap();
    let row = |step: u32, key, value| Row {
        step,
        time_s: f64::from(step) * 0.5,
        values: in_order(KIND.columns, [("unexplored_pct", Some(42.0)), (key, value)]),
        ..Row::default()
    };
    let mut rows = csv::Writer::from_path(folder.join("metrics.csv")).unwrap();
    rows.write_record(metrics_file::header(KIND.columns)).unwrap();
    for row in [row(0, "oem_iou_pct", None), row(1, "oem_iou_pct", Some(7.5))] {
        rows.write_record(metrics_file::record(KIND.columns, &row)).unwrap();
    }
    rows.flush().unwrap();
    let [map, metrics] = redraw(&folder).unwrap();
    assert_eq!(std::fs::read_to_string(map).unwrap(), map_svg(&view, 0));
    assert!(std::fs::read_to_string(metrics).unwrap().contains("unexplored: 42.00 %"));
    assert!(!folder.join("map.svg.tmp").exists());
}

#[test]
fn real_towns_are_drawn_with_their_attribution() {
    let request = Request { scenario: Some("helsinki-17"), ..Request::default() };
    let loaded = scenario::load(request).unwrap();
    let view = View { time_s: 300.0, ..View::of_town(&loaded) };
    let svg = map_svg(&view, 0);
    show("helsinki-17.svg", &svg);
    assert!(svg.contains("OpenStreetMap contributors"));
    assert!(view.obstacles.len() > 20 && svg.contains("helsinki-17, seed 1"));
}

/// A layer of each kind, none of them of the set-membership mission.
fn other_layers() -> (Vec<Style>, Vec<Layer>) {
    let style = |key: &'static str, kind, fill| Style {
        key: key.into(),
        title: format!("title of {key}").into(),
        kind,
        colour: Colour::By("target".into()),
        fill,
        line: None,
        label: Some("target".into()),
        mark: None,
        unit: Some("per ha".into()),
        panel: (kind == Form::Heat).then(|| "What it believes".into()),
        is_ground: kind == Form::Heat,
        is_in_scene: true,
    };
    let hatch = Fill::Hatch { spacing_px: 4.0, width_px: 1.0, is_falling: false };
    let styles = vec![
        style("belief", Form::Heat, Fill::None),
        style("blocked", Form::Areas, hatch),
        style("swept", Form::Cells, Fill::Plain { opacity: 0.3 }),
        style("seen", Form::Points, Fill::None),
    ];
    let values = (0..100).map(|cell| f64::from(cell) / 100.0).collect();
    let origin_m = [-250.0; 2];
    let heat = Heat { cell_m: 50.0, origin_m, columns: 10, maximum: 1.0, values };
    let cells = Cells { cell_m: 50.0, origin_m, runs: vec![[0, 2, 5]] };
    let square = vec![vec![rectangle([100.0, 100.0], [60.0, 40.0])]];
    let mark = Mark { point: [10.0, -20.0], properties: named(1) };
    let layers = vec![
        Layer::new("seen", Content::Points(vec![mark])),
        Layer::new("belief", Content::Heat(heat)),
        Layer::new("swept", Content::Cells(cells)),
        Layer::new("blocked", Content::Areas(vec![Area { shapes: square, properties: named(3) }])),
    ];
    (styles, layers)
}

fn named(target: u16) -> Properties {
    Properties::from_iter([("target".to_owned(), target.into())])
}

#[test]
fn the_layers_of_any_mission_are_drawn() {
    let (layers, known) = other_layers();
    let view = View { layers, agents: vec![known], ..sample_view() };
    let svg = map_svg(&view, 0);
    show("map-other.svg", &svg);
    for key in ["belief", "blocked", "swept", "seen", "belief-filled", "seen-labels"] {
        assert!(svg.contains(&format!("class=\"{key}\"")), "{key}");
    }
    // In the order of the styles, whatever the order of the layers.
    let places = ["belief", "buildings", "blocked", "swept", "seen"];
    let places = places.map(|key| svg.find(&format!("class=\"{key}\"")).unwrap());
    assert!(places.is_sorted(), "{places:?}");
    assert!(svg.contains("What it believes") && svg.contains("title of swept"));
    assert!(
        svg.contains("≤0.20")
            && svg.contains("title of belief, per ha")
            && svg.contains("2 of 6 cars;")
    );
    assert!(svg.contains("url(#hatch-blocked-3)") && svg.contains("id=\"hatch-blocked-3\""));
    for gone in ["unexplored", "OEM", "NaN"] {
        assert!(!svg.contains(gone), "{gone}");
    }
    assert!(agents_svg(&view).contains("class=\"blocked\""));
}
