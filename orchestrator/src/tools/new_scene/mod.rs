//! A new scene: a folder with a commented manifest that runs as it is, from a template or around a part.
//!
//! [`template`] has the scenes that are ready, [`annotate`] what their manifests say of themselves.
//! For a file of triangles, [`file_unit`] finds its unit, [`passage`] the way of a flow through its [`voxels`], and
//! [`part_domain`] cells, domain and velocity. [`part_scene`] puts them together, and [`part_manifest`] writes the
//! text.

pub mod annotate;
pub mod domain_face;
pub mod file_unit;
pub mod part_domain;
pub mod part_manifest;
pub mod part_scene;
pub mod passage;
pub mod quantity_text;
pub mod template;
pub mod voxels;

use annotate::ManifestHead;
use clap::Args;
use clap_complete::ArgValueCompleter;
use clap_complete::engine::{CompletionCandidate, PathCompleter, ValueCompleter};
use domain_face::DomainFace;
use file_unit::FileUnit;
use part_scene::{FlowKind, PartScene};
use std::ffi::OsStr;
use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use template::{TEMPLATES, Template};
use tremie_results::CommandError;
use tremie_sdk::parameters::nearest;

/// Arguments of `tremie new`.
#[derive(Debug, Args)]
pub struct NewArgs {
    /// Folder to make, as my-scene
    pub name: PathBuf,
    /// Scene to begin with: dam-break, packed-bed, valve, or a file of triangles (STL, OBJ) to let water flow through
    /// or around
    #[arg(long, value_name = "TEMPLATE|PART.stl", default_value = "dam-break", add = ArgValueCompleter::new(complete_beginning))]
    pub from: String,
    /// What one unit of the file of triangles is
    #[arg(long)]
    pub unit: Option<FileUnit>,
    /// Whether the flow goes through the part, around it, or fills the inside of its surface [default: through, where a
    /// passage leads from inlet to outlet, else around]
    #[arg(long)]
    pub flow: Option<FlowKind>,
    /// Face at which water enters [default: by the part's longest axis]
    #[arg(long, value_name = "FACE")]
    pub inlet: Option<DomainFace>,
    /// Face at which it leaves [default: opposite the inlet]
    #[arg(long, value_name = "FACE")]
    pub outlet: Option<DomainFace>,
}

/// A folder that was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NewScene {
    /// The folder.
    pub folder: PathBuf,
    /// Its files, each with what it is.
    pub files: Vec<(String, String)>,
    /// What was chosen, in sentences.
    pub notes: Vec<String>,
}

