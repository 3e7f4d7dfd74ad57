//! Two hosts on one machine, for ranks: name spaces of network, mounts, processes' memory and names. They share the project's
//! folder, as hosts share a file system, and nothing else: each has a /tmp and a /dev/shm of its own.

use crate::tremie::{root, script};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// A host, with NAME and FOLDER as arguments, and the folders below /tmp that it keeps. It is there until its standard
/// input ends. The far one does what it is asked for, as a server of ssh would.
const HOST: &str = r#"
set -e
name=$1 folder=$2
shift 2
hostname "$name"
mount -t tmpfs tmpfs /dev/shm
mount -t tmpfs tmpfs /mnt
for kept in "$@"; do
  mkdir -p "/mnt${kept#/tmp}"
  mount --bind "$kept" "/mnt${kept#/tmp}"
done
mount --rbind /mnt /tmp
umount -l /mnt
mount --bind "$folder/hosts" /etc/hosts
ip link set lo up
true &
if [ "$name" = far ]; then
  while read -r line; do
    { sh -c "$line"; touch "$folder/ended"; } </dev/null &
  done <>"$folder/asked" >/dev/null 2>&1 &
fi
server=$!
echo ready
read -r _ || kill $server
"#;

/// What Open MPI starts in place of ssh. As ssh, it stays until the command beyond has ended, and does not learn of that
/// where the link is cut.
const AGENT: &str = r#"
shift
rm -f "$(dirname "$0")/ended"
echo "$*" >"$(dirname "$0")/asked"
until [ -e "$(dirname "$0")/ended" ] && ! [ -e "$(dirname "$0")/cut" ]; do sleep 0.05; done
"#;

/// A name space of the system in which a host has its network.
fn network_of(id: u32) -> Option<PathBuf> {
    std::fs::read_link(format!("/proc/{id}/ns/net")).ok()
}

/// One of the hosts.
pub struct Host {
    /// What keeps its name spaces.
    holder: Child,
    network: PathBuf,
}

impl Host {
    fn make(name: &str, folder: &Path) -> Self {
        let program = Path::new(env!("CARGO_BIN_EXE_tremie")).parent().unwrap();
        let kept = [root(), program, Path::new(env!("CARGO_TARGET_TMPDIR"))];
        let mut command = Command::new("unshare");
        command.args(["--net", "--mount", "--ipc", "--uts", "sh", "-c", HOST, "sh", name]);
        command.arg(folder).args(kept.iter().filter(|kept| kept.starts_with("/tmp")));
        let mut holder = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
        let mut said = String::new();
        BufReader::new(holder.stdout.take().unwrap()).read_line(&mut said).unwrap();
        assert_eq!(said, "ready\n", "the host {name} cannot be made");
        let network = network_of(holder.id()).unwrap();
        Self { holder, network }
    }

    /// A command on this host.
    pub fn command(&self, program: &str) -> Command {
        let mut command = Command::new("nsenter");
        command.args(["--net", "--mount", "--ipc", "--uts", "--target"]);
        command.arg(self.holder.id().to_string()).arg(program).stdin(Stdio::null());
        command
    }

    /// All processes on this host.
    fn all(&self) -> impl Iterator<Item = u32> {
        let entries = std::fs::read_dir("/proc").unwrap().flatten();
        let ids = entries.filter_map(|entry| entry.file_name().to_str()?.parse().ok());
        ids.filter(|&id| network_of(id).as_ref() == Some(&self.network))
    }

    /// Numbers and names of the processes on this host, but for those that make it a host.
    pub fn processes(&self) -> Vec<(u32, String)> {
        let of_host = |id: &u32| {
            let words = std::fs::read_to_string(format!("/proc/{id}/cmdline")).unwrap_or_default();
            words.contains(HOST)
        };
        let name = |id| std::fs::read_to_string(format!("/proc/{id}/comm")).ok();
        let others = self.all().filter(|id| crate::running::is_alive(*id) && !of_host(id));
        others.filter_map(|id| Some((id, name(id)?.trim().to_string()))).collect()
    }

