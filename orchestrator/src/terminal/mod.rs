//! Terminal: messages of a run to its user, as text, in a pipe, or as JSON for another program.

pub mod standard;

use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use standard::{answer, complain};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Time between progress events in JSON.
const JSON_INTERVAL: Duration = Duration::from_secs(1);

/// Time between progress lines where there is no terminal to draw on.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);

/// Time until the first such line. It comes early, because it gives the length of the run.
const FIRST_LINE: Duration = Duration::from_secs(1);

/// Amount and form of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// For a person.
    Person,
    /// Errors and the last line only.
    Quiet,
    /// Nothing at all: the caller informs the user.
    Silent,
    /// One JSON document a line on standard output.
    Json,
}

impl Style {
    /// As the options `--quiet` and `--json` ask for.
    pub fn asked(quiet: bool, json: bool) -> Self {
        match (quiet, json) {
            (_, true) => Self::Json,
            (true, _) => Self::Quiet,
            _ => Self::Person,
        }
    }
}

/// Progress of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Last window that all components completed.
    pub window: u64,
    /// Windows of the whole run.
    pub windows: u64,
    /// Simulated time [s].
    pub time: f64,
    /// Windows a second, of the last measurement.
    pub rate: f64,
    /// Work of each component: name, unit, amount a second.
    pub work: Vec<(String, String, f64)>,
    /// Share of wall time by component: name, computing, waiting.
    pub shares: Vec<(String, f64, f64)>,
    /// Bodies.
    pub bodies: u64,
}

/// Progress of many runs.
#[derive(Clone, Debug, PartialEq)]
pub struct RunsProgress {
    /// Runs that have ended, also earlier.
    pub ended: usize,
    /// All runs.
    pub runs: usize,
    /// Runs under way.
    pub going_on: usize,
    /// Runs that failed.
    pub failed: usize,
    /// Wall time to the end, if the runs go on as before [s].
    pub seconds_left: Option<f64>,
}

/// The user's end of a run: messages, progress bar, last line.
pub struct Terminal {
    style: Style,
    bar: Option<ProgressBar>,
    last_plain: Instant,
    told: bool,
    /// Messages are the command's answer, and belong on standard output.
    answers: bool,
    /// Standard error is a terminal to draw on.
    draws: bool,
}

impl Terminal {
    /// A terminal of this style for a run, whose messages go to standard error.
    pub fn new(style: Style) -> Self {
        // Asked once: the answer is a call of the system, and progress is offered all the time.
        let draws = std::io::stderr().is_terminal();
        Self { style, bar: None, last_plain: Instant::now(), told: false, answers: false, draws }
    }

    /// A terminal of this style for a command whose answer is its messages: they go to standard
    /// output, but for errors. (A run is asked for its files, so its messages go to standard
    /// error.)
    pub fn answering(style: Style) -> Self {
        Self { answers: true, ..Self::new(style) }
    }

    /// True if errors may be coloured.
    pub fn colour(&self) -> bool {
        self.draws && std::env::var_os("NO_COLOR").is_none()
    }

    /// True if a program reads the messages, and not a person.
    pub fn speaks_json(&self) -> bool {
        self.style == Style::Json
    }

    /// Something that a user wants to read.
    pub fn say(&self, text: &str) {
        match self.style {
            Style::Person => self.speak(text),
            Style::Json => self.json(json!({"event": "note", "text": text})),
            Style::Quiet | Style::Silent => {}
        }
    }

    /// Something that may spoil a result.
    pub fn warn(&self, text: &str) {
        match self.style {
            Style::Json => self.json(json!({"event": "warning", "text": text})),
            Style::Silent => {}
            _ => self.speak(&format!("warning: {text}")),
        }
    }

    /// Something that a user must read, with its verdict in the text; programs get it otherwise.
    pub fn point_out(&self, text: &str) {
        if matches!(self.style, Style::Person | Style::Quiet) {
            self.speak(text);
        }
    }

    /// The reason why the command failed; its last line, too.
    pub fn fail(&mut self, text: &str) {
        self.clear();
        match self.style {
            Style::Json => self.json(json!({"event": "error", "text": text})),
            Style::Silent => {}
            _ => self.print(&format!("error: {text}")),
        }
    }

    /// The last line, in every style but the silent one.
    pub fn end(&mut self, text: &str, details: Value) {
        self.clear();
        match self.style {
            Style::Json => self.json(json!({"event": "end", "text": text, "summary": details})),
            Style::Silent => {}
            _ => self.print(text),
        }
    }

    /// Takes the progress bar away.
    fn clear(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }

    /// An event for programs.
    pub fn event(&self, event: Value) {
        if self.style == Style::Json {
            self.json(event);
        }
    }

