//! A browser without a window, driven by its DevTools protocol over two pipes: no driver, no
//! further language, nothing but a Chromium that is installed.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde_json::{Value, json};
use tempfile::TempDir;

/// Names that the browser goes by.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];

/// A browser with one page.
pub struct Browser {
    process: Child,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
    session: String,
    last: u64,
    /// Errors and refusals that the page reported.
    pub complaints: Vec<String>,
    _profile: TempDir,
}

impl Browser {
    /// Starts one; `None` when none is installed.
    pub fn start() -> Option<Self> {
        let name = NAMES.iter().find(|name| {
            let paths = std::env::var_os("PATH").unwrap_or_default();
            std::env::split_paths(&paths).any(|path| path.join(name).is_file())
        })?;
        let profile = tempfile::tempdir().unwrap();
        // The protocol is spoken over descriptors 3 (in) and 4 (out), a NUL after each message.
        let line = format!(
            "exec {name} --headless --remote-debugging-pipe --no-sandbox --disable-gpu \
             --disable-dev-shm-usage --no-first-run --hide-scrollbars --user-data-dir='{}' \
             about:blank 3<&0 4>&1 </dev/null >/dev/null 2>/dev/null",
            profile.path().display()
        );
        let mut process = Command::new("sh")
            .args(["-c", &line])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (to, from) = (process.stdin.take().unwrap(), process.stdout.take().unwrap());
        let (from, session) = (BufReader::new(from), String::new());
        let mut browser =
            Self { process, to, from, session, last: 0, complaints: Vec::new(), _profile: profile };
        let target = browser.call("Target.createTarget", json!({"url": "about:blank"}));
        let attach = json!({"targetId": target["targetId"], "flatten": true});
        let attached = browser.call("Target.attachToTarget", attach);
        browser.session = attached["sessionId"].as_str().unwrap().to_owned();
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        Some(browser)
    }

