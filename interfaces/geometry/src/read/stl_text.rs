//! STL files in text.
//!
//! The library reads them in single precision, and knows neither capitals nor names that are no
//! UTF-8. Here numbers are read in double precision, words in any case and on any lines, and an
//! error tells the line.

use super::text::{coordinate, quoted};
use crate::{Mesh, Vec3};
use std::str::{Lines, SplitAsciiWhitespace};

/// The triangles of a text, of all its solids, or why it is none.
pub fn parse(text: &str) -> Result<Mesh, String> {
    let mut words = Words::of(text);
    let mut mesh = Mesh::default();
    // The line of the solid that is open.
    let mut open = None;
    while let Some(word) = words.next() {
        match word.to_ascii_lowercase().as_str() {
            "solid" => {
                open = Some(words.number);
                // Its name.
                words.skip_name();
            }
            "endsolid" if open.is_some() => {
                open = None;
                words.skip_name();
            }
            "facet" if open.is_some() => {
                let corners = facet(&mut words)?;
                let first = u32::try_from(mesh.vertices.len() + 2).map_err(|_| {
                    "it has more triangles than 32-bit numbers can tell apart".to_string()
                })? - 2;
                mesh.vertices.extend(corners);
                mesh.triangles.push([first, first + 1, first + 2]);
            }
            _ if open.is_some() => {
                return Err(words.expected("\"facet\" or \"endsolid\"", Some(word)));
            }
            _ => return Err(words.expected("\"solid\"", Some(word))),
        }
    }
    match open {
        None => Ok(mesh),
        Some(begin) => Err(format!(
            "it ends at line {}, after {} triangles, without the \"endsolid\" of the solid of line {begin}: it was cut off",
            words.number,
            mesh.triangles.len()
        )),
    }
}

/// The corners of a facet whose first word was read. Its normal follows from them, and is passed
/// over, whatever it is.
fn facet(words: &mut Words<'_>) -> Result<[Vec3; 3], String> {
    let mut passed = 0;
    loop {
        match words.next() {
            Some(word) if word.eq_ignore_ascii_case("outer") => break,
            // "normal" and three numbers.
            Some(_) if passed < 4 => passed += 1,
            other => return Err(words.expected("\"outer loop\"", other)),
        }
    }
    words.expect("loop")?;
    let mut corners = [Vec3::zeros(); 3];
    for corner in &mut corners {
        words.expect("vertex")?;
        for x in corner {
            *x = words.number()?;
        }
    }
    words.expect("endloop")?;
    words.expect("endfacet")?;
    Ok(corners)
}

/// The words of a text, and the line of the last one.
struct Words<'a> {
    lines: Lines<'a>,
    line: &'a str,
    rest: SplitAsciiWhitespace<'a>,
    number: usize,
}

impl<'a> Words<'a> {
    fn of(text: &'a str) -> Self {
        Self { lines: text.lines(), line: "", rest: "".split_ascii_whitespace(), number: 0 }
    }

    fn next(&mut self) -> Option<&'a str> {
        loop {
            if let Some(word) = self.rest.next() {
                return Some(word);
            }
            self.line = self.lines.next()?;
            self.number += 1;
            self.rest = self.line.split_ascii_whitespace();
        }
    }

    /// Passes over the name of a solid: the rest of the line, or up to its first facet where a text
    /// has no lines.
    fn skip_name(&mut self) {
        loop {
            let mut ahead = self.rest.clone();
            match (ahead.next(), ahead.next()) {
                (Some(word), Some(next))
                    if word.eq_ignore_ascii_case("facet")
                        && next.eq_ignore_ascii_case("normal") =>
                {
                    return;
                }
                (Some(_), _) => {
                    self.rest.next();
                }
                (None, _) => return,
            }
        }
    }

    fn expect(&mut self, expected: &str) -> Result<(), String> {
        match self.next() {
            Some(word) if word.eq_ignore_ascii_case(expected) => Ok(()),
            other => Err(self.expected(&format!("\"{expected}\""), other)),
        }
    }

    fn number(&mut self) -> Result<f64, String> {
        let word = self.next().ok_or_else(|| self.expected("a number", None))?;
        coordinate(word).map_err(|why| {
            format!("line {}: {}: {why}{}", self.number, quoted(self.line), self.end())
        })
    }

    fn expected(&self, expected: &str, found: Option<&str>) -> String {
        let number = self.number;
        let Some(word) = found else {
            return format!(
                "it ends at line {number}, where {expected} is missing: it was cut off"
            );
        };
        let (line, word, end) = (quoted(self.line), quoted(word), self.end());
        format!("line {number}: {line}: expected {expected}, found {word}{end}")
    }

    /// Words for a place where nothing follows.
    fn end(&self) -> &'static str {
        let is_over = self.rest.clone().next().is_none()
            && self.lines.clone().all(|line| line.trim_ascii().is_empty());
        if is_over { "; the file ends there: it was cut off" } else { "" }
    }
}
