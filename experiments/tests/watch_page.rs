//! The page of `csat watch` in a browser: what shows, what can be pressed, on a desk and in a hand.
//!
//! Needs a Chromium (`apt-get install chromium`); without one it says so and passes. With
//! `CSAT_WATCH_SHOTS=DIR` it leaves screenshots there.

#[path = "common/browser.rs"]
mod browser;
mod common;
#[path = "watch_page/controls.rs"]
mod controls;
#[path = "common/flight.rs"]
mod flight;
#[path = "common/watched.rs"]
mod watched;

use std::sync::Arc;
use std::time::Duration;

use browser::Browser;
use csat_experiments::watch::document::Document;
use csat_experiments::watch::feed::Hub;
use csat_experiments::watch::server::{self, Source};
use serde_json::json;
use watched::{CLEARED, HASH, SEARCHED, SMALL, browser, picture, shot, text, watch, watch_with};

/// A mission of three UAVs and 12 s, the third of which crashes at 8 s, and what the page shows of it.
struct Shown {
    scenario: &'static str,
    sets: &'static [&'static str],
    curves: u32,
    /// How the words of its layers begin, from the bottom up.
    legend: &'static [&'static str],
    /// A layer that differs between agents.
    layer: &'static str,
    /// The layers of which there is nothing to show.
    empty: &'static [&'static str],
}

const STORM: Shown = Shown {
    scenario: "city-storm",
    sets: SMALL,
    curves: 8,
    legend: &["X̄ unexplored", "ground hidden and not seen since"],
    layer: "oem",
    empty: &[],
};

const SEARCH: Shown = Shown {
    scenario: "tisdale",
    sets: SEARCHED,
    curves: 8,
    legend: &[
        "where the target may be: probability of a cell: up to ",
        "particles",
        "densest cells with 95 % of the probability",
        "95 % ellipse of mean and covariance",
        "detections, false alarms included",
    ],
    layer: "belief",
    empty: &["buildings", "roads"],
};

const CLEARING: Shown = Shown {
    scenario: "clearing",
    sets: CLEARED,
    curves: 8,
    legend: &[
        "road that it has cleared so far",
        "road that others have cleared",
        "road that is not known to be cleared",
        "its frontier",
        "image of a cleaner",
    ],
    layer: "frontier",
    empty: &["buildings", "cars", "plans", "view-foreign", "view-wing", "view-tail", "view-helper"],
};

#[test]
fn a_recording_plays_in_a_browser() {
    plays(&STORM);
}

#[test]
fn a_recorded_search_plays_in_a_browser() {
    plays(&SEARCH);
}

#[test]
fn recorded_road_clearing_plays_in_a_browser() {
    plays(&CLEARING);
}

fn plays(shown: &Shown) {
    let Some(mut browser) = browser() else { return };
    let folder = common::scratch();
    flight::record(folder.path(), shown.scenario, shown.sets);
    let (_watching, address) = watch(folder.path());
    browser.resize(1280, 800);
    browser.open(&address);
    browser.wait_for("document.getElementById('time').textContent === '12.0 of 12 s'");
    assert_eq!(text(&mut browser, "title"), format!("{} · seed 1", shown.scenario));
    assert_eq!(text(&mut browser, "violations"), "0");
    assert_eq!(browser.value("document.querySelectorAll('#agents button').length"), 3);
    assert_eq!(browser.value("document.querySelectorAll('.curve canvas').length"), shown.curves);
    shot(&mut browser, &format!("{}-end", shown.scenario));

    the_legend_names_the_layers(&mut browser, shown.legend);
    layers_can_be_switched(&mut browser, shown.empty);
    keys_and_buttons_work(&mut browser, shown);
    it_fits_a_hand(&mut browser, &address);
    assert_eq!(browser.complaints, Vec::<String>::new());
}

