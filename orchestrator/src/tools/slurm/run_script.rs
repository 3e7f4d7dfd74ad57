//! The script of a run's job.

use super::job_size::JobSize;
use super::script_options::{option_lines, quoted};
use std::path::Path;

/// The script of a run's job.
pub struct RunScript {
    /// Name of the job.
    pub name: String,
    /// Its tasks and their cores.
    pub size: JobSize,
    /// More options of `sbatch`, which override the others.
    pub options: Vec<String>,
    /// Command line of the run.
    pub line: String,
    /// Components that may use all cores of the job on their machine.
    pub open: Vec<String>,
}

impl RunScript {
    /// The text; what the job says goes into `folder`.
    pub fn text(&self, folder: &Path) -> String {
        let JobSize { tasks, cores } = self.size;
        let mut options = vec![
            format!("--job-name={}", quoted(&self.name)),
            format!("--ntasks={tasks}"),
            format!("--cpus-per-task={cores}"),
            format!("--output={}", quoted(&format!("{}/%j.txt", folder.display()))),
            // It would find its own outputs there. `tremie resume` goes on with it.
            "--no-requeue".into(),
        ];
        // Last: they hold where an option stands twice.
        options.extend(self.options.iter().cloned());
        // Slurm knows them only on the node, and after all options.
        let open = self.open.iter().map(|name| {
            format!(" \\\n  --set components.{name}.threads=\"${{SLURM_CPUS_ON_NODE:-{cores}}}\"")
        });
        format!(
            "#!/bin/sh\n{}\n# `srun` takes the cores of a task from here.\n\
             export SRUN_CPUS_PER_TASK=\"${{SLURM_CPUS_PER_TASK:-{cores}}}\"\n\
             # `exec`: signals reach the run.\nexec {}{}\n",
            option_lines(&options),
            self.line,
            open.collect::<String>(),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_script_asks_for_what_the_run_needs() {
        let script = RunScript {
            name: "tremie-a b".into(),
            size: JobSize { tasks: 4, cores: 2 },
            options: vec!["--ntasks-per-node=2".into(), "--time=1:00:00".into()],
            line: "tremie run m.toml".into(),
            open: vec!["fluid".into()],
        };
        let text = script.text(Path::new("/home/a b/slurm"));
        for line in [
            "#SBATCH --job-name='tremie-a b'",
            "#SBATCH --ntasks=4",
            "#SBATCH --cpus-per-task=2",
            "#SBATCH --output='/home/a b/slurm/%j.txt'",
            "#SBATCH --time=1:00:00",
            "exec tremie run m.toml \\",
            "  --set components.fluid.threads=\"${SLURM_CPUS_ON_NODE:-2}\"",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}\n{text}");
        }
        let at = |word: &str| text.find(word).unwrap();
        assert!(at("--ntasks=4") < at("--ntasks-per-node=2"), "the user's options hold");
    }
}
