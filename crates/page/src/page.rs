//! Starts and stops the server.

use std::io;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, JoinHandle};

use fingervision_pipeline::{SensorHandle, Subscription};
use tokio::sync::oneshot;

use crate::access::Access;
use crate::feed::Feed;
use crate::server;
use crate::shared::Shared;
use crate::{Actions, PageError, PageOptions};

/// The default port, and the number of ports that are tried from it on.
const FIRST_PORT: u16 = 8090;
const PORTS: u16 = 20;

/// A page that is being served.
pub struct Page {
    shared: Arc<Shared>,
    is_stopped: Arc<AtomicBool>,
    end_server: Option<oneshot::Sender<()>>,
    threads: Vec<JoinHandle<()>>,
}

impl Page {
    /// Serves the page for these sensors; `subscription` gives their readings.
    ///
    /// # Errors
    ///
    /// [`PageError`] if the port is taken or the address is not one of this machine.
    pub fn start(
        options: PageOptions,
        handles: &[SensorHandle],
        subscription: Subscription,
        actions: Arc<dyn Actions>,
    ) -> Result<Self, PageError> {
        let listener = listen(options)?;
        let system = |error: io::Error| PageError::System { reason: error.to_string() };
        let access = Access::new(listener.local_addr().map_err(system)?)?;
        let shared = Arc::new(Shared::new(access, handles, actions));
        let is_stopped = Arc::new(AtomicBool::new(false));
        let (end_server, ended) = oneshot::channel();
        let feed = Feed::new(subscription, handles.to_vec(), Arc::clone(&shared));
        let stop_feed = Arc::clone(&is_stopped);
        let serving = server::prepare(listener, Arc::clone(&shared)).map_err(system)?;
        let server = thread::Builder::new().name("page-server".into()).spawn(|| serving.run(ended)).map_err(system)?;
        let mut page = Self { shared, is_stopped, end_server: Some(end_server), threads: vec![server] };
        let feeding = thread::Builder::new().name("page-feed".into()).spawn(move || feed.run(&stop_feed));
        page.threads.push(feeding.map_err(system)?);
        Ok(page)
    }

    /// Whether the page could be served now, before work that takes long.
    ///
    /// # Errors
    ///
    /// As [`Self::start`].
    pub fn check(options: PageOptions) -> Result<(), PageError> {
        listen(options).map(drop)
    }

    /// Whether a browser shows the page.
    #[must_use]
    pub fn is_open(&self) -> bool {
        self.shared.has_pages()
    }

    /// The address to open in a browser.
    #[must_use]
    pub fn url(&self) -> String {
        self.shared.access.url()
    }

    /// Stops serving. Open pages show this.
    pub fn stop(mut self) {
        self.end();
    }

    fn end(&mut self) {
        self.is_stopped.store(true, Ordering::Release);
        if let Some(end) = self.end_server.take() {
            // The server may have ended already.
            let _ = end.send(());
        }
        for thread in self.threads.drain(..) {
            // A thread that panicked has ended, too.
            let _ = thread.join();
        }
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.end();
    }
}

fn listen(options: PageOptions) -> Result<TcpListener, PageError> {
    let bind = |port: u16| {
        let address = SocketAddr::new(options.address, port);
        TcpListener::bind(address).map_err(|error| PageError::bind(address, error))
    };
    if let Some(port) = options.port {
        return bind(port);
    }
    let mut last = bind(FIRST_PORT);
    for port in FIRST_PORT + 1..FIRST_PORT + PORTS {
        if !matches!(last, Err(PageError::PortTaken { .. })) {
            break;
        }
        last = bind(port);
    }
    last
}
