//! Pictures of a case's results, as SVG.

use super::ValidationError;
use super::case::{Case, Draw, Picture};
use super::judge::Reference;
use super::record::Record;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;
use std::ops::Range;
use std::path::Path;

/// Width and height.
const SIZE: (u32, u32) = (760, 460);

/// Colours that differ also for those who see red and green alike (Okabe and Ito).
const COLOURS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// One curve or set of marks.
struct Curve {
    name: String,
    points: Vec<(f64, f64)>,
    /// Marks instead of a line: a reference.
    marks: bool,
}

/// Draws all pictures of a case into its folder.
///
/// # Errors
/// If a picture cannot be drawn or written.
pub fn draw_all(case: &Case, record: &Record) -> Result<(), ValidationError> {
    for picture in &case.pictures {
        let path = case.folder.join(&picture.file).with_extension("svg");
        let curves = curves(picture, record);
        draw(picture, &curves, &path)
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
    vec![curve(check, found, false), curve("reference", expected, true)]
}

/// The range of all numbers, with a margin.
fn range(values: impl Iterator<Item = f64>, margin: f64) -> Range<f64> {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    match high - low {
        span if span > 0.0 => low - margin * span..high + margin * span,
        _ if low.is_finite() => low - 0.5 * low.abs() - 1e-30..high + 0.5 * high.abs() + 1e-30,
        _ => 0.0..1.0,
    }
}

fn draw(picture: &Picture, curves: &[Curve], path: &Path) -> Result<(), String> {
    let points = || curves.iter().flat_map(|curve| curve.points.iter().copied());
    let x = range(points().map(|p| p.0), 0.02);
    let y = range(points().map(|p| p.1), 0.05);
    let area = SVGBackend::new(path, SIZE).into_drawing_area();
    if picture.log_x {
        let positive = points().map(|p| p.0).fold(f64::INFINITY, f64::min);
        let x = (0.9 * positive..1.1 * x.end).log_scale();
        draw_on(picture, curves, &area, x, y)
    } else {
        draw_on(picture, curves, &area, x, y)
    }
}

fn draw_on<X>(
    picture: &Picture,
    curves: &[Curve],
    area: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    x: X,
    y: Range<f64>,
) -> Result<(), String>
where
    X: AsRangedCoord<Value = f64>,
    X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let wrong = |error: DrawingAreaErrorKind<std::io::Error>| error.to_string();
    area.fill(&WHITE).map_err(wrong)?;
    let mut chart = ChartBuilder::on(area)
        .caption(&picture.title, ("sans-serif", 18))
        .margin(10)
        .x_label_area_size(42)
        .y_label_area_size(70)
        .build_cartesian_2d(x, y)
        .map_err(wrong)?;
    chart
        .configure_mesh()
        .x_desc(&picture.x)
        .y_desc(&picture.y)
        .light_line_style(WHITE)
        .y_label_formatter(&|value| format!("{}", (value * 1e9).round() / 1e9))
        .draw()
        .map_err(wrong)?;
    let lines = curves.iter().filter(|curve| !curve.marks).count().max(1);
    let mut colours = [0; 2];
    for curve in curves {
        let place = &mut colours[usize::from(curve.marks)];
        let colour = COLOURS[*place % lines.min(COLOURS.len())];
        *place += 1;
        let finite: Vec<_> =
            curve.points.iter().copied().filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
        if curve.marks {
            let marks = finite.iter().map(|p| Circle::new(*p, 4, colour.stroke_width(1)));
            let drawn = chart.draw_series(marks).map_err(wrong)?;
            drawn.label(&curve.name).legend(move |p| Circle::new(p, 4, colour.stroke_width(1)));
        } else {
            let drawn = chart
                .draw_series(LineSeries::new(finite, colour.stroke_width(2)))
                .map_err(wrong)?;
            drawn.label(&curve.name).legend(move |(x, y)| {
                PathElement::new([(x - 8, y), (x + 8, y)], colour.stroke_width(2))
            });
        }
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.3))
        .draw()
        .map_err(wrong)?;
    area.present().map_err(wrong)
}
