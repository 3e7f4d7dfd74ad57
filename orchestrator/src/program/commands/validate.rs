//! `tremie validate`.

use crate::program::cli::ValidateArgs;
use crate::terminal::standard::{answer, complain};
use crate::tools::validation::case::{Case, CheckKind};
use crate::tools::validation::record::{Record, Verdicts};
use crate::tools::validation::{ValidationError, cases, picture, report, try_case};
use std::path::Path;
use std::process::ExitCode;

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
    let ValidateArgs { names, cases: folder, short, report: path } = arguments;
    let scratch = tempfile::tempdir()
        .map_err(|error| ValidationError::Io { path: std::env::temp_dir(), error })?;
    let mut all = Verdicts::default();
    for case in cases(folder, names)? {
        let say = &mut |text: &str| answer(text);
        let record = try_case(&case, *short, scratch.path(), say)?;
        all.join(&record.verdicts(&case));
        if !short {
            record.keep(&case)?;
            picture::draw_all(&case, &record)?;
        }
    }
    if !short {
        write_report(folder, path)?;
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

/// Writes the report on all cases, from their kept results.
fn write_report(folder: &Path, path: &Path) -> Result<(), ValidationError> {
    let kept = |case: Case| Record::kept(&case.folder).map(|record| (case, record));
    let all: Vec<_> = cases(folder, &[])?.into_iter().map(kept).collect::<Result<_, _>>()?;
    let text = report::text(&all, &folder.to_string_lossy());
    std::fs::write(path, text)
        .map_err(|error| ValidationError::Io { path: path.to_path_buf(), error })
}
