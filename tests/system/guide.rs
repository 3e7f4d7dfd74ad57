//! The user's guide: its commands run, its manifests pass `tremie check`, its links lead somewhere.
//!
//! The language of a block says what becomes of it: `sh` is run, `sh,fails` too, and each of its lines must fail;
//! `sh,no-run` is left out, for a reason that the text gives; `toml` is a whole manifest, and its first line may be a
//! comment with its file's name. `python` is run where there is Python, but for `python,no-run`. The blocks of a page are
//! taken in order, in a folder that holds the examples and tests.

use crate::tremie::{root, tremie};
use std::fs;
use std::io::ErrorKind;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use tempfile::TempDir;

macro_rules! pages {
    ($($page:ident),*) => {
        $(#[test] fn $page() { follow(&stringify!($page).replace('_', "-")); })*
        const FOLLOWED: &[&str] = &[$(stringify!($page)),*];
    };
}

// Those with commands or manifests.
pages!(
    first_run,
    geometry,
    cell_and_step,
    grains,
    valve,
    free_surface,
    shocks,
    swapping,
    components_rust,
    components_python,
    components_c,
    restarting,
    studies,
    results,
    theory,
    same_bits
);

/// Runs that end earlier here than in the guide: how their lines begin, and when they end.
const SHORTER: &[(&str, &str)] = &[
    ("tremie run examples/settling-sphere/short.toml", "20 ms"),
    ("tremie run examples/suspension/short.toml", "10 ms"),
    ("tremie run examples/pressure-valve --out", "0.1 ms"),
    ("tremie run examples/pressure-valve/grains.toml", "10 us"),
    ("tremie run examples/dam-break/short.toml", "20 ms"),
    ("tremie run examples/wave-flume", "20 ms"),
    ("tremie run examples/dice", "1 ms"),
    ("tremie run examples/shock-and-disc/short.toml", "5 ms"),
    ("tremie run examples/two-discs/short.toml", "0.1 s"),
    ("tremie run examples/shock-curtain/short.toml", "1 us"),
    ("tremie run my-choke", "20 ms"),
    ("tremie run choke.toml", "5 ms"),
    ("tremie run bin.toml", "10 ms"),
    ("tremie run tank.toml", "50 ms"),
    ("tremie run tube.toml", "8 us"),
];

/// Languages of blocks that are there to be read.
const READ: &[&str] = &["text", "rust", "c", "cpp", "json", "sh,no-run", "python,no-run"];

/// A block of code of a page.
struct Block {
    language: String,
    code: String,
}

fn pages_folder() -> PathBuf {
    root().join("examples/guide/src")
}

/// The names of all pages, without ending.
fn page_names() -> Vec<String> {
    let files = fs::read_dir(pages_folder()).unwrap();
    let names = files.map(|file| file.unwrap().file_name().into_string().unwrap());
    let mut names: Vec<_> =
        names.filter_map(|name| Some(name.strip_suffix(".md")?.into())).collect();
    names.sort();
    names
}

/// The text of a page, as it was written.
fn page(name: &str) -> String {
    fs::read_to_string(pages_folder().join(name).with_extension("md")).unwrap()
}

/// The text with the files in it that it includes.
fn with_includes(text: &str) -> String {
    let include = |line: &str| {
        let path = line.strip_prefix("{{#include ")?.strip_suffix("}}")?;
        Some(fs::read_to_string(pages_folder().join(path)).expect(path))
    };
    text.lines().map(|line| include(line).unwrap_or_else(|| format!("{line}\n"))).collect()
}

/// The blocks of code of a page, and what stands outside of them.
fn blocks(text: &str) -> (Vec<Block>, String) {
    let (mut blocks, mut rest, mut open) = (Vec::new(), String::new(), None);
    for line in text.lines() {
        match (line.strip_prefix("```"), &mut open) {
            (Some(language), None) => {
                open = Some(Block { language: language.into(), code: String::new() });
            }
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (None, Some(block)) => block.code += &format!("{line}\n"),
            (None, None) => rest += &format!("{line}\n"),
        }
    }
    assert!(open.is_none(), "a block of code has no end");
    (blocks, rest)
}

/// The folder in which the blocks of a page are taken.
struct Desk(TempDir);

impl Desk {
    fn new() -> Self {
        let home = tempfile::tempdir().unwrap();
        for folder in ["examples", "tests"] {
            symlink(root().join(folder), home.path().join(folder)).unwrap();
        }
        Self(home)
    }

    fn command(&self, program: &str) -> Command {
        let programs = Path::new(env!("CARGO_BIN_EXE_tremie")).parent().unwrap();
        let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap());
        let mut command = Command::new(program);
        command.current_dir(self.0.path()).env("PATH", path).stdin(Stdio::null());
        command
    }

    fn shell(&self, script: &str) -> Output {
        self.command("sh").args(["-ec", script]).output().unwrap()
    }

    fn run(&self, commands: &str) {
        succeeded(&self.shell(&script(commands)), commands);
    }

    fn fail(&self, commands: &str) {
        for line in commands.lines() {
            let output = self.shell(&script(line));
            assert!(!output.status.success(), "{line}\n{}", words(&output));
        }
    }

    fn check(&self, manifest: &str) {
        let named = manifest.lines().next().and_then(|line| line.strip_prefix("# "));
        let name = named.filter(|name| name.ends_with(".toml") && !name.contains(' '));
        let name = name.unwrap_or("manifest.toml");
        fs::write(self.0.path().join(name), manifest).unwrap();
        let output = tremie().args(["check", name]).current_dir(self.0.path()).output().unwrap();
        succeeded(&output, manifest);
    }

    /// A script in Python, where there is one.
    fn python(&self, code: &str) {
        match self.command("python3").args(["-c", code]).output() {
            Err(error) if error.kind() == ErrorKind::NotFound => {}
            output => succeeded(&output.unwrap(), code),
        }
    }
}

