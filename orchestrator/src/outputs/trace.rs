//! Trace of a run's windows: times at which each component waited, computed and exchanged. The file
//! is in the JSON format of trace events, for Perfetto (ui.perfetto.dev) and Chrome's tracing page.
//!
//! A component reports when it began a window and how long it waited, computed and exchanged in it.
//! The three are drawn one after the other. Their lengths are exact. A component that exchanges
//! inside the window waits more than once, so the borders between the three are not exact. The same holds for the
//! ranks of a component that has some: each has a track of its own.

use super::folder::OutputError;
use serde::Serialize;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use tremie_messages::control::Report;
use tremie_messages::start::RankTime;

/// A trace file that is being written.
#[derive(Debug)]
pub struct Trace {
    file: BufWriter<File>,
    path: PathBuf,
    windows: RangeInclusive<u64>,
    /// Names of the components.
    components: Vec<String>,
    /// Track of each rank that has one, by component.
    ranks: BTreeMap<(usize, usize), usize>,
    /// The machine's clock at the trace's zero [ns].
    zero: Option<u64>,
    is_empty: bool,
    is_closed: bool,
}

/// An event of the format: a name for a track, or a span of time on one.
#[derive(Serialize)]
struct TraceEvent<'a> {
    name: &'a str,
    ph: &'a str,
    pid: u32,
    tid: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    ts: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    dur: Option<f64>,
    args: Details<'a>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Details<'a> {
    Name { name: &'a str },
    Window { window: u64 },
}

impl Trace {
    /// Begins the trace at `path` of some windows of components, which get a track each.
    ///
    /// # Errors
    /// If the file cannot be made.
    pub fn create<'a>(
        path: &Path,
        windows: RangeInclusive<u64>,
        components: impl Iterator<Item = &'a str>,
    ) -> Result<Self, OutputError> {
        let file = BufWriter::new(File::create(path).map_err(OutputError::at(path))?);
        let path = path.to_path_buf();
        let components: Vec<String> = components.map(String::from).collect();
        let mut trace = Self {
            file,
            path,
            windows,
            components: components.clone(),
            ranks: BTreeMap::new(),
            zero: None,
            is_empty: true,
            is_closed: false,
        };
        components.iter().enumerate().try_for_each(|(tid, name)| trace.name_track(tid, name))?;
        Ok(trace)
    }

    fn name_track(&mut self, tid: usize, name: &str) -> Result<(), OutputError> {
        self.write(&TraceEvent {
            name: "thread_name",
            ph: "M",
            pid: 1,
            tid,
            ts: None,
            dur: None,
            args: Details::Name { name },
        })
    }

    /// Takes the report of component `index` on a window.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn take(&mut self, index: usize, report: &Report) -> Result<(), OutputError> {
        let window = report.stamp.window;
        if !self.windows.contains(&window) {
            return Ok(());
        }
        let spans =
            [("wait", report.wait), ("compute", report.compute), ("exchange", report.exchange)];
        self.draw(index, window, report.begin, &spans)
    }

    /// Takes the times of the ranks of component `index` in a window that they began to compute at `begin`.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn take_ranks(
        &mut self,
        index: usize,
        window: u64,
        begin: u64,
        ranks: &[RankTime],
    ) -> Result<(), OutputError> {
        if !self.windows.contains(&window) {
            return Ok(());
        }
        for (rank, time) in ranks.iter().enumerate() {
            let next = self.components.len() + self.ranks.len();
            let track = match self.ranks.entry((index, rank)) {
                Entry::Occupied(known) => *known.get(),
                Entry::Vacant(new) => {
                    new.insert(next);
                    let component = self.components.get(index).map_or("", String::as_str);
                    let name = format!("{component} rank {rank}");
                    self.name_track(next, &name)?;
                    next
                }
            };
            let spans = [("compute", time.compute), ("wait for ranks", time.wait)];
            self.draw(track, window, begin, &spans)?;
        }
        Ok(())
    }

    /// Draws spans one after the other on a track.
    fn draw(
        &mut self,
        track: usize,
        window: u64,
        begin: u64,
        spans: &[(&str, u64)],
    ) -> Result<(), OutputError> {
        // The first spans set the zero: nanoseconds since 1970 would lose digits in a viewer's
        // floats.
        let zero = *self.zero.get_or_insert(begin);
        let mut at = begin;
        for &(name, length) in spans {
            // Clocks of other components may have begun a little earlier.
            let ts = (at as i64 - zero as i64) as f64 * 1e-3;
            let (ts, dur) = (Some(ts), Some(length as f64 * 1e-3));
            self.write(&TraceEvent {
                name,
                ph: "X",
                pid: 1,
                tid: track,
                ts,
                dur,
                args: Details::Window { window },
            })?;
            at += length;
        }
        Ok(())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn close(mut self) -> Result<(), OutputError> {
        self.end().map_err(OutputError::at(&self.path))
    }

    fn end(&mut self) -> std::io::Result<()> {
        self.is_closed = true;
        self.file.write_all(b"\n]\n").and_then(|()| self.file.flush())
    }

    fn write(&mut self, event: &TraceEvent<'_>) -> Result<(), OutputError> {
        let before: &[u8] = if std::mem::take(&mut self.is_empty) { b"[\n" } else { b",\n" };
        self.file
            .write_all(before)
            .and_then(|()| {
                serde_json::to_writer(&mut self.file, event).map_err(std::io::Error::from)
            })
            .map_err(OutputError::at(&self.path))
    }
}

