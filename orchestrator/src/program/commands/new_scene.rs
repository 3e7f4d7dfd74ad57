//! `tremie new NAME`: a folder with a scene that runs as it is.

use super::packages::end;
use crate::terminal::standard::complain_text;
use crate::tools::new_scene::{NewArgs, NewScene, make_scene};
use crate::tools::shell::shell_word;
use std::io::IsTerminal;
use std::process::ExitCode;

/// `tremie new NAME`: makes the folder, and says what is in it and what to type next.
pub fn new_scene(arguments: &NewArgs) -> ExitCode {
    end(make_scene(arguments, &mut ask).map(|made| answer(&made)))
}

/// Puts a question to whoever sits at the terminal, if somebody does.
fn ask(question: &str) -> Option<String> {
    if !std::io::stdin().is_terminal() {
        return None;
    }
    complain_text(question);
    let mut line = String::new();
    match std::io::stdin().read_line(&mut line) {
        Ok(0) | Err(_) => None,
        Ok(_) => Some(line),
    }
}

/// The folder, its files, and the next commands.
fn answer(made: &NewScene) -> String {
    let folder = shell_word(made.folder.as_os_str());
    let mut text = format!("made {folder}\n");
    let width = made.files.iter().map(|(file, _)| file.chars().count()).max().unwrap_or(0);
    for (file, what) in &made.files {
        text += &format!("  {file:<width$}  {what}\n");
    }
    for note in &made.notes {
        text += &format!("{note}\n");
    }
    text + &format!("next:\n  tremie check {folder}\n  tremie run {folder} --view web\n")
}
