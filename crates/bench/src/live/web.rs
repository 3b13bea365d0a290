//! A local web page with live plots, over server-sent events.
//!
//! Two resources, on a loopback address only: `/`, the page, and `/events`, the stream. A request
//! whose `Host` is not this address is refused, so that no foreign page reads it by a name that
//! leads here. A request has two seconds, however its bytes come; where too many wait, the oldest
//! gives way to a new one; and one address has half of the streams at most.

use std::fmt::Write as _;
use std::io::{self, Read, Write};
use std::net::{IpAddr, Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use serde_json::json;
use thiserror::Error;

use super::dashboard::Dashboard;
use crate::record::View;

/// Time between two events.
const INTERVAL: Duration = Duration::from_millis(50);
/// Most streams at a time, and most of one address.
const STREAMS: (usize, usize) = (16, 8);
/// Most connections that have not asked for anything yet.
const WAITING: usize = 8;
/// Longest head of a request.
const HEAD: usize = 8192;
/// How long a request may take, and an answer that nobody reads.
const REQUEST: Duration = Duration::from_secs(2);
/// How long the end of a run waits for the streams to send its last row.
const PATIENCE: Duration = Duration::from_secs(1);

const PAGE: &str = include_str!("page.html");

/// The server on its own threads; it ends with the run.
#[derive(Debug)]
pub struct Web {
    shared: Arc<Shared>,
    thread: JoinHandle<()>,
}

/// A server that does not start.
#[derive(Debug, Error)]
#[error("the live page cannot be served at 127.0.0.1:{port}: {error}{way_out}")]
pub struct WebError {
    port: u16,
    error: io::Error,
    way_out: &'static str,
}

/// What every connection knows.
#[derive(Debug)]
struct Shared {
    dashboard: Dashboard,
    view: View,
    stop: AtomicBool,
    address: SocketAddr,
    /// Numbers the connections.
    count: AtomicU64,
    open: Mutex<Open>,
}

/// The connections that there are.
#[derive(Debug, Default)]
struct Open {
    /// Those that have not asked for anything yet, the oldest first.
    waiting: Vec<(u64, TcpStream)>,
    /// Where the streams lead.
    streams: Vec<IpAddr>,
}

impl Shared {
    fn open(&self) -> MutexGuard<'_, Open> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Has a place for a stream, if there is one.
    fn takes(&self, address: IpAddr) -> bool {
        let streams = &mut self.open().streams;
        let own = streams.iter().filter(|other| **other == address).count();
        let takes = streams.len() < STREAMS.0 && own < STREAMS.1;
        if takes {
            streams.push(address);
        }
        takes
    }

    fn gives_back(&self, address: IpAddr) {
        let streams = &mut self.open().streams;
        if let Some(place) = streams.iter().position(|other| *other == address) {
            streams.swap_remove(place);
        }
    }
}

impl Web {
    /// Serves the page at 127.0.0.1 and this port; 0: a free one.
    ///
    /// # Errors
    /// The port is taken.
    pub fn start(dashboard: Dashboard, view: View, port: u16) -> Result<Self, WebError> {
        let way_out = "; choose another port with --web PORT, 0 for a free one";
        let failed = |error| WebError { port, error, way_out };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let shared = Arc::new(Shared {
            dashboard,
            view,
            stop: AtomicBool::new(false),
            address,
            count: AtomicU64::new(0),
            open: Mutex::default(),
        });
        let all = Arc::clone(&shared);
        let thread = std::thread::Builder::new().spawn(move || listen(&listener, &all));
        let thread = thread.map_err(|error| WebError {
            port,
            error: numerics::threads::refused(error),
            way_out: "",
        })?;
        Ok(Web { shared, thread })
    }

    /// Where it is.
    #[must_use]
    pub fn url(&self) -> String {
        format!("http://{}/", self.shared.address)
    }

    /// Ends it, once the open streams have sent the last row, or after a second.
    pub fn finish(self) {
        self.shared.stop.store(true, Ordering::Relaxed);
        let _ = self.thread.join();
        let begin = Instant::now();
        while !self.shared.open().streams.is_empty() && begin.elapsed() < PATIENCE {
            std::thread::sleep(INTERVAL / 10);
        }
    }
}

fn listen(listener: &TcpListener, shared: &Arc<Shared>) {
    while !shared.stop.load(Ordering::Relaxed) {
        let Ok((stream, peer)) = listener.accept() else {
            std::thread::sleep(INTERVAL);
            continue;
        };
        // A connection that cannot be served is closed.
        let Ok(second) = stream.try_clone() else { continue };
        let number = shared.count.fetch_add(1, Ordering::Relaxed);
        {
            let waiting = &mut shared.open().waiting;
            if waiting.len() >= WAITING {
                let _ = waiting.remove(0).1.shutdown(Shutdown::Both);
            }
            waiting.push((number, second));
        }
        let all = Arc::clone(shared);
        let served = std::thread::Builder::new().spawn(move || {
            // A reader that goes away is no trouble of the run.
            let _ = answer(stream, number, peer.ip(), &all);
            asked(number, &all);
        });
        if served.is_err() {
            asked(number, shared);
        }
    }
}

/// A connection does not wait any more.
fn asked(number: u64, shared: &Shared) {
    shared.open().waiting.retain(|(waiting, _)| *waiting != number);
}

fn answer(mut stream: TcpStream, number: u64, peer: IpAddr, shared: &Shared) -> io::Result<()> {
    stream.set_nonblocking(false)?;
    stream.set_write_timeout(Some(REQUEST))?;
    let (path, host) = request(&mut stream)?;
    asked(number, shared);
    let port = shared.address.port();
    let ours = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
    if !host.is_some_and(|host| ours.contains(&host)) {
        return say(&mut stream, "403 Forbidden", "text/plain", "this page is for this computer\n");
    }
    match path.as_deref() {
        Some("/") => say(&mut stream, "200 OK", "text/html; charset=utf-8", PAGE),
        Some("/events") if !shared.takes(peer) => {
            let why = "so many pages are open that no other is served; close one\n";
            say(&mut stream, "503 Service Unavailable", "text/plain", why)
        }
        Some("/events") => {
            let sent = events(&mut stream, shared);
            shared.gives_back(peer);
            sent
        }
        _ => say(&mut stream, "404 Not Found", "text/plain", "there is / and /events\n"),
    }
}

/// Path of a GET request, and its host.
fn request(stream: &mut TcpStream) -> io::Result<(Option<String>, Option<String>)> {
    let begin = Instant::now();
    let (mut head, mut piece) = (Vec::new(), [0; 1024]);
    let is_complete = |head: &[u8]| head.windows(4).any(|end| end == b"\r\n\r\n");
    while !is_complete(&head) {
        let left = REQUEST.saturating_sub(begin.elapsed());
        if left.is_zero() || head.len() > HEAD {
            return Err(io::ErrorKind::TimedOut.into());
        }
        stream.set_read_timeout(Some(left))?;
        match stream.read(&mut piece)? {
            0 => break,
            count => head.extend_from_slice(&piece[..count]),
        }
    }
    let head = String::from_utf8_lossy(&head);
    let mut lines = head.lines();
    let mut words = lines.next().unwrap_or_default().split(' ');
    let path = (words.next() == Some("GET")).then(|| words.next().map(str::to_owned)).flatten();
    let host = lines.take_while(|line| !line.is_empty()).find_map(|line| {
        let (name, value) = line.split_once(':')?;
        name.eq_ignore_ascii_case("host").then(|| value.trim().to_owned())
    });
    Ok((path, host))
}

fn say(stream: &mut TcpStream, status: &str, kind: &str, body: &str) -> io::Result<()> {
    let length = body.len();
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n\
         Content-Security-Policy: default-src 'none'; script-src 'unsafe-inline'; \
         style-src 'unsafe-inline'; connect-src 'self'\r\nX-Content-Type-Options: nosniff\r\n\
         Cache-Control: no-store\r\nConnection: close\r\n\r\n{body}"
    )
}

