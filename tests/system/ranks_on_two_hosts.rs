//! A lattice on ranks of two hosts: the bits of one process, and what happens to a rank that dies, a rank that hangs and a
//! link that is cut.
//!
//! It needs Open MPI, iproute2 and root. The hosts are name spaces of this machine.

use crate::ranks::{STREAM, allow_ranks, assert_same_outputs, last_error, on_ranks};
use crate::running::{Running, send, until};
use crate::tremie::run_text;
use crate::two_hosts::TwoHosts;
use std::path::PathBuf;
use std::process::Stdio;
use std::time::{Duration, Instant, SystemTime};

/// Disturbances that are tried, if `TREMIE_DISTURBANCES` gives no other number.
const DISTURBANCES: u64 = 6;

/// Longest time from a disturbance of a run with `DEADLINE` to its end: the deadline, a second in which the ranks say that
/// they are there, one in which the launcher ends them, and as much for a busy machine.
const IN_TIME: Duration = Duration::from_secs(9);

/// What ranks have to answer.
const DEADLINE: &str = "4 s";

/// Longest time until the last process on a host beyond a cut link has ended: its ranks' own deadline, or its daemon's.
const BEYOND: Duration = Duration::from_secs(40);

/// A run of four ranks, two on either host.
struct Spread {
    run: Running,
    out: PathBuf,
}

impl Spread {
    /// Begins it, and waits for its first window.
    fn begin(hosts: &TwoHosts, text: &str, name: &str) -> Self {
        let (manifest, out) =
            (hosts.folder().join(format!("{name}.toml")), hosts.folder().join(name));
        let text =
            on_ranks(text, 4, DEADLINE).replace("\"-n\"", "\"--host\", \"near:2,far:2\", \"-n\"");
        std::fs::write(&manifest, text).unwrap();
        let mut command = hosts.tremie();
        command.arg("run").arg(&manifest).arg("--out").arg(&out);
        command.stdout(Stdio::null()).stderr(Stdio::null());
        let run = Running::start(&mut command);
        let spread = Self { run, out };
        until("the run begins", || spread.log().contains(" begin, with"));
        for (host, ranks) in [(&hosts.near, [0, 1]), (&hosts.far, [2, 3])] {
            let mut found: Vec<_> = host.ranks().into_iter().map(|(_, rank)| rank).collect();
            found.sort_unstable();
            assert_eq!(found, ranks, "the ranks are not on both hosts");
        }
        spread
    }

    fn log(&self) -> String {
        std::fs::read_to_string(self.out.join("log.jsonl")).unwrap_or_default()
    }
}

#[test]
#[ignore = "it needs MPI, and root for network name spaces"]
fn ranks_on_two_hosts_have_the_bits_of_one_process() {
    allow_ranks();
    let hosts = TwoHosts::make();
    for precision in ["f64", "f32"] {
        let cell = "cell = \"0.5 mm\"";
        let text = STREAM.replace(cell, &format!("{cell}\nprecision = \"{precision}\""));
        let alone = run_text(&text, &[]).succeeded();
        assert!(alone.summary()["windows"].as_u64() >= Some(1000), "too short a run to tell");
        let mut spread = Spread::begin(&hosts, &text, precision);
        assert_eq!(spread.run.wait(Duration::from_secs(600)), Some(0), "{}", spread.log());
        assert_same_outputs(&alone.out, &spread.out, &format!("two hosts, {precision}"));
        hosts.wait_until_empty(Duration::from_secs(5), precision);
    }
}

/// What happens to a run.
#[derive(Clone, Copy, Debug)]
enum Disturbance {
    Killed,
    Stopped,
    Cut,
}

const ALL: [Disturbance; 3] = [Disturbance::Killed, Disturbance::Stopped, Disturbance::Cut];

/// Commits a disturbance; returns words with which the run names what it hit.
fn disturb(hosts: &TwoHosts, what: Disturbance, random: u64) -> Vec<String> {
    let signal = match what {
        Disturbance::Killed => "-KILL",
        Disturbance::Stopped => "-STOP",
        Disturbance::Cut => {
            hosts.cut();
            return [2, 3].map(|rank| format!("rank {rank} on far (process ")).into();
        }
    };
    let ranks = hosts.far.ranks();
    let (process, rank) = ranks[(random % ranks.len() as u64) as usize];
    send(process, signal);
    match what {
        // So Open MPI's launcher says it.
        Disturbance::Killed => {
            vec![format!("process rank {rank} with PID {process} on node far exited on signal 9")]
        }
        _ => vec![format!("rank {rank} on far (process {process}) has not answered")],
    }
}

