//! The `fingervision` command on cameras of a real kernel.

use crate::producer::Producer;
use crate::{node, vivid};
use image::codecs::jpeg::JpegEncoder;
use image::{Rgb, RgbImage};
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

/// The loopback device of these tests alone: after programs have used one, the module refuses other sizes.
const NAME: &str = "Command";
const SIZE: [u32; 2] = [320, 240];

/// A random pattern that was moved to the right by so many pixels.
fn pattern(shift: u32) -> Vec<u8> {
    let level = |x: u32, y: u32, channel: u32| {
        let cell =
            (x / 3).wrapping_mul(0x9e37_79b1) ^ (y / 3).wrapping_mul(0x85eb_ca77) ^ channel.wrapping_mul(0xc2b2_ae3d);
        (cell.wrapping_mul(0x27d4_eb2f) >> 24) as u8 / 2 + 60
    };
    let colour = |x, y| Rgb([0, 1, 2].map(|channel| level(x + 3 - shift, y, channel)));
    let mut bytes = Vec::new();
    let mut coder = JpegEncoder::new_with_quality(&mut bytes, 90);
    coder.encode_image(&RgbImage::from_fn(SIZE[0], SIZE[1], colour)).unwrap();
    bytes
}

/// At rest, then moved to and fro.
fn film() -> Vec<Vec<u8>> {
    [0, 0, 0, 1, 2, 3, 3, 2, 1, 0].map(pattern).into()
}

/// The command with a camera that sends motion JPEG.
fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("FINGERVISION").unwrap());
    command.args(arguments).args(["--set", "capture.format=MJPG", "--set", "capture.size_px=[320, 240]"]);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// The next line of a command's notes that contains this text; notes before it are skipped.
fn line_with(text: &str, notes: &mut impl BufRead) -> String {
    let mut said = String::new();
    loop {
        let begin = said.len();
        assert!(notes.read_line(&mut said).unwrap() > 0, "no \"{text}\" in {said}");
        if said[begin..].contains(text) {
            return said[begin..].to_owned();
        }
    }
}

/// Ends a command as Ctrl-C does; returns its exit code and what it printed.
fn interrupt(mut child: Child) -> (Option<i32>, String, String) {
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let (mut out, mut errors) = (String::new(), String::new());
    child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
    if let Some(mut rest) = child.stderr.take() {
        rest.read_to_string(&mut errors).unwrap();
    }
    (child.wait().unwrap().code(), out, errors)
}

/// Records what the camera sends: every picture is in the file, and the file can be tracked.
fn expect_recorded(film: &[Vec<u8>]) {
    let (camera, file) = (format!("camera:{NAME}"), "/tmp/recorded.mcap");
    let ended = command(&["record", &camera, file, "--seconds", "4", "--frames-only"]).output().unwrap();
    let said = String::from_utf8_lossy(&[ended.stdout, ended.stderr].concat()).into_owned();
    assert!(ended.status.success(), "{said}");
    let bytes = fs::read(file).unwrap();
    for (number, picture) in film.iter().enumerate() {
        let is_there = bytes.windows(picture.len()).any(|part| part == picture);
        assert!(is_there, "picture {number} is not in the file: {said}");
    }
    let mut track = Command::new(std::env::var_os("FINGERVISION").unwrap());
    let ended = track.args(["track", file, "--out", "/tmp/of-recording", "--frames", "0..16"]).output().unwrap();
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let table = fs::read_to_string("/tmp/of-recording/readings.csv").unwrap();
    assert!(table.lines().count() > 4 && !table.contains("lost"), "{table}");
}

