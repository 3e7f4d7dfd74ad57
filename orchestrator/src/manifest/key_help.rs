//! What a key of the manifest means: the words of the reference page, for a terminal.

use super::reference::{Key, Section, sections};
use super::resolve;
use tremie_sdk::parameters::nearest;

/// What is known of a key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyHelp {
    /// Its path: `scene.parts[].motion`.
    pub path: String,
    /// What its value is.
    pub kind: String,
    /// What it means.
    pub meaning: String,
    /// The keys of the tables that it may hold: name, kind, meaning.
    pub keys: Vec<[String; 3]>,
}

/// Keys that a name may mean: the one at a path, or all whose paths end with it. Numbers in brackets may
/// be there or not. Without a name, the manifest as a whole.
///
/// # Errors
/// A sentence: no key has the name.
pub fn key_help(name: &str) -> Result<Vec<KeyHelp>, String> {
    let all = sections(&resolve::schema());
    let steps: Vec<&str> = name.split('.').map(bare).filter(|step| !step.is_empty()).collect();
    if steps.is_empty() {
        let [root, ..] = &all[..] else { return Ok(Vec::new()) };
        let keys = root.keys.iter().map(row).collect();
        let (kind, meaning) = ("tables".into(), plain(&root.about));
        return Ok(vec![KeyHelp { path: "manifest".into(), kind, meaning, keys }]);
    }
    if let Some(found) = at(&all, &steps) {
        return Ok(vec![found]);
    }
    let ending: Vec<KeyHelp> = all
        .iter()
        .flat_map(|section| section.keys.iter().map(move |key| (section, key)))
        .filter(|(section, key)| {
            let path = path_of(section, key);
            let own: Vec<&str> = path.split('.').map(bare).collect();
            own.ends_with(&steps)
        })
        .map(|(section, key)| help(&all, path_of(section, key), key))
        .collect();
    if !ending.is_empty() {
        return Ok(ending);
    }
    let names: Vec<&str> =
        all.iter().flat_map(|section| &section.keys).map(|key| key.name.as_str()).collect();
    let last = steps[steps.len() - 1];
    Err(match nearest(last, &names).filter(|near| *near != last) {
        Some(near) => {
            format!("no key of a manifest is called \"{name}\"; did you mean \"{near}\"?")
        }
        None => {
            format!("no key of a manifest is called \"{name}\"; `tremie explain` lists the first")
        }
    })
}

/// A key as far as a command line may go on with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeyBeginning {
    /// Its path, and what comes after it: `=` before a value, `.` before a key of a table, `[0].` before one of
    /// a list's first table.
    pub text: String,
    /// What its value is.
    pub kind: String,
}

/// Keys that begin with a text: those of the table that it names up to its last dot. Where a table is the
/// only one, its keys.
pub fn keys_beginning(text: &str) -> Vec<KeyBeginning> {
    let all = sections(&resolve::schema());
    let mut text = text.to_string();
    loop {
        let found = beginnings(&all, &text);
        match &found[..] {
            [only] if only.text.ends_with('.') && only.text != text => text.clone_from(&only.text),
            _ => return found,
        }
    }
}

fn beginnings(all: &[Section], text: &str) -> Vec<KeyBeginning> {
    let (parent, begin) = text.rsplit_once('.').map_or(("", text), |(parent, end)| (parent, end));
    let of_table = |path: &str| all.iter().find(|section| section.path == path);
    let mut tables = vec![String::new()];
    for step in parent.split('.').map(bare).filter(|step| !step.is_empty()) {
        let keys = tables.iter().filter_map(|path| of_table(path)).flat_map(|table| &table.keys);
        match keys.filter(|key| key.name == step).map(|key| key.tables.clone()).next() {
            Some(within) => tables = within,
            None => return Vec::new(),
        }
    }
    let dot = if parent.is_empty() { "" } else { "." };
    let keys = tables.iter().filter_map(|path| of_table(path)).flat_map(|table| &table.keys);
    let mut found: Vec<KeyBeginning> = Vec::new();
    for key in keys.filter(|key| key.name.starts_with(begin)) {
        for end in ends(key) {
            let text = format!("{parent}{dot}{}{end}", key.name);
            if !found.iter().any(|other| other.text == text) {
                found.push(KeyBeginning { text, kind: plain(&key.kind) });
            }
        }
    }
    found
}

/// What may come after a key: a value, and a key of a table in it.
fn ends(key: &Key) -> Vec<&'static str> {
    let is_list = key.tables.iter().any(|table| table.ends_with("[]"));
    let within = match (key.tables.is_empty(), is_list) {
        (true, _) => None,
        (false, true) => Some("[0]."),
        (false, false) => Some("."),
    };
    let is_table = ["table", "list of table"].iter().any(|word| key.kind.starts_with(word));
    let is_only_table = within.is_some() && is_table && !key.kind.contains(", or ");
    let value = (!is_only_table).then_some("=");
    value.into_iter().chain(within).collect()
}