/// Disturbs a run at a random moment; returns how long it took to end, and until nothing was left on either host.
fn try_one(what: Disturbance, random: u64) -> [Duration; 2] {
    let about = format!("{what:?}, {random}");
    let hosts = TwoHosts::make();
    let text = STREAM.replace("until = \"50 ms\"", "until = \"100 s\"");
    let mut spread = Spread::begin(&hosts, &text, "out");
    std::thread::sleep(Duration::from_millis(random / 7 % 3000));
    let words = disturb(&hosts, what, random);
    let begin = Instant::now();
    let code = spread.run.wait(Duration::from_secs(60));
    let took = begin.elapsed();
    let log = spread.log();
    let last = last_error(&log);
    assert_eq!(code, Some(1), "{about}: {last}");
    assert!(words.iter().all(|words| last.contains(words)), "{about}: {words:?} not in {last}");
    assert!(took < IN_TIME, "{about}: it took {took:?}");
    let of_near = match what {
        Disturbance::Cut => hosts.near.processes(),
        _ => Vec::new(),
    };
    assert_eq!(of_near, [], "{about}: they stay near");
    let empty = hosts.wait_until_empty(BEYOND, &about);
    [took, took + empty]
}

/// Beyond the link all wait for a call, which does not come because the grains are stopped. Then only the daemons can find the
/// cut.
#[test]
#[ignore = "it needs MPI, and root for network name spaces"]
fn a_link_that_is_cut_while_ranks_wait_for_a_call_ends_them() {
    allow_ranks();
    let hosts = TwoHosts::make();
    let text = STREAM.replace("until = \"50 ms\"", "until = \"100 s\"\ndeadline = \"60 s\"");
    let mut spread = Spread::begin(&hosts, &text, "out");
    let components = crate::running::children_of(spread.run.id());
    let is_grains = |id: &u32| {
        let words = std::fs::read_to_string(format!("/proc/{id}/cmdline")).unwrap_or_default();
        words.contains("grains-dem")
    };
    send(components.into_iter().find(is_grains).unwrap(), "-STOP");
    // The window under way is over.
    std::thread::sleep(Duration::from_secs(2));
    hosts.cut();
    let begin = Instant::now();
    assert_eq!(spread.run.wait(BEYOND), Some(1));
    let log = spread.log();
    let last = last_error(&log);
    assert!(last.contains("Remote daemon: ") && last.contains("on node far"), "{last}");
    let empty = hosts.wait_until_empty(BEYOND, "cut while ranks wait");
    println!("ended after {:.1?}, nothing left {empty:.1?} later", begin.elapsed() - empty);
}

/// Median and longest of some times.
fn told(mut times: Vec<Duration>) -> String {
    times.sort_unstable();
    let (median, longest) = (times[times.len() / 2], times[times.len() - 1]);
    format!("median {:.1} s, worst {:.1} s", median.as_secs_f64(), longest.as_secs_f64())
}

/// `TREMIE_DISTURBANCES=40 TREMIE_CASE=7`, with `--nocapture`, tries 40 of them and says how long each took.
#[test]
#[ignore = "it needs MPI, and root for network name spaces"]
fn what_happens_on_the_other_host_ends_the_run_in_time_and_is_named() {
    allow_ranks();
    let number = |name: &str| std::env::var(name).ok().map(|text| text.parse::<u64>().unwrap());
    let disturbances = number("TREMIE_DISTURBANCES").unwrap_or(DISTURBANCES);
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap().as_millis() as u64;
    let case = number("TREMIE_CASE").unwrap_or(now);
    println!("TREMIE_CASE={case}");
    let mut all = ALL.map(|what| (what, Vec::new()));
    for k in 0..disturbances {
        // Knuth's multiplier spreads the numbers of the cases.
        let random = (case + k).wrapping_mul(6_364_136_223_846_793_005) >> 33;
        // The last kind first: of a number that three does not divide, cuts get the rest.
        let (what, times) = &mut all[2 - (k % 3) as usize];
        let [took, empty] = try_one(*what, random);
        println!("{what:?}: ended after {took:.1?}, nothing left after {empty:.1?}");
        times.push([took, empty]);
    }
    for (what, times) in all.into_iter().filter(|(_, times)| !times.is_empty()) {
        let of = |k: usize| told(times.iter().map(|times: &[Duration; 2]| times[k]).collect());
        println!("{} {what:?}: ended {}; nothing left {}", times.len(), of(0), of(1));
    }
}