fn the_legend_names_the_layers(browser: &mut Browser, expected: &[&str]) {
    let words =
        "styles.map((style) => document.getElementById(`words-view-${style.key}`).textContent)";
    let words = browser.value(words);
    let words: Vec<&str> = words.as_array().unwrap().iter().filter_map(|w| w.as_str()).collect();
    assert!(words.len() >= expected.len(), "{words:?}");
    for (words, expected) in words.iter().zip(expected) {
        assert!(words.starts_with(expected), "{words}, not {expected}");
    }
}

/// Every layer shows, unless there is nothing of it, and its switch takes it away.
fn layers_can_be_switched(browser: &mut Browser, empty: &[&str]) {
    browser.press("Home");
    browser.press("ArrowRight");
    browser.wait_for("document.getElementById('time').textContent.startsWith('0.5')");
    let layers = browser.value("LAYERS.filter((l) => l.id).map((l) => l.id)");
    browser.press("End");
    browser.wait_for("document.getElementById('time').textContent.startsWith('12.0')");
    let layers = layers.as_array().unwrap().iter().filter_map(|layer| layer.as_str());
    for layer in layers.filter(|layer| !empty.contains(layer)) {
        let canvases = ["ground", "fleet"];
        let before = canvases.map(|canvas| picture(browser, canvas));
        browser.click(&format!("#layer-{layer}"));
        let after = canvases.map(|canvas| picture(browser, canvas));
        assert_ne!(before, after, "{layer} shows nothing");
        browser.click(&format!("#layer-{layer}"));
        assert_eq!(canvases.map(|canvas| picture(browser, canvas)), before, "{layer}");
    }
}

/// Agents, steps, playing, zoom.
fn keys_and_buttons_work(browser: &mut Browser, Shown { scenario, layer, .. }: &Shown) {
    let of_0 = picture(browser, "ground");
    browser.press("1");
    browser.wait_for("document.getElementById('details-title').textContent === 'UAV 1'");
    browser.wait_for(&format!("view(1, '{layer}')"));
    assert_ne!(picture(browser, "ground"), of_0);
    browser.click("#agents button:nth-child(1)");
    browser.wait_for(&format!("view(0, '{layer}')"));
    assert_eq!(picture(browser, "ground"), of_0);
    browser.value("seek(9)");
    browser.wait_for(
        "document.querySelector('#agents button:nth-child(3) small').textContent === 'crashed'",
    );
    shot(browser, &format!("{scenario}-crashed"));
    browser.click("#back");
    browser.wait_for("document.getElementById('time').textContent.startsWith('8.5')");
    browser.click("#zoom-in");
    assert_ne!(picture(browser, "ground"), of_0);
    browser.click("#fit");
    browser.press(" ");
    browser.wait_for("document.getElementById('time').textContent.startsWith('12.0')");
    browser.wait_for("document.getElementById('play').textContent === 'Play'");
}

/// A station is called one, and its knowledge is drawn like any agent's.
#[test]
fn a_station_is_shown_and_can_be_chosen() {
    let Some(mut browser) = browser() else { return };
    let folder = common::scratch();
    let station = ["stations=[{x_m=-100,y_m=-90,z_m=4}]", "netem.radio.range_m=inf"];
    flight::record(folder.path(), "city-storm", &[SMALL, &station].concat());
    let (_watching, address) = watch(folder.path());
    browser.resize(1280, 800);
    browser.open(&address);
    browser.wait_for("document.getElementById('time').textContent === '12.0 of 12 s'");
    let names = "[...document.querySelectorAll('#agents button span')].map((e) => e.textContent)";
    browser.wait_for(&format!("({names}).length === 4"));
    assert_eq!(browser.value(names), json!(["U0", "U1", "U2", "S3"]));
    assert_eq!(
        browser.value("document.querySelector('#agents button:nth-child(4)').title"),
        "What station 3 knows (key 3)"
    );
    let of_0 = picture(&mut browser, "fleet");
    browser.click("#agents button:nth-child(4)");
    browser.wait_for("document.getElementById('details-title').textContent === 'station 3'");
    browser.wait_for("view(3, 'oem')");
    assert_ne!(picture(&mut browser, "fleet"), of_0, "its mast is larger now");
    let details = text(&mut browser, "details");
    assert!(details.contains("age of news") && details.contains("from U0"), "{details}");
    assert!(!details.contains("course"), "{details}");
    let label = "document.getElementById('fleet').getAttribute('aria-label')";
    let label = browser.value(label);
    assert!(label.as_str().unwrap().contains("knowledge of station 3"), "{label}");
    assert!(label.as_str().unwrap().contains("3 UAVs, 1 stations"), "{label}");
    shot(&mut browser, "station");
    // Chosen on the map, too.
    browser.press("0");
    browser.wait_for("document.getElementById('details-title').textContent === 'UAV 0'");
    assert_eq!(browser.value("agentAt(toPixel(placeOf(3)))"), 3);
    assert_eq!(browser.complaints, Vec::<String>::new());
}

