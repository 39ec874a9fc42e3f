//! Every control of the page of `csat watch`, operated in a browser as a person does: with a mouse, two
//! fingers and keys.

use serde_json::json;

use crate::browser::Browser;
use crate::common;
use crate::watched::{browser, picture, record_small, text, watch};

/// Each control with the function below that operates it; layers beside this file as well.
const OPERATED: [&str; 14] = [
    "#back",
    "#fit",
    "#fleet",
    "#forward",
    "#play",
    "#slider",
    "#speed",
    "#zoom-in",
    "#zoom-out",
    "#agents button",
    "#curves canvas",
    "#details-box summary",
    "#layers input",
    "#layers-box summary",
];

#[test]
fn every_control_of_a_recording_works() {
    let Some(mut browser) = browser() else { return };
    let folder = common::scratch();
    record_small(folder.path());
    let (_watching, address) = watch(folder.path());
    let browser = &mut browser;
    browser.resize(1280, 800);
    browser.open(&address);
    wait_for_time(browser, 12.0);
    assert_eq!(text(browser, "connection"), "recorded: the mission ended");
    no_control_is_forgotten(browser);
    the_slider_seeks(browser);
    buttons_step_and_play(browser);
    curves_seek_and_tell_values(browser);
    the_map_moves_and_zooms(browser);
    agents_are_chosen(browser);
    keys_do_what_buttons_do(browser);
    boxes_fold_and_layers_switch(browser);
    two_fingers_zoom(browser, &address);
    assert_eq!(browser.complaints, Vec::<String>::new());
}

fn wait_for_time(browser: &mut Browser, time_s: f64) {
    browser.wait_for(&format!(
        "document.getElementById('time').textContent === '{time_s:.1} of 12 s'"
    ));
}

fn number(browser: &mut Browser, expression: &str) -> f64 {
    browser.value(expression).as_f64().unwrap_or_else(|| panic!("{expression} is no number"))
}

/// A new control must be added to the list, and operated.
fn no_control_is_forgotten(browser: &mut Browser) {
    let known = json!(OPERATED.join(", "));
    let others = browser.value(&format!(
        "[...document.querySelectorAll('button, input, select, summary, textarea, a, canvas, [tabindex]')]\
         .filter((e) => !e.matches({known}) && e.id !== 'ground' && !e.closest('#layers label, #layers li'))\
         .map((e) => e.outerHTML)"
    ));
    assert_eq!(others, json!([]));
    for selector in OPERATED {
        assert_ne!(
            browser.value(&format!("document.querySelectorAll('{selector}').length")),
            0,
            "{selector}"
        );
    }
}

/// A click and a drag show the moment under the pointer; the thumb stays there, and playing ends.
fn the_slider_seeks(browser: &mut Browser) {
    for (share, about_s) in [(0.25, 3.0), (0.75, 9.0), (0.5, 6.0)] {
        let [x, y] = browser.pixel("#slider", [share, 0.5]);
        browser.click_at(x, y);
        let value = number(browser, "Number(document.getElementById('slider').value)");
        assert!((value * 0.5 - about_s).abs() <= 1.0, "{value} at {share}");
        wait_for_time(browser, value * 0.5);
        let after = number(browser, "Number(document.getElementById('slider').value)");
        assert_eq!(after, value, "the thumb went elsewhere");
        assert_eq!(text(browser, "connection"), "recorded");
    }
    let [from, to] = [0.5, 0.9].map(|share| browser.pixel("#slider", [share, 0.5]));
    browser.drag(from, to, |browser| {
        browser.wait_for("state.time > 7 && state.time < 9.6");
    });
    browser.wait_for("state.time > 10 && state.time < 11.6");
    // While it plays, too.
    browser.value("(document.getElementById('speed').value = '0.5', 0)");
    browser.press("Home");
    browser.click("#play");
    browser.wait_for("state.playing");
    let [x, y] = browser.pixel("#slider", [0.75, 0.5]);
    browser.click_at(x, y);
    browser.wait_for("!state.playing && state.time > 8 && state.time < 10");
    assert_eq!(text(browser, "play"), "Play");
    // With the keyboard on it, keys move it as everywhere.
    let before = number(browser, "state.time");
    browser.press("ArrowRight");
    wait_for_time(browser, before + 0.5);
    assert_eq!(
        number(browser, "recorded.times[document.getElementById('slider').value]"),
        before + 0.5
    );
}

