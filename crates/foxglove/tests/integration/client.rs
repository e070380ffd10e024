//! A client of Foxglove's WebSocket protocol: it knows the server's channels, subscribes, and gets messages.

use std::net::TcpStream;

use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::http::HeaderValue;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

/// The version of the protocol whose channels contain their schemas.
const PROTOCOL: &str = "foxglove.sdk.v1";
/// The first byte of a binary message with data.
const MESSAGE_DATA: u8 = 1;

/// A topic that the server has.
pub(crate) struct Channel {
    pub(crate) id: u64,
    pub(crate) topic: String,
    pub(crate) schema_name: String,
    /// The descriptors, decoded.
    pub(crate) schema: Vec<u8>,
}

pub(crate) struct Client(WebSocket<MaybeTlsStream<TcpStream>>);

impl Client {
    pub(crate) fn connect(url: &str) -> Self {
        let mut request = url.into_client_request().unwrap();
        request.headers_mut().insert("sec-websocket-protocol", HeaderValue::from_static(PROTOCOL));
        let (socket, answer) = tungstenite::connect(request).unwrap();
        assert_eq!(answer.headers()["sec-websocket-protocol"], PROTOCOL);
        Self(socket)
    }

    /// The channels that the server advertises after it has said who it is.
    pub(crate) fn channels(&mut self) -> Vec<Channel> {
        let info = self.text("serverInfo");
        assert_eq!(info["name"], "fingervision", "{info}");
        let advertised = self.text("advertise");
        let channels = advertised["channels"].as_array().unwrap().iter();
        let channel = |channel: &Value| {
            assert_eq!((&channel["encoding"], &channel["schemaEncoding"]), (&json!("protobuf"), &json!("protobuf")));
            let text = |key: &str| channel[key].as_str().unwrap().to_owned();
            let schema = from_base64(&text("schema"));
            Channel {
                id: channel["id"].as_u64().unwrap(),
                topic: text("topic"),
                schema_name: text("schemaName"),
                schema,
            }
        };
        channels.map(channel).collect()
    }

    /// Asks for the messages of channels, each under a number.
    pub(crate) fn subscribe(&mut self, subscriptions: &[(u32, u64)]) {
        let one = |(id, channel): &(u32, u64)| json!({"id": id, "channelId": channel});
        let subscriptions: Vec<Value> = subscriptions.iter().map(one).collect();
        let request = json!({"op": "subscribe", "subscriptions": subscriptions});
        self.0.send(Message::text(request.to_string())).unwrap();
    }

    /// The next message: the number of its subscription, its time, ns, and its bytes.
    pub(crate) fn message(&mut self) -> (u32, u64, Vec<u8>) {
        loop {
            if let Message::Binary(bytes) = self.0.read().unwrap()
                && let [MESSAGE_DATA, a, b, c, d, rest @ ..] = bytes.as_ref()
            {
                let (time_ns, bytes) = rest.split_first_chunk().unwrap();
                return (u32::from_le_bytes([*a, *b, *c, *d]), u64::from_le_bytes(*time_ns), bytes.to_vec());
            }
        }
    }

    /// Reads until the server ends the connection.
    pub(crate) fn until_closed(mut self) {
        while self.0.read().is_ok() {}
    }

    fn text(&mut self, op: &str) -> Value {
        loop {
            if let Message::Text(text) = self.0.read().unwrap() {
                let value: Value = serde_json::from_str(&text).unwrap();
                if value["op"] == op {
                    return value;
                }
            }
        }
    }
}

fn from_base64(text: &str) -> Vec<u8> {
    const LETTERS: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let value = |letter: u8| LETTERS.iter().position(|known| *known == letter).unwrap() as u32;
    let group = |letters: &[u8]| {
        let filled = letters.iter().filter(|letter| **letter != b'=').count();
        let bits = letters.iter().fold(0, |bits, letter| bits << 6 | if *letter == b'=' { 0 } else { value(*letter) });
        bits.to_be_bytes()[1..].iter().copied().take(filled - 1).collect::<Vec<u8>>()
    };
    text.as_bytes().chunks(4).flat_map(group).collect()
}
