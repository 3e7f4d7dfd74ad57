//! Size of the job of a run: its tasks, and the cores of each.

use crate::manifest::Spec;
use crate::run::handshake::launch_words;

/// Tasks of a job, and cores of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JobSize {
    /// Tasks: ranks of the programs that are launched, or one.
    pub tasks: u32,
    /// Cores of a task.
    pub cores: u32,
}

impl JobSize {
    /// The size that a run needs. A component with a launcher has a task for each of its ranks. All the others
    /// are on the first node, within the cores of the tasks there: so each task has its part of their threads.
    /// That is enough where all tasks are on one node; of several, the first has less.
    pub fn of(spec: &Spec) -> Self {
        let (mut tasks, mut threads) = (0u32, 0u32);
        for component in &spec.components {
            let words = launch_words(component).unwrap_or_default();
            let ranks = ranks_in(&words).unwrap_or(0);
            tasks = tasks.saturating_add(ranks);
            // Ranks share the component's threads, and have one each at least.
            threads = threads.saturating_add(component.threads_of(1).max(ranks));
        }
        let tasks = tasks.max(1);
        Self { tasks, cores: threads.div_ceil(tasks).max(1) }
    }
}

/// Number of ranks that the words of a launcher ask for, as `mpiexec` and `srun` take it.
fn ranks_in(words: &[String]) -> Option<u32> {
    const NAMES: [&str; 5] = ["-n", "-np", "--n", "--np", "--ntasks"];
    let mut words = words.iter().map(String::as_str);
    while let Some(word) = words.next() {
        let number = match word.split_once('=') {
            Some((name, number)) if NAMES.contains(&name) => Some(number),
            _ if NAMES.contains(&word) => words.next(),
            _ => word.strip_prefix("-n").filter(|rest| !rest.is_empty()),
        };
        if let Some(ranks) = number.and_then(|number| number.parse().ok()) {
            return Some(ranks);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::manifest;

    fn spec(sets: &[(String, String)]) -> Spec {
        manifest::load("examples/settling-sphere/short.toml".as_ref(), sets).unwrap().spec
    }

    #[test]
    fn a_launcher_tells_its_ranks() {
        for (words, ranks) in [
            (&["mpiexec", "-n", "4"][..], Some(4)),
            (&["srun", "--mpi=pmix", "--ntasks=8"], Some(8)),
            (&["srun", "-n16", "--cpu-bind=none"], Some(16)),
            (&["mpirun", "--hostfile", "hosts", "-np", "3"], Some(3)),
            (&["nice", "-n", "many"], None),
            (&["env", "A=1"], None),
        ] {
            let words: Vec<String> = words.iter().map(|word| word.to_string()).collect();
            assert_eq!(ranks_in(&words), ranks, "{words:?}");
        }
    }

    #[test]
    fn a_run_has_a_core_for_each_thread_and_a_task_for_each_rank() {
        let plain = JobSize::of(&spec(&[]));
        assert_eq!(plain, JobSize { tasks: 1, cores: 2 });
        let launched = |ranks: u32| {
            let words = format!("['srun', '-n', '{ranks}']");
            JobSize::of(&spec(&[("settings.fluid-lbm.launch".into(), words)]))
        };
        // One rank has the place of the fluid alone.
        assert_eq!(launched(1), plain);
        assert_eq!(launched(64), JobSize { tasks: 64, cores: 2 });
    }
}
