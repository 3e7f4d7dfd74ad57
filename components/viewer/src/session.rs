//! The session that shows a run, from the first frame until the user has seen enough.

use crate::page::{Page, listen};
use crate::parameters::{Mode, Parameters};
use rerun::grpc_server::GrpcServerSink;
use rerun::{RecordingStream, RecordingStreamBuilder, ServerOptions, SpawnOptions};
use std::fs::File;
use std::io::{Seek, SeekFrom, Write};
use std::path::PathBuf;
use tremie_sdk::{ObserverError, own_file};

/// Version of the viewer that belongs to this crate's Rerun.
const RERUN: &str = "0.36.3";

/// Frames after which what did not change is sent again: a server that drops its oldest frames must
/// not lose the only copy.
pub const REPEAT: u32 = 64;

/// A run being shown. Data are served while the session lives; dropping it ends the servers and
/// completes the file.
pub struct Session {
    recording: RecordingStream,
    place: Place,
}

enum Place {
    Web {
        url: String,
        _page: Page,
    },
    Native,
    /// The file, and the hold that this run has on it.
    File(PathBuf, File),
}

impl Session {
    /// Opens what the parameters ask for; `output` is the run's output folder.
    pub(crate) fn open(parameters: &Parameters, output: &str) -> Result<Self, ObserverError> {
        let builder = RecordingStreamBuilder::new("tremie").recording_name(name_of(output));
        match parameters.mode {
            Mode::Web => web(builder, parameters),
            Mode::Native => native(builder, parameters),
            Mode::File => file(builder, parameters.recording(output)),
        }
    }

    pub(crate) fn recording(&self) -> &RecordingStream {
        &self.recording
    }

    /// Address of the page, in web mode.
    pub fn url(&self) -> Option<&str> {
        match &self.place {
            Place::Web { url, .. } => Some(url),
            _ => None,
        }
    }

    /// Sends everything on its way.
    ///
    /// # Errors
    /// If it could not be written or sent.
    pub fn flush(&self) -> Result<(), ObserverError> {
        self.recording.flush_blocking().map_err(|error| match &self.place {
            // Rerun's writer ends at the first error, and keeps the reason to itself.
            Place::File(path, file) => ObserverError::output(path, &refusal(file)),
            _ => ObserverError::Other(format!("the viewer's data could not be written: {error}")),
        })
    }

    /// Looks whether a file still takes what is sent; elsewhere that is not known.
    ///
    /// # Errors
    /// If it does not.
    pub(crate) fn check(&self) -> Result<(), ObserverError> {
        if matches!(self.place, Place::File(..)) { self.flush() } else { Ok(()) }
    }

    /// Completes a file: all that was sent, and its index.
    ///
    /// # Errors
    /// If it could not be written.
    pub(crate) fn complete(&self) -> Result<(), ObserverError> {
        self.flush()?;
        let Place::File(path, file) = &self.place else { return Ok(()) };
        let failed = |error| ObserverError::output(path, &error);
        let before = file.metadata().map_err(failed)?;
        self.recording.disconnect();
        // In order with what was sent: afterwards the old writer has ended.
        let _ = self.recording.flush_blocking();
        let after = file.metadata().map_err(failed)?;
        // The index comes last, and is never of no length.
        if before.is_file() && after.len() <= before.len() {
            return Err(failed(refusal(file)));
        }
        Ok(())
    }

    /// One line for the user: where to look.
    pub fn note(&self) -> String {
        match &self.place {
            Place::Web { url, .. } => format!("served at {url} while this program runs"),
            Place::Native => "shown in the Rerun viewer".into(),
            Place::File(path, _) => format!("{} (open it with `rerun` {RERUN})", path.display()),
        }
    }
}

