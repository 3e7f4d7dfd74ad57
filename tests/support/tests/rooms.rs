//! Rooms of a crate: a folder of sources imports only folders below it, and within a folder few
//! files import each other in circles. ARCHITECTURE.md says what each room is for.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Rooms from the lowest floor up.
const FLUID: [&str; 9] =
    ["lattice", "ranks", "domain", "bodies", "boundary", "gaps", "solver", "report", "fluid"];
const GRAINS: [&str; 10] = [
    "math",
    "bodies",
    "contact",
    "neighbours",
    "forces",
    "walls",
    "polyhedra",
    "solver",
    "setup",
    "grains",
];

const KIT: [&str; 7] = ["cells", "bodies", "window", "probes", "survey", "checks", "observed"];

const GRAINS_KIT: [&str; 8] =
    ["math", "space", "motion", "neighbours", "packing", "checks", "signals", "profiles"];

const HARD: [&str; 6] = ["impact", "cells", "bodies", "solver", "setup", "grains"];

const PARTICLES: [&str; 9] =
    ["grid", "pressure", "particles", "solids", "surface", "solver", "domain", "report", "fluid"];

const WAVELET: [&str; 7] = ["grid", "gas", "bodies", "solver", "domain", "report", "fluid"];

const RUBBER: [&str; 6] = ["mesh", "fem", "table", "runtime", "import", "spec"];

const ORCHESTRATOR: [&str; 10] = [
    "registry",
    "terminal",
    "manifest",
    "plan",
    "outputs",
    "steering",
    "preflight",
    "run",
    "tools",
    "program",
];

/// The crates with rooms: their sources, and the rooms.
const CRATES: [(&str, &[&str]); 9] = [
    ("components/fluid-kit/src", &KIT),
    ("components/grains-kit/src", &GRAINS_KIT),
    ("components/fluid-lbm/src", &FLUID),
    ("components/fluid-pic/src", &PARTICLES),
    ("components/fluid-wavelet/src", &WAVELET),
    ("components/grains-dem/src", &GRAINS),
    ("components/grains-hard-sphere/src", &HARD),
    ("components/rubber-table/src", &RUBBER),
    ("orchestrator/src", &ORCHESTRATOR),
];

/// Crates that only the room `registry` may name: what the program carries in itself.
const CARRIED: [&str; 11] = [
    "tremie_fluid_lbm",
    "tremie_fluid_pic",
    "tremie_fluid_wavelet",
    "tremie_grains_dem",
    "tremie_grains_hard_sphere",
    "tremie_rubber_table",
    "tremie_viewer",
    "tremie_recorder",
    "tremie_fields",
    "tremie_profiles",
    "tremie_pressure_valve",
];

/// Most files of a room that may import each other in a circle.
const LARGEST_CIRCLE: usize = 8;

/// A source file: its path below `src`, its text without tests, and what that imports of its crate,
/// `room::file`.
struct Source {
    path: PathBuf,
    text: String,
    imports: BTreeSet<[String; 2]>,
}

impl Source {
    /// Its room, and its file or folder in there.
    fn place(&self) -> [String; 2] {
        let mut parts = self.path.components().map(|part| {
            let part = part.as_os_str().to_string_lossy();
            part.strip_suffix(".rs").unwrap_or(&part).to_string()
        });
        [parts.next().unwrap_or_default(), parts.next().unwrap_or_default()]
    }
}

/// All Rust files below a folder, in order.
fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut folders = vec![folder.to_path_buf()];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "rs") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// All files in rooms of a crate.
fn sources(of: &str) -> Vec<Source> {
    let src = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(of);
    let in_rooms = rust_files(&src).into_iter().filter(|path| path.parent() != Some(&src));
    let source = |path: PathBuf| {
        let file = path.strip_prefix(&src).unwrap().to_path_buf();
        // Tests may import anything: their text is left out.
        let is_tests = file.with_extension("").iter().any(|part| part == "tests");
        let mut text = fs::read_to_string(&path).unwrap();
        let end = text.find("#[cfg(test)]\nmod tests").unwrap_or(text.len());
        text.truncate(if is_tests { 0 } else { end });
        let imports = imports(&text);
        Source { path: file, text, imports }
    };
    in_rooms.map(source).collect()
}