    /// One command and its result.
    pub fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.last += 1;
        let mut message = json!({"id": self.last, "method": method, "params": parameters});
        if !self.session.is_empty() {
            message["sessionId"] = self.session.clone().into();
        }
        self.to.write_all(message.to_string().as_bytes()).unwrap();
        self.to.write_all(&[0]).unwrap();
        self.to.flush().unwrap();
        loop {
            let mut bytes = Vec::new();
            self.from.read_until(0, &mut bytes).unwrap();
            assert_eq!(bytes.pop(), Some(0), "the browser ended during {method}");
            let message: Value = serde_json::from_slice(&bytes).unwrap();
            if message["id"] == self.last {
                assert!(message["error"].is_null(), "{method}: {message}");
                return message["result"].clone();
            }
            self.note(&message);
        }
    }

    fn note(&mut self, message: &Value) {
        let parameters = &message["params"];
        match message["method"].as_str() {
            Some("Runtime.exceptionThrown") => self.complaints.push(parameters.to_string()),
            Some("Log.entryAdded") if parameters["entry"]["level"] == "error" => {
                self.complaints.push(parameters["entry"].to_string());
            }
            Some("Runtime.consoleAPICalled") if parameters["type"] == "error" => {
                self.complaints.push(parameters["args"].to_string());
            }
            Some("Network.requestWillBeSent") => {
                let url = parameters["request"]["url"].as_str().unwrap_or_default();
                if !url.starts_with("http://127.0.0.1:") && !url.starts_with("data:") {
                    self.complaints.push(format!("asked for {url}"));
                }
            }
            _ => {}
        }
    }

    /// The size of the window, with two device pixels per pixel for a telephone.
    pub fn resize(&mut self, width: u32, height: u32) {
        let mobile = width < 500;
        let scale = if mobile { 2 } else { 1 };
        let metrics =
            json!({"width": width, "height": height, "deviceScaleFactor": scale, "mobile": mobile});
        self.call("Emulation.setDeviceMetricsOverride", metrics);
        self.call("Emulation.setTouchEmulationEnabled", json!({"enabled": mobile}));
    }

    /// Goes to a page.
    pub fn open(&mut self, url: &str) {
        self.call("Page.navigate", json!({"url": url}));
        let there =
            format!("location.href.startsWith('{url}') && document.readyState === 'complete'");
        self.wait_for(&there);
    }

    /// The value of an expression, awaited.
    pub fn value(&mut self, expression: &str) -> Value {
        let ask = json!({"expression": expression, "awaitPromise": true, "returnByValue": true});
        let answer = self.call("Runtime.evaluate", ask);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {answer}");
        answer["result"]["value"].clone()
    }

    /// Waits until an expression is true, for up to 20 s; what throws is not true yet.
    pub fn wait_for(&mut self, expression: &str) {
        for _ in 0..400 {
            if self.value(&format!(
                "(() => {{ try {{ return Boolean({expression}); }} catch {{ return false; }} }})()"
            )) == true
            {
                return;
            }
            std::thread::sleep(std::time::Duration::from_millis(50));
        }
        let body = self.value("document.body.innerText");
        panic!("never true: {expression}\n{:#?}\n{body}", self.complaints);
    }

    /// Where the element is that a selector finds, scrolled into view: left, top, width and height.
    pub fn place(&mut self, selector: &str) -> [f64; 4] {
        let quoted = json!(selector);
        let place = self.value(&format!(
            "(() => {{ const e = document.querySelector({quoted}); e.scrollIntoView({{block: 'center'}}); \
             const b = e.getBoundingClientRect(); return [b.x, b.y, b.width, b.height]; }})()"
        ));
        std::array::from_fn(|i| place[i].as_f64().expect(selector))
    }

    /// A pixel of an element, by shares of its width and height.
    pub fn pixel(&mut self, selector: &str, [right, down]: [f64; 2]) -> [f64; 2] {
        let [x, y, width, height] = self.place(selector);
        [x + right * width, y + down * height]
    }

    /// Clicks the middle of the element that a selector finds.
    pub fn click(&mut self, selector: &str) {
        let [x, y] = self.pixel(selector, [0.5, 0.5]);
        self.click_at(x, y);
    }

    /// Clicks a pixel.
    pub fn click_at(&mut self, x: f64, y: f64) {
        self.mouse("mousePressed", [x, y], "left");
        self.mouse("mouseReleased", [x, y], "left");
    }

    /// Moves the mouse to a pixel.
    pub fn hover(&mut self, at: [f64; 2]) {
        self.mouse("mouseMoved", at, "none");
    }

    /// Drags from one pixel to another, and calls `halfway` in the middle.
    pub fn drag(&mut self, from: [f64; 2], to: [f64; 2], halfway: impl FnOnce(&mut Self)) {
        self.hover(from);
        self.mouse("mousePressed", from, "left");
        let between = |share: f64| std::array::from_fn(|i| from[i] + share * (to[i] - from[i]));
        for share in [0.1, 0.3, 0.5] {
            self.mouse("mouseMoved", between(share), "left");
        }
        halfway(self);
        for share in [0.7, 0.9, 1.0] {
            self.mouse("mouseMoved", between(share), "left");
        }
        self.mouse("mouseReleased", to, "left");
    }

    fn mouse(&mut self, kind: &str, [x, y]: [f64; 2], button: &str) {
        let buttons = u8::from(button == "left" && kind != "mouseReleased");
        let event = json!({"type": kind, "x": x, "y": y, "button": button, "buttons": buttons,
            "clickCount": u8::from(kind != "mouseMoved")});
        self.call("Input.dispatchMouseEvent", event);
    }

    /// Turns the wheel over a pixel, towards the user when positive.
    pub fn wheel(&mut self, [x, y]: [f64; 2], delta_y: f64) {
        let event = json!({"type": "mouseWheel", "x": x, "y": y, "deltaX": 0, "deltaY": delta_y});
        self.call("Input.dispatchMouseEvent", event);
    }

    /// Moves two fingers, from two pixels to two others.
    pub fn pinch(&mut self, from: [[f64; 2]; 2], to: [[f64; 2]; 2]) {
        let fingers = |at: [[f64; 2]; 2]| {
            let finger = |i: usize| json!({"x": at[i][0], "y": at[i][1], "id": i});
            json!([finger(0), finger(1)])
        };
        for (kind, points) in
            [("touchStart", fingers(from)), ("touchMove", fingers(to)), ("touchEnd", json!([]))]
        {
            self.call("Input.dispatchTouchEvent", json!({"type": kind, "touchPoints": points}));
        }
    }

    /// Presses a key, by the names of `KeyboardEvent.key`.
    pub fn press(&mut self, key: &str) {
        let mut event = json!({"type": "keyDown", "key": key});
        if key.len() == 1 {
            event["text"] = key.into();
        }
        // What a browser does by itself it does by the code of the key.
        let codes = [
            ("End", 35),
            ("Home", 36),
            ("ArrowLeft", 37),
            ("ArrowUp", 38),
            ("ArrowRight", 39),
            ("ArrowDown", 40),
        ];
        if let Some((_, code)) = codes.iter().find(|(name, _)| *name == key) {
            event["windowsVirtualKeyCode"] = (*code).into();
        }
        self.call("Input.dispatchKeyEvent", event.clone());
        event["type"] = "keyUp".into();
        self.call("Input.dispatchKeyEvent", event);
    }

    /// Writes what shows as a PNG.
    pub fn screenshot(&mut self, path: &Path) {
        let shot = self.call("Page.captureScreenshot", json!({"format": "png"}));
        std::fs::write(path, from_base64(shot["data"].as_str().unwrap())).unwrap();
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn from_base64(text: &str) -> Vec<u8> {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let (mut bytes, mut bits, mut count) = (Vec::new(), 0u32, 0);
    for character in text.bytes().filter(|c| *c != b'=') {
        let digit = DIGITS.iter().position(|d| *d == character).expect("base64") as u32;
        bits = bits << 6 | digit;
        count += 6;
        if count >= 8 {
            count -= 8;
            bytes.push((bits >> count) as u8);
            bits &= (1 << count) - 1;
        }
    }
    bytes
}
