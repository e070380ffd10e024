use std::io::{Read, Write};
use std::net::TcpStream;

use crate::bench::Bench;
use fingervision_page::{Page, PageError, PageOptions};
use fingervision_pipeline::{Interest, Pipeline};

/// The answer to a request with these headers.
fn ask(bench: &Bench, path: &str, headers: &[(&str, &str)]) -> String {
    let mut stream = TcpStream::connect(bench.host()).unwrap();
    // The server closes the connection after its answer.
    let mut request = format!("GET {path} HTTP/1.1\r\nConnection: close, Upgrade\r\n");
    for (name, value) in headers {
        request += &[name, ": ", value, "\r\n"].concat();
    }
    stream.write_all((request + "\r\n").as_bytes()).unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    String::from_utf8_lossy(&answer).into_owned()
}

#[test]
fn the_page_and_its_files_are_served() {
    let bench = Bench::start();
    let host = bench.host();
    let page = ask(&bench, "/", &[("Host", &host)]);
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("<title>fingervision</title>"), "{page}");
    assert!(page.contains("content-security-policy: default-src 'self'"), "{page}");
    let script = ask(&bench, "/app.js", &[("Host", &host)]);
    assert!(script.contains("content-type: text/javascript"), "{script}");
    for path in ["/nothing.js", "/../Cargo.toml", "/%2e%2e/Cargo.toml"] {
        assert!(ask(&bench, path, &[("Host", &host)]).starts_with("HTTP/1.1 404"), "{path}");
    }
}

#[test]
fn other_hosts_and_sites_are_refused() {
    let bench = Bench::start();
    let host = bench.host();
    let rebound = ask(&bench, "/", &[("Host", "evil.example")]);
    assert!(rebound.starts_with("HTTP/1.1 403") && rebound.contains("answers only to localhost"), "{rebound}");
    let upgrade = [
        ("Host", host.as_str()),
        ("Origin", "http://evil.example"),
        ("Upgrade", "websocket"),
        ("Sec-WebSocket-Version", "13"),
        ("Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ=="),
    ];
    let foreign = ask(&bench, "/ws", &upgrade);
    assert!(foreign.starts_with("HTTP/1.1 403"), "{foreign}");
    let why = ask(&bench, "/access", &upgrade);
    assert!(why.starts_with("HTTP/1.1 403") && why.contains("other web sites are refused"), "{why}");
    assert!(ask(&bench, "/access", &[("Host", &host)]).starts_with("HTTP/1.1 204"));
}

#[test]
fn a_port_that_is_taken_is_named() {
    let bench = Bench::start();
    let port = bench.host().rsplit_once(':').unwrap().1.parse().unwrap();
    let options = PageOptions { port: Some(port), ..PageOptions::default() };
    let messages = Pipeline::prepare(Vec::new()).subscribe(Interest::readings());
    let error = Page::start(options, &[], messages, bench.actions.clone()).err().unwrap();
    assert!(matches!(error, PageError::PortTaken { .. }), "{error}");
    assert_eq!(error.to_string(), format!("the page cannot be served at 127.0.0.1:{port}: the port is taken"));
}

#[test]
fn from_elsewhere_a_token_is_needed() {
    let options = PageOptions { address: "0.0.0.0".parse().unwrap(), port: Some(0) };
    let bench = Bench::start();
    let messages = bench.running.subscribe(Interest::readings());
    let page = Page::start(options, bench.running.handles(), messages, bench.actions.clone()).unwrap();
    let url = page.url();
    let (address, token) = url.trim_start_matches("http://").split_once("/?token=").unwrap();
    let local = address.replace("0.0.0.0", "127.0.0.1");
    assert!(tungstenite::connect(format!("ws://{local}/ws")).is_err());
    assert!(tungstenite::connect(format!("ws://{local}/ws?token=wrong")).is_err());
    assert!(tungstenite::connect(format!("ws://{local}/ws?token={token}")).is_ok());
}