/// Items that a text names as `crate::room::file`.
fn imports(text: &str) -> BTreeSet<[String; 2]> {
    let code: String = text
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .collect::<Vec<_>>()
        .join("\n");
    assert!(!code.contains("use crate::{"), "imports name a room each: {code:.300}");
    let word = |text: &str| -> String {
        text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
    };
    let mut found = BTreeSet::new();
    for named in code.split("crate::").skip(1) {
        let room = word(named);
        let Some(rest) = named[room.len()..].strip_prefix("::") else { continue };
        match rest.strip_prefix('{') {
            Some(list) => {
                for item in items(list) {
                    found.insert([room.clone(), word(item)]);
                }
            }
            None => {
                found.insert([room, word(rest)]);
            }
        }
    }
    found
}

/// The items of a list up to its closing brace.
fn items(list: &str) -> Vec<&str> {
    let (mut depth, mut begin, mut found) = (0, 0, Vec::new());
    for (at, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                found.push(list[begin..at].trim());
                begin = at + 1;
                if c == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    found.retain(|item| !item.is_empty());
    found
}

/// Everything that files of a room reach by imports within it.
fn reached(of: &BTreeMap<String, BTreeSet<String>>, from: &str) -> BTreeSet<String> {
    let (mut all, mut next) = (BTreeSet::new(), vec![from.to_string()]);
    while let Some(file) = next.pop() {
        for other in of.get(&file).into_iter().flatten() {
            if all.insert(other.clone()) {
                next.push(other.clone());
            }
        }
    }
    all
}

#[test]
fn rooms_import_only_rooms_below() {
    for (component, floors) in CRATES {
        let floor = |room: &str| floors.iter().position(|other| *other == room);
        let mut wrong = Vec::new();
        for source in sources(component) {
            let [room, _] = source.place();
            let own = floor(&room).unwrap_or_else(|| panic!("{component}: {room} is on no floor"));
            for [other, file] in &source.imports {
                if floor(other).is_some_and(|other| other > own) {
                    wrong.push(format!(
                        "{component}: {} imports {other}::{file}",
                        source.path.display()
                    ));
                }
            }
        }
        assert!(wrong.is_empty(), "imports go down, from floor to floor:\n{}", wrong.join("\n"));
    }
}

#[test]
fn circles_of_imports_stay_small() {
    for (component, _) in CRATES {
        let mut rooms: BTreeMap<String, BTreeMap<String, BTreeSet<String>>> = BTreeMap::new();
        for source in sources(component) {
            let [room, file] = source.place();
            let own = rooms.entry(room.clone()).or_default().entry(file.clone()).or_default();
            let inside = source.imports.into_iter().filter(|[other, _]| *other == room);
            own.extend(inside.map(|[_, other]| other).filter(|other| *other != file));
        }
        for (room, files) in rooms {
            for file in files.keys() {
                let ahead = reached(&files, file);
                let is_in_circle = |other: &&String| reached(&files, other).contains(file);
                let circle: Vec<_> = ahead.iter().filter(is_in_circle).collect();
                assert!(
                    circle.len() <= LARGEST_CIRCLE,
                    "{component}, {room}: {} files import each other: {circle:?}",
                    circle.len()
                );
            }
        }
    }
}

/// True if a text defines an item of that name.
fn is_defined(name: &str, text: &str) -> bool {
    let kinds = ["fn", "struct", "enum", "trait", "const", "type", "mod"];
    let ends = |rest: &str| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
    kinds.iter().any(|kind| {
        let item = format!("{kind} {name}");
        text.match_indices(&item).any(|(at, _)| ends(&text[at + item.len()..]))
    })
}

/// The table from papers to files names files that are there, and items that one of them defines.
#[test]
fn architecture_names_files_that_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let page = fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap();
    let rows = page.lines().filter(|line| line.starts_with('|') && line.contains("/src/"));
    let mut seen = 0;
    for row in rows {
        let quoted: Vec<&str> = row.split('`').skip(1).step_by(2).collect();
        let (files, words): (Vec<&str>, Vec<&str>) =
            quoted.into_iter().partition(|word| word.ends_with(".rs"));
        let text: String = files
            .iter()
            .map(|file| {
                let path = root.join("components").join(file);
                fs::read_to_string(&path).unwrap_or_else(|error| panic!("{file}: {error}"))
            })
            .collect();
        seen += files.len();
        for word in words.into_iter().filter(|word| !word.contains('/') && !files.is_empty()) {
            assert!(is_defined(word, &text), "{word} is defined in none of {files:?}");
        }
    }
    assert!(seen > 20, "{seen}");
}

