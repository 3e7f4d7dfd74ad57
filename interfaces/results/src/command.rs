//! Errors that end a command, and pairs `KEY=VALUE` of a command line.

/// Reason why a command failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CommandError {
    /// The input is wrong: a sentence for each thing that is. The program ends with code 2.
    #[error("{}", .0.join("; "))]
    Input(Vec<String>),
    /// The input is wrong, and the text says all, with file and line. The program ends with code 2.
    #[error("{0}")]
    Explained(String),
    /// The system or the input's physics refuses. The program ends with code 1.
    #[error("{0}")]
    Failed(String),
}

impl CommandError {
    /// One thing that is wrong with the input.
    pub fn input(what: impl ToString) -> Self {
        Self::Input(vec![what.to_string()])
    }

    /// A refusal.
    pub fn failed(why: impl ToString) -> Self {
        Self::Failed(why.to_string())
    }
}

/// `KEY=VALUE` of a command line.
///
/// # Errors
/// A sentence, if there is no `=`.
pub fn key_value(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or("expected KEY=VALUE")?;
    Ok((key.trim().to_string(), value.trim().to_string()))
}