/// Why a file takes no more, in the system's words: tried with a few bytes at its end.
fn refusal(mut file: &File) -> std::io::Error {
    let tried = file
        .seek(SeekFrom::End(0))
        .and_then(|end| file.write_all(&[0; 4096]).and_then(|()| file.set_len(end)));
    tried.err().unwrap_or_else(|| std::io::Error::other("the file's writer has ended"))
}

/// The folder's own name tells runs apart in the viewer's list.
fn name_of(output: &str) -> String {
    PathBuf::from(output)
        .file_name()
        .map_or_else(|| "run".into(), |name| name.to_string_lossy().into_owned())
}

fn failed(what: &str, error: impl std::fmt::Display) -> ObserverError {
    ObserverError::Other(format!("the viewer cannot {what}: {error}"))
}

fn web(builder: RecordingStreamBuilder, parameters: &Parameters) -> Result<Session, ObserverError> {
    let unbound = |error| failed("listen on loopback", error);
    let page = listen(parameters.web_port).map_err(unbound)?;
    // The data server binds its port itself: this only finds one that is free.
    let data = listen(parameters.grpc_port).and_then(|l| l.local_addr()).map_err(unbound)?.port();
    let options = ServerOptions {
        memory_limit: parameters.memory().map_err(ObserverError::Other)?,
        ..ServerOptions::default()
    };
    let sink =
        GrpcServerSink::new("127.0.0.1", data, options).map_err(|e| failed("serve data", e))?;
    let recording = builder.set_sinks((sink,)).map_err(|e| failed("serve data", e))?;
    let page = Page::serve(page, data).map_err(|e| failed("serve its page", e))?;
    let url = format!(
        "http://127.0.0.1:{}/?url=rerun%2Bhttp%3A%2F%2F127.0.0.1%3A{data}%2Fproxy&hide_welcome_screen=1",
        page.port()
    );
    if parameters.open {
        open_browser(&url);
    }
    tracing::info!("the run is shown at {url}");
    Ok(Session { recording, place: Place::Web { url, _page: page } })
}

/// Asks the desktop to open the page; a desktop that cannot is no reason to stop.
fn open_browser(url: &str) {
    let opener = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };
    let quiet = std::process::Stdio::null;
    let started = std::process::Command::new(opener)
        .arg(url)
        .stdin(quiet())
        .stdout(quiet())
        .stderr(quiet())
        .spawn();
    if let Err(error) = started {
        tracing::warn!("`{opener}` did not open the browser ({error}); open {url} by hand");
    }
}

fn native(
    builder: RecordingStreamBuilder,
    parameters: &Parameters,
) -> Result<Session, ObserverError> {
    if !is_on_path("rerun") {
        return Err(ObserverError::Other(format!(
            "mode \"native\" needs the program `rerun` {RERUN} on PATH: install it with \
             `pip install rerun-sdk=={RERUN}` or `cargo install rerun-cli@{RERUN} --locked`, \
             or set mode = \"web\", which needs nothing"
        )));
    }
    let data = listen(parameters.grpc_port)
        .and_then(|l| l.local_addr())
        .map_err(|error| failed("listen on loopback", error))?;
    let options = SpawnOptions {
        port: data.port(),
        wait_for_bind: true,
        server_memory_limit: parameters.memory_limit.split_whitespace().collect(),
        hide_welcome_screen: true,
        extra_args: vec!["--bind=127.0.0.1".into()],
        ..SpawnOptions::default()
    };
    let recording = builder.spawn_opts(&options).map_err(|e| failed("start `rerun`", e))?;
    Ok(Session { recording, place: Place::Native })
}

fn is_on_path(program: &str) -> bool {
    std::env::var_os("PATH").is_some_and(|path| {
        std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
    })
}

fn file(builder: RecordingStreamBuilder, path: PathBuf) -> Result<Session, ObserverError> {
    let file = own_file(&path)?;
    let recording = builder.save(&path).map_err(|error| ObserverError::output(&path, &error))?;
    Ok(Session { recording, place: Place::File(path, file) })
}
