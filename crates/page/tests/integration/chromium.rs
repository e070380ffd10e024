//! A real browser, headless, driven by the protocol of its developer tools.

use std::env;
use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tempfile::TempDir;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// Names of the browser, the first that is found is taken.
const NAMES: [&str; 4] = ["chromium", "chromium-browser", "google-chrome", "chrome"];
/// WebGL is drawn by the processor, and the browser itself asks for nothing on the network.
const OPTIONS: [&str; 12] = [
    "--headless",
    "--no-sandbox",
    "--remote-debugging-port=0",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-dev-shm-usage",
    "--hide-scrollbars",
];
/// How long anything on the page may take to happen on a busy machine.
const PATIENCE: Duration = Duration::from_mins(1);

/// A browser with one empty tab.
pub(crate) struct Chromium {
    child: Child,
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
    session: Option<String>,
    last_request: u64,
    /// Errors that the page caused.
    pub(crate) page_errors: Vec<String>,
    /// The profile of the browser.
    _folder: TempDir,
}

impl Chromium {
    /// Starts a browser with further options; none, and a message, if this machine has no browser.
    pub(crate) fn start(options: &[&str]) -> Option<Self> {
        let Some(program) = find() else {
            println!("skipped: this machine has no Chromium; on Debian: apt-get install chromium");
            return None;
        };
        let folder = tempfile::tempdir().unwrap();
        let mut command = Command::new(program);
        command.args(OPTIONS).args(options).arg(format!("--user-data-dir={}", folder.path().display()));
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let address = lines.find_map(|line| Some(line.unwrap().split_once("listening on ")?.1.to_owned())).unwrap();
        // What it says further is of no interest, but it must be able to say it.
        thread::spawn(move || lines.count());
        let (socket, _) = tungstenite::connect(address).unwrap();
        if let MaybeTlsStream::Plain(stream) = socket.get_ref() {
            stream.set_read_timeout(Some(PATIENCE)).unwrap();
        }
        let mut browser =
            Self { child, socket, session: None, last_request: 0, page_errors: Vec::new(), _folder: folder };
        let target = browser.call("Target.createTarget", &json!({ "url": "about:blank" }))["targetId"].clone();
        let session = browser.call("Target.attachToTarget", &json!({ "targetId": target, "flatten": true }));
        browser.session = session["sessionId"].as_str().map(Into::into);
        for domain in ["Page.enable", "Runtime.enable", "Log.enable"] {
            browser.call(domain, &json!({}));
        }
        Some(browser)
    }

    /// Sends a command of the protocol, and returns its result.
    pub(crate) fn call(&mut self, method: &str, parameters: &Value) -> Value {
        self.last_request += 1;
        let mut request = json!({ "id": self.last_request, "method": method, "params": parameters });
        if let Some(session) = &self.session {
            request["sessionId"] = session.as_str().into();
        }
        self.socket.send(Message::text(request.to_string())).unwrap();
        loop {
            let Message::Text(text) = self.socket.read().unwrap() else { continue };
            let answer: Value = serde_json::from_str(&text).unwrap();
            if answer["id"] == self.last_request {
                assert!(answer["error"].is_null(), "{method}: {answer}");
                return answer["result"].clone();
            }
            self.note_errors(&answer);
        }
    }

    fn note_errors(&mut self, event: &Value) {
        let parameters = &event["params"];
        let is_error = match event["method"].as_str() {
            Some("Runtime.exceptionThrown") => true,
            Some("Log.entryAdded") => parameters["entry"]["level"] == "error",
            Some("Runtime.consoleAPICalled") => parameters["type"] == "error",
            _ => false,
        };
        if is_error {
            self.page_errors.push(parameters.to_string());
        }
    }

    /// Opens an address and waits until it is loaded.
    pub(crate) fn open(&mut self, url: &str) {
        self.call("Page.navigate", &json!({ "url": url }));
        self.wait_until(&format!("location.href.startsWith({url:?}) && document.readyState === 'complete'"));
    }

    /// The value of an expression on the page.
    pub(crate) fn value(&mut self, expression: &str) -> Value {
        let parameters = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let answer = self.call("Runtime.evaluate", &parameters);
        assert!(answer["exceptionDetails"].is_null(), "{expression}: {answer}");
        answer["result"]["value"].clone()
    }

    /// Waits until an expression is true.
    pub(crate) fn wait_until(&mut self, expression: &str) {
        let start = Instant::now();
        // A page that is being loaded has no elements yet.
        let expression = &format!("(() => {{ try {{ return {expression}; }} catch {{ return false; }} }})()");
        while self.value(expression) != true {
            assert!(start.elapsed() < PATIENCE, "never true: {expression}\n{:?}", self.page_errors);
            thread::sleep(Duration::from_millis(50));
        }
    }

    /// Presses a key, as in `r` or `ArrowLeft`.
    pub(crate) fn press(&mut self, key: &str) {
        for kind in ["keyDown", "keyUp"] {
            self.call("Input.dispatchKeyEvent", &json!({ "type": kind, "key": key }));
        }
    }

    /// Drags the mouse from the middle of an element.
    pub(crate) fn drag(&mut self, selector: &str, [right, down]: [f64; 2]) {
        self.value(&format!("document.querySelector({selector:?}).scrollIntoView()"));
        let middle = format!(
            "(() => {{ const box = document.querySelector({selector:?}).getBoundingClientRect();
            return [box.x + box.width / 2, box.y + box.height / 2]; }})()"
        );
        let middle = self.value(&middle);
        let [x, y] = [0, 1].map(|index| middle[index].as_f64().unwrap());
        let steps = [("mousePressed", 0.0), ("mouseMoved", 0.5), ("mouseMoved", 1.0), ("mouseReleased", 1.0)];
        for (kind, part) in steps {
            let place = json!({
                "type": kind, "x": x + part * right, "y": y + part * down,
                "button": "left", "buttons": u8::from(kind != "mouseReleased"), "clickCount": 1
            });
            self.call("Input.dispatchMouseEvent", &place);
        }
    }

    /// Makes the window so large, and chooses dark or light.
    pub(crate) fn resize(&mut self, width: u32, height: u32, theme: &str) {
        let size = json!({ "width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 600 });
        self.call("Emulation.setDeviceMetricsOverride", &size);
        let feature = json!({ "name": "prefers-color-scheme", "value": theme });
        self.call("Emulation.setEmulatedMedia", &json!({ "features": [feature] }));
    }
}

impl Drop for Chromium {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn find() -> Option<PathBuf> {
    let path = env::var_os("PATH")?;
    let folders: Vec<PathBuf> = env::split_paths(&path).collect();
    let is_program = |file: &Path| file.is_file();
    NAMES.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name))).find(|file| is_program(file))
}