    /// Processes of the ranks on this host, each with its number among the ranks.
    pub fn ranks(&self) -> Vec<(u32, usize)> {
        let number = |id: u32| {
            let all = std::fs::read(format!("/proc/{id}/environ")).ok()?;
            let all = String::from_utf8_lossy(&all).into_owned();
            all.split('\0').find_map(|it| it.strip_prefix("OMPI_COMM_WORLD_RANK=")?.parse().ok())
        };
        let all = self.processes().into_iter().filter(|(_, name)| name == "fluid-lbm-mpi");
        all.filter_map(|(id, _)| Some((id, number(id)?))).collect()
    }

    /// Names in the shared memory of this host.
    pub fn shared_memory(&self) -> Vec<String> {
        let place = format!("/proc/{}/root/dev/shm", self.holder.id());
        let names = std::fs::read_dir(place).unwrap().flatten();
        names.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
    }

    /// Sets the end of the link between the hosts on this one.
    fn link(&self, words: &[&str]) {
        let id = self.holder.id().to_string();
        let mut command = Command::new("nsenter");
        command.args(["--net", "--target", &id, "ip"]).args(words);
        assert!(command.status().unwrap().success(), "ip {words:?}");
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // A process may start another meanwhile. A host without processes is gone, with its ends of links.
        for _ in 0..10 {
            for id in self.all() {
                let _ = crate::running::kill("-KILL", id).stderr(Stdio::null()).status();
            }
        }
        let _ = self.holder.wait();
    }
}

/// Two hosts with a link between them. They are gone when this is.
pub struct TwoHosts {
    /// The host of the orchestrator.
    pub near: Host,
    /// The other one.
    pub far: Host,
    folder: TempDir,
}

impl TwoHosts {
    /// Makes the hosts.
    pub fn make() -> Self {
        let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
        let names = "127.0.0.1 localhost\n10.77.0.1 near\n10.77.0.2 far\n";
        std::fs::write(folder.path().join("hosts"), names).unwrap();
        script(folder.path(), "agent", AGENT);
        let asked = folder.path().join("asked");
        assert!(Command::new("mkfifo").arg(asked).status().unwrap().success());
        let make = |name| Host::make(name, folder.path());
        let hosts = Self { near: make("near"), far: make("far"), folder };
        let far = hosts.far.holder.id().to_string();
        let pair = ["link", "add", "link0", "type", "veth", "peer", "name", "link0", "netns", &far];
        hosts.near.link(&pair);
        for (host, address) in [(&hosts.near, "10.77.0.1/24"), (&hosts.far, "10.77.0.2/24")] {
            host.link(&["addr", "add", address, "dev", "link0"]);
            host.link(&["link", "set", "link0", "up"]);
        }
        hosts
    }

    /// A folder that both see.
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The program on the near host, whose ranks may be on both.
    pub fn tremie(&self) -> Command {
        let mut command = self.near.command(env!("CARGO_BIN_EXE_tremie"));
        command.env("OMPI_MCA_plm_rsh_agent", self.folder().join("agent"));
        command.env("TMPDIR", "/tmp").current_dir(root());
        command
    }

    /// Cuts the link.
    pub fn cut(&self) {
        std::fs::write(self.folder().join("cut"), "").unwrap();
        self.near.link(&["link", "set", "link0", "down"]);
    }

    /// Waits until only what makes them hosts is on both; returns how long that took.
    #[track_caller]
    pub fn wait_until_empty(&self, limit: Duration, about: &str) -> Duration {
        let begin = Instant::now();
        loop {
            let left = [self.near.processes(), self.far.processes()];
            if left.iter().all(Vec::is_empty) {
                break;
            }
            assert!(begin.elapsed() < limit, "{about}: near and far, {left:?} stay");
            std::thread::sleep(Duration::from_millis(20));
        }
        for (host, name) in [(&self.near, "near"), (&self.far, "far")] {
            assert_eq!(host.shared_memory(), Vec::<String>::new(), "{about}: {name}");
        }
        begin.elapsed()
    }
}
