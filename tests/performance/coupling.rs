//! What a coupling window costs when nothing is computed in it: `cargo bench --bench coupling`.
//!
//! A fluid that finds no loads and grains that never move, as processes of their own under the
//! orchestrator, for a few numbers of bodies; waiting by polling and by sleeping at once. The
//! components are this very program, started under other names.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::AtomicUsize;
use std::time::Duration;
use tremie::outputs::{Ending, Summary};
use tremie::run::{Execution, prepare};
use tremie::terminal::{Style, Terminal};
use tremie_sdk::messages::start::Description;
use tremie_sdk::messages::{BodyEvent, BodyState, Load, Problem, Stamp};
use tremie_sdk::{Fluid, Grains, Setup, SolverError, main_fluid, main_grains};

/// Bodies, and windows of a run, so that it takes a second or two.
const CASES: [(usize, u64); 3] = [(1, 50_000), (1_000, 15_000), (100_000, 100)];
/// Runs of each case; the median is told.
const REPEATS: usize = 5;
/// Length of a window [s]; means nothing here.
const WINDOW: f64 = 1e-6;

fn main() -> ExitCode {
    let name = std::env::args().next().unwrap_or_default();
    match Path::new(&name).file_name().and_then(|name| name.to_str()) {
        Some("null-fluid") => main_fluid::<NullFluid>(),
        Some("null-grains") => main_grains::<NullGrains>(),
        _ => bench(),
    }
}

/// Prints the table. Without `--bench`, as in `cargo test --all-targets`, only tries that it works.
fn bench() -> ExitCode {
    let whole = std::env::args().any(|argument| argument == "--bench");
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    println!("{cores} cores, load before: {}", load.trim());
    println!(
        "{:>7}  {:8}  {:>11}  {:>21}  {:>21}  {:>12}",
        "bodies",
        "waiting",
        "us/window",
        "fluid exchange, wait",
        "grains exchange, wait",
        "B/window"
    );
    for (bodies, windows) in CASES {
        for (waiting, poll) in [("polling", None), ("blocking", Some(Duration::ZERO))] {
            let (windows, repeats) = if whole { (windows, REPEATS) } else { (10, 1) };
            let mut runs: Vec<_> = (0..repeats).map(|_| measure(bodies, windows, poll)).collect();
            runs.sort_by(|a, b| a.wall_time.total_cmp(&b.wall_time));
            print_row(bodies, waiting, &runs);
        }
    }
    ExitCode::SUCCESS
}

/// Tells of the median of `runs`, which are sorted, and how far they spread.
fn print_row(bodies: usize, waiting: &str, runs: &[Summary]) {
    let median = &runs[runs.len() / 2];
    let a_window = |summary: &Summary, seconds| 1e6 * seconds / summary.windows as f64;
    let part = |name: &str| {
        let part = &median.components[name];
        format!("{:10.1} {:10.1}", a_window(median, part.exchange), a_window(median, part.wait))
    };
    let [least, most] =
        [&runs[0], &runs[runs.len() - 1]].map(|summary| a_window(summary, summary.wall_time));
    println!(
        "{bodies:7}  {waiting:8}  {:11.1}  {}  {}  {:12}  ({least:.1} to {most:.1})",
        a_window(median, median.wall_time),
        part("fluid"),
        part("grains"),
        bytes(bodies),
    );
}

/// What crosses between fluid and grains in a window, stamps included [bytes].
fn bytes(bodies: usize) -> usize {
    3 * size_of::<Stamp>() + bodies * (size_of::<BodyState>() + size_of::<Load>())
}

