//! Pictures of a case's results, as SVG.

use super::ValidationError;
use super::case::{Case, Draw, Picture};
use super::judge::Reference;
use super::record::Record;
use plotters::prelude::{IntoDrawingArea, SVGBackend, WHITE};
use std::path::Path;
use tremie_results::{Chart, Curve};

/// Width and height.
const SIZE: (u32, u32) = (760, 460);

/// Draws all pictures of a case into its folder.
///
/// # Errors
/// If a picture cannot be drawn or written.
pub fn draw_all(case: &Case, record: &Record) -> Result<(), ValidationError> {
    for picture in &case.pictures {
        let path = case.folder.join(&picture.file).with_extension("svg");
        draw(picture, curves(picture, record), &path)
            .map_err(|message| ValidationError::Picture { path: path.clone(), message })?;
    }
    Ok(())
}

fn curves(picture: &Picture, record: &Record) -> Vec<Curve> {
    match &picture.draw {
        Draw::Table(check) => of_table(check, record),
        Draw::Signals(names) => of_signals(names, record),
        Draw::Check(check) => over_runs(check, record),
    }
}

fn of_table(check: &str, record: &Record) -> Vec<Curve> {
    let mut curves = Vec::new();
    for run in &record.runs {
        for finding in run.findings.iter().filter(|finding| finding.check == check) {
            let mut entries = finding.entries.clone();
            entries.sort_by(|a, b| a.x.total_cmp(&b.x));
            curves.push(Curve {
                name: run.name.clone(),
                points: entries.iter().map(|entry| (entry.x, entry.found)).collect(),
                marks: false,
            });
            curves.push(Curve {
                name: format!("{}, reference", run.name),
                points: entries.iter().map(|entry| (entry.x, entry.expected)).collect(),
                marks: true,
            });
        }
    }
    curves
}

fn of_signals(names: &[String], record: &Record) -> Vec<Curve> {
    let mut curves = Vec::new();
    for run in &record.runs {
        for name in names {
            let Ok(column) = run.signals.column(name) else { continue };
            let points = run.signals.times.iter().copied().zip(column.iter().copied()).collect();
            let short = name.split_once('.').map_or(name.as_str(), |(_, signal)| signal);
            let name = match names.len() {
                1 => run.name.clone(),
                _ => format!("{}, {short}", run.name),
            };
            curves.push(Curve { name, points, marks: false });
        }
    }
    curves
}

fn over_runs(check: &str, record: &Record) -> Vec<Curve> {
    let mut found = Vec::new();
    let mut expected = Vec::new();
    for run in &record.runs {
        let Some(x) = run.x else { continue };
        for finding in run.findings.iter().filter(|finding| finding.check == check) {
            found.push((x, finding.found));
            if let Reference::Number(reference, _) = finding.reference {
                expected.push((x, reference));
            }
        }
    }
    let curve = |name: &str, points, marks| Curve { name: name.into(), points, marks };
    let references = (!expected.is_empty()).then(|| curve("reference", expected, true));
    std::iter::once(curve(check, found, false)).chain(references).collect()
}

fn draw(picture: &Picture, curves: Vec<Curve>, path: &Path) -> Result<(), String> {
    let chart = Chart {
        title: picture.title.clone(),
        x: picture.x.clone(),
        y: picture.y.clone(),
        log_x: picture.log_x,
        log_y: false,
        curves,
    };
    draw_chart(&chart, path)
}

/// Draws a chart into an SVG file.
///
/// # Errors
/// A sentence, if it cannot be drawn or written.
pub fn draw_chart(chart: &Chart, path: &Path) -> Result<(), String> {
    let area = SVGBackend::new(path, SIZE).into_drawing_area();
    area.fill(&WHITE).map_err(|error| error.to_string())?;
    chart.draw(&area)?;
    area.present().map_err(|error| error.to_string())
}
