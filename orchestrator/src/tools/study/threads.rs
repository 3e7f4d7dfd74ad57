//! Threads of a run, and its share of the machine's cores.

use super::file::SlurmTable;
use crate::manifest::Spec;

/// Threads that the components of a run may use.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RunThreads {
    /// Sum over the components whose threads are known.
    pub fixed: u32,
    /// Components whose threads the manifest leaves to the machine.
    pub open: Vec<String>,
}

/// Threads of a run in a study, with the changes of its manifest that keep it to them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ThreadShare {
    /// Threads of all its components.
    pub threads: u32,
    /// Changes of the manifest, key and value; results do not depend on them.
    pub sets: Vec<(String, String)>,
}

impl RunThreads {
    /// The threads of a manifest's components.
    pub fn of(spec: &Spec) -> Self {
        let mut all = Self::default();
        for component in &spec.components {
            if component.threads.is_none() && component.role.has_steps() {
                all.open.push(component.name.clone());
            } else {
                all.fixed += component.threads_of(1);
            }
        }
        all
    }

    /// The share of a run on a machine of `cores`. Without a number of `jobs`, open components may use
    /// all cores, as in a run alone. With it, they divide what a job's part of the cores leaves.
    pub fn share(&self, cores: u32, jobs: Option<usize>) -> ThreadShare {
        let open = u32::try_from(self.open.len()).unwrap_or(u32::MAX);
        let Some(jobs) = jobs.filter(|_| open > 0) else {
            let threads = self.fixed.saturating_add(open.saturating_mul(cores));
            return ThreadShare { threads, sets: Vec::new() };
        };
        let part = cores / u32::try_from(jobs.max(1)).unwrap_or(u32::MAX);
        let each = (part.saturating_sub(self.fixed) / open).max(1);
        let set = |name: &String| (format!("components.{name}.threads"), each.to_string());
        let sets = self.open.iter().map(set).collect();
        ThreadShare { threads: self.fixed + each * open, sets }
    }
}

impl SlurmTable {
    /// The share of a run on a cluster. Open components may use all its cores, as they take turns.
    pub fn share(&self, run: &RunThreads) -> ThreadShare {
        let least = run.fixed + u32::try_from(run.open.len()).unwrap_or(u32::MAX);
        let threads = self.cpus.unwrap_or(least).max(1);
        let set = |name: &String| (format!("components.{name}.threads"), threads.to_string());
        ThreadShare { threads, sets: run.open.iter().map(set).collect() }
    }
}

/// True if a run of so many threads may begin beside those that go on: there are fewer than `jobs`, and
/// all threads have a core. A run alone may always begin.
pub fn may_begin(going_on: &[u32], threads: u32, jobs: usize, cores: u32) -> bool {
    let sum = going_on.iter().fold(threads, |sum, threads| sum.saturating_add(*threads));
    going_on.is_empty() || (going_on.len() < jobs && sum <= cores)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn open_components_share_the_cores_of_a_job() {
        let run = RunThreads { fixed: 1, open: vec!["fluid".into(), "grains".into()] };
        assert_eq!(run.share(16, None), ThreadShare { threads: 33, sets: Vec::new() });
        let share = run.share(16, Some(2));
        let set = |name: &str| (format!("components.{name}.threads"), "3".to_string());
        assert_eq!((share.threads, share.sets), (7, vec![set("fluid"), set("grains")]));
        assert_eq!(run.share(2, Some(8)).threads, 3);
        let fixed = RunThreads { fixed: 4, open: Vec::new() };
        assert_eq!(fixed.share(16, Some(2)), ThreadShare { threads: 4, sets: Vec::new() });
    }

    #[test]
    fn open_components_take_turns_on_the_cores_of_a_cluster() {
        let run = RunThreads { fixed: 1, open: vec!["fluid".into(), "grains".into()] };
        assert_eq!(SlurmTable::default().share(&run).threads, 3);
        let four = SlurmTable { cpus: Some(4), ..SlurmTable::default() };
        let set = |name: &str| (format!("components.{name}.threads"), "4".to_string());
        let share = four.share(&run);
        assert_eq!((share.threads, share.sets), (4, vec![set("fluid"), set("grains")]));
    }

    #[test]
    fn a_run_alone_begins_and_others_where_they_fit() {
        assert!(may_begin(&[], 64, 1, 4));
        assert!(may_begin(&[2], 2, 2, 4));
        assert!(!may_begin(&[2], 3, 2, 4));
        assert!(!may_begin(&[1, 1], 1, 2, 4));
    }

    proptest! {
        #[test]
        fn threads_never_outnumber_the_cores_but_for_a_run_alone(
            runs in proptest::collection::vec(1u32..20, 1..30), jobs in 1usize..9, cores in 1u32..33,
        ) {
            let mut going_on: Vec<u32> = Vec::new();
            for threads in runs {
                while !may_begin(&going_on, threads, jobs, cores) {
                    going_on.remove(0);
                }
                going_on.push(threads);
                prop_assert!(going_on.len() <= jobs);
                prop_assert!(going_on.len() == 1 || going_on.iter().sum::<u32>() <= cores);
            }
        }
    }
}
