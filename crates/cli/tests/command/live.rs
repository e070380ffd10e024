//! `live` and the page of `demo`.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};

use serde_json::Value;

use crate::workbench::Workbench;

/// A command that serves a page at a free port until it is interrupted.
struct Served {
    child: Child,
    errors: BufReader<std::process::ChildStderr>,
    /// As in `127.0.0.1:8090`.
    host: String,
}

impl Served {
    fn start(bench: &Workbench, arguments: &str) -> Self {
        let mut command = bench.command(arguments);
        let mut child = command.args(["--port", "0"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut errors = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        while !line.contains("the page: ") {
            line.clear();
            assert!(errors.read_line(&mut line).unwrap() > 0, "the command ended without a page");
        }
        let url = line.trim_end().rsplit("http://").next().unwrap();
        Self { child, errors, host: url.trim_end_matches(['/', '"', '}']).to_owned() }
    }

    /// The answer to a request for this path.
    fn get(&self, path: &str) -> String {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n", self.host).unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        String::from_utf8_lossy(&answer).into_owned()
    }

    /// Ends it as Ctrl-C does; returns the exit code, standard output and the rest of standard error.
    fn interrupt(mut self) -> (Option<i32>, String, String) {
        Command::new("kill").args(["-INT", &self.child.id().to_string()]).status().unwrap();
        let (mut out, mut errors) = (String::new(), String::new());
        self.child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
        self.errors.read_to_string(&mut errors).unwrap();
        (self.child.wait().unwrap().code(), out, errors)
    }
}

#[test]
fn a_wrong_scene_is_refused_before_others_are_solved() {
    let bench = Workbench::with_empty_cache();
    let ended = bench.run("live sim:letter?draft sim:shear?draft --no-page");
    assert!(!ended.errors.contains("solving"), "{}", ended.errors);
    ended.expect_failure("no scene shear", "did you mean press-then-shear?");
}

#[test]
fn the_demo_serves_a_page_until_it_is_interrupted() {
    let bench = Workbench::new();
    let demo = Served::start(&bench, "demo --no-browser --json");
    assert!(demo.get("/").starts_with("HTTP/1.1 200"));
    assert!(demo.get("/app.js").contains("javascript"));
    assert!(demo.get("/missing").starts_with("HTTP/1.1 404"));
    let (code, out, errors) = demo.interrupt();
    assert_eq!(code, Some(0), "Ctrl-C is how a demo ends: {errors}");
    let result: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(result["sensors"][0]["sensor"], "demo", "{result}");
    assert!(!bench.path("fingervision-demo").exists(), "a demo on a page writes nothing");
}

#[test]
fn recordings_are_tracked_to_their_end_side_by_side() {
    let bench = Workbench::new();
    bench.press(6);
    let result = bench.run("live press press --no-page --json").expect_done().out;
    let result: Value = serde_json::from_str(&result).unwrap();
    for (sensor, name) in ["press", "press 2"].into_iter().enumerate() {
        let sensor = &result["sensors"][sensor];
        assert_eq!(sensor["sensor"], name, "{result}");
        let [read, dropped] = ["readings", "dropped_before_tracking"].map(|name| sensor[name].as_u64().unwrap());
        assert!(read > 0 && read + dropped == 6, "{result}");
    }
}

#[test]
fn a_page_closes_with_its_recording() {
    let bench = Workbench::new();
    bench.press(3);
    let ended = bench.run("live press --port 0").expect_done();
    assert!(ended.errors.contains("note: the page: http://127.0.0.1:"), "{ended:?}");
    assert!(ended.out.starts_with("press: "), "{ended:?}");
}

#[test]
fn what_cannot_be_shown_is_refused() {
    let bench = Workbench::new();
    bench.press(3);
    let other = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = other.local_addr().unwrap().port();
    bench.run(&format!("live press --port {port}")).expect_failure("the port is taken", "free one");
    bench.run("live press --bind 203.0.113.7").expect_failure("203.0.113.7", "address");
    bench.run("live absent --no-page").expect_failure("absent", "");
    bench.run("live camera:absent --no-page").expect_failure("camera", "");
    bench.run("live press --profile a.toml --profile b.toml").expect_failure("1 sources and 2 profiles", "one for all");
}
