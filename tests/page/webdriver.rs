//! A browser without a window, driven by the WebDriver protocol (W3C) of chromedriver: as much of it as the tests need.

use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use tempfile::TempDir;

const BROWSERS: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];

/// Many times what an answer takes: a browser that is silent for so long hangs.
const LONGEST: Duration = Duration::from_secs(60);

/// What a page may see of how its reader wants it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    pub(crate) width: u32,
    pub(crate) scheme: &'static str,
}

/// A browser with one page.
pub(crate) struct Browser {
    driver: Child,
    port: u16,
    session: String,
    _profile: TempDir,
}

impl Browser {
    /// Opens one, or says on standard error why a test is skipped.
    pub(crate) fn or_skip(test: &str) -> Option<Self> {
        let opened = Self::open();
        if let Err(why) = &opened {
            // Past the capture of the test harness, so that it is seen.
            let _ = writeln!(std::io::stderr(), "skipped: {test}: {why}");
        }
        opened.ok()
    }

    fn open() -> Result<Self, String> {
        let remedy = "install chromium and chromium-driver, or name them in CHROME and CHROMEDRIVER";
        let browser = program("CHROME", &BROWSERS).ok_or(format!("no browser; {remedy}"))?;
        let driver =
            program("CHROMEDRIVER", &["chromedriver"]).ok_or(format!("no chromedriver; {remedy}"))?;
        let mut driver = Command::new(&driver)
            .arg("--port=0")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| format!("{} does not start: {error}", driver.display()))?;
        let lines = BufReader::new(driver.stdout.take().expect("it is piped")).lines();
        let port = lines.map_while(Result::ok).find_map(|line| {
            line.strip_suffix('.')?.rsplit_once("started successfully on port ")?.1.parse().ok()
        });
        let profile = tempfile::tempdir().expect("a temporary folder");
        let mut opened = Self { driver, port: port.unwrap_or(0), session: String::new(), _profile: profile };
        if port.is_none() {
            return Err("chromedriver names no port".to_owned());
        }
        let switches = [
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
            "--no-first-run",
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
        ];
        let folder = format!("--user-data-dir={}", opened._profile.path().display());
        let switches: Vec<&str> = switches.into_iter().chain([folder.as_str()]).collect();
        let wanted = json!({"capabilities": {"alwaysMatch": {
            "goog:chromeOptions": {"binary": browser, "args": switches},
            "goog:loggingPrefs": {"browser": "ALL"},
        }}});
        let session = opened.ask("POST", "/session", &wanted)?;
        opened.session = session["sessionId"].as_str().ok_or("a session without an id")?.to_owned();
        Ok(opened)
    }

    /// Shows a page of the disk in such a window and waits until its scripts are done.
    pub(crate) fn show(&self, page: &Path, Window { width, scheme }: Window) {
        let size = json!({"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 600});
        self.devtools("Emulation.setDeviceMetricsOverride", &size);
        let media = json!({"features": [{"name": "prefers-color-scheme", "value": scheme}]});
        self.devtools("Emulation.setEmulatedMedia", &media);
        let path = page.display().to_string().replace('%', "%25").replace('?', "%3F").replace('#', "%23");
        self.of_session("POST", "/url", &json!({"url": format!("file://{path}")}));
        let ready = "const done = arguments[0]; const look = () => document.body.dataset.ready === undefined ? setTimeout(look, 20) : done(true); look();";
        self.of_session("POST", "/execute/async", &json!({"script": ready, "args": []}));
    }

    /// What a script returns.
    pub(crate) fn script(&self, script: &str) -> Value {
        self.of_session("POST", "/execute/sync", &json!({"script": script, "args": []}))
    }

    /// What a script returns as text.
    pub(crate) fn text(&self, script: &str) -> String {
        self.script(script).as_str().map(str::to_owned).unwrap_or_default()
    }

    /// Presses and releases a key for whatever has the focus; keys without a letter have the code points of WebDriver.
    pub(crate) fn press(&self, key: char) {
        let stroke = |kind: &str| json!({"type": kind, "value": key.to_string()});
        let keys = json!({"type": "key", "id": "keys", "actions": [stroke("keyDown"), stroke("keyUp")]});
        self.of_session("POST", "/actions", &json!({"actions": [keys]}));
    }

    /// Moves the pointer to a place of the window.
    pub(crate) fn point(&self, x: i64, y: i64) {
        let to = json!({"type": "pointerMove", "duration": 0, "x": x, "y": y, "origin": "viewport"});
        let pointer = json!({"type": "pointer", "id": "mouse", "actions": [to]});
        self.of_session("POST", "/actions", &json!({"actions": [pointer]}));
    }

    /// What the browser had to say of its pages since it was asked last.
    pub(crate) fn console(&self) -> Vec<String> {
        let entries = self.of_session("POST", "/se/log", &json!({"type": "browser"}));
        entries.as_array().expect("a list").iter().map(|entry| entry["message"].to_string()).collect()
    }

    fn devtools(&self, command: &str, parameters: &Value) {
        self.of_session("POST", "/goog/cdp/execute", &json!({"cmd": command, "params": parameters}));
    }

    fn of_session(&self, method: &str, path: &str, body: &Value) -> Value {
        let path = format!("/session/{}{path}", self.session);
        self.ask(method, &path, body).unwrap_or_else(|problem| panic!("{path}: {problem}"))
    }

    fn ask(&self, method: &str, path: &str, body: &Value) -> Result<Value, String> {
        let answer = self.exchange(method, path, &body.to_string()).map_err(|error| error.to_string())?;
        let mut answer: Value =
            serde_json::from_str(&answer).map_err(|error| format!("{error}: {answer}"))?;
        match answer["value"].take() {
            value if value["error"].is_string() => Err(value["message"].to_string()),
            value => Ok(value),
        }
    }

    /// The body of the answer. The driver keeps connections open, so its length counts.
    fn exchange(&self, method: &str, path: &str, body: &str) -> std::io::Result<String> {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port))?;
        stream.set_read_timeout(Some(LONGEST))?;
        let length = body.len();
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nContent-Type: application/json\r\n\
             Content-Length: {length}\r\nConnection: close\r\n\r\n{body}",
            self.port
        )?;
        let mut stream = BufReader::new(stream);
        let mut length = 0;
        for line in stream.by_ref().lines() {
            let line = line?.to_ascii_lowercase();
            if let Some(told) = line.strip_prefix("content-length:") {
                length = told.trim().parse().unwrap_or(0);
            }
            if line.is_empty() {
                break;
            }
        }
        let mut answer = vec![0; length];
        stream.read_exact(&mut answer)?;
        String::from_utf8(answer).map_err(std::io::Error::other)
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // The browser goes with its session; the driver is ours to end. A failure of the test is the one to tell.
        if !self.session.is_empty() {
            let _ = self.exchange("DELETE", &format!("/session/{}", self.session), "");
        }
        let _ = self.driver.kill();
        let _ = self.driver.wait();
    }
}

/// The program that a variable names, or the first of these on the path.
fn program(variable: &str, names: &[&str]) -> Option<PathBuf> {
    if let Some(named) = std::env::var_os(variable) {
        return Some(named.into());
    }
    let path = std::env::var_os("PATH")?;
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let mut places = names.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    places.find(|place| place.is_file())
}
