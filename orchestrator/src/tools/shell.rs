//! Command lines as a shell takes them.

use crate::run::launch::own_words;
use std::ffi::{OsStr, OsString};
use std::io;

/// A command line of this program.
///
/// # Errors
/// If the system does not tell where this program lies.
pub fn shell_line(arguments: Vec<OsString>) -> io::Result<String> {
    let words = own_words()?.into_iter().chain(arguments);
    Ok(words.map(|word| shell_word(&word)).collect::<Vec<_>>().join(" "))
}

/// A word as a shell reads it back.
pub fn shell_word(word: &OsStr) -> String {
    let text = word.to_string_lossy();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:,".contains(c);
    match !text.is_empty() && text.chars().all(is_plain) {
        true => text.into_owned(),
        false => format!("'{}'", text.replace('\'', r"'\''")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_a_shell_are_quoted_where_they_must_be() {
        assert_eq!(shell_word(OsStr::new("runs/a-1")), "runs/a-1");
        assert_eq!(shell_word(OsStr::new("a=\"1 m\"")), "'a=\"1 m\"'");
        assert_eq!(shell_word(OsStr::new("it's")), r"'it'\''s'");
        assert_eq!(shell_word(OsStr::new("")), "''");
    }
}