impl Drop for Trace {
    fn drop(&mut self) {
        // A run that another output's error ends still leaves a whole file.
        if !self.is_closed {
            let _ = self.end();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;
    use tremie_messages::Stamp;

    #[test]
    fn ranks_have_tracks_behind_those_of_the_components() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.json");
        let mut trace = Trace::create(&path, 1..=2, ["fluid", "grains"].into_iter()).unwrap();
        let ranks = [(3_000, 1_000), (2_500, 1_500)];
        let ranks = ranks.map(|(compute, wait)| RankTime { compute, wait });
        (1..4).for_each(|window| trace.take_ranks(0, window, 7_000 * window, &ranks).unwrap());
        trace.close().unwrap();
        let text = std::fs::read_to_string(path).unwrap();
        let events: Vec<Value> = serde_json::from_str(&text).unwrap();
        let names: Vec<&Value> = events.iter().filter(|e| e["ph"] == "M").collect();
        let names: Vec<_> = names.iter().map(|e| (&e["tid"], &e["args"]["name"])).collect();
        assert_eq!((names.len(), names[3]), (4, (&3.into(), &"fluid rank 1".into())));
        let spans: Vec<&Value> = events.iter().filter(|e| e["ph"] == "X").collect();
        assert_eq!(spans.len(), 8);
        let last = (&spans[7]["name"], spans[7]["ts"].as_f64(), spans[7]["dur"].as_f64());
        assert_eq!(last, (&"wait for ranks".into(), Some(9.5), Some(1.5)));
    }

    #[test]
    fn spans_of_the_wanted_windows_follow_each_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trace.json");
        let mut trace = Trace::create(&path, 1..=2, ["fluid", "grains"].into_iter()).unwrap();
        for window in 0..5 {
            let stamp = Stamp { window, ..Stamp::default() };
            let begin = 5_000 + window * 10_000;
            let report =
                Report { stamp, begin, compute: 3_000, wait: 6_000, exchange: 500, work: 1 };
            trace.take(1, &report).unwrap();
        }
        trace.close().unwrap();
        let events: Vec<Value> =
            serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        let names: Vec<_> =
            events[..2].iter().map(|e| e["args"]["name"].as_str().unwrap()).collect();
        assert_eq!(names, ["fluid", "grains"]);
        let spans: Vec<_> = events[2..]
            .iter()
            .map(|e| {
                (e["name"].as_str().unwrap(), e["ts"].as_f64().unwrap(), e["dur"].as_f64().unwrap())
            })
            .collect();
        assert_eq!(spans[..3], [("wait", 0.0, 6.0), ("compute", 6.0, 3.0), ("exchange", 9.0, 0.5)]);
        assert_eq!((spans.len(), spans[3].1), (6, 10.0));
        assert!(events[2..].iter().all(|e| e["tid"] == 1 && e["ph"] == "X"));
    }
}