fn buttons_step_and_play(browser: &mut Browser) {
    browser.press("Home");
    wait_for_time(browser, 0.0);
    browser.click("#forward");
    wait_for_time(browser, 0.5);
    browser.click("#forward");
    wait_for_time(browser, 1.0);
    browser.click("#back");
    wait_for_time(browser, 0.5);
    // The speed is chosen with the keyboard: a select opens no list without a window.
    for (name, speed) in [("5", 5.0), ("0", 0.5)] {
        browser.press("Home");
        browser.value("document.getElementById('speed').focus()");
        browser.press(if name == "5" { "End" } else { "Home" });
        let top = if name == "5" { "100" } else { "0.5" };
        browser.wait_for(&format!("document.getElementById('speed').value === '{top}'"));
        for _ in 0..3 {
            if name == "5" {
                browser.press("ArrowUp");
            }
        }
        browser.wait_for(&format!("Number(document.getElementById('speed').value) === {speed}"));
        browser.click("#back");
        wait_for_time(browser, 0.0);
        browser.click("#play");
        browser.wait_for("state.playing && recorded.clock > 0");
        assert_eq!(text(browser, "play"), "Pause");
        // Seconds of the mission in a second of the page, whatever the load.
        let measured = number(
            browser,
            "new Promise((done) => requestAnimationFrame((start) => { const clock = recorded.clock; \
             const go = (now) => (now - start > 400 ? done((recorded.clock - clock) / (now - start) * 1000) \
             : requestAnimationFrame(go)); requestAnimationFrame(go); }))",
        );
        assert!((measured / speed - 1.0).abs() < 0.5, "{measured} at {speed}");
        browser.click("#play");
        browser.wait_for("!state.playing");
    }
    // At the end it stops by itself, and says what became of the mission.
    browser.press("End");
    wait_for_time(browser, 12.0);
    browser.click("#back");
    browser.click("#play");
    wait_for_time(browser, 12.0);
    browser.wait_for(
        "document.getElementById('connection').textContent === 'recorded: the mission ended'",
    );
    browser.wait_for("document.getElementById('play').textContent === 'Play'");
}

fn curves_seek_and_tell_values(browser: &mut Browser) {
    let curves = number(browser, "document.querySelectorAll('#curves canvas').length") as usize;
    for curve in 1..=curves {
        let selector = format!("#curves figure:nth-child({curve}) canvas");
        let [x, y, width, height] = browser.place(&selector);
        // A curve begins 30 pixels from the left of its canvas and ends 6 before the right.
        let at = |share: f64| [x + 30.0 + share * (width - 36.0), y + height / 2.0];
        let near = |share: f64| format!("Math.abs(state.time - {}) <= 0.5", 12.0 * share);
        let [x, y] = at(0.25);
        browser.click_at(x, y);
        browser.wait_for(&near(0.25));
        browser.drag(at(0.25), at(0.75), |browser| browser.wait_for(&near(0.5)));
        browser.wait_for(&near(0.75));
    }
    // Under the pointer stands the value of that time.
    let unexplored = "#curves figure:nth-child(3)";
    let at = browser.pixel(&format!("{unexplored} canvas"), [0.2, 0.5]);
    browser.hover(at);
    let told = format!("document.querySelector('{unexplored} output').textContent");
    browser.wait_for("hovered !== null && hovered < 4");
    browser.wait_for(&format!("{told} === short(valueAt('unexplored_pct', hovered), '%')"));
    browser.hover([5.0, 5.0]);
    browser.wait_for(&format!("{told} === short(valueAt('unexplored_pct', state.time), '%')"));
}

fn the_map_moves_and_zooms(browser: &mut Browser) {
    browser.click("#fit");
    let middle = browser.pixel("#fleet", [0.5, 0.5]);
    browser.hover(middle);
    browser.wait_for("document.getElementById('where').textContent === inWords(...toWorld([camera.width / 2, camera.height / 2]), 1)");
    let before = picture(browser, "ground");
    let x = number(browser, "camera.x");
    let to = [middle[0] + 60.0, middle[1] + 20.0];
    browser.drag(middle, to, |_| ());
    let moved = (x - number(browser, "camera.x")) * number(browser, "camera.scale");
    assert!((moved - 60.0).abs() < 1e-6, "{moved}");
    assert_ne!(picture(browser, "ground"), before);
    assert_eq!(browser.value("camera.touched"), true);
    browser.click("#fit");
    assert_eq!(picture(browser, "ground"), before);
    let scale = number(browser, "camera.scale");
    browser.click("#zoom-in");
    assert!((number(browser, "camera.scale") / scale - 1.4).abs() < 1e-9);
    browser.click("#zoom-out");
    assert!((number(browser, "camera.scale") / scale - 1.0).abs() < 1e-9);
    // The wheel zooms about the pointer.
    let at = browser.pixel("#fleet", [0.25, 0.25]);
    let under = "toWorld([camera.width / 4, camera.height / 4])";
    let (scale, place) = (number(browser, "camera.scale"), browser.value(under));
    browser.wheel(at, -200.0);
    browser.wait_for(&format!("camera.scale > {scale} * 1.2"));
    let off_m = number(browser, &format!("Math.hypot(...{under}.map((m, i) => m - {place}[i]))"));
    // A mouse stands on whole pixels.
    assert!(off_m * scale < 1.0, "{off_m} m");
    browser.wheel(at, 200.0);
    browser.wait_for(&format!("Math.abs(camera.scale / {scale} - 1) < 1e-6"));
    browser.click("#fit");
}

