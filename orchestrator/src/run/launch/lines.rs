//! Lines of a component that is a process. Each pipe has a thread of its own, so that no component,
//! busy or silent, holds up the orchestrator.

use super::{ComponentEvent, PeerEvent};
use std::io::{BufRead, Read, Write};
use std::sync::mpsc::{Receiver, SyncSender};
use tremie_messages::start::Request;

/// Writes requests to a component, which may be slow to read them, or never do. Ends when the
/// orchestrator hangs up, which closes the line, or when the component is gone.
pub(super) fn write_requests(mut to: impl Write, requests: Receiver<Request>) {
    for request in requests {
        let Ok(mut text) = serde_json::to_string(&request) else { continue };
        text.push('\n');
        if to.write_all(text.as_bytes()).and_then(|()| to.flush()).is_err() {
            return;
        }
    }
}

/// Longest piece of a line on standard error [bytes]; a longer line comes in pieces.
const LOG_LINE: u64 = 64 << 10;
/// Longest reply [bytes]: room for a problem with each of a hundred thousand bodies.
const REPLY_LINE: u64 = 64 << 20;
/// Longest part of a line that is no reply that goes into the message [characters].
const GARBAGE: usize = 1000;

/// Passes on replies from a component's standard output, to its end. Its launcher, if it has one, may write there too,
/// as MPICH's does of ranks that have died.
pub(super) fn forward_replies(
    output: impl BufRead,
    (index, is_launched): (usize, bool),
    post: &SyncSender<PeerEvent>,
) {
    for line in lines(output, REPLY_LINE) {
        let news = match serde_json::from_str(&line) {
            Ok(reply) => ComponentEvent::Reply(Box::new(reply)),
            Err(_) if is_launched => ComponentEvent::Log(line),
            Err(_) => ComponentEvent::Garbage(line.chars().take(GARBAGE).collect()),
        };
        let _ = post.send((index, news));
    }
}

/// Passes on lines from a component's standard error.
pub(super) fn forward_log(errors: impl BufRead, index: usize, post: &SyncSender<PeerEvent>) {
    for line in lines(errors, LOG_LINE) {
        let _ = post.send((index, ComponentEvent::Log(line)));
    }
}

/// Lines of text, whatever bytes are in them: a component's pipe must be read to its end. A line of
/// more than `most` bytes comes in pieces, so that an endless line does not fill the memory.
fn lines(mut from: impl BufRead, most: u64) -> impl Iterator<Item = String> {
    std::iter::from_fn(move || {
        let mut bytes = Vec::new();
        match from.by_ref().take(most).read_until(b'\n', &mut bytes) {
            Ok(0) | Err(_) => None,
            Ok(_) => Some(String::from_utf8_lossy(&bytes).trim_end().to_string()),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_without_an_end_comes_in_pieces() {
        let all: Vec<_> = lines(&b"one\nand more\xff\nend"[..], 5).collect();
        assert_eq!(all, ["one", "and m", "ore\u{fffd}", "end"]);
    }
}