/// A grep for a type finds one: no two structs, enums or traits of these crates have one name.
#[test]
fn a_name_of_a_type_is_unique_in_its_crate() {
    for (component, _) in CRATES {
        let mut homes: BTreeMap<String, PathBuf> = BTreeMap::new();
        for source in sources(component) {
            for line in source.text.lines() {
                let mut words = line.split_whitespace().filter(|word| !word.starts_with("pub"));
                let Some("struct" | "enum" | "trait") = words.next() else { continue };
                let name = words.next().unwrap_or_default();
                let name = name.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
                let other = homes.insert(name.to_string(), source.path.clone());
                assert!(
                    other.is_none(),
                    "{component}: {name} is in {other:?} and {:?}",
                    source.path
                );
            }
        }
        assert!(homes.len() > 5, "{component}: {}", homes.len());
    }
}

#[test]
fn the_registry_alone_names_what_the_program_carries() {
    for source in sources("orchestrator/src") {
        let [room, _] = source.place();
        let named = CARRIED.iter().find(|name| source.text.contains(**name));
        assert!(named.is_none() || room == "registry", "{:?} names {named:?}", source.path);
    }
}

/// Longest function, in lines.
const LONGEST: usize = 70;

/// Functions that may be longer: each is the text of a file with its numbers filled in.
const TEMPLATES: [(&str, &str); 2] = [
    ("examples/pressure-valve/src/scene/working.rs", "manifest"),
    ("examples/pressure-valve/src/scene/grains.rs", "tables"),
];

/// Name of the function that a line begins, and how far the line is indented.
fn function(line: &str) -> Option<(usize, &str)> {
    let code = line.trim_start();
    let rest = ["pub(crate) ", "pub(super) ", "pub ", "const ", "unsafe "]
        .iter()
        .fold(code, |rest, word| rest.strip_prefix(word).unwrap_or(rest));
    let name = rest.strip_prefix("fn ")?;
    let end = name.find(|c: char| !c.is_alphanumeric() && c != '_')?;
    Some((line.len() - code.len(), &name[..end]))
}

/// All sources of the workspace, with the path from its root.
fn all_sources() -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folders = ["interfaces", "components", "orchestrator", "tests", "examples"];
    let files = folders.iter().flat_map(|folder| rust_files(&root.join(folder)));
    files
        .map(|path| {
            let text = fs::read_to_string(&path).unwrap();
            (path.strip_prefix(&root).unwrap().display().to_string(), text)
        })
        .collect()
}

#[test]
fn functions_are_short() {
    let (mut seen, mut long) = (0, Vec::new());
    for (path, text) in all_sources() {
        let lines: Vec<&str> = text.lines().collect();
        for (begin, line) in lines.iter().enumerate() {
            let Some((indent, name)) = function(line) else { continue };
            let closing = format!("{}}}", " ".repeat(indent));
            let length = lines[begin..].iter().position(|line| *line == closing);
            // A function without a body ends with a semicolon, on this line or a later one.
            let semicolon = lines[begin..].iter().position(|line| line.ends_with(';'));
            let opening = lines[begin..].iter().position(|line| line.ends_with('{'));
            if line.ends_with('}') || semicolon < opening {
                continue;
            }
            seen += 1;
            let lines = length.map_or(0, |length| length + 1);
            if lines > LONGEST && !TEMPLATES.contains(&(path.as_str(), name)) {
                long.push(format!("{path}: {name}, {lines} lines"));
            }
        }
    }
    assert!(seen > 3000, "{seen}");
    assert!(long.is_empty(), "{}", long.join("\n"));
}