/// Nothing beside the window, everything large enough for a finger.
fn it_fits_a_hand(browser: &mut Browser, address: &str) {
    browser.resize(360, 740);
    browser.open(address);
    browser.wait_for("document.getElementById('time').textContent === '12.0 of 12 s'");
    assert_eq!(browser.value("document.documentElement.scrollWidth"), 360);
    shot(browser, "small-phone");
    browser.click("#layers-box summary");
    let small = browser.value(
        "[...document.querySelectorAll('button, select, summary, #layers label, #slider')].filter((e) => \
         e.offsetParent && (e.offsetHeight < 40 || e.offsetWidth < 40)).map((e) => e.outerHTML)",
    );
    assert_eq!(small, json!([]));
    assert_eq!(browser.value("document.documentElement.scrollWidth"), 360);
}

/// A hub with the first seconds of a flight, and its server.
fn live(runtime: &tokio::runtime::Runtime, documents: &[Document]) -> (Arc<Hub>, String) {
    let hub = Arc::new(Hub::default());
    hub.begin("1");
    hub.publish(documents.iter().cloned());
    let listener = runtime.block_on(server::listen(0)).unwrap();
    let address = format!("http://{}", listener.local_addr().unwrap());
    runtime.spawn(server::serve(listener, Source::Live(hub.clone())));
    (hub, address)
}

