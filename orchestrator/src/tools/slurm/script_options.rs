//! Options of `sbatch` in a script.

use crate::tools::shell::shell_word;
use std::ffi::OsStr;

/// The lines of a script that give `sbatch` its options. Where an option stands twice the last holds.
pub fn option_lines(options: &[String]) -> String {
    options.iter().map(|option| format!("#SBATCH {option}\n")).collect()
}

/// A value as Slurm reads it back. It takes the quotes off; without them a name ends at its first space.
pub fn quoted(value: &str) -> String {
    shell_word(OsStr::new(value))
}

/// Checks an option that a user gives: each stands in a line of the script.
///
/// # Errors
/// What was found, and what was expected.
pub fn check_option(option: &str) -> Result<(), String> {
    match option.starts_with('-') && !option.contains('\n') {
        true => Ok(()),
        false => Err(format!("found {option:?}, expected an option of sbatch")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_option_is_one_line_that_begins_as_one() {
        assert_eq!(check_option("--time=1:00:00"), Ok(()));
        assert!(check_option("time=1").unwrap_err().contains("an option of sbatch"));
        assert!(check_option("--a\nrm -r x").is_err());
    }
}