fn words(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|said| String::from_utf8_lossy(said)).concat()
}

#[track_caller]
fn succeeded(output: &Output, what: &str) {
    assert!(output.status.success(), "{what}\n{}", words(output));
}

/// The commands, with runs that end earlier. A run in the background must be in progress before the next line.
fn script(commands: &str) -> String {
    let line = |line: &str| {
        let shorter = SHORTER.iter().find(|(begin, _)| line.starts_with(begin));
        match (shorter, line.strip_suffix(" &")) {
            (_, Some(run)) => format!("{run} &\n{}", until_in_progress(run)),
            (Some((_, end)), None) if !line.contains("--until") => {
                format!("{line} --until '{end}'\n")
            }
            _ => format!("{line}\n"),
        }
    };
    commands.lines().map(line).collect()
}

/// Waits for a run in the background, for a minute; ends it if a later line fails.
fn until_in_progress(run: &str) -> String {
    let out = run.split("--out ").nth(1).and_then(|rest| rest.split(' ').next()).unwrap();
    format!(
        "trap 'kill $! 2>/dev/null || true' EXIT\n\
         tries=0\n\
         until tremie ps | grep -q '/{out}$'; do\n\
         tries=$((tries + 1)); [ $tries -lt 600 ]; sleep 0.1\n\
         done\n"
    )
}

/// Takes the blocks of a page in order.
fn follow(name: &str) {
    let desk = Desk::new();
    for Block { language, code } in blocks(&with_includes(&page(name))).0 {
        match language.as_str() {
            "sh" => desk.run(&code),
            "sh,fails" => desk.fail(&code),
            "toml" => desk.check(&code),
            "python" => desk.python(&code),
            other if READ.contains(&other) => {}
            other => panic!("{name}.md has a block of \"{other}\", which no test knows"),
        }
    }
}