fn events(stream: &mut TcpStream, shared: &Shared) -> io::Result<()> {
    write!(
        stream,
        "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\n\
         Connection: close\r\n\r\n"
    )?;
    let mut seen = u64::MAX;
    loop {
        let latest = shared.view.latest();
        let ended = latest.ended || shared.stop.load(Ordering::Relaxed);
        if latest.rows != seen {
            seen = latest.rows;
            let mut text = String::new();
            // Writing to a string cannot fail.
            let _ = write!(text, "data: {}\n\n", event(&shared.dashboard, &latest));
            stream.write_all(text.as_bytes())?;
        }
        if ended {
            return stream.write_all(b"event: end\ndata: {}\n\n");
        }
        std::thread::sleep(INTERVAL);
    }
}

/// What the page gets.
fn event(dashboard: &Dashboard, latest: &crate::record::Latest) -> serde_json::Value {
    let state = dashboard.state(latest);
    let axes: Vec<serde_json::Value> = dashboard
        .axes(latest)
        .iter()
        .map(|axis| {
            json!({
                "name": axis.name, "unit": axis.unit, "command_unit": axis.command_unit,
                "reference": axis.reference, "position": axis.position, "command": axis.command,
            })
        })
        .collect();
    let own = |name: &str| dashboard.own(latest, name);
    json!({
        "time": latest.row.first(),
        "rows": latest.rows,
        "state": state.map(|(state, _)| state.name()),
        "reason": state.map(|(_, reason)| reason.sentence()),
        "axes": axes,
        "wake": dashboard.greatest(latest, "wake"),
        "work": dashboard.greatest(latest, "work"),
        "round_trip": dashboard.greatest(latest, "round_trip"),
        "lost": own("lost"), "late": own("late"), "duplicate": own("duplicate"),
        "reordered": own("reordered"), "corrupt": own("corrupt"),
    })
}

