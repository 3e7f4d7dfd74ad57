//! Serves the web viewer's page, on loopback, and keeps it from speaking to anyone else.
//!
//! Rerun's own page server sends no content security policy. The viewer that it serves reports
//! usage to Rerun's makers and loads fonts from elsewhere; under the policy sent here the browser
//! refuses both. The policy does not keep a browser from connecting to a host ahead of time, so links
//! to others are taken out of the page.

use re_web_viewer_server::WebViewerData;
use std::io::{self, BufRead, BufReader, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

/// A browser that says nothing for so long is let go.
const PATIENCE: Duration = Duration::from_secs(10);

/// A server of the page; ends when dropped.
pub struct Page {
    address: SocketAddr,
    stopped: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Page {
    /// Serves the page on `listener`, for data on the gRPC port `data`.
    pub fn serve(listener: TcpListener, data: u16) -> io::Result<Self> {
        let files = WebViewerData::load(None).map_err(io::Error::other)?;
        let index = without_foreign_links(&String::from_utf8_lossy(files.index_html()));
        let address = listener.local_addr()?;
        let stopped = Arc::new(AtomicBool::new(false));
        let server = Server { files, index, policy: policy(data), stopped: Arc::clone(&stopped) };
        let thread = std::thread::Builder::new()
            .name("viewer-page".into())
            .spawn(move || Arc::new(server).run(&listener))?;
        Ok(Self { address, stopped, thread: Some(thread) })
    }

    /// Port of the page.
    pub fn port(&self) -> u16 {
        self.address.port()
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.stopped.store(true, Ordering::Release);
        // The thread sleeps in `accept`: this wakes it.
        drop(TcpStream::connect(self.address));
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}

/// A listener on loopback at `wanted`, or at a free port if that is taken.
pub fn listen(wanted: u16) -> io::Result<TcpListener> {
    let at = |port| TcpListener::bind((Ipv4Addr::LOCALHOST, port));
    at(wanted).or_else(|_| at(0))
}

/// Content security policy of the page: run its own program, and speak to this server and the run's
/// data.
fn policy(data: u16) -> String {
    format!(
        "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval' 'wasm-unsafe-eval'; \
         style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; worker-src 'self' blob:; \
         connect-src 'self' data: blob: http://127.0.0.1:{data} http://localhost:{data}"
    )
}

/// A page without its `link` elements that name another host.
fn without_foreign_links(page: &str) -> String {
    let mut parts = page.split("<link");
    let mut kept = String::from(parts.next().unwrap_or_default());
    for part in parts {
        let (element, rest) = part.split_once('>').unwrap_or((part, ""));
        if !element.contains("://") {
            kept.push_str("<link");
            kept.push_str(element);
            kept.push('>');
        }
        kept.push_str(rest);
    }
    kept
}

struct Server {
    files: WebViewerData,
    /// The page itself.
    index: String,
    policy: String,
    stopped: Arc<AtomicBool>,
}

impl Server {
    fn run(self: Arc<Self>, listener: &TcpListener) {
        for stream in listener.incoming() {
            if self.stopped.load(Ordering::Acquire) {
                return;
            }
            let Ok(stream) = stream else { continue };
            // A thread each: a browser opens connections that it does not use at once.
            let server = Arc::clone(&self);
            let answer = move || {
                if let Err(error) = server.answer(&stream) {
                    tracing::debug!("a browser left: {error}");
                }
            };
            std::thread::Builder::new().name("viewer-page".into()).spawn(answer).ok();
        }
    }

    fn answer(&self, stream: &TcpStream) -> io::Result<()> {
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let target = read_request(stream)?;
        let path = target.split('?').next().unwrap_or_default();
        match self.file(path) {
            Some((kind, content)) => self.reply(stream, "200 OK", kind, content),
            None => self.reply(stream, "404 Not Found", "text/plain", b"not found"),
        }
    }

    fn file(&self, path: &str) -> Option<(&'static str, &[u8])> {
        let files = &self.files;
        Some(match path {
            "/" | "/index.html" => ("text/html", self.index.as_bytes()),
            "/favicon.ico" => ("image/x-icon", files.favicon()),
            "/apple-touch-icon.png" => ("image/png", files.apple_touch_icon()),
            "/sw.js" => ("text/javascript", files.sw_js()),
            "/re_viewer.js" => ("text/javascript", files.viewer_js()),
            "/re_viewer_bg.wasm" => ("application/wasm", files.viewer_wasm()),
            _ => return None,
        })
    }

    fn reply(
        &self,
        mut stream: &TcpStream,
        status: &str,
        kind: &str,
        content: &[u8],
    ) -> io::Result<()> {
        write!(
            stream,
            "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n\
             Content-Security-Policy: {}\r\nCache-Control: no-cache\r\nConnection: close\r\n\r\n",
            content.len(),
            self.policy
        )?;
        stream.write_all(content)?;
        stream.flush()
    }
}

/// Target of a GET request, its headers read past.
fn read_request(stream: &TcpStream) -> io::Result<String> {
    // A request's head is small; whoever sends more is no browser of ours.
    let mut lines = BufReader::new(io::Read::take(stream, 64 * 1024)).lines();
    let first = lines.next().ok_or(io::ErrorKind::UnexpectedEof)??;
    for line in lines {
        if line?.is_empty() {
            break;
        }
    }
    let mut words = first.split(' ');
    match (words.next(), words.next()) {
        (Some("GET"), Some(target)) => Ok(target.to_string()),
        _ => Err(io::ErrorKind::InvalidInput.into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    fn get(port: u16, path: &str) -> String {
        let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port)).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        String::from_utf8_lossy(&answer).into_owned()
    }

    #[test]
    fn serves_the_page_under_a_policy_and_ends() {
        let page = Page::serve(listen(0).unwrap(), 9876).unwrap();
        let port = page.port();
        let answer = get(port, "/?url=x");
        assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
        assert!(answer.contains("connect-src 'self' data: blob: http://127.0.0.1:9876"));
        assert!(answer.contains("Rerun Viewer"));
        let links = answer.split("<link").skip(1).map(|rest| rest.split('>').next().unwrap());
        let links: Vec<&str> = links.collect();
        assert!(links.iter().any(|link| link.contains("favicon.ico")), "{links:?}");
        assert!(!links.iter().any(|link| link.contains("://")), "{links:?}");
        assert!(get(port, "/etc/passwd").starts_with("HTTP/1.1 404"));
        drop(page);
        assert!(TcpStream::connect((Ipv4Addr::LOCALHOST, port)).is_err());
    }

    #[test]
    fn a_taken_port_is_stepped_around() {
        let first = listen(0).unwrap();
        let taken = first.local_addr().unwrap().port();
        assert_ne!(listen(taken).unwrap().local_addr().unwrap().port(), taken);
    }
}
