//! The run's end of steering: a socket, on which commands arrive.

use super::{Answer, LONGEST, OUTPUTS, SOCKET, SteeringCommand};
use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

/// Most users at a time: each has a thread.
const MOST_USERS: usize = 16;
/// Most commands that wait for the loop of windows.
const MOST_WAITING: usize = 64;
/// Interval at which the thread of a user looks whether the run is over.
const LOOK: Duration = Duration::from_millis(100);

/// A command that waits for its answer. Dropped without one, the user hears that the run has ended.
pub struct SteeringRequest {
    /// The command.
    pub command: SteeringCommand,
    /// `None` of a command that was planned before the run.
    answer: Option<SyncSender<Answer>>,
}

impl SteeringRequest {
    /// A command that was planned before the run.
    pub fn planned(command: SteeringCommand) -> Self {
        Self { command, answer: None }
    }

    /// True if it was planned before the run.
    pub fn is_planned(&self) -> bool {
        self.answer.is_none()
    }

    /// Answers the command; a user that is gone misses it.
    pub fn answer(self, answer: Answer) {
        if let Some(user) = self.answer {
            let _ = user.try_send(answer);
        }
    }

    /// Refuses the command.
    pub fn refuse(self, why: impl Into<String>) {
        self.answer(Answer::Refused { why: why.into() });
    }
}

/// The socket of a run; it is closed when this is dropped.
pub struct SteeringSocket {
    path: PathBuf,
    asked: Receiver<SteeringRequest>,
    is_over: Arc<AtomicBool>,
}

impl SteeringSocket {
    /// Opens the socket in the folder of a run with outputs in `out`; none but its user can open the folder.
    ///
    /// # Errors
    /// If the system refuses, or others could open the folder.
    pub fn open(folder: &Path, out: &Path) -> io::Result<Self> {
        let mode = std::fs::metadata(folder)?.permissions().mode();
        if mode & 0o077 != 0 {
            let text = format!("{} is open to other users", folder.display());
            return Err(io::Error::new(io::ErrorKind::PermissionDenied, text));
        }
        let out = std::path::absolute(out)?;
        std::fs::write(folder.join(OUTPUTS), out.as_os_str().as_bytes())?;
        let path = folder.join(SOCKET);
        let listener = UnixListener::bind(&path)?;
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o600))?;
        let (sender, asked) = sync_channel(MOST_WAITING);
        let is_over = Arc::new(AtomicBool::new(false));
        let door = Door { sender, is_over: is_over.clone(), users: Arc::default() };
        std::thread::Builder::new().name("steering".into()).spawn(move || door.watch(&listener))?;
        Ok(Self { path, asked, is_over })
    }

    /// The next command, if one has come.
    pub fn next(&self) -> Option<SteeringRequest> {
        self.asked.try_recv().ok()
    }
}

impl Drop for SteeringSocket {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        // The thread that waits for users looks up when one comes.
        let _ = UnixStream::connect(&self.path);
        let _ = std::fs::remove_file(&self.path);
    }
}

/// What lets users in.
struct Door {
    sender: SyncSender<SteeringRequest>,
    is_over: Arc<AtomicBool>,
    users: Arc<AtomicUsize>,
}

impl Door {
    fn watch(self, listener: &UnixListener) {
        for user in listener.incoming() {
            if self.is_over.load(Ordering::Relaxed) {
                return;
            }
            let Ok(user) = user else {
                // Out of descriptors, say: without a pause this would spin.
                std::thread::sleep(LOOK);
                continue;
            };
            if self.users.load(Ordering::Relaxed) >= MOST_USERS {
                let why = format!("{MOST_USERS} users steer this run already; try again later");
                let _ = say(&user, &Answer::Refused { why });
                continue;
            }
            self.users.fetch_add(1, Ordering::Relaxed);
            let (sender, is_over, users) =
                (self.sender.clone(), self.is_over.clone(), self.users.clone());
            let serve = move || {
                let _ = serve(&user, &sender, &is_over);
                users.fetch_sub(1, Ordering::Relaxed);
            };
            if std::thread::Builder::new().spawn(serve).is_err() {
                self.users.fetch_sub(1, Ordering::Relaxed);
            }
        }
    }
}

/// Takes the commands of one user, one after the other.
fn serve(
    user: &UnixStream,
    sender: &SyncSender<SteeringRequest>,
    is_over: &AtomicBool,
) -> io::Result<()> {
    user.set_read_timeout(Some(LOOK))?;
    user.set_write_timeout(Some(Duration::from_secs(1)))?;
    let mut lines = BufReader::new(user);
    while let Some(line) = next_line(&mut lines, is_over)? {
        let command = match serde_json::from_slice(&line) {
            Ok(command) => command,
            Err(error) => {
                let why = format!("no command of this version of Tremie: {error}");
                say(user, &Answer::Refused { why })?;
                continue;
            }
        };
        let (answer, answered) = sync_channel(1);
        let answer = match sender.try_send(SteeringRequest { command, answer: Some(answer) }) {
            Ok(()) => await_answer(&answered),
            Err(_) => Answer::Refused { why: "the run takes no command now".into() },
        };
        say(user, &answer)?;
    }
    Ok(())
}

