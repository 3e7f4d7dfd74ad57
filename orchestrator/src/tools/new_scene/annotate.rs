//! What a new manifest says of itself: who made it, what to type next, what to change first, and what its tables
//! are. Units and meanings come from the schema, as those of `tremie explain` do.

use super::NewArgs;
use crate::manifest::{KeyHelp, key_help};
use crate::tools::shell::shell_word;
use clap::ValueEnum;
use std::ffi::OsStr;

/// Longest line of a comment, in letters.
const LINE: usize = 110;

/// The first lines of a manifest.
#[derive(Clone, Debug)]
pub struct ManifestHead<'a> {
    /// Name of the scene.
    pub name: String,
    /// Command line that made it.
    pub arguments: &'a NewArgs,
}

impl ManifestHead<'_> {
    /// The lines, with a sentence on what the scene is.
    pub fn text(&self, title: &str) -> String {
        let folder = shell_word(self.arguments.name.as_os_str()).replace(char::is_control, "?");
        // A path may have signs that end a comment's line.
        let from = shell_word(OsStr::new(&self.arguments.from)).replace(char::is_control, "?");
        let name = &self.name;
        let commands = [
            (
                format!("tremie check {folder}"),
                "is it right? The plan, and a verdict on each number",
            ),
            (format!("tremie run {folder} --view web"), "run it, and watch it in a browser"),
            (
                "tremie explain KEY".into(),
                "what a key of this file means: its value, unit and default",
            ),
        ];
        let options = options(self.arguments);
        let width = commands.iter().map(|(command, _)| command.chars().count()).max().unwrap_or(0);
        let commands = commands.map(|(command, what)| format!("#   {command:<width$}  # {what}"));
        let commands = commands.join("\n");
        format!(
            "# {name}: {title}
#
# `tremie new {folder} --from {from}{options}` made this file. It runs as it is:
#
{commands}
#
# Each quantity is a text with its unit, as \"0.3 mm\". Change one and check again: `tremie check` names the line of
# whatever does not fit, with a remedy. `tremie run {folder} --set KEY=VALUE` tries a value without a change of the file."
        )
    }
}

/// The further options of a command line, as it had them.
fn options(arguments: &NewArgs) -> String {
    fn option<T: ValueEnum>(name: &str, value: Option<T>) -> String {
        let value = value.and_then(|value| value.to_possible_value());
        value.map_or_else(String::new, |value| format!(" --{name} {}", value.get_name()))
    }
    [
        option("unit", arguments.unit),
        option("flow", arguments.flow),
        option("inlet", arguments.inlet),
        option("outlet", arguments.outlet),
    ]
    .concat()
}

/// A manifest under another head: its own, all lines of comments before the first other line, goes.
pub fn with_head(text: &str, head: &str) -> String {
    let begin = text.split_inclusive('\n').take_while(|line| line.starts_with('#')).map(str::len);
    let own = begin.sum::<usize>();
    format!("{head}\n{}", &text[own..])
}

/// Lines on the keys that a user changes first: path, unit, meaning.
pub fn first_changes(keys: &[&str]) -> String {
    let mut lines = vec!["#".to_string(), "# What to change first:".to_string(), "#".to_string()];
    for key in keys {
        for KeyHelp { path, kind, meaning, .. } in key_help(key).unwrap_or_default() {
            lines.push(format!("#   {path}: {kind}"));
            lines.extend(wrapped(&meaning, "#       "));
        }
    }
    lines.join("\n")
}

/// A manifest in which each table that has no comment above it has one: what the schema says of it.
pub fn with_table_comments(text: &str) -> String {
    let mut lines: Vec<String> = Vec::new();
    for line in text.lines() {
        let has_comment = lines.last().is_some_and(|line| line.starts_with('#'));
        if let Some(path) = table_of(line)
            && !has_comment
        {
            lines.extend(table_comment(path));
        }
        lines.push(line.to_string());
    }
    lines.join("\n") + "\n"
}

/// Path of the table that a line begins.
fn table_of(line: &str) -> Option<&str> {
    let inner = line.strip_prefix('[')?;
    let inner = inner.strip_prefix('[').unwrap_or(inner);
    inner.split(']').next()
}

fn table_comment(path: &str) -> Vec<String> {
    // Names of materials and components are no keys: their tables are explained by the table around them.
    let path = path.trim_matches('"');
    let found = key_help(path).ok().and_then(|found| found.into_iter().next());
    let Some(help) = found.filter(|help| !help.path.is_empty()) else { return Vec::new() };
    let hint = format!("`tremie explain {path}` lists its keys.");
    match help.meaning.is_empty() {
        true => vec![format!("# {hint}")],
        false => wrapped(&format!("{} {hint}", help.meaning), "# "),
    }
}

/// Words in lines that are not too long, each with a beginning.
fn wrapped(text: &str, begin: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let mut line = String::new();
    for word in text.split_whitespace() {
        if !line.is_empty() && begin.len() + line.chars().count() + word.chars().count() >= LINE {
            lines.push(format!("{begin}{line}"));
            line.clear();
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line += word;
    }
    if !line.is_empty() {
        lines.push(format!("{begin}{line}"));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::super::tests::arguments;
    use super::*;
    use std::path::Path;

    #[test]
    fn a_head_has_the_commands_to_type() {
        let arguments = arguments(Path::new("my scene"), "dam-break");
        let head =
            ManifestHead { name: "my scene".into(), arguments: &arguments }.text("Water falls.");
        assert!(head.starts_with("# my scene: Water falls.\n"));
        assert!(head.contains("tremie check 'my scene'") && head.contains("tremie explain KEY"));
        assert!(head.lines().all(|line| line.starts_with('#')));
        let text = with_head("# old\n# head\n\n[run]\nuntil = \"1 s\"\n", &head);
        assert!(!text.contains("old") && text.ends_with("\n\n[run]\nuntil = \"1 s\"\n"), "{text}");
    }

    #[test]
    fn tables_have_comments_of_the_schema() {
        let text = with_table_comments(
            "[run]\nuntil = \"1 s\"\n\n# Mine.\n[scene.domain]\n\n[[scene.parts]]\n",
        );
        let expected =
            "# How long and in which order. `tremie explain run` lists its keys.\n[run]\n";
        assert!(text.starts_with(expected), "{text}");
        assert!(text.contains("\n\n# Mine.\n[scene.domain]\n"), "{text}");
        assert!(
            text.contains("`tremie explain scene.parts` lists its keys.\n[[scene.parts]]"),
            "{text}"
        );
    }

    #[test]
    fn changes_come_with_unit_and_meaning() {
        let text = first_changes(&["scene.fluid.viscosity"]);
        assert!(text.contains("scene.fluid.viscosity: a dynamic viscosity, \"1 mPa s\""), "{text}");
        assert!(text.contains("#       Dynamic viscosity."), "{text}");
    }

    #[test]
    fn lines_are_not_too_long() {
        let lines = wrapped(&"word ".repeat(100), "# ");
        assert!(lines.len() > 3 && lines.iter().all(|line| line.len() <= LINE), "{lines:?}");
        assert_eq!(wrapped("", "# "), Vec::<String>::new());
    }
}