/// A run of `windows` windows.
fn measure(bodies: usize, windows: u64, poll: Option<Duration>) -> Summary {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let own = std::env::current_exe().expect("this program has a path");
    for name in ["null-fluid", "null-grains"] {
        std::os::unix::fs::symlink(&own, folder.path().join(name)).expect("a link");
    }
    let file = folder.path().join("manifest.toml");
    let manifest = tremie::manifest::parse(&file, manifest(bodies, windows), &[])
        .unwrap_or_else(|errors| panic!("{errors}"));
    let execution = Execution { poll, ..Execution::default() };
    let nobody = AtomicUsize::new(0);
    let prepared = prepare(&manifest, folder.path(), folder.path(), &execution, &nobody)
        .unwrap_or_else(|error| panic!("{error}: {error:?}"));
    let mut terminal = Terminal::new(Style::Silent);
    let ended = prepared
        .execute(&manifest, folder.path(), &execution, &mut terminal, &nobody)
        .unwrap_or_else(|error| panic!("{error}"));
    let summary = ended.close();
    assert_eq!(summary.ending, Ending::Completed);
    summary
}

fn manifest(bodies: usize, windows: u64) -> String {
    let until = WINDOW * windows as f64;
    format!(
        r#"
        [run]
        until = "{until} s"

        [scene.domain]
        size = ["10 mm", "10 mm", "10 mm"]

        [scene.fluid]
        density = "1000 kg/m3"
        viscosity = "1 Pa s"

        [components]
        fluid = "null-fluid"
        grains = "null-grains"

        [settings.null-grains]
        bodies = {bodies}

        [outputs]
        record = false
        "#
    )
}

/// A fluid that finds no loads.
struct NullFluid;

impl Fluid for NullFluid {
    const PROGRAM: &'static str = "null-fluid";

    fn describe(_: &Setup) -> Result<Description, Vec<Problem>> {
        Ok(Description::default())
    }

    fn create(_: &Setup) -> Result<Self, Vec<Problem>> {
        Ok(Self)
    }

    fn events(&mut self, _: &[BodyEvent]) -> Result<(), SolverError> {
        Ok(())
    }

    fn start(&mut self, _: &[BodyState], _: &mut [Load]) -> Result<(), SolverError> {
        Ok(())
    }

    fn advance(&mut self, _: u32, _: &[BodyState], _: &mut [Load]) -> Result<(), SolverError> {
        // The loads are zero already.
        Ok(())
    }

    fn signals(&mut self, _: &mut Vec<f64>) {}
}

/// Grains that never move.
struct NullGrains {
    count: usize,
    /// The initial bodies until the first window is over.
    events: Vec<BodyEvent>,
}

/// The number of bodies that the settings ask for.
fn count(setup: &Setup) -> Result<usize, Vec<Problem>> {
    let parameters: BTreeMap<String, usize> = setup.parameters()?;
    parameters.get("bodies").copied().ok_or_else(|| vec![Problem::new("bodies", "is missing")])
}

impl Grains for NullGrains {
    const PROGRAM: &'static str = "null-grains";

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        let bodies = count(setup)? as u64;
        Ok(Description { step: Some(WINDOW), bodies, ..Description::default() })
    }

    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let count = count(setup)?;
        let added = |id| BodyEvent {
            id,
            kind: BodyEvent::ADDED,
            shape: BodyEvent::SPHERE,
            motion: BodyEvent::FREE,
            set: 0,
            mass: 1.0,
            size: [1e-3, 0.0, 0.0],
            table: 0,
        };
        Ok(Self { count, events: (0..count as u64).map(added).collect() })
    }

    fn events(&self) -> &[BodyEvent] {
        &self.events
    }

    fn count(&self) -> usize {
        self.count
    }

    fn state(&self, bodies: &mut [BodyState]) {
        for (id, body) in bodies.iter_mut().enumerate() {
            *body = BodyState::at_rest(id as u64, [0.0; 3]);
        }
    }

    fn advance(&mut self, _: u32, _: &[Load]) -> Result<(), SolverError> {
        self.events.clear();
        Ok(())
    }

    fn signals(&mut self, _: &mut Vec<f64>) {}
}
