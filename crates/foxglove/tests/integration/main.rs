//! A client that speaks Foxglove's protocol, against a sensor that runs.

#![allow(clippy::unwrap_used, reason = "a test may fail where it stands")]

mod client;
mod film;

use client::Client;
use fingervision_foxglove::{FoxgloveServer, FoxgloveServerError};

#[test]
fn a_client_gets_every_topic_with_its_schema_and_what_it_asks_for() {
    let running = film::start("left finger");
    let server = FoxgloveServer::start(0, running.handles(), running.subscribe(FoxgloveServer::interest())).unwrap();
    let mut client = Client::connect(&server.url());
    let channels = client.channels();
    let topics: Vec<(&str, &str)> =
        channels.iter().map(|channel| (channel.topic.as_str(), channel.schema_name.as_str())).collect();
    for expected in [
        ("/left_finger/image", "foxglove.CompressedImage"),
        ("/left_finger/preview", "foxglove.RawImage"),
        ("/left_finger/reading", "fingervision.Reading"),
        ("/left_finger/surface", "foxglove.PointCloud"),
        ("/left_finger/transform", "foxglove.FrameTransform"),
        ("/left_finger/log", "foxglove.Log"),
    ] {
        assert!(topics.contains(&expected), "no {expected:?} in {topics:?}");
    }
    assert!(!topics.iter().any(|(topic, _)| topic.ends_with("/frame")), "{topics:?}");
    // The schema that comes with the channel names the message's fields.
    let of_topic = |topic: &str| channels.iter().find(|channel| channel.topic == topic).unwrap();
    let reading = of_topic("/left_finger/reading");
    let names = |text: &str| reading.schema.windows(text.len()).any(|bytes| bytes == text.as_bytes());
    assert!(names("photometric_error") && names("force_z_n") && names("google/protobuf/timestamp.proto"));
    client.subscribe(&[(1, reading.id), (2, of_topic("/left_finger/preview").id)]);
    let (mut readings, mut pictures) = (0, 0);
    while readings < 5 || pictures < 1 {
        let (subscription, time_ns, bytes) = client.message();
        assert!(time_ns > 1_600_000_000_000_000_000 && !bytes.is_empty());
        match subscription {
            1 => readings += 1,
            2 => {
                // The picture of `film`: a grey picture of at most 160 columns.
                assert!(bytes.windows(5).any(|text| text == b"mono8"));
                pictures += 1;
            }
            other => panic!("subscription {other}"),
        }
    }
    drop(server);
    client.until_closed();
    running.stop();
}

#[test]
fn a_port_that_is_taken_is_named() {
    let running = film::start("left");
    let start = |port| FoxgloveServer::start(port, running.handles(), running.subscribe(FoxgloveServer::interest()));
    let first = start(0).unwrap();
    let port: u16 = first.url().rsplit(':').next().unwrap().parse().unwrap();
    let error = start(port).unwrap_err();
    assert!(matches!(error, FoxgloveServerError::PortTaken { port: taken } if taken == port), "{error}");
    assert!(error.to_string().contains(&port.to_string()) && error.hint().contains("--foxglove"), "{error}");
    running.stop();
}
