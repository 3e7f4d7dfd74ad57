//! What files hold, compared.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

/// True if two files hold the same bytes.
///
/// # Errors
/// If one of them cannot be read.
pub fn have_same_content(one: &Path, other: &Path) -> io::Result<bool> {
    let (one, other) = (File::open(one)?, File::open(other)?);
    if one.metadata()?.len() != other.metadata()?.len() {
        return Ok(false);
    }
    let (mut one, mut other) = (BufReader::new(one).bytes(), BufReader::new(other).bytes());
    loop {
        match (one.next().transpose()?, other.next().transpose()?) {
            (None, None) => return Ok(true),
            (a, b) if a != b => return Ok(false),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_the_same_by_their_bytes() {
        let home = tempfile::tempdir().unwrap();
        let path = |name: &str| home.path().join(name);
        for (name, content) in
            [("a", "solid 1"), ("b", "solid 1"), ("c", "solid 2"), ("d", "solid")]
        {
            std::fs::write(path(name), content).unwrap();
        }
        let same = |one: &str, other: &str| have_same_content(&path(one), &path(other));
        assert!(same("a", "b").unwrap() && same("a", "a").unwrap());
        assert!(!same("a", "c").unwrap() && !same("d", "a").unwrap());
        assert!(same("a", "none").is_err());
    }
}