#[test]
fn a_fleet_that_flies_shows_and_a_page_comes_back() {
    let Some(mut browser) = browser() else { return };
    let documents = flight::documents("city-storm", SMALL);
    let (start, rest): (Vec<_>, Vec<_>) = documents.into_iter().partition(|d| d.time_s <= 5.0);
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let (hub, address) = live(&runtime, &start);
    browser.resize(1280, 800);
    browser.open(&address);
    browser.wait_for("document.getElementById('time').textContent === '5.0 of 12 s'");
    browser.wait_for("document.getElementById('connection').textContent === 'live'");
    assert_eq!(browser.value("state.metrics.length"), 11, "curves reach back to the start");
    assert_eq!(browser.value("state.paths.get(0).length"), 11);

    // Paused, it hears on and shows the same.
    browser.click("#play");
    browser.wait_for("document.getElementById('connection').textContent === 'paused'");
    let paused = picture(&mut browser, "ground");
    hub.publish(rest);
    browser.wait_for("document.getElementById('moment').textContent === '7.0 s behind'");
    assert_eq!(picture(&mut browser, "ground"), paused);
    browser.press(" ");
    browser.wait_for("document.getElementById('time').textContent === '12.0 of 12 s'");
    assert_eq!(browser.value("state.metrics.length"), 25);

    // Another agent is drawn with what it knows, by its button and by its key; a step brings what is now.
    browser.click("#agents button:nth-child(2)");
    browser.wait_for("state.agent === 1 && view(1, 'oem') && !live.step");
    browser.press("0");
    browser.wait_for("state.agent === 0 && view(0, 'oem') && !live.step");
    browser.click("#play");
    browser.wait_for("!state.playing");
    let body = json!({"time_s": 12.25, "violations": 0, "alive": [true, true, true]}).to_string();
    hub.publish([Document::parse("truth/metrics", body.as_bytes()).unwrap()]);
    browser.wait_for("behind() > 0");
    browser.press("ArrowRight");
    browser.wait_for("state.time === 12.25 && !state.playing");
    browser.click("#play");
    browser.wait_for("state.playing");
    // What moves a recording in time is not there.
    let hidden =
        "[...document.querySelectorAll('.recorded')].every((e) => e.offsetParent === null)";
    assert_eq!(browser.value(hidden), true);

    // A mission that is over is not quiet: it says so, also to who comes later or paused it.
    hub.end(true);
    let ended = "document.getElementById('connection').textContent === 'the mission ended'";
    browser.wait_for(ended);
    shot(&mut browser, "ended");
    browser.click("#play");
    browser.wait_for(ended);
    browser.click("#play");
    browser.open(&address);
    browser.wait_for(ended);
    hub.end(false);
    browser.wait_for("document.getElementById('connection').textContent === 'live'");

    // A violation is loud, whatever else shows.
    assert_eq!(browser.value("document.getElementById('alarm').hidden"), true);
    let body = json!({"time_s": 12.5, "violations": 2, "alive": [true, true, true]}).to_string();
    hub.publish([Document::parse("truth/metrics", body.as_bytes()).unwrap()]);
    browser.wait_for("document.getElementById('alarm').textContent.startsWith('VIOLATED 2 times')");
    shot(&mut browser, "violated");

    // Text of a fleet is text.
    let body = json!({"time_s": 0.0, "scenario": "<img src=x onerror=alert(1)>", "seed": 1, "features": []});
    hub.publish([Document::parse("truth/town", body.to_string().as_bytes()).unwrap()]);
    browser.wait_for("document.getElementById('title').textContent.startsWith('<img')");
    // Another mission: nothing of the last one stays.
    hub.begin("2");
    hub.publish(start.iter().filter(|d| d.time_s < 1.0).cloned());
    browser.wait_for("document.getElementById('time').textContent === '0.5 of 12 s'");
    assert_eq!(browser.value("document.getElementById('alarm').hidden"), true);
    // This one ends before its time.
    hub.end(true);
    browser.wait_for(
        "document.getElementById('connection').textContent === 'the mission ended early'",
    );
    assert_eq!(browser.complaints, Vec::<String>::new());

    drop(runtime);
    browser.wait_for(
        "document.getElementById('connection').textContent.startsWith('connection lost')",
    );
}

/// Nothing is heard yet, and then documents that are no documents of `docs/topics.md`.
#[test]
fn odd_documents_leave_the_page_working() {
    let Some(mut browser) = browser() else { return };
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let (hub, address) = live(&runtime, &[]);
    browser.resize(1280, 800);
    browser.open(&address);
    browser.wait_for("!document.getElementById('empty').hidden");
    shot(&mut browser, "waiting");
    let odd = [
        ("view/0/pose", json!({"time_s": 1.0, "p_world": "here", "footprint": 3})),
        ("view/0/oem", json!({"time_s": 1.0})),
        ("view/0/targets", json!({"time_s": 1.0, "features": [{"geometry": null}, {}]})),
        ("view/0/hidden", json!({"time_s": 1.0, "runs": null})),
        ("view/99999999/pose", json!({"time_s": 1.0})),
        ("truth/metrics", json!({"time_s": 1.0, "unexplored_pct": "much", "alive": 3})),
        ("truth/town", json!({"features": null, "agents": "four", "size_m": null})),
        ("view/0/links", json!({"time_s": 1.0, "heard": [{"src": 5, "outcome": "__proto__"}]})),
    ];
    let parse = |(topic, body): &(&str, serde_json::Value)| {
        Document::parse(*topic, body.to_string().as_bytes()).unwrap()
    };
    hub.publish(odd.iter().map(parse));
    browser.wait_for("document.getElementById('time').textContent === '1.0 s'");
    std::thread::sleep(Duration::from_millis(300));
    let good = json!({"time_s": 2.0, "p_world": [0, 0, 50], "yaw_rad": 0, "footprint": []});
    hub.publish([parse(&("view/1/pose", good))]);
    browser.wait_for("document.getElementById('time').textContent === '2.0 s'");
    assert_eq!(browser.complaints, Vec::<String>::new());
}