#[cfg(test)]
mod tests {
    use std::io::{BufRead, BufReader};

    use super::*;
    use crate::cycle::columns;
    use crate::record::Recorder;

    fn get(address: SocketAddr, path: &str, host: &str) -> String {
        let mut stream = TcpStream::connect(address).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        text
    }

    #[test]
    fn it_serves_the_page_and_the_stream_to_this_computer() {
        let axis = |word: &str| [(format!("{word}[1]"), Some("um".to_owned()))];
        let columns = columns(&axis("reference"), &axis("position"), &axis("command"), false);
        let (recorder, mut ring) = Recorder::start(None, columns.len(), 100).unwrap();
        let view = recorder.view().clone();
        let web = Web::start(Dashboard::new(&columns), view, 0).unwrap();
        assert!(web.shared.address.ip().is_loopback());
        for k in 0..columns.len() {
            ring.push(k as f64).unwrap();
        }
        recorder.finish().unwrap();
        let host = web.shared.address.to_string();
        let page = get(web.shared.address, "/", &host);
        assert!(page.starts_with("HTTP/1.1 200") && page.contains("/events"));
        let stream = get(web.shared.address, "/events", &host);
        assert!(stream.contains("\"position\":2.0") && stream.contains("event: end"), "{stream}");
        assert!(get(web.shared.address, "/x", &host).starts_with("HTTP/1.1 404"));
        assert!(get(web.shared.address, "/", "evil.example").starts_with("HTTP/1.1 403"));
        web.finish();
    }

    /// Those that drip keep nobody away, and have two seconds.
    #[test]
    fn slow_connections_give_way() {
        let (recorder, _ring) = Recorder::start(None, 1, 100).unwrap();
        let web = Web::start(Dashboard::new(&[]), recorder.view().clone(), 0).unwrap();
        let (address, host) = (web.shared.address, web.shared.address.to_string());
        let mut slow: Vec<TcpStream> =
            (0..3 * WAITING).map(|_| TcpStream::connect(address).unwrap()).collect();
        let begin = Instant::now();
        assert!(get(address, "/", &host).starts_with("HTTP/1.1 200"));
        assert!(begin.elapsed() < REQUEST);
        let last = slow.last_mut().unwrap();
        let is_open = |stream: &mut TcpStream| stream.write_all(b"G").is_ok();
        while is_open(last) && begin.elapsed() < 3 * REQUEST {
            std::thread::sleep(INTERVAL);
        }
        assert!(begin.elapsed() < 2 * REQUEST, "{:?}", begin.elapsed());
        // One address does not take all streams.
        let peer = IpAddr::from(Ipv4Addr::LOCALHOST);
        assert_eq!((0..STREAMS.0).filter(|_| web.shared.takes(peer)).count(), STREAMS.1);
        assert!(get(address, "/events", &host).starts_with("HTTP/1.1 503"));
        (0..STREAMS.1).for_each(|_| web.shared.gives_back(peer));
        recorder.finish().unwrap();
        web.finish();
    }

    /// The process ends after `finish`, and its threads with it.
    #[test]
    fn the_last_row_has_been_sent_when_it_has_finished() {
        let axis = |word: &str| [(format!("{word}[1]"), Some("um".to_owned()))];
        let columns = columns(&axis("reference"), &axis("position"), &axis("command"), false);
        let (recorder, mut ring) = Recorder::start(None, columns.len(), 100).unwrap();
        let web = Web::start(Dashboard::new(&columns), recorder.view().clone(), 0).unwrap();
        let mut stream = TcpStream::connect(web.shared.address).unwrap();
        write!(stream, "GET /events HTTP/1.1\r\nHost: {}\r\n\r\n", web.shared.address).unwrap();
        let mut reader = BufReader::new(stream.try_clone().unwrap());
        let mut line = String::new();
        while !line.starts_with("data:") {
            line.clear();
            assert!(reader.read_line(&mut line).unwrap() > 0, "the first event");
        }
        for k in 0..columns.len() {
            ring.push(k as f64).unwrap();
        }
        recorder.finish().unwrap();
        web.finish();
        stream.set_nonblocking(true).unwrap();
        let mut rest = Vec::new();
        // Nothing more comes: the stream has ended, or would have to be waited for.
        let _ = reader.read_to_end(&mut rest);
        let rest = String::from_utf8_lossy(&rest);
        assert!(rest.contains("\"position\":2.0") && rest.contains("event: end"), "{rest}");
    }
}
