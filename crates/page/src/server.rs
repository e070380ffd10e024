//! The server: the page's files and one WebSocket for each open page.

use std::io;
use std::net::TcpListener;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::ws::{Message, WebSocket};
use axum::extract::{State, WebSocketUpgrade};
use axum::http::{HeaderMap, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use fingervision_pipeline::host_time_s;
use serde::{Deserialize, Serialize};
use tokio::runtime::{Builder, Runtime};
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::oneshot;
use tokio::time::timeout;

use crate::assets::asset;
use crate::hello::Hello;
use crate::shared::{OpenPage, Shared};

/// A connection is closed if the browser accepts nothing for this time.
const LONGEST_SEND: Duration = Duration::from_secs(10);
/// The longest request of a page, bytes.
const LONGEST_REQUEST: usize = 1024;

/// The requests of a page.
#[derive(Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Request {
    /// Re-zero: the next frame of this sensor becomes the reference.
    Rezero(usize),
    /// Begin or end a recording.
    Record(bool),
    /// Answered with the same number and the host's time.
    Ping(f64),
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
enum Answer<'a> {
    Hello(&'a Hello),
    Pong { sent: f64, now_s: f64 },
    Refused(String),
}

/// A server that is ready to run.
pub(crate) struct Serving {
    runtime: Runtime,
    listener: tokio::net::TcpListener,
    shared: Arc<Shared>,
}

pub(crate) fn prepare(listener: TcpListener, shared: Arc<Shared>) -> io::Result<Serving> {
    listener.set_nonblocking(true)?;
    let runtime = Builder::new_current_thread().enable_io().enable_time().build()?;
    let listener = {
        let _inside = runtime.enter();
        tokio::net::TcpListener::from_std(listener)?
    };
    Ok(Serving { runtime, listener, shared })
}

impl Serving {
    /// Serves until `ended` is received; open connections are then closed.
    pub(crate) fn run(self, ended: oneshot::Receiver<()>) {
        let Self { runtime, listener, shared } = self;
        let router = Router::new()
            .route("/ws", get(open_socket))
            .route("/access", get(access))
            .fallback(get(file))
            .with_state(shared);
        runtime.block_on(async {
            tokio::select! {
                // Only an error of the system ends the server early; pages then show that it cannot be reached.
                _ = axum::serve(listener, router) => {}
                _ = ended => {}
            }
        });
        runtime.shutdown_background();
    }
}

fn header_of(headers: &HeaderMap, name: header::HeaderName) -> Option<&str> {
    headers.get(name).and_then(|value| value.to_str().ok())
}

fn token_of(uri: &Uri) -> Option<&str> {
    uri.query()?.split('&').find_map(|part| part.strip_prefix("token="))
}

async fn file(State(shared): State<Arc<Shared>>, headers: HeaderMap, uri: Uri) -> Response {
    let (host, origin) = (header_of(&headers, header::HOST), header_of(&headers, header::ORIGIN));
    if let Err(refusal) = shared.access.check_site(host, origin) {
        return (StatusCode::FORBIDDEN, refusal.sentence()).into_response();
    }
    let Some(asset) = asset(uri.path()) else { return StatusCode::NOT_FOUND.into_response() };
    // The page loads nothing from other servers, and no other page may show it in a frame.
    let policy =
        "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; frame-ancestors 'none'";
    let headers = [
        (header::CONTENT_TYPE, asset.media_type),
        (header::CACHE_CONTROL, "no-cache"),
        (header::CONTENT_SECURITY_POLICY, policy),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    ];
    (headers, asset.bytes).into_response()
}

/// Why a request for data is refused, if it is.
fn refusal(shared: &Shared, headers: &HeaderMap, uri: &Uri) -> Option<Response> {
    let (host, origin) = (header_of(headers, header::HOST), header_of(headers, header::ORIGIN));
    let refusal = shared.access.check(host, origin, token_of(uri)).err()?;
    Some((StatusCode::FORBIDDEN, refusal.sentence()).into_response())
}

/// Tells a page why its connection is refused: a browser does not show it the answer to a WebSocket's request.
async fn access(State(shared): State<Arc<Shared>>, headers: HeaderMap, uri: Uri) -> Response {
    refusal(&shared, &headers, &uri).unwrap_or_else(|| StatusCode::NO_CONTENT.into_response())
}

async fn open_socket(
    State(shared): State<Arc<Shared>>,
    headers: HeaderMap,
    uri: Uri,
    upgrade: WebSocketUpgrade,
) -> Response {
    refusal(&shared, &headers, &uri).unwrap_or_else(|| {
        upgrade.max_message_size(LONGEST_REQUEST).on_upgrade(|socket| talk(socket, shared)).into_response()
    })
}

/// Serves one open page to its end.
async fn talk(mut socket: WebSocket, shared: Arc<Shared>) {
    let (mut texts, mut fields) = (shared.texts.subscribe(), shared.fields.subscribe());
    let _open = OpenPage::new(Arc::clone(&shared));
    if send(&mut socket, answer(&Answer::Hello(&shared.hello))).await.is_none() {
        return;
    }
    loop {
        let message = tokio::select! {
            request = socket.recv() => match request {
                Some(Ok(Message::Text(text))) => respond(&shared, text.as_str()).await,
                Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                Some(Ok(_)) => None,
            },
            text = texts.recv() => match text {
                Ok(text) => Some(Message::Text(text)),
                Err(RecvError::Lagged(_)) => None,
                Err(RecvError::Closed) => return,
            },
            newest = fields.recv() => match newest {
                Ok(bytes) => Some(Message::Binary(bytes)),
                Err(RecvError::Lagged(_)) => None,
                Err(RecvError::Closed) => return,
            },
        };
        if let Some(message) = message
            && send(&mut socket, message).await.is_none()
        {
            return;
        }
    }
}

/// Sends a message; `None` if the connection is closed.
async fn send(socket: &mut WebSocket, message: Message) -> Option<()> {
    timeout(LONGEST_SEND, socket.send(message)).await.ok()?.ok()
}

fn answer(answer: &Answer) -> Message {
    // Numbers and texts can always be written as JSON.
    Message::Text(serde_json::to_string(answer).unwrap_or_default().into())
}

async fn respond(shared: &Arc<Shared>, text: &str) -> Option<Message> {
    let request = match serde_json::from_str(text) {
        Ok(request) => request,
        Err(error) => return Some(answer(&Answer::Refused(format!("not a request: {error}")))),
    };
    match request {
        Request::Ping(sent) => Some(answer(&Answer::Pong { sent, now_s: host_time_s() })),
        Request::Rezero(sensor) => match shared.handles.get(sensor) {
            Some(handle) => {
                handle.rezero();
                None
            }
            None => Some(answer(&Answer::Refused(format!("there is no sensor {sensor}")))),
        },
        Request::Record(on) => {
            let actions = Arc::clone(&shared.actions);
            // This may wait for the disk.
            let done = tokio::task::spawn_blocking(move || actions.set_recording(on)).await;
            match done {
                Ok(Ok(_)) => None,
                Ok(Err(reason)) => Some(answer(&Answer::Refused(reason))),
                Err(error) => Some(answer(&Answer::Refused(error.to_string()))),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_read_and_others_refused() {
        let read = |text: &str| serde_json::from_str::<Request>(text).ok();
        assert_eq!(read("{\"rezero\":1}"), Some(Request::Rezero(1)));
        assert_eq!(read("{\"record\":true}"), Some(Request::Record(true)));
        assert_eq!(read("{\"ping\":1.5}"), Some(Request::Ping(1.5)));
        for other in ["", "{}", "{\"rezero\":-1}", "{\"format\":1}", "[1]", "{\"rezero\":1,\"record\":true}"] {
            assert_eq!(read(other), None, "{other}");
        }
    }

    #[test]
    fn a_token_is_found_among_other_parameters() {
        let token = |uri: &str| token_of(&uri.parse().unwrap()).map(str::to_owned);
        assert_eq!(token("/ws?token=abc"), Some("abc".into()));
        assert_eq!(token("/ws?a=1&token=abc&b=2"), Some("abc".into()));
        assert_eq!((token("/ws"), token("/ws?xtoken=1")), (None, None));
    }
}