fn agents_are_chosen(browser: &mut Browser) {
    for agent in [1, 2, 0] {
        browser.click(&format!("#agents button:nth-child({})", agent + 1));
        browser.wait_for(&format!("state.agent === {agent} && view({agent}, 'oem')"));
        let pressed = "[...document.querySelectorAll('#agents button')].map((b) => b.getAttribute('aria-pressed'))";
        let expected: Vec<String> = (0..3).map(|i| (i == agent).to_string()).collect();
        browser.wait_for(&format!("{pressed}.join() === '{}'", expected.join(",")));
    }
    // A click on a UAV chooses it, one beside it none.
    let place = browser.place("#fleet");
    let uav = browser.value("toPixel(placeOf(2))");
    let [x, y] = [0, 1].map(|i| place[i] + uav[i].as_f64().unwrap());
    browser.click_at(x, y);
    browser.wait_for("state.agent === 2");
    browser.click_at(place[0] + 3.0, place[1] + place[3] / 2.0);
    assert_eq!(browser.value("state.agent"), 2);
    browser.press("0");
    browser.wait_for("state.agent === 0 && view(0, 'oem')");
}

fn keys_do_what_buttons_do(browser: &mut Browser) {
    browser.press("Home");
    wait_for_time(browser, 0.0);
    browser.press("ArrowRight");
    wait_for_time(browser, 0.5);
    browser.press("ArrowLeft");
    wait_for_time(browser, 0.0);
    browser.press("End");
    wait_for_time(browser, 12.0);
    for key in ["f", "F"] {
        let fitted = number(browser, "camera.scale");
        for (zoom, factor) in [("+", 1.4), ("=", 1.4), ("-", 1.0 / 1.4)] {
            let scale = number(browser, "camera.scale");
            browser.press(zoom);
            assert!(
                (number(browser, "camera.scale") / scale / factor - 1.0).abs() < 1e-9,
                "{zoom}"
            );
        }
        browser.press(key);
        assert_eq!(number(browser, "camera.scale"), fitted);
    }
    browser.press("2");
    browser.wait_for("state.agent === 2");
    browser.press("9");
    browser.press("0");
    browser.wait_for("state.agent === 0");
    browser.press("Home");
    browser.press(" ");
    browser.wait_for("state.playing");
    browser.press(" ");
    browser.wait_for("!state.playing");
    browser.press("End");
    wait_for_time(browser, 12.0);
}

fn boxes_fold_and_layers_switch(browser: &mut Browser) {
    for fold in ["layers-box", "details-box"] {
        let open = format!("document.getElementById('{fold}').open");
        assert_eq!(browser.value(&open), true);
        browser.click(&format!("#{fold} summary"));
        browser.wait_for(&format!("!{open}"));
        browser.click(&format!("#{fold} summary"));
        browser.wait_for(&open);
    }
    // By its words as well as by its box.
    browser.click("#words-buildings");
    assert_eq!(browser.value("layerShown('buildings')"), false);
    browser.click("#layer-buildings");
    assert_eq!(browser.value("layerShown('buildings')"), true);
}

fn two_fingers_zoom(browser: &mut Browser, address: &str) {
    browser.resize(360, 740);
    browser.open(address);
    wait_for_time(browser, 12.0);
    let [x, y] = browser.pixel("#fleet", [0.5, 0.5]);
    let scale = number(browser, "camera.scale");
    let apart = |by: f64| [[x - by, y], [x + by, y]];
    browser.pinch(apart(30.0), apart(60.0));
    browser.wait_for(&format!("Math.abs(camera.scale / {scale} - 2) < 0.05"));
    browser.pinch(apart(60.0), apart(30.0));
    browser.wait_for(&format!("Math.abs(camera.scale / {scale} - 1) < 0.05"));
}

/// A recording that was cut short says that its mission did not last.
#[test]
fn a_mission_that_was_cut_short_says_so() {
    let Some(mut browser) = browser() else { return };
    let folder = common::scratch();
    record_small(folder.path());
    let (_watching, address) = watch(folder.path());
    browser.open(&address);
    browser.wait_for(
        "document.getElementById('connection').textContent === 'recorded: the mission ended'",
    );
    let words = "(() => { town().duration_s = 60; return endInWords(0.5); })()";
    assert_eq!(browser.value(words), "the mission ended early");
}