/// What `truth/layers` lists is drawn, whatever the mission; what was switched off stays off.
#[test]
fn the_layers_of_another_mission_show() {
    let Some(mut browser) = browser() else { return };
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let (hub, address) = live(&runtime, &[]);
    browser.resize(1280, 800);
    browser.open(&address);
    let legend = "[...document.querySelectorAll('#layers span')].map((e) => e.textContent)";
    let of_old = browser.value(&format!("{legend}[0]"));
    assert!(of_old.as_str().unwrap().starts_with("X̄ unexplored"), "{of_old}");
    browser.click("#layer-roads");

    let red = json!({"fixed": "#C03010"});
    let hatch = json!({"hatch": {"spacing_px": 5.0, "width_px": 1.5, "falling": true}});
    let square = json!([[[[0, 0], [40, 0], [40, 40], [0, 40], [0, 0]]]]);
    let area = json!({"geometry": {"type": "MultiPolygon", "coordinates": square}});
    let car = json!({"geometry": {"type": "Point", "coordinates": [-60, -60]}, "properties": {"target": 2}});
    let values: Vec<f64> = (0..100).map(|cell| f64::from(cell) / 100.0).collect();
    let said = [
        ("truth/town", json!({"features": [], "agents": 1, "targets": 3, "size_m": [200, 200]})),
        (
            "truth/layers",
            json!({"layers": [
                {"key": "belief", "title": "belief", "kind": "heat", "colour": red, "unit": "per ha", "ground": true},
                {"key": "blocked", "title": "blocked", "kind": "areas", "colour": red, "fill": hatch},
                {"key": "cars", "title": "cars seen", "kind": "points", "colour": {"by": "target"}, "label": "target"},
                {"key": "<b>", "title": "no key", "kind": "areas"},
                {"key": "later", "title": "no kind", "kind": "of tomorrow"},
            ]}),
        ),
        (
            "view/0/pose",
            json!({"time_s": 1.0, "p_world": [0, 0, 50], "yaw_rad": 0, "footprint": []}),
        ),
        (
            "view/0/belief",
            json!({"time_s": 1.0, "cell_m": 20, "origin_m": [-100, -100], "columns": 10,
            "maximum": 1.0, "values": values}),
        ),
        ("view/0/blocked", json!({"time_s": 1.0, "features": [area]})),
        ("view/0/cars", json!({"time_s": 1.0, "features": [car]})),
    ];
    hub.publish(
        said.iter()
            .map(|(topic, body)| Document::parse(*topic, body.to_string().as_bytes()).unwrap()),
    );
    browser.wait_for("document.getElementById('time').textContent === '1.0 s'");
    let words = browser.value(&format!("{legend}.slice(0, 4)"));
    assert_eq!(words, json!(["belief: up to 1 per ha", "blocked", "cars seen", "paths"]));
    assert_eq!(browser.value("layerShown('roads')"), false);
    for layer in ["belief", "blocked", "cars"] {
        let before = picture(&mut browser, "ground");
        browser.click(&format!("#layer-view-{layer}"));
        assert_ne!(picture(&mut browser, "ground"), before, "{layer} shows nothing");
        browser.click(&format!("#layer-view-{layer}"));
        assert_eq!(picture(&mut browser, "ground"), before, "{layer}");
    }
    shot(&mut browser, "other-mission");
    assert_eq!(browser.complaints, Vec::<String>::new());
}