fn await_answer(answered: &Receiver<Answer>) -> Answer {
    loop {
        match answered.recv_timeout(LOOK) {
            Ok(answer) => return answer,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                return Answer::Refused { why: "the run has ended".into() };
            }
        }
    }
}

/// The next line of a user; `None` when the user is gone or the run is over.
fn next_line(
    lines: &mut BufReader<&UnixStream>,
    is_over: &AtomicBool,
) -> io::Result<Option<Vec<u8>>> {
    let mut line = Vec::new();
    while !is_over.load(Ordering::Relaxed) {
        let room = LONGEST - line.len() as u64;
        if room == 0 {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "the line is too long"));
        }
        match lines.by_ref().take(room).read_until(b'\n', &mut line) {
            Ok(0) => return Ok(None),
            Ok(_) if line.ends_with(b"\n") => return Ok(Some(line)),
            Ok(_) => {}
            // What has come of the line is kept.
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
            Err(error) => return Err(error),
        }
    }
    Ok(None)
}

fn say(mut user: &UnixStream, answer: &Answer) -> io::Result<()> {
    let mut line = serde_json::to_vec(answer)?;
    line.push(b'\n');
    user.write_all(&line)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn private_folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        std::fs::set_permissions(folder.path(), std::fs::Permissions::from_mode(0o700)).unwrap();
        folder
    }

    fn wait_for(socket: &SteeringSocket) -> SteeringRequest {
        loop {
            if let Some(asked) = socket.next() {
                return asked;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn only_its_user_can_reach_a_run() {
        let folder = private_folder();
        let socket = SteeringSocket::open(folder.path(), Path::new("out")).unwrap();
        let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode(&folder.path().join(SOCKET)), 0o600);
        drop(socket);
        assert!(!folder.path().join(SOCKET).exists(), "it goes with its run");
        std::fs::set_permissions(folder.path(), std::fs::Permissions::from_mode(0o755)).unwrap();
        let refused = SteeringSocket::open(folder.path(), Path::new("out"))
            .err()
            .expect("others can open the folder");
        assert!(refused.to_string().contains("open to other users"), "{refused}");
    }

    #[test]
    fn a_command_that_comes_in_pieces_is_one_command() {
        let folder = private_folder();
        let socket = SteeringSocket::open(folder.path(), Path::new("out")).unwrap();
        let mut user = UnixStream::connect(folder.path().join(SOCKET)).unwrap();
        user.write_all(br#"{"command":"#).unwrap();
        // Longer than the server's look.
        std::thread::sleep(2 * LOOK);
        user.write_all(b"\"step\",\"windows\":3}\n").unwrap();
        let asked = wait_for(&socket);
        assert_eq!(asked.command, SteeringCommand::Step { windows: 3 });
        asked.refuse("no");
        let mut answer = String::new();
        BufReader::new(&user).read_line(&mut answer).unwrap();
        assert_eq!(answer, "{\"answer\":\"refused\",\"why\":\"no\"}\n");
    }

    #[test]
    fn nonsense_is_refused_and_a_run_that_ends_says_so() {
        let folder = private_folder();
        let socket = SteeringSocket::open(folder.path(), Path::new("out")).unwrap();
        let mut user = UnixStream::connect(folder.path().join(SOCKET)).unwrap();
        let mut answers = BufReader::new(user.try_clone().unwrap());
        let mut next = || {
            let mut answer = String::new();
            answers.read_line(&mut answer).unwrap();
            answer
        };
        user.write_all(b"{\"command\":\"fly\"}\n").unwrap();
        assert!(next().contains("unknown variant `fly`"));
        user.write_all(b"{\"command\":\"pause\"}\n").unwrap();
        drop(wait_for(&socket));
        assert!(next().contains("the run has ended"));
    }

    #[test]
    fn an_endless_line_ends_the_conversation() {
        let folder = private_folder();
        let _socket = SteeringSocket::open(folder.path(), Path::new("out")).unwrap();
        let mut user = UnixStream::connect(folder.path().join(SOCKET)).unwrap();
        let _ = user.write_all(&vec![b' '; 2 * LONGEST as usize]);
        let mut rest = Vec::new();
        // Closed with bytes unread: the user sees an end, or a connection that is reset.
        let _ = user.read_to_end(&mut rest);
        assert!(rest.is_empty());
    }
}
