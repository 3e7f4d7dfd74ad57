//! `tremie validate`.

use crate::program::cli::ValidateArgs;
use crate::terminal::standard::{answer, complain};
use crate::tools::validation::case::{Case, CheckKind};
use crate::tools::validation::record::{Record, Verdicts};
use crate::tools::validation::{ValidationError, cases, picture, report, try_case};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};

/// `tremie validate`: makes the runs of the cases and holds them against their references.
pub fn validate(arguments: &ValidateArgs) -> ExitCode {
    match validate_cases(arguments) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => {
            complain("some results are not near enough to their references");
            ExitCode::FAILURE
        }
        Err(error) => {
            complain(format_args!("error: {error}"));
            ExitCode::FAILURE
        }
    }
}

fn validate_cases(arguments: &ValidateArgs) -> Result<bool, ValidationError> {
    let ValidateArgs { names, cases: folder, short, report: path, jobs } = arguments;
    let scratch = tempfile::tempdir()
        .map_err(|error| ValidationError::Io { path: std::env::temp_dir(), error })?;
    let cases = cases(folder, names)?;
    let all = side_by_side(jobs.get().min(cases.len()), &cases, |case| {
        let record = try_case(case, *short, scratch.path(), &mut |text| answer(text))?;
        if !short {
            record.keep(case)?;
            picture::draw_all(case, &record)?;
        }
        Ok(record.verdicts(case))
    })?;
    if !short {
        let path = path.clone().unwrap_or_else(|| folder.join("VALIDATION.md"));
        write_report(folder, &path)?;
        answer(format_args!("the report is in {}", path.display()));
    }
    let how = match (all.failed, all.standing) {
        (0, 0) => "all passed".to_string(),
        (0, standing) => format!("all passed but {standing} whose failure stands"),
        _ => "not all passed".to_string(),
    };
    let of_kind = CheckKind::ALL.iter().zip(all.of_kind).filter(|(_, of)| of.checks > 0);
    let of_kind =
        of_kind.map(|(kind, of)| format!("{} of {} {}s", of.passed, of.checks, kind.name()));
    let of_kind = of_kind.collect::<Vec<_>>().join(", ");
    answer(format_args!("{} checks, {how}: {of_kind}", all.checks()));
    Ok(all.failed == 0)
}

/// Tries the cases, `jobs` at a time, each on its share of the cores. After an error none begins.
fn side_by_side(
    jobs: usize,
    cases: &[Case],
    attempt: impl Fn(&Case) -> Result<Verdicts, ValidationError> + Sync,
) -> Result<Verdicts, ValidationError> {
    let next = AtomicUsize::new(0);
    let work = |job: usize| {
        share_cores(job, jobs);
        let mut all = Verdicts::default();
        while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
            let verdicts = attempt(case);
            if verdicts.is_err() {
                next.store(cases.len(), Ordering::Relaxed);
            }
            all.join(&verdicts?);
        }
        Ok(all)
    };
    std::thread::scope(|scope| {
        let work = &work;
        let others: Vec<_> = (1..jobs).map(|job| scope.spawn(move || work(job))).collect();
        let mut all = work(0);
        for other in others {
            // A panic goes on here, as if there were no threads.
            let found = other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            all = all.and_then(|mut all: Verdicts| {
                all.join(&found?);
                Ok(all)
            });
        }
        all
    })
}

/// Keeps the calling thread, and the programs that it starts, to every `jobs`-th core: a run takes
/// as many threads as it sees cores. Where the system refuses, runs compete for all of them.
fn share_cores(job: usize, jobs: usize) {
    let Ok(all) = sched_getaffinity(None) else { return };
    let cores: Vec<usize> = (0..CpuSet::MAX_CPU).filter(|&core| all.is_set(core)).collect();
    if jobs == 1 || cores.is_empty() {
        return;
    }
    let mut own = CpuSet::new();
    own.set(cores[job % cores.len()]);
    cores.iter().skip(job).step_by(jobs).for_each(|&core| own.set(core));
    let _ = sched_setaffinity(None, &own);
}

/// Writes the report on all cases, from their kept results.
fn write_report(folder: &Path, path: &Path) -> Result<(), ValidationError> {
    let kept = |case: Case| Record::kept(&case.folder).map(|record| (case, record));
    let all: Vec<_> = cases(folder, &[])?.into_iter().map(kept).collect::<Result<_, _>>()?;
    // The report's links begin where it lies.
    let seen = match path.parent() == Some(folder) {
        true => Path::new(""),
        false => folder,
    };
    let text = report::text(&all, seen);
    std::fs::write(path, text)
        .map_err(|error| ValidationError::Io { path: path.to_path_buf(), error })
}