/// The pictures of the documentation, from the shipped storm.
#[test]
#[ignore = "flies two minutes of the paper's city: only for the pictures of the documentation"]
fn pictures_of_the_documentation() {
    let mut browser = browser().expect("a chromium");
    let folder = common::scratch();
    let storm = ["run.duration_s=170", "netem.radio.range_m=260"];
    flight::record(folder.path(), "city-storm", &storm);
    let (_watching, address) = watch(folder.path());
    for (name, width, height) in [("desk", 1280, 800), ("phone", 360, 740)] {
        browser.resize(width, height);
        for time_s in [20, 80, 155, 170] {
            browser.open(&address);
            browser.wait_for("typeof state === 'object' && state.time === 170");
            browser.value(&format!("seek({time_s})"));
            browser.wait_for(&format!("state.time === {time_s}"));
            picture(&mut browser, "fleet");
            shot(&mut browser, &format!("{name}-{time_s}"));
        }
        if width < 500 {
            browser.call(
                "Emulation.setDeviceMetricsOverride",
                json!({"width": width, "height": 2000, "deviceScaleFactor": 2, "mobile": true}),
            );
            browser.click("#layers-box summary");
            picture(&mut browser, "fleet");
            shot(&mut browser, "phone-long");
        }
    }
}

/// A fleet of processes in real time, seen in a browser.
#[test]
fn a_fleet_of_processes_shows_itself() {
    let Some(mut browser) = browser() else { return };
    let (folder, endpoint) = (common::scratch(), common::fleet::endpoint());
    let fleet = common::fleet::spawn(
        folder.path(),
        &endpoint,
        "3000",
        &["--realtime", "10", "--seed", "3"],
    );
    let (_watching, address) = watch_with(folder.path(), &["--connect", &endpoint]);
    browser.resize(1280, 800);
    browser.open(&address);
    browser.wait_for("document.getElementById('connection').textContent === 'live'");
    browser.wait_for("document.querySelectorAll('#agents button').length === 2");
    browser.wait_for("state.paths.get(1) && state.paths.get(1).length > 5");
    // The town is asked for, and comes when it comes.
    browser.wait_for("document.getElementById('title').textContent === 'city · seed 3'");
    let before = picture(&mut browser, "fleet");
    browser.wait_for(&format!("({HASH})('fleet') !== {before}"));
    common::fleet::signal(fleet.id(), "-INT");
    assert_eq!(common::fleet::end(fleet).status.code(), Some(130));
    browser.wait_for(
        "document.getElementById('connection').textContent === 'the mission ended early'",
    );
    assert_eq!(browser.complaints, Vec::<String>::new());
}

/// The pictures of running fleets in the documentation.
#[test]
#[ignore = "flies two fleets in real time: only for the pictures of the documentation"]
fn pictures_of_running_fleets() {
    let mut browser = browser().expect("a chromium");
    for (scenario, at_s) in [("city", 150), ("helsinki-17", 120)] {
        let (folder, endpoint) = (common::scratch(), common::fleet::endpoint());
        let arguments = [
            &["spawn", scenario, "--realtime", "4", "--listen", &endpoint, "--out", "out"][..],
            &["--set", "netem.radio.range_m=250"],
        ];
        let fleet = common::fleet::process(folder.path(), &arguments.concat());
        let (_watching, address) = watch_with(folder.path(), &["--connect", &endpoint]);
        for (name, width, height) in [("desk", 1280, 800), ("phone", 360, 740)] {
            browser.resize(width, height);
            browser.open(&address);
            let is_time = format!("typeof state === 'object' && state.time >= {at_s}");
            common::fleet::wait_until("the fleet has flown", || browser.value(&is_time) == true);
            picture(&mut browser, "fleet");
            shot(&mut browser, &format!("live-{scenario}-{name}"));
        }
        common::fleet::signal(fleet.id(), "-INT");
        common::fleet::end(fleet);
    }
}
