//! `csat watch` in a browser, for the tests of its page.

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};

use crate::browser::Browser;
use crate::{common, flight};

/// A small town in which everything happens within 12 s: losses, a crash and a restart.
pub const SMALL: &[&str] = &[
    "run.duration_s=12",
    "map.size_m=[200, 200]",
    "camera.columns=96",
    "camera.rows=72",
    "camera.min_pixels=1",
    "targets.count=4",
    "agents.count=3",
    "netem.radio.range_m=60",
    "netem.partition=[]",
    "netem.outage=[{agent=2, from_s=8, until_s=10, kind=\"crash\"}]",
];

/// A small region in which three aircraft find the target within 12 s; everything else happens as in [`SMALL`].
pub const SEARCHED: &[&str] = &[
    "run.duration_s=12",
    "run.period_s=0.5",
    "map.size_m=[200, 200]",
    "belief.kind=\"particles\"",
    "agents.count=3",
    "agents.start=[{x_m=-60,y_m=-110,yaw_deg=90},{x_m=0,y_m=-110,yaw_deg=90},{x_m=60,y_m=-110,yaw_deg=90}]",
    "netem.radio.range_m=90",
    "netem.outage=[{agent=2, from_s=8, until_s=10, kind=\"crash\"}]",
];

/// A small network in which UAV 0 clears roads for 12 s; everything else happens as in [`SMALL`].
pub const CLEARED: &[&str] = &[
    "run.duration_s=12",
    "run.period_s=0.5",
    "map.size_m=[240, 240]",
    "map.road_spacing_m=75",
    "agents.count=3",
    "netem.outage=[{agent=2, from_s=8, until_s=10, kind=\"crash\"}]",
];

/// A browser, or a loud word that none is installed.
pub fn browser() -> Option<Browser> {
    let browser = Browser::start();
    if browser.is_none() {
        common::skipped("no chromium is installed, so nobody looked at the page");
    }
    browser
}

/// A screenshot, where `CSAT_WATCH_SHOTS` says.
pub fn shot(browser: &mut Browser, name: &str) {
    if let Some(folder) = std::env::var_os("CSAT_WATCH_SHOTS") {
        browser.screenshot(&PathBuf::from(folder).join(format!("watch-{name}.png")));
    }
}

/// A process that ends with its test.
pub struct Watching(Child);

impl Drop for Watching {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// `csat watch` of the recording in a folder, and the address that it said.
pub fn watch(folder: &Path) -> (Watching, String) {
    watch_with(folder, &["."])
}

/// `csat watch` with these arguments, and the address that it said.
pub fn watch_with(folder: &Path, arguments: &[&str]) -> (Watching, String) {
    let arguments = [&["watch", "--port", "0"], arguments].concat();
    let mut command = common::command(folder, &arguments);
    let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
    let mut line = String::new();
    BufReader::new(child.stdout.as_mut().unwrap()).read_line(&mut line).unwrap();
    (Watching(child), line.trim_end().to_owned())
}

/// Whether two pictures of the map differ by a little and by nothing.
pub const HASH: &str = "(id) => { const c = document.getElementById(id); const d = \
    c.getContext('2d').getImageData(0, 0, c.width, c.height).data; let h = 0; \
    for (let i = 0; i < d.length; i += 7) h = (h * 31 + d[i]) | 0; return h; }";

/// A number that differs when what a canvas shows differs.
pub fn picture(browser: &mut Browser, canvas: &str) -> i64 {
    browser.value("new Promise((r) => requestAnimationFrame(() => requestAnimationFrame(r)))");
    browser.value(&format!("({HASH})('{canvas}')")).as_i64().unwrap()
}

/// The text of an element.
pub fn text(browser: &mut Browser, id: &str) -> String {
    browser
        .value(&format!("document.getElementById('{id}').textContent"))
        .as_str()
        .unwrap()
        .to_owned()
}

/// Flies and records [`SMALL`].
pub fn record_small(folder: &Path) {
    flight::record(folder, "city-storm", SMALL);
}