/// Beginning of a scene.
#[derive(Clone, Debug)]
pub enum Beginning {
    /// One that is ready.
    Ready(&'static Template),
    /// A flow through or around the part in a file of triangles.
    Part(PathBuf),
}

impl Beginning {
    /// What `--from` names: a template, or a file.
    ///
    /// # Errors
    /// A sentence: it is neither. The nearest template is offered.
    pub fn of(text: &str) -> Result<Self, String> {
        if let Some(template) = TEMPLATES.iter().find(|template| template.name == text) {
            return Ok(Self::Ready(template));
        }
        if is_part_file(text) || Path::new(text).is_file() {
            return Ok(Self::Part(text.into()));
        }
        let names: Vec<&str> = TEMPLATES.iter().map(|template| template.name).collect();
        let near = nearest(text, &names)
            .map_or(String::new(), |near| format!("; did you mean \"{near}\"?"));
        Err(format!(
            "--from {text}: there is no such template{near}\nexpected {}, or a file that ends in .stl or .obj",
            names.join(", ")
        ))
    }
}

/// Templates and files that begin with what is typed after `--from`.
fn complete_beginning(typed: &OsStr) -> Vec<CompletionCandidate> {
    let begins = |name: &str| typed.to_str().is_some_and(|typed| name.starts_with(typed));
    let templates = TEMPLATES.iter().filter(|template| begins(template.name));
    templates
        .map(|template| CompletionCandidate::new(template.name).help(Some(template.about.into())))
        .chain(PathCompleter::file().complete(typed))
        .collect()
}

/// Makes the folder. `ask` puts a question to the user and gives the answer; `None` where there is nobody to
/// ask.
///
/// # Errors
/// The folder is there already, there is no such template, or the part is no closed surface; then nothing
/// is made.
pub fn make_scene(
    arguments: &NewArgs,
    ask: &mut dyn FnMut(&str) -> Option<String>,
) -> Result<NewScene, CommandError> {
    let beginning = Beginning::of(&arguments.from).map_err(CommandError::input)?;
    let name = free_name(&arguments.name).map_err(CommandError::input)?;
    let head = ManifestHead { name, arguments };
    match beginning {
        Beginning::Ready(template) => {
            refuse_part_options(arguments)?;
            let (files, made) = filled(&arguments.name, |folder| template.write(&head, folder))?;
            Ok(NewScene { folder: made, files, notes: Vec::new() })
        }
        Beginning::Part(file) => {
            let scene = PartScene::of(&file, arguments, ask)?;
            let (files, made) = filled(&arguments.name, |folder| scene.write(&head, folder))?;
            Ok(NewScene { folder: made, files, notes: scene.notes() })
        }
    }
}

/// Options that only a part has.
fn refuse_part_options(arguments: &NewArgs) -> Result<(), CommandError> {
    let given = [
        ("--unit", arguments.unit.is_some()),
        ("--flow", arguments.flow.is_some()),
        ("--inlet", arguments.inlet.is_some()),
        ("--outlet", arguments.outlet.is_some()),
    ];
    match given.iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((option, _)) => Err(CommandError::input(format!(
            "{option} goes with a file of triangles, as --from part.stl; found the template {}",
            arguments.from
        ))),
    }
}

/// True for the name of a file of triangles.
fn is_part_file(name: &str) -> bool {
    let lower = name.to_ascii_lowercase();
    [".stl", ".obj"].iter().any(|ending| lower.ends_with(ending))
}

/// The scene's name: the last part of a path at which nothing is, or an empty folder.
fn free_name(folder: &Path) -> Result<String, String> {
    let shown = folder.display();
    let Some(name) = folder.file_name().and_then(|name| name.to_str()) else {
        return Err(format!("\"{shown}\" names no new folder; expected a name, as my-scene"));
    };
    if is_part_file(name) {
        return Err(format!(
            "\"{shown}\" is a name of a file; expected that of a folder, and then the file: tremie new my-scene --from {shown}"
        ));
    }
    if name.chars().any(char::is_control) {
        return Err(format!(
            "{name:?} has a sign that no line can show; expected a name, as my-scene"
        ));
    }
    let is_empty =
        |folder: &Path| fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_none());
    if folder.symlink_metadata().is_ok() && !is_empty(folder) {
        return Err(format!(
            "{shown} is there already, and nothing is overwritten; expected a new name or an empty folder"
        ));
    }
    Ok(name.to_string())
}

/// Files with what each is.
type Listed = Vec<(String, String)>;

/// Fills a folder beside the one that is asked for, and gives it its name when all is well: what fails leaves
/// nothing behind, and nothing can be overwritten.
fn filled(
    folder: &Path,
    write: impl FnOnce(&Path) -> Result<Listed, CommandError>,
) -> Result<(Listed, PathBuf), CommandError> {
    let failed = |error: std::io::Error| {
        CommandError::failed(format!("cannot make {}: {error}", folder.display()))
    };
    let parent = match folder.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    fs::create_dir_all(parent).map_err(failed)?;
    let own = tempfile::Builder::new()
        .prefix(".tremie-new-")
        .permissions(Permissions::from_mode(0o777))
        .tempdir_in(parent)
        .map_err(failed)?;
    let files = write(own.path())?;
    // Onto a folder with files in it this fails.
    fs::rename(own.path(), folder).map_err(failed)?;
    let _ = own.keep();
    Ok((files, folder.to_path_buf()))
}