/// The key at the end of a way through the tables, which several keys may share.
fn at(all: &[Section], steps: &[&str]) -> Option<KeyHelp> {
    let (mut tables, mut path) = (vec![String::new()], String::new());
    for (k, step) in steps.iter().enumerate() {
        let of = |table: &String| all.iter().find(|section| section.path == *table);
        let sections = tables.iter().filter_map(of);
        let key = sections.flat_map(|section| &section.keys).find(|key| key.name == *step)?;
        path = if path.is_empty() { (*step).to_string() } else { format!("{path}.{step}") };
        if k + 1 == steps.len() {
            return Some(help(all, path, key));
        }
        // Of a list, or of tables by name, the section says so.
        let ends = key.tables.iter().filter_map(|table| table.rsplit('.').next());
        if ends.clone().any(|end| end.ends_with("[]")) {
            path += "[]";
        }
        tables.clone_from(&key.tables);
    }
    None
}

fn help(all: &[Section], path: String, key: &Key) -> KeyHelp {
    let is_own = |section: &&Section| key.tables.contains(&section.path);
    let keys = all.iter().filter(is_own).flat_map(|section| &section.keys).map(row).collect();
    KeyHelp { path, kind: plain(&key.kind), meaning: plain(&key.meaning), keys }
}

fn row(key: &Key) -> [String; 3] {
    [key.name.clone(), plain(&key.kind), plain(&key.meaning)]
}

fn path_of(section: &Section, key: &Key) -> String {
    match section.path.is_empty() {
        true => key.name.clone(),
        false => format!("{}.{}", section.path, key.name),
    }
}

/// A step of a path without a number in brackets.
fn bare(step: &str) -> &str {
    step.split('[').next().unwrap_or(step)
}

/// Words without the marks of Markdown: links are their texts.
fn plain(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text;
    while let Some((before, link)) = rest.split_once("[`") {
        let (name, after) = link.split_once("`](").unwrap_or((link, ")"));
        plain += before;
        plain += name;
        rest = after.split_once(')').map_or("", |(_, after)| after);
    }
    (plain + rest).replace('`', "").replace("\\|", "|")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn one(name: &str) -> KeyHelp {
        let mut all = key_help(name).unwrap();
        assert_eq!(all.len(), 1, "{name}: {all:?}");
        all.remove(0)
    }

    #[test]
    fn a_key_is_found_by_its_path() {
        let viscosity = one("scene.fluid.viscosity");
        assert_eq!(viscosity.path, "scene.fluid.viscosity");
        assert!(viscosity.kind.contains("Pa s"), "{viscosity:?}");
        assert!(viscosity.keys.is_empty() && !viscosity.meaning.is_empty());
        let cell = one("settings.fluid-lbm.cell");
        assert!(cell.kind.contains("length") && !cell.kind.contains('`'), "{cell:?}");
        let fluid = one("scene.fluid");
        assert!(fluid.keys.iter().any(|key| key[0] == "density"), "{fluid:?}");
    }

    /// A reservoir's keys are those of faces and of parts; lists may have numbers.
    #[test]
    fn tables_that_several_keys_share_are_found_below_each() {
        for path in
            ["scene.parts[0].boundary.reservoir.area", "scene.parts.boundary.reservoir.area"]
        {
            let area = one(path);
            assert_eq!(area.path, "scene.parts[].boundary.reservoir.area");
            assert!(area.meaning.contains("Area of the piston"), "{area:?}");
        }
        let lower = one("scene.domain.x.lower.reservoir.area");
        assert_eq!(lower.meaning, one("scene.parts.boundary.reservoir.area").meaning);
    }

    #[test]
    fn a_name_alone_finds_all_keys_that_have_it() {
        let all = key_help("boundary.reservoir").unwrap();
        assert_eq!(all.len(), 1, "{all:?}");
        let all = key_help("restitution").unwrap();
        assert!(all.len() > 1 && all.iter().all(|key| key.path.ends_with(".restitution")));
        let wrong = key_help("scene.fluid.viscosty").unwrap_err();
        assert!(wrong.contains("did you mean \"viscosity\"?"), "{wrong}");
        assert!(one("").keys.iter().any(|key| key[0] == "scene"));
    }

    #[test]
    fn a_key_is_completed_step_by_step() {
        let texts = |text: &str| -> Vec<String> {
            keys_beginning(text).into_iter().map(|key| key.text).collect()
        };
        let first = texts("");
        assert!(
            first.contains(&"run.".to_string()) && first.contains(&"scene.".to_string()),
            "{first:?}"
        );
        assert_eq!(texts("scene.fluid.visc"), ["scene.fluid.viscosity="]);
        assert_eq!(texts("run.unti"), ["run.until="]);
        // A table that is the only one: its keys.
        let fluid = texts("scene.flu");
        assert!(fluid.contains(&"scene.fluid.density=".to_string()), "{fluid:?}");
        assert!(texts("settings.fluid-lbm.ce").contains(&"settings.fluid-lbm.cell=".to_string()));
        let part = texts("scene.parts[2].mot");
        assert!(part.contains(&"scene.parts[2].motion=".to_string()), "{part:?}");
        assert!(texts("scene.par").contains(&"scene.parts[0].name=".to_string()));
        assert_eq!(texts("scene.fluids.density"), Vec::<String>::new());
        assert_eq!(texts("nothing"), Vec::<String>::new());
    }

    #[test]
    fn marks_are_taken_off() {
        assert_eq!(plain("table [`a.b[]`](#ab), or `\"x\"`"), "table a.b[], or \"x\"");
        assert_eq!(plain("one \\| two"), "one | two");
    }
}