#[test]
#[ignore = "needs the cameras of cargo xtask camera-test"]
fn a_camera_is_recorded_bit_for_bit_and_tracked_to_a_folder() {
    let film = film();
    let _producer = Producer::start(node(NAME), SIZE, 5, film.clone());
    expect_recorded(&film);
    let folder = "/tmp/tracked";
    let mut tracking = command(&["track", &format!("camera:{NAME}"), "--out", folder]).spawn().unwrap();
    let table = || fs::read_to_string(format!("{folder}/readings.csv")).unwrap_or_default();
    while table().lines().count() < 6 && tracking.try_wait().unwrap().is_none() {
        thread::sleep(Duration::from_millis(100));
    }
    let (code, out, errors) = interrupt(tracking);
    assert_eq!(code, Some(0), "{out}{errors}");
    let table = table();
    let mut rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let names = rows.next().unwrap();
    let rows: Vec<_> = rows.collect();
    let column = |name: &str| names.iter().position(|other| *other == name).unwrap();
    assert!(rows.len() >= 5, "{table}");
    let times: Vec<f64> = rows.iter().map(|row| row[column("capture_time_s")].parse().unwrap()).collect();
    assert!(times.is_sorted(), "{times:?}");
    let lost = rows.iter().filter(|row| row[column("flags")].contains("lost")).count();
    assert_eq!(lost, 0, "{table}");
}

/// Waits until a page at this host has received so many readings.
fn expect_readings(host: &str, count: usize) {
    let mut page = TcpStream::connect(host).unwrap();
    let key = "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==";
    let upgrade = "Connection: Upgrade\r\nUpgrade: websocket";
    write!(page, "GET /ws HTTP/1.1\r\nHost: {host}\r\n{upgrade}\r\n{key}\r\n\r\n").unwrap();
    let (mut seen, mut part) = (0, [0; 1 << 14]);
    while seen < count {
        let bytes = page.read(&mut part).unwrap();
        assert!(bytes > 0, "the page's connection has ended after {seen} readings");
        // The server does not mask its messages, so their texts are found among the bytes. One that arrives in two parts
        // is not counted.
        seen += String::from_utf8_lossy(&part[..bytes]).matches("{\"readings\":").count();
    }
}

#[test]
#[ignore = "needs the cameras of cargo xtask camera-test"]
fn a_camera_is_shown_on_the_page() {
    let _producer = Producer::start(node(NAME), SIZE, 5, film());
    let camera = format!("camera:{NAME}");
    let mut live = command(&["live", &camera, "--port", "0", "--json"]).spawn().unwrap();
    let mut notes = BufReader::new(live.stderr.take().unwrap());
    let line = line_with("the page: ", &mut notes);
    let host = line.rsplit("http://").next().unwrap().trim_end().trim_end_matches(['}', '"', '/']).to_owned();
    let mut page = TcpStream::connect(&host).unwrap();
    write!(page, "GET / HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    page.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 200") && answer.contains("fingervision"), "{answer}");
    expect_readings(&host, 2);
    let (code, out, _) = interrupt(live);
    assert_eq!(code, Some(0), "{out}");
    let readings = out.split("\"readings\": ").nth(1).unwrap().split(',').next().unwrap();
    assert!(readings.parse::<u64>().unwrap() > 1, "{out}");
}

#[test]
#[ignore = "needs the cameras of cargo xtask camera-test"]
fn live_goes_on_after_the_camera_was_unplugged() {
    let camera = format!("camera:{}", vivid::ID);
    let mut command = Command::new(std::env::var_os("FINGERVISION").unwrap());
    command.args(["live", &camera, "--port", "0", "--set", "capture.size_px=[320, 180]"]);
    let mut live = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut notes = BufReader::new(live.stderr.take().unwrap());
    line_with("the page: ", &mut notes);
    vivid::set("Disconnect", None);
    let driver = vivid::driver();
    fs::write(driver.join("unbind"), "vivid.0").unwrap();
    line_with("unplugged", &mut notes);
    fs::write(driver.join("bind"), "vivid.0").unwrap();
    line_with("again", &mut notes);
    let (code, out, _) = interrupt(live);
    assert_eq!(code, Some(0), "{out}");
}