/// Writes a file of the new folder.
fn write_file(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), CommandError> {
    let path = folder.join(name);
    fs::write(&path, bytes)
        .map_err(|error| CommandError::failed(format!("cannot write {name}: {error}")))
}

/// A text with values in place of their names, `{{name}}`.
fn fill_in(text: &str, values: &[(&str, String)]) -> String {
    let mut pieces = text.split("{{");
    let mut filled = pieces.next().unwrap_or_default().to_string();
    for piece in pieces {
        let (name, after) = piece.split_once("}}").unwrap_or((piece, ""));
        filled += values.iter().find(|(known, _)| *known == name).map_or("", |(_, value)| value);
        filled += after;
    }
    filled
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn arguments(name: &Path, from: &str) -> NewArgs {
        NewArgs {
            name: name.into(),
            from: from.into(),
            unit: None,
            flow: None,
            inlet: None,
            outlet: None,
        }
    }

    #[test]
    fn a_beginning_is_a_template_or_a_file() {
        assert!(matches!(Beginning::of("valve"), Ok(Beginning::Ready(t)) if t.name == "valve"));
        assert!(matches!(Beginning::of("a/Part.STL"), Ok(Beginning::Part(_))));
        let wrong = Beginning::of("dambreak").unwrap_err();
        assert!(wrong.contains("did you mean \"dam-break\"?"), "{wrong}");
        assert!(wrong.contains("dam-break, packed-bed, valve"), "{wrong}");
    }

    #[test]
    fn a_folder_with_something_in_it_is_left_alone() {
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join("mine");
        assert_eq!(free_name(&folder).unwrap(), "mine");
        fs::create_dir(&folder).unwrap();
        assert_eq!(free_name(&folder).unwrap(), "mine");
        fs::write(folder.join("notes.txt"), "mine").unwrap();
        assert!(free_name(&folder).unwrap_err().contains("nothing is overwritten"));
        assert!(free_name(&folder.join("notes.txt")).unwrap_err().contains("there already"));
        assert!(free_name(Path::new("..")).unwrap_err().contains("names no new folder"));
        let file = free_name(Path::new("a/part.stl")).unwrap_err();
        assert!(file.contains("tremie new my-scene --from a/part.stl"), "{file}");
        assert!(free_name(Path::new("a\nb")).unwrap_err().contains("no line can show"));
    }

    #[test]
    fn values_are_filled_in_once() {
        let values = [("a", "{{b}}".to_string()), ("b", "2".to_string())];
        assert_eq!(fill_in("x {{a}} {{b}}.", &values), "x {{b}} 2.");
    }

    #[test]
    fn what_fails_leaves_nothing_behind() {
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join("deep/mine");
        let failing = filled(&folder, |inside| {
            write_file(inside, "manifest.toml", b"half")?;
            Err(CommandError::failed("no more"))
        });
        assert!(failing.is_err() && !folder.exists());
        let left: Vec<_> = fs::read_dir(home.path().join("deep")).unwrap().collect();
        assert!(left.is_empty(), "{left:?}");
    }

    /// A folder that fills while the scene is made is left alone.
    #[test]
    fn what_comes_in_between_is_not_overwritten() {
        let home = tempfile::tempdir().unwrap();
        let folder = home.path().join("mine");
        let result = filled(&folder, |inside| {
            write_file(inside, "manifest.toml", b"new")?;
            fs::create_dir(&folder).unwrap();
            fs::write(folder.join("manifest.toml"), "old").unwrap();
            Ok(Vec::new())
        });
        assert!(result.is_err());
        assert_eq!(fs::read_to_string(folder.join("manifest.toml")).unwrap(), "old");
    }
}