#[test]
fn every_page_with_commands_is_followed() {
    let mut lines = Vec::new();
    for name in page_names() {
        let blocks = blocks(&page(&name)).0;
        let is_read = |block: &&Block| READ.contains(&block.language.as_str());
        let tried: Vec<_> = blocks.iter().filter(|block| !is_read(block)).collect();
        let is_followed = FOLLOWED.contains(&name.replace('-', "_").as_str());
        assert!(tried.is_empty() || is_followed, "{name}.md is not among the pages of this test");
        lines.extend(tried.iter().flat_map(|block| block.code.lines().map(String::from)));
    }
    for (begin, _) in SHORTER {
        assert!(lines.iter().any(|line| line.starts_with(begin)), "no page has \"{begin}\"");
    }
}

/// Targets of the links and pictures of a text, without its blocks of code.
fn links(text: &str) -> Vec<String> {
    let prose = blocks(text).1;
    let targets = prose.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    targets.filter(|target| !target.contains("://")).map(String::from).collect()
}

/// The anchors that a page's headings have in the book.
fn anchors(name: &str) -> Vec<String> {
    let kept = |c: char| c.is_alphanumeric() || "-_ ".contains(c);
    let of = |title: &str| title.to_lowercase().chars().filter(|c| kept(*c)).collect::<String>();
    let prose = blocks(&with_includes(&page(name))).1;
    let titles = prose.lines().filter(|line| line.starts_with('#'));
    titles.map(|line| of(line.trim_start_matches('#').trim()).replace(' ', "-")).collect()
}

#[test]
fn every_link_and_picture_of_the_guide_leads_somewhere() {
    let mut seen = 0;
    for name in page_names() {
        for link in links(&page(&name)) {
            seen += 1;
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            assert!(pages_folder().join(file).exists(), "{name}.md: {link}");
            let of = if file.is_empty() { &name } else { file.trim_end_matches(".md") };
            assert!(
                anchor.is_empty() || anchors(of).iter().any(|a| a == anchor),
                "{name}.md: {link}"
            );
        }
    }
    assert!(seen > 100, "{seen}");
}

#[test]
fn every_page_has_its_place_in_the_book() {
    let summary = links(&page("SUMMARY"));
    for name in page_names() {
        let is_listed = summary.contains(&format!("{name}.md"));
        assert!(is_listed || name == "SUMMARY", "SUMMARY.md lacks {name}.md");
    }
}

/// Links of pages that the book includes lead to pages of the book, or further by `book.toml`.
#[test]
fn links_of_included_pages_are_in_the_book() {
    let book = fs::read_to_string(root().join("examples/guide/book.toml")).unwrap();
    for name in ["MANIFEST", "MANIFEST-REFERENCE"] {
        for link in links(&with_includes(&page(name))) {
            let Some(page) = link.split('#').next().and_then(|file| file.strip_suffix(".md"))
            else {
                continue;
            };
            let is_page = pages_folder().join(page).with_extension("md").exists();
            let onward = format!("\"/{page}.html\"");
            assert!(is_page || book.contains(&onward), "{name}.md: {link} is not in the book");
        }
    }
}

/// Whoever follows all pages in one folder meets no output of an earlier one.
#[test]
fn no_two_commands_of_the_guide_write_to_the_same_folder() {
    let pages: Vec<_> = page_names().iter().flat_map(|name| blocks(&page(name)).0).collect();
    let commands = pages.iter().filter(|block| block.language.starts_with("sh"));
    let lines = commands.flat_map(|block| block.code.lines());
    let written = |line: &str| {
        let made = ["tremie new ", "tremie scene pressure-valve "];
        let rest = made.iter().find_map(|begin| line.strip_prefix(begin));
        let out = line.starts_with("tremie run ").then(|| line.split("--out ").nth(1)).flatten();
        rest.or(out).and_then(|rest| rest.split(' ').next()).map(String::from)
    };
    let mut folders: Vec<String> = lines.filter_map(written).collect();
    folders.sort();
    let number = folders.len();
    assert!(number > 30, "{folders:?}");
    folders.dedup();
    assert_eq!(folders.len(), number, "{folders:?}");
}