    /// True if the user would see progress now.
    pub fn wants_progress(&self) -> bool {
        let since = self.last_plain.elapsed();
        match self.style {
            Style::Quiet | Style::Silent => false,
            Style::Json => since > JSON_INTERVAL,
            Style::Person if self.draws => true,
            Style::Person => since > if self.told { PLAIN_INTERVAL } else { FIRST_LINE },
        }
    }

    /// Shows progress, of which [`Terminal::wants_progress`] says when.
    pub fn progress(&mut self, progress: &Progress) {
        match self.style {
            Style::Quiet | Style::Silent => {}
            Style::Json => {
                self.last_plain = Instant::now();
                self.json(json!({
                    "event": "progress", "window": progress.window, "windows": progress.windows,
                    "time": progress.time, "windows_per_second": progress.rate,
                    "seconds_left": progress.seconds_left(),
                }));
            }
            Style::Person if self.draws => {
                self.draw(progress.window, progress.windows, progress.line());
            }
            Style::Person if progress.rate > 0.0 => {
                self.told = true;
                self.last_plain = Instant::now();
                let percent = 100 * progress.window / progress.windows.max(1);
                self.print(&format!("{percent:3} %  {}", progress.line()));
            }
            Style::Person => {}
        }
    }

    /// Shows progress of many runs, of which [`Terminal::wants_progress`] says when.
    pub fn progress_of_runs(&mut self, progress: &RunsProgress) {
        let RunsProgress { ended, runs, going_on, failed, seconds_left } = progress;
        match self.style {
            Style::Quiet | Style::Silent => {}
            Style::Json => {
                self.last_plain = Instant::now();
                self.json(json!({
                    "event": "progress", "ended": ended, "runs": runs, "going_on": going_on,
                    "failed": failed, "seconds_left": seconds_left,
                }));
            }
            Style::Person if self.draws => self.draw(*ended as u64, *runs as u64, progress.line()),
            Style::Person => {
                self.told = true;
                self.last_plain = Instant::now();
                let percent = 100 * ended / runs.max(&1);
                self.print(&format!("{percent:3} %  {}", progress.line()));
            }
        }
    }

    fn draw(&mut self, position: u64, length: u64, line: String) {
        let bar = self.bar.get_or_insert_with(|| {
            let bar =
                ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::stderr_with_hz(5));
            let style = ProgressStyle::with_template("{bar:30} {percent:>3} %  {msg}");
            bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
            bar
        });
        // A change may make the run longer.
        bar.set_length(length);
        bar.set_position(position);
        bar.set_message(line);
    }

    fn speak(&self, text: &str) {
        if self.answers {
            answer(text);
        } else {
            self.print(text);
        }
    }

    fn print(&self, text: &str) {
        match &self.bar {
            // Above the bar; a plain write would land inside it.
            Some(bar) => bar.println(text),
            None => complain(text),
        }
    }

    fn json(&self, value: Value) {
        // The reader may stop reading; the run goes on.
        answer(value);
    }
}

impl RunsProgress {
    fn line(&self) -> String {
        let mut line = format!("{} of {} runs", self.ended, self.runs);
        line += &format!("  {} under way", self.going_on);
        if self.failed > 0 {
            line += &format!("  {} failed", self.failed);
        }
        if let Some(left) = self.seconds_left {
            line += &format!("  {}", time_left(left));
        }
        line
    }
}

/// A time in words [s].
fn time_left(seconds: f64) -> String {
    // Bounded: `from_secs_f64` panics where the seconds overflow.
    format!("{} left", HumanDuration(Duration::from_secs_f64(seconds.clamp(0.0, 1e9))))
}

impl Progress {
    /// Wall time to the planned end, if the rate stays [s]; `None` before it is known.
    fn seconds_left(&self) -> Option<f64> {
        let windows = self.windows.saturating_sub(self.window) as f64;
        (self.rate > 0.0).then(|| windows / self.rate)
    }

    fn line(&self) -> String {
        let mut parts = vec![
            format!("t = {:.4e} s", self.time),
            format!("window {}/{}", self.window, self.windows),
            format!("{:.1} windows/s", self.rate),
        ];
        for (_, unit, rate) in &self.work {
            parts.push(match unit.as_str() {
                "cell updates" => format!("{:.1} MLUPS", rate * 1e-6),
                "" => continue,
                unit => format!("{:.2e} {unit}/s", rate),
            });
        }
        if self.bodies > 0 {
            let plural = if self.bodies == 1 { "y" } else { "ies" };
            parts.push(format!("{} bod{plural}", self.bodies));
        }
        for (name, compute, wait) in &self.shares {
            parts.push(format!(
                "{name} computes {:.0} %, waits {:.0} %",
                100.0 * compute,
                100.0 * wait
            ));
        }
        if let Some(left) = self.seconds_left() {
            parts.push(time_left(left));
        }
        parts.join("  ")
    }
}
