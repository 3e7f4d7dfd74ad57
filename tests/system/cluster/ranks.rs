//! Ranks of MPI in a job of Slurm.

use super::runs::Jobs;
use crate::ranks::{STREAM, allow_ranks, on_ranks, ranks_of};
use crate::running::until;
use crate::study::errors;
use std::time::Duration;

/// Two ranks within a job have the bits of one process. Cancelled, they leave nothing.
#[test]
#[ignore = "it needs MPI, Slurm (apt-get install slurm-wlm) and root"]
fn ranks_in_a_job_have_the_bits_of_one_process() {
    allow_ranks();
    let jobs = Jobs::new(STREAM);
    std::fs::write(jobs.out("ranks.toml"), on_ranks(STREAM, 2, "60 s")).unwrap();
    let alone = ["run", "m.toml", "--out", "here", "--quiet", "--until", "6 ms"];
    assert!(jobs.ran(&alone).status.success());
    let ran = jobs.ran(&["run", "ranks.toml", "--out", "out", "--slurm", "--until", "6 ms"]);
    assert!(ran.status.success(), "{}", errors(&ran));
    jobs.assert_same("here", "out");
    jobs.left_nothing("out");
    let script = jobs.text("out/slurm/1.sh");
    // Two ranks, the grains and the recorder.
    assert!(script.contains("--ntasks=2\n#SBATCH --cpus-per-task=2\n"), "{script}");

    let long = ["run", "ranks.toml", "--out", "long", "--slurm", "--until", "100 s"];
    let mut following = jobs.following(&long);
    jobs.await_windows("long");
    let out = jobs.out("long");
    assert_eq!(ranks_of(&out).len(), 2, "ranks");
    jobs.slurm("scancel", &["2"]);
    // Slurm's signal reaches the launcher of MPI, too, which ends its ranks at once.
    following.wait(Duration::from_secs(60));
    let said = following.errors();
    assert!(said.contains("Slurm: job 2 CANCELLED"), "{said}");
    jobs.left_nothing("long");
    until("the ranks end", || ranks_of(&out).is_empty());
}
