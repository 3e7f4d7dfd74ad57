//! Problems as messages for people and for machines.

use super::source::{KeyPlace, Source};
use std::fmt::Write;
use std::ops::Range;
use tremie_messages::Problem;

impl Source {
    /// The problems, in the order of the file: what is wrong, where, what would be right.
    /// `colour`: with the escape codes of a terminal.
    pub fn render(&self, problems: &[Problem], colour: bool) -> String {
        let ink = Ink { colour };
        let mut out = String::new();
        for problem in self.sorted(problems) {
            self.render_one(&mut out, problem, &ink);
            out.push('\n');
        }
        let count = problems.len();
        let _ = writeln!(out, "{count} problem{}", if count == 1 { "" } else { "s" });
        out
    }

    /// One JSON object a line, in the order of the file: `event` (`problem`), `key`, `message`,
    /// `help`, `file`, `line`, `column`; line and column (from 1) are null where the problem is not
    /// one of a line.
    pub fn json_lines(&self, problems: &[Problem]) -> String {
        let mut out = String::new();
        for problem in self.sorted(problems) {
            let at = self.at(problem).map(|at| line_and_column(&self.text, at.start));
            let line = serde_json::json!({
                "event": "problem",
                "key": problem.key,
                "message": problem.message,
                "help": problem.help,
                "file": self.whereabouts(problem),
                "line": at.map(|(line, _)| line),
                "column": at.map(|(_, column)| column),
            });
            let _ = writeln!(out, "{line}");
        }
        out
    }

    /// In the order of the file; what is not in it comes last.
    fn sorted<'a>(&self, problems: &'a [Problem]) -> Vec<&'a Problem> {
        let mut sorted: Vec<&Problem> = problems.iter().collect();
        sorted.sort_by_key(|problem| self.at(problem).map_or(usize::MAX, |at| at.start));
        sorted
    }

    fn render_one(&self, out: &mut String, problem: &Problem, ink: &Ink) {
        let title = match (problem.key.as_str(), self.at(problem)) {
            ("", _) => problem.message.clone(),
            (key, _) if key.starts_with("line ") => problem.message.clone(),
            (key, _) => format!("{key}: {}", problem.message),
        };
        let _ = writeln!(out, "{}: {}", ink.error("error"), ink.bold(&title));
        let margin = match self.at(problem) {
            Some(at) => self.excerpt(out, &at, ink),
            None => {
                let _ = writeln!(out, " {} {}", ink.line("-->"), self.whereabouts(problem));
                1
            }
        };
        if let Some(help) = &problem.help {
            let _ = writeln!(out, "{:margin$} {} help: {help}", "", ink.line("="));
        }
    }

    /// The file of the problem, or the words of the command line.
    fn whereabouts(&self, problem: &Problem) -> &str {
        match self.place(&problem.key) {
            Some((KeyPlace::CommandLine(words), _)) => words,
            None if problem.key.starts_with("--") => "command line",
            _ => &self.file,
        }
    }

    /// The line of the problem with carets below; returns the margin's width.
    fn excerpt(&self, out: &mut String, at: &Range<usize>, ink: &Ink) -> usize {
        let (number, column) = line_and_column(&self.text, at.start);
        let line = self.text.lines().nth(number - 1).unwrap_or("");
        // Of a value over several lines, the first is shown.
        let marked = self.text.get(at.clone()).and_then(|value| value.lines().next());
        let marked = marked.map_or(1, |value| value.trim_end().chars().count().max(1));
        // Tabs stay tabs, so that the caret stands below its word.
        let indent: String =
            (line.chars().take(column - 1)).map(|c| if c == '\t' { '\t' } else { ' ' }).collect();
        let margin = number.to_string().len();
        let bar = ink.line("|");
        let _ = writeln!(out, "{:margin$}{} {}:{number}:{column}", "", ink.line("-->"), self.file);
        let _ = writeln!(out, "{:margin$} {bar}", "");
        let _ = writeln!(out, "{} {bar} {line}", ink.line(&number.to_string()));
        let _ = writeln!(out, "{:margin$} {bar} {indent}{}", "", ink.error(&"^".repeat(marked)));
        margin
    }

    /// The bytes to point at: an unknown key itself, else the value, else the table around.
    fn at(&self, problem: &Problem) -> Option<Range<usize>> {
        let (place, own) = self.place(&problem.key)?;
        match place {
            KeyPlace::File { key: Some(key), .. }
                if own && problem.message.starts_with("unknown key") =>
            {
                Some(key.clone())
            }
            KeyPlace::File { value, .. } => Some(value.clone()),
            KeyPlace::CommandLine(_) => None,
        }
    }
}

/// Line and column of a byte, both from 1; columns count characters.
pub(super) fn line_and_column(text: &str, byte: usize) -> (usize, usize) {
    let mut byte = byte.min(text.len());
    while !text.is_char_boundary(byte) {
        byte -= 1;
    }
    let before = &text[..byte];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

/// Colours of a terminal, or none.
struct Ink {
    colour: bool,
}

impl Ink {
    fn paint(&self, code: &str, text: &str) -> String {
        if self.colour { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_string() }
    }

    fn error(&self, text: &str) -> String {
        self.paint("1;31", text)
    }

    fn bold(&self, text: &str) -> String {
        self.paint("1", text)
    }

    fn line(&self, text: &str) -> String {
        self.paint("1;34", text)
    }
}
