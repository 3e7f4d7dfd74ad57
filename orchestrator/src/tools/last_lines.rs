//! The last lines that a program wrote: as a rule they say why it ended.

use std::io::{self, Read};

/// Most lines that a user is shown.
const LINES: usize = 30;

/// The last lines of a text.
///
/// # Errors
/// If it cannot be read.
pub fn last_lines(from: &mut impl Read) -> io::Result<Vec<String>> {
    let mut bytes = Vec::new();
    from.read_to_end(&mut bytes)?;
    let text = String::from_utf8_lossy(&bytes);
    let lines: Vec<&str> = text.trim_end().lines().collect();
    let first = lines.len().saturating_sub(LINES);
    Ok(lines[first..].iter().map(|line| line.to_string()).collect())
}
