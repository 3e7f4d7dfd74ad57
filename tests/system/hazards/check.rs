//! A disturbed run, and what must hold of it.

use super::hazard::{Hazard, Target, What};
use super::watched::WatchedRun;
use crate::resume::{assert_same_outputs, assert_same_states, checkpoints, files};
use crate::tremie::tremie;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::{Display, Formatter};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Longest wait for a component that hangs.
const DEADLINE: Duration = Duration::from_millis(1500);
/// Longest time to notice anything else, on a machine that is busy with other tests. The long form
/// prints how long it took.
const NOTICED: Duration = Duration::from_secs(5);

/// Outputs of runs that nothing disturbed, by scene and schedule.
#[derive(Default)]
pub struct Undisturbed {
    runs: BTreeMap<(&'static str, &'static str), TempDir>,
}

impl Undisturbed {
    /// The folder of the manifest, with the outputs in `out`.
    fn of(&mut self, hazard: &Hazard) -> &Path {
        let key = (hazard.scene.name, hazard.schedule);
        let run = self.runs.entry(key).or_insert_with(|| {
            let home = tempfile::tempdir().unwrap();
            hazard.scene.write(home.path());
            let out = home.path().join("out");
            let order = order(hazard, home.path(), &out);
            let output = tremie().args(order).arg("--quiet").output().unwrap();
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.success(), "{}: {said}", hazard.scene.name);
            assert!(!said.contains("is lost"), "{}: {said}", hazard.scene.name);
            home
        });
        run.path()
    }
}

/// The words that order a run of the manifest in a folder, with its outputs in another.
fn order(hazard: &Hazard, manifest: &Path, out: &Path) -> Vec<String> {
    let mut words: Vec<String> = vec!["run".into(), manifest.display().to_string()];
    words.extend(["--out".into(), out.display().to_string()]);
    let every = hazard.scene.every;
    words.push("--set".into());
    words.push(format!("run.checkpoints={{ windows = {every}, keep = 99 }}"));
    if hazard.scene.has_schedules {
        words.extend(["--schedule".into(), hazard.schedule.into()]);
    }
    words
}

/// What became of a disturbed run.
pub struct Disturbed {
    /// Time from the fault, or from the deadline of one that hangs, until it was noticed.
    pub noticed_after: Option<Duration>,
    /// The run was over before.
    pub came_too_late: bool,
    /// Window from which it went on.
    resumed_from: Option<u64>,
}

impl Display for Disturbed {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        if self.came_too_late {
            return f.write_str("the run was over before");
        }
        if let Some(delay) = self.noticed_after {
            write!(f, "noticed after {:.1} ms, ", 1e3 * delay.as_secs_f64())?;
        }
        match self.resumed_from {
            Some(window) => write!(f, "went on from window {window} to the same bits"),
            None => f.write_str("there was nothing to go on from"),
        }
    }
}

impl Disturbed {
    /// Carries a hazard out, and lets the run go on.
    #[track_caller]
    pub fn run(hazard: &Hazard, undisturbed: &mut Undisturbed, about: &str) -> Self {
        // Of the same manifest: a recording names the files of its scene.
        let manifest = undisturbed.of(hazard).to_path_buf();
        let whole = manifest.join("out");
        let home = tempfile::tempdir().unwrap();
        let (manifest, whole) = (manifest.as_path(), whole.as_path());
        let disturbance = Disturbance { hazard, manifest, home: home.path(), whole, about };
        disturbance.carry_out()
    }
}

struct Disturbance<'a> {
    hazard: &'a Hazard,
    manifest: &'a Path,
    home: &'a Path,
    whole: &'a Path,
    about: &'a str,
}

