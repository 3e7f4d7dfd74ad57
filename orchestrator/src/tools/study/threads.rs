//! Threads of a run, and its share of the machine's cores.

use super::file::SlurmTable;
use crate::manifest::Spec;
use tremie_messages::schedule::Schedule;

/// Threads that the components of a run may use.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RunThreads {
    /// Sum over the components whose threads are known, and that compute at any time.
    pub fixed: u32,
    /// Components whose threads the manifest leaves to the machine.
    pub open: Vec<String>,
    /// Most threads of a component whose threads are known, and that computes while others wait.
    /// `None` if those that step compute at the same time.
    pub turns: Option<u32>,
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
        let turns = (spec.run.schedule == Schedule::Serial).then_some(0);
        let mut all = Self { turns, ..Self::default() };
        for component in &spec.components {
            let (role, threads) = (component.role, component.threads_of(1));
            // Observers work beside those that step.
            let steps = role.has_steps() || role.steps_with().is_some();
            if role.has_steps() && component.threads.is_none() {
                all.open.push(component.name.clone());
            } else if let Some(most) = &mut all.turns
                && steps
            {
                *most = threads.max(*most);
            } else {
                all.fixed += threads;
            }
        }
        all
    }

    /// Open components that compute at the same time.
    fn open_at_once(&self) -> u32 {
        let open = u32::try_from(self.open.len()).unwrap_or(u32::MAX);
        if self.turns.is_some() { open.min(1) } else { open }
    }

    /// Threads of all components while an open one has `each`.
    fn with(&self, each: u32) -> u32 {
        let open = each.saturating_mul(self.open_at_once());
        self.fixed.saturating_add(open.max(self.turns.unwrap_or(0)))
    }

    /// The share of a run on a machine of `cores`. Without a number of `jobs`, open components may use
    /// all cores, as in a run alone. With it, they have what a job's part of the cores leaves: each
    /// all of it if they take turns, else they divide it.
    pub fn share(&self, cores: u32, jobs: Option<usize>) -> ThreadShare {
        let at_once = self.open_at_once();
        let Some(jobs) = jobs.filter(|_| at_once > 0) else {
            return ThreadShare { threads: self.with(cores), sets: Vec::new() };
        };
        let part = cores / u32::try_from(jobs.max(1)).unwrap_or(u32::MAX);
        let each = (part.saturating_sub(self.fixed) / at_once).max(1);
        ThreadShare { threads: self.with(each), sets: self.sets(each) }
    }

    /// Changes that give each open component so many threads.
    fn sets(&self, each: u32) -> Vec<(String, String)> {
        let set = |name: &String| (format!("components.{name}.threads"), each.to_string());
        self.open.iter().map(set).collect()
    }

    /// Changes for a run that goes on with a share of `cores`: its manifest has those of the share
    /// that it began with.
    pub fn resuming_sets(&self, share: &ThreadShare, cores: u32) -> Vec<(String, String)> {
        if share.sets.is_empty() { self.sets(cores) } else { share.sets.clone() }
    }
}

impl SlurmTable {
    /// The share of a run on a cluster. Open components may use all its cores, as they take turns.
    pub fn share(&self, run: &RunThreads) -> ThreadShare {
        let least = run.fixed + u32::try_from(run.open.len()).unwrap_or(u32::MAX);
        let threads = self.cpus.unwrap_or(least).max(1);
        ThreadShare { threads, sets: run.sets(threads) }
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
        let open = vec!["fluid".into(), "grains".into()];
        let run = RunThreads { fixed: 1, open, turns: None };
        assert_eq!(run.share(16, None), ThreadShare { threads: 33, sets: Vec::new() });
        let share = run.share(16, Some(2));
        let set = |name: &str| (format!("components.{name}.threads"), "3".to_string());
        assert_eq!((share.threads, share.sets), (7, vec![set("fluid"), set("grains")]));
        assert_eq!(run.share(2, Some(8)).threads, 3);
        let fixed = RunThreads { fixed: 4, ..RunThreads::default() };
        assert_eq!(fixed.share(16, Some(2)), ThreadShare { threads: 4, sets: Vec::new() });
    }

    #[test]
    fn observers_work_beside_components_that_take_turns() {
        let file = "examples/pressure-valve/manifest.toml";
        let of = |schedule: &str| {
            let sets = [("run.schedule", schedule), ("components.fields", "fields")];
            let sets = sets.map(|(key, value)| (key.to_string(), value.to_string()));
            RunThreads::of(&crate::manifest::load(file.as_ref(), &sets).unwrap().spec)
        };
        let open = vec!["fluid".to_string(), "grains".to_string()];
        let rubber_and_fields = RunThreads { fixed: 2, open: open.clone(), turns: None };
        assert_eq!(of("parallel"), rubber_and_fields);
        assert_eq!(of("serial"), RunThreads { fixed: 1, open, turns: Some(1) });
    }

    #[test]
    fn components_that_take_turns_need_cores_for_one() {
        let open = vec!["fluid".into(), "grains".into()];
        let run = RunThreads { fixed: 1, open, turns: Some(0) };
        assert_eq!(run.share(16, None), ThreadShare { threads: 17, sets: Vec::new() });
        let share = run.share(16, Some(2));
        let set = |name: &str| (format!("components.{name}.threads"), "7".to_string());
        assert_eq!((share.threads, share.sets), (8, vec![set("fluid"), set("grains")]));
        assert_eq!(run.share(2, Some(8)).threads, 2);
        let wide = RunThreads { turns: Some(12), ..run.clone() };
        assert_eq!(wide.share(16, Some(2)).threads, 13);
        let alone = run.share(16, None);
        assert_eq!(run.resuming_sets(&alone, 16)[0].1, "16", "its manifest may say less");
        assert_eq!(run.resuming_sets(&run.share(16, Some(2)), 16)[0].1, "7");
        let known = RunThreads { fixed: 1, open: Vec::new(), turns: Some(4) };
        assert_eq!(known.share(16, Some(2)), ThreadShare { threads: 5, sets: Vec::new() });
    }

    #[test]
    fn open_components_take_turns_on_the_cores_of_a_cluster() {
        let open = vec!["fluid".into(), "grains".into()];
        let run = RunThreads { fixed: 1, open, turns: Some(0) };
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
