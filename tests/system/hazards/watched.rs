//! A run that is watched from outside: its events with their times, its processes, its places.

use super::hazard::{Moment, Target};
use crate::resume::checkpoints;
use crate::running::{children_of, is_alive, kill, places, run_of, send};
use crate::tremie::tremie;
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Longest time of a run, on a busy machine.
const LONGEST: Duration = Duration::from_secs(120);

/// An event, and when it came.
type Told = (Instant, Value);

/// A run under way.
pub struct WatchedRun {
    child: Child,
    out: PathBuf,
    events: Arc<Mutex<Vec<Told>>>,
    reader: Option<std::thread::JoinHandle<()>>,
    /// Its components, once they were seen.
    pub processes: Vec<u32>,
    /// Its id, once it was seen.
    pub id: Option<String>,
}

impl Drop for WatchedRun {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl WatchedRun {
    /// Starts `tremie ARGUMENTS`, whose outputs are in `out` and whose temporary files, if it makes any,
    /// are in `temporary`.
    pub fn start(arguments: &[String], out: &Path, temporary: &Path) -> Self {
        let mut command = tremie();
        command.args(arguments).arg("--json").env("TMPDIR", temporary);
        Self::of(command.stdout(Stdio::piped()).stderr(Stdio::null()), out)
    }

    fn of(command: &mut Command, out: &Path) -> Self {
        let mut child = command.spawn().unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let events: Arc<Mutex<Vec<Told>>> = Arc::default();
        let told = Arc::clone(&events);
        let reader = std::thread::spawn(move || {
            for line in lines.map_while(Result::ok) {
                let at = Instant::now();
                let event = serde_json::from_str(&line).unwrap_or(Value::String(line));
                told.lock().unwrap().push((at, event));
            }
        });
        let out = out.to_path_buf();
        Self { child, out, events, reader: Some(reader), processes: Vec::new(), id: None }
    }

    /// True once it has ended.
    pub fn has_ended(&mut self) -> bool {
        self.child.try_wait().unwrap().is_some()
    }

    /// Looks which processes and places are the run's.
    fn look(&mut self) {
        let id = self.child.id();
        for child in children_of(id) {
            if !self.processes.contains(&child) {
                self.processes.push(child);
            }
        }
        if self.id.is_none() {
            self.id = run_of(id);
        }
    }

    /// Waits for a moment; `false` if the run ends before.
    fn wait_for(&mut self, moment: Moment) -> bool {
        let begin = Instant::now();
        let wanted = match moment {
            Moment::After { checkpoints, .. } | Moment::WhileWriting { checkpoints } => checkpoints,
        };
        while begin.elapsed() < LONGEST {
            if self.has_ended() {
                return false;
            }
            self.look();
            let names = checkpoints(&self.out);
            let whole = names.iter().filter(|name| name.starts_with("window")).count() as u64;
            let is_begun = self.out.join("log.jsonl").exists();
            match moment {
                Moment::After { milliseconds, .. } if is_begun && whole >= wanted => {
                    std::thread::sleep(Duration::from_millis(milliseconds));
                    return !self.has_ended();
                }
                Moment::WhileWriting { .. } if whole >= wanted && whole < names.len() as u64 => {
                    return true;
                }
                _ => std::thread::sleep(Duration::from_micros(500)),
            }
        }
        panic!("{moment:?} did not come within {LONGEST:?}");
    }

    /// Sends a signal at a moment; returns when it did, or `None` if the run was over before.
    pub fn strike(&mut self, to: Target, signal: &str, moment: Moment) -> Option<Instant> {
        self.strike_by(to, moment, |target| kill(&format!("-{signal}"), target))
    }

    /// As [`WatchedRun::strike`], by any command.
    pub fn strike_by(
        &mut self,
        to: Target,
        moment: Moment,
        command: impl FnOnce(u32) -> Command,
    ) -> Option<Instant> {
        if !self.wait_for(moment) {
            return None;
        }
        self.look();
        let target = match to {
            Target::Orchestrator => Some(self.child.id()),
            Target::Component(_, program) => {
                self.processes.iter().copied().find(|process| runs(*process, program))
            }
        };
        let target = target.filter(|id| is_alive(*id))?;
        let at = Instant::now();
        let sent = command(target).status();
        sent.is_ok_and(|status| status.success()).then_some(at)
    }

    /// Waits for the end; returns the exit code, or `None` where a signal ended it.
    pub fn wait(&mut self) -> Option<i32> {
        let begin = Instant::now();
        loop {
            self.look();
            if let Some(status) = self.child.try_wait().unwrap() {
                let _ = self.reader.take().map(std::thread::JoinHandle::join);
                return status.code();
            }
            if begin.elapsed() > LONGEST {
                self.processes.iter().for_each(|id| send(*id, "-KILL"));
                panic!("the run did not end within {LONGEST:?}: {:?}", self.events.lock().unwrap());
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// The first event of a kind, with a word in it.
    pub fn event(&self, kind: &str, word: &str) -> Option<Told> {
        let events = self.events.lock().unwrap();
        let is = |(_, event): &&Told| event["event"] == kind && event.to_string().contains(word);
        events.iter().find(is).cloned()
    }

    /// Everything that it said, for the text of a failure.
    pub fn said(&self) -> String {
        let events = self.events.lock().unwrap();
        let is_short =
            |event: &&Value| !["plan", "progress"].contains(&event["event"].as_str().unwrap_or(""));
        let texts = events.iter().map(|(_, event)| event).filter(is_short);
        texts
            .map(|event| event["text"].as_str().map_or(event.to_string(), String::from) + "\n")
            .collect()
    }

    /// That no component lives and no place of the run is left.
    #[track_caller]
    pub fn left_nothing(&self, about: &str) {
        let begin = Instant::now();
        let alive = |id: &&u32| is_alive(**id);
        while self.processes.iter().any(|id| is_alive(*id)) {
            let left: Vec<_> = self.processes.iter().filter(alive).collect();
            assert!(begin.elapsed() < Duration::from_secs(5), "{left:?} live: {about}");
            std::thread::sleep(Duration::from_millis(2));
        }
        let Some(run) = &self.id else { return };
        for place in [PathBuf::from("/dev/shm"), places()] {
            let entries = std::fs::read_dir(&place).into_iter().flatten().flatten();
            let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
            let left: Vec<_> = names.filter(|name| name.contains(run.as_str())).collect();
            assert_eq!(left, Vec::<String>::new(), "in {}: {about}", place.display());
        }
    }
}

/// True if a process runs this program.
fn runs(process: u32, program: &str) -> bool {
    let line = std::fs::read_to_string(format!("/proc/{process}/cmdline")).unwrap_or_default();
    line.split('\0').any(|word| word == program)
}
