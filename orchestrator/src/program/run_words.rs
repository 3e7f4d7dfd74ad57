//! The command line of a run, made of its arguments: for a job, which reads it again.

use super::cli::{ManifestArgs, ResumeArgs, RunArgs, View};
use std::ffi::{OsStr, OsString};
use std::path::Path;
use tremie_messages::schedule::Schedule;
use tremie_messages::start::InjectionKind;

/// Words of a command line.
#[derive(Default)]
struct CommandWords(Vec<OsString>);

impl CommandWords {
    fn add(&mut self, word: impl AsRef<OsStr>) {
        self.0.push(word.as_ref().into());
    }

    fn option(&mut self, name: &str, value: impl AsRef<OsStr>) {
        self.add(name);
        self.add(value);
    }

    fn flag(&mut self, name: &str, is_set: bool) {
        if is_set {
            self.add(name);
        }
    }

    fn sets(&mut self, sets: &[(String, String)]) {
        for (key, value) in sets {
            self.option("--set", format!("{key}={value}"));
        }
    }

    fn of_manifest(&mut self, arguments: &ManifestArgs) {
        self.add(absolute(&arguments.manifest));
        if let Some(until) = &arguments.until {
            self.option("--until", until);
        }
        match arguments.schedule {
            Some(Schedule::Serial) => self.option("--schedule", "serial"),
            Some(Schedule::Parallel) => self.option("--schedule", "parallel"),
            None => {}
        }
        self.sets(&arguments.set);
    }

    fn view(&mut self, view: &View) {
        match view {
            View::None => {}
            View::Web => self.option("--view", "web"),
            View::Native => self.option("--view", "native"),
            View::File(file) => self.option("--view", file),
        }
    }

    fn restarts(&mut self, restarts: u32) {
        if restarts > 0 {
            self.option("--restart-on-fault", restarts.to_string());
        }
    }
}

/// Words of `tremie run` in a job, with its outputs in `out`. A job tells little: the plan was shown before.
pub fn run_words(arguments: &RunArgs, out: &Path) -> Vec<OsString> {
    let mut words = CommandWords::default();
    words.add("run");
    words.of_manifest(&arguments.manifest);
    words.option("--out", absolute(out));
    words.view(&arguments.view);
    words.flag("--in-process", arguments.in_process);
    if let Some(windows) = &arguments.trace {
        words.add(format!("--trace={}-{}", windows.start(), windows.end()));
    }
    words.restarts(arguments.restart_on_fault);
    if let Some((from, window)) = &arguments.from {
        let mut from = absolute(from);
        if let Some(window) = window {
            from.push(format!("@{window}"));
        }
        words.option("--from", from);
    }
    if let Some(changes) = &arguments.changes {
        words.option("--changes", absolute(changes));
    }
    if let Some(window) = arguments.pause_at {
        words.option("--pause-at", window.to_string());
    }
    for (component, injection) in &arguments.inject {
        let mut kinds = InjectionKind::ALL.iter();
        let name = kinds.find(|(kind, _)| *kind == injection.kind).map_or("", |(_, name)| name);
        words.option("--inject", format!("{component}:{name}@{}", injection.window));
    }
    if let Some(content) = &arguments.content {
        words.option("--content", content);
    }
    words.add("--quiet");
    words.add("--in-job");
    words.0
}

/// Words of `tremie resume` in a job.
pub fn resume_words(arguments: &ResumeArgs) -> Vec<OsString> {
    let mut words = CommandWords::default();
    words.add("resume");
    words.add(absolute(&arguments.out));
    if let Some(window) = arguments.at {
        words.option("--at", window.to_string());
    }
    if let Some(until) = &arguments.until {
        words.option("--until", until);
    }
    words.sets(&arguments.set);
    words.view(&arguments.view);
    words.flag("--in-process", arguments.in_process);
    words.restarts(arguments.restart_on_fault);
    words.add("--quiet");
    words.0
}

fn absolute(path: &Path) -> OsString {
    std::path::absolute(path).unwrap_or_else(|_| path.into()).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::cli::{Asked, Command, read};

    fn command(line: &[&str]) -> Command {
        words_read(std::iter::once("tremie").chain(line.iter().copied()).map(OsString::from))
    }

    fn words_read(words: impl IntoIterator<Item = OsString>) -> Command {
        match read(words) {
            Ok(Asked::Own(command)) => *command,
            Ok(_) => panic!("no command of the program itself"),
            Err(error) => panic!("{error}"),
        }
    }

    fn again(words: Vec<OsString>) -> Command {
        words_read(std::iter::once("tremie".into()).chain(words))
    }

    #[test]
    fn all_arguments_of_a_run_are_in_its_words() {
        let whole = [
            "run",
            "/m.toml",
            "--until",
            "2 s",
            "--schedule",
            "serial",
            "--set",
            "a.b=\"1 m\"",
            "--set",
            "c=d=e",
            "--out",
            "/out",
            "--view",
            "/a.rrd",
            "--in-process",
            "--trace=3-9",
            "--restart-on-fault",
            "2",
            "--from",
            "/old@7",
            "--changes",
            "/c.jsonl",
            "--pause-at",
            "0",
            "--inject",
            "grains:drop@17",
            "--content",
            "00ff",
            "--quiet",
            "--in-job",
        ];
        for line in [&whole[..], &["run", "/m.toml", "--out", "/out", "--quiet", "--in-job"]] {
            let first = command(line);
            let Command::Run(arguments) = &first else { panic!() };
            let again = again(run_words(arguments, Path::new("/out")));
            assert_eq!(format!("{again:?}"), format!("{first:?}"));
        }
    }

    #[test]
    fn all_arguments_of_a_resumption_are_in_its_words() {
        let first = command(&[
            "resume",
            "/out",
            "--at",
            "3",
            "--until",
            "2 s",
            "--set",
            "a=1",
            "--view",
            "/a.rrd",
            "--in-process",
            "--restart-on-fault",
            "1",
            "--quiet",
        ]);
        let Command::Resume(arguments) = &first else { panic!() };
        assert_eq!(format!("{:?}", again(resume_words(arguments))), format!("{first:?}"));
    }
}