impl Disturbance<'_> {
    fn out(&self) -> PathBuf {
        self.home.join("out")
    }

    fn start(&self, arguments: &[String]) -> WatchedRun {
        let temporary = self.home.join("temporary");
        std::fs::create_dir_all(&temporary).unwrap();
        WatchedRun::start(arguments, &self.out(), &temporary)
    }

    #[track_caller]
    fn carry_out(&self) -> Disturbed {
        let mut words = order(self.hazard, self.manifest, &self.out());
        if let What::Fault { component, kind, window } = &self.hazard.what {
            words.extend(["--inject".into(), format!("{component}:{kind}@{window}")]);
        }
        if self.hazard.what.hangs() {
            words.extend(["--set".into(), format!("run.deadline={} s", DEADLINE.as_secs_f64())]);
        }
        let mut run = self.start(&words);
        let struck = match &self.hazard.what {
            What::Fault { .. } => None,
            What::Signal { to, signal, moment } => run.strike(*to, signal, *moment),
            What::KilledTwice { moments, .. } => {
                run.strike(Target::Orchestrator, "KILL", moments[0])
            }
        };
        let code = run.wait();
        let is_fault = matches!(self.hazard.what, What::Fault { .. });
        if !is_fault && struck.is_none() || code == Some(0) {
            return self.was_not_broken_off(&run, struck, code);
        }
        let noticed_after = self.ended_as_it_should(&run, struck, code);
        let resumed_from = self.goes_on(&run);
        Disturbed { noticed_after, came_too_late: false, resumed_from }
    }

    /// A run whose recorder was killed goes on without, and one that was struck too late is whole.
    #[track_caller]
    fn was_not_broken_off(
        &self,
        run: &WatchedRun,
        struck: Option<Instant>,
        code: Option<i32>,
    ) -> Disturbed {
        let about = format!("{}\n{}", self.about, run.said());
        assert_eq!(code, Some(0), "{about}");
        run.left_nothing(&about);
        let table = |out: &Path| std::fs::read(out.join("signals.csv")).unwrap();
        assert!(table(&self.out()) == table(self.whole), "the tables differ: {about}");
        let is_recorder = self.hazard.what.blamed() == Some("recorder");
        let mut disturbed =
            Disturbed { noticed_after: None, came_too_late: true, resumed_from: None };
        match (is_recorder, struck) {
            (true, Some(struck)) => {
                if let Some((at, _)) = run.event("warning", "recorder is lost") {
                    disturbed.noticed_after = Some(at.saturating_duration_since(struck));
                    disturbed.came_too_late = false;
                }
            }
            // A signal in the very last moment finds nothing to break off.
            (_, _) => assert!(!matches!(self.hazard.what, What::Fault { .. }), "{about}"),
        }
        disturbed
    }

    /// How the run ended: noticed in time, with one sentence, and with nothing left behind.
    #[track_caller]
    fn ended_as_it_should(
        &self,
        run: &WatchedRun,
        struck: Option<Instant>,
        code: Option<i32>,
    ) -> Option<Duration> {
        let about = format!("{}\n{}", self.about, run.said());
        let killed = matches!(
            self.hazard.what,
            What::KilledTwice { .. }
                | What::Signal { to: Target::Orchestrator, signal: "KILL", .. }
        );
        if killed {
            assert_eq!(code, None, "{about}");
            return None;
        }
        run.left_nothing(&about);
        if let Some((_, error)) = run.event("error", "") {
            // Killed before the first window: nothing was begun.
            let blamed = self.hazard.what.blamed().unwrap_or("interrupted");
            assert!(error["text"].as_str().is_some_and(|text| text.contains(blamed)), "{about}");
            assert!(matches!(code, Some(1 | 130)) && !self.out().exists(), "{about}");
            return None;
        }
        self.left_no_files(&about);
        let (_, end) = run.event("end", "").expect(&about);
        let text = end["text"].as_str().unwrap();
        let has_checkpoint = end["summary"]["checkpoint"].is_u64();
        assert_eq!(text.contains("tremie resume"), has_checkpoint, "{about}");
        if self.hazard.what.blamed().is_none() {
            assert_eq!(code, Some(130), "{about}");
            return None;
        }
        assert_eq!(code, Some(1), "{about}");
        self.names_what_happened(&end["summary"], text, &about);
        self.noticed_in_time(run, struck, &about)
    }

    #[track_caller]
    fn names_what_happened(&self, summary: &Value, text: &str, about: &str) {
        let fault = &summary["fault"];
        assert_eq!(fault["blamed"].as_str(), self.hazard.what.blamed(), "{about}");
        let sentence = text.lines().find(|line| line.starts_with("failed: ")).expect(about);
        let blamed = self.hazard.what.blamed().unwrap();
        assert!(sentence.contains(blamed) && sentence.contains("at window "), "{about}");
        if let What::Fault { window, .. } = self.hazard.what {
            let found = fault["window"].as_u64().unwrap();
            assert!(found.abs_diff(window) <= 2, "{about}");
        }
    }

    #[track_caller]
    fn noticed_in_time(
        &self,
        run: &WatchedRun,
        struck: Option<Instant>,
        about: &str,
    ) -> Option<Duration> {
        let committed = || run.event("warning", "on purpose").map(|(at, _)| at);
        let since = struck.or_else(committed)?;
        let (noticed, _) = run.event("fault", "").expect(about);
        let due = if self.hazard.what.hangs() { since + DEADLINE } else { since };
        let delay = noticed.saturating_duration_since(due);
        assert!(delay < NOTICED, "noticed after {delay:?}: {about}");
        Some(delay)
    }

    /// No temporary files, no half files, no unfinished checkpoints.
    #[track_caller]
    fn left_no_files(&self, about: &str) {
        let in_folder = |folder: PathBuf| {
            let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
            entries.map(|entry| entry.file_name().to_string_lossy().into_owned())
        };
        let temporary: Vec<_> = in_folder(self.home.join("temporary")).collect();
        assert_eq!(temporary, Vec::<String>::new(), "{about}");
        let folders = ["", "fields", "inputs"].map(|name| self.out().join(name));
        let half: Vec<_> = folders
            .into_iter()
            .flat_map(in_folder)
            .filter(|name| name.ends_with(".part"))
            .collect();
        assert_eq!(half, Vec::<String>::new(), "{about}");
        let kept = checkpoints(&self.out());
        assert!(kept.iter().all(|name| name.starts_with("window")), "{kept:?}: {about}");
    }

    /// Lets the run go on from its newest checkpoint; returns the window of that, if there was one.
    #[track_caller]
    fn goes_on(&self, broken: &WatchedRun) -> Option<u64> {
        let mut words = vec!["resume".to_string(), self.out().display().to_string()];
        words.extend(self.hazard.resume.clone());
        if self.hazard.what.hangs() {
            words.extend(["--set".into(), "run.deadline=60 s".into()]);
        }
        let whole = |name: &String| name.starts_with("window");
        let kept = || checkpoints(&self.out()).into_iter().filter(whole);
        if let What::KilledTwice { moments, goes_back } = &self.hazard.what {
            let first = kept().next().and_then(|name| name.rsplit('-').next()?.parse::<u64>().ok());
            let mut again = words.clone();
            if let Some(first) = first.filter(|_| *goes_back) {
                again.extend(["--at".into(), first.to_string()]);
            }
            let mut run = self.start(&again);
            if run.strike(Target::Orchestrator, "KILL", moments[1]).is_some() {
                run.wait();
            }
        }
        let newest = kept().next_back();
        let mut run = self.start(&words);
        let code = run.wait();
        let about = format!("{}\n{}then\n{}", self.about, broken.said(), run.said());
        let Some(newest) = newest else {
            assert_eq!(code, Some(2), "{about}");
            assert!(run.said().contains("holds no checkpoint"), "{about}");
            let cleaned = tremie().arg("clean").output().unwrap();
            assert!(cleaned.status.success(), "{about}");
            broken.left_nothing(&about);
            return None;
        };
        assert_eq!(code, Some(0), "{about}");
        broken.left_nothing(&about);
        run.left_nothing(&about);
        self.left_no_files(&about);
        self.is_the_same(&about);
        newest.rsplit('-').next()?.parse().ok()
    }

    #[track_caller]
    fn is_the_same(&self, about: &str) {
        println!("{}", about.lines().next().unwrap_or_default());
        assert_eq!(files(self.whole), files(&self.out()), "{about}");
        assert_same_outputs(self.whole, &self.out());
        // An end that is asked for makes one of its own, and so does a limit that is passed: when the
        // orchestrator hears of it, a window sooner or later.
        let is_planned = |name: &String| {
            let window: u64 = name.rsplit('-').next().unwrap().parse().unwrap();
            window.is_multiple_of(self.hazard.scene.every)
        };
        let (mut whole, mut resumed) = (checkpoints(self.whole), checkpoints(&self.out()));
        whole.retain(|name| is_planned(name) || resumed.contains(name));
        resumed.retain(|name| is_planned(name) || whole.contains(name));
        assert_eq!(whole, resumed, "{about}");
        assert_same_states(self.whole, &self.out(), &whole);
        let summary = |out: &Path| -> Value {
            let text = std::fs::read_to_string(out.join("summary.json")).unwrap();
            serde_json::from_str(&text).unwrap()
        };
        let (whole, resumed) = (summary(self.whole), summary(&self.out()));
        for key in ["status", "windows", "simulated_time", "signals", "observers"] {
            assert_eq!(whole[key], resumed[key], "{key}: {about}");
        }
    }
}
