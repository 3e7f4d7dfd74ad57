//! Pictures of a table, as SVG: the force over the compression, and the section's shapes.

use crate::mesh::Point;
use crate::table::{Contents, Table};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::path::{Path, PathBuf};

/// A picture that could not be drawn or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {message}", path.display())]
pub struct PictureError {
    /// The file.
    pub path: PathBuf,
    /// The reason.
    pub message: String,
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Wrong = DrawingAreaErrorKind<std::io::Error>;

const BLUE: RGBColor = RGBColor(0, 114, 178);

/// Draws the force over the compression.
///
/// # Errors
/// If the file cannot be written.
pub fn draw_force(table: &Table, path: &Path) -> Result<(), PictureError> {
    let area = SVGBackend::new(path, (760, 460)).into_drawing_area();
    force(table.contents(), &area).map_err(|wrong| failed(path, &wrong))
}

/// Draws the section at four compressions, the last among them, coloured by Mises stress where the
/// table has that.
///
/// # Errors
/// If the file cannot be written.
pub fn draw_shapes(table: &Table, path: &Path) -> Result<(), PictureError> {
    let area = SVGBackend::new(path, (980, 640)).into_drawing_area();
    shapes(table.contents(), &area).map_err(|wrong| failed(path, &wrong))
}

fn failed(path: &Path, wrong: &Wrong) -> PictureError {
    PictureError { path: path.into(), message: wrong.to_string() }
}

fn force(contents: &Contents, area: &Area<'_>) -> Result<(), Wrong> {
    let points: Vec<(f64, f64)> = contents
        .compressions
        .iter()
        .map(|c| 1e3 * c)
        .zip(contents.forces.iter().copied())
        .collect();
    let (right, top) = points[points.len() - 1];
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(area)
        .caption("Force of the seat on the whole ring", ("sans-serif", 18))
        .margin(10)
        .x_label_area_size(42)
        .y_label_area_size(70)
        .build_cartesian_2d(0.0..1.02 * right, 0.0..1.05 * top)?;
    chart
        .configure_mesh()
        .x_desc("compression in mm")
        .y_desc("force in N")
        .light_line_style(WHITE)
        .x_label_formatter(&short)
        .y_label_formatter(&short)
        .draw()?;
    chart.draw_series(LineSeries::new(points.iter().copied(), BLUE.stroke_width(2)))?;
    chart.draw_series(points.iter().map(|point| Circle::new(*point, 2, BLUE.filled())))?;
    area.present()
}

fn short(value: &f64) -> String {
    format!("{}", (value * 1e6).round() / 1e6)
}

fn shapes(contents: &Contents, area: &Area<'_>) -> Result<(), Wrong> {
    area.fill(&WHITE)?;
    let (title, pictures) = area.split_vertically(44);
    let last = contents.compressions.len() - 1;
    let chosen = [0, last / 3, 2 * last / 3, last];
    let most = chosen
        .iter()
        .filter_map(|k| contents.mises.get(*k))
        .flatten()
        .fold(0.0f64, |a, b| a.max(*b));
    legend(&title, contents, most)?;
    let bounds = bounds(contents);
    for (part, frame) in pictures.split_evenly((2, 2)).iter().zip(chosen) {
        section(part, contents, frame, bounds, most)?;
    }
    area.present()
}

/// As seen from the seat: all frames fit.
fn bounds(contents: &Contents) -> [Point; 2] {
    let mut out = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
    for (vertices, compression) in contents.vertices.iter().zip(&contents.compressions) {
        for [r, z] in vertices {
            for (axis, x) in [(0, 1e3 * r), (1, 1e3 * (z - compression))] {
                out[0][axis] = out[0][axis].min(x);
                out[1][axis] = out[1][axis].max(x);
            }
        }
    }
    out
}

fn section(
    part: &Area<'_>,
    contents: &Contents,
    frame: usize,
    bounds: [Point; 2],
    most: f64,
) -> Result<(), Wrong> {
    let (x, y) = to_scale(part, bounds);
    let compression = contents.compressions[frame];
    let title = format!("{:.3} mm, {:.1} N", 1e3 * compression, contents.forces[frame]);
    let mut chart = ChartBuilder::on(part)
        .caption(title, ("sans-serif", 15))
        .margin(8)
        .x_label_area_size(26)
        .y_label_area_size(40)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_labels(6)
        .y_labels(5)
        .x_label_formatter(&short)
        .y_label_formatter(&short)
        .draw()?;
    let place = |vertex: &usize| {
        let [r, z] = contents.vertices[frame][*vertex];
        (1e3 * r, 1e3 * (z - compression))
    };
    let stresses = contents.mises.get(frame);
    for (number, quad) in contents.quads.iter().enumerate() {
        let corners: Vec<(f64, f64)> = quad.iter().map(place).collect();
        let stress = stresses.map_or(0.0, |stresses| stresses[number]);
        chart
            .plotting_area()
            .draw(&Polygon::new(corners.clone(), colour(stress / most.max(1.0)).filled()))?;
        let around = corners.iter().chain(&corners[..1]).copied().collect::<Vec<_>>();
        chart.plotting_area().draw(&PathElement::new(around, WHITE.mix(0.35).stroke_width(1)))?;
    }
    let facets = &contents.facets;
    let kinds =
        [(&facets.exposed, 1), (&facets.seat, 2), (&facets.covered, 3), (&facets.bonded, 4)];
    for (edges, width) in kinds {
        for edge in edges {
            let ends: Vec<(f64, f64)> = edge.iter().map(place).collect();
            chart.plotting_area().draw(&PathElement::new(ends, BLACK.stroke_width(width)))?;
        }
    }
    Ok(())
}

/// Ranges in which a millimetre is as long across as up.
fn to_scale(
    part: &Area<'_>,
    [low, high]: [Point; 2],
) -> (std::ops::Range<f64>, std::ops::Range<f64>) {
    // What margins, labels and title leave, about.
    let (width, height) = part.dim_in_pixel();
    let (width, height) = (f64::from(width) - 56.0, f64::from(height) - 70.0);
    let pixel = 1.1 * f64::max((high[0] - low[0]) / width, (high[1] - low[1]) / height);
    let range = |axis: usize, pixels: f64| {
        let middle = 0.5 * (low[axis] + high[axis]);
        middle - 0.5 * pixels * pixel..middle + 0.5 * pixels * pixel
    };
    (range(0, width), range(1, height))
}

fn legend(title: &Area<'_>, contents: &Contents, most: f64) -> Result<(), Wrong> {
    let style = ("sans-serif", 14).into_font();
    if contents.mises.is_empty() {
        return title.draw(&Text::new("Section in mm", (14, 14), style));
    }
    title.draw(&Text::new("Section in mm; Mises stress in MPa:  0", (14, 14), style.clone()))?;
    for step in 0..120 {
        let left = 280 + 2 * step;
        let bar =
            Rectangle::new([(left, 12), (left + 2, 30)], colour(f64::from(step) / 119.0).filled());
        title.draw(&bar)?;
    }
    title.draw(&Text::new(format!("{:.3}", 1e-6 * most), (530, 14), style))
}

/// From dark blue over green to yellow, even in lightness (viridis, in five steps).
fn colour(share: f64) -> RGBColor {
    const STOPS: [[f64; 3]; 5] = [
        [68.0, 1.0, 84.0],
        [59.0, 82.0, 139.0],
        [33.0, 145.0, 140.0],
        [94.0, 201.0, 98.0],
        [253.0, 231.0, 37.0],
    ];
    let at = 4.0 * share.clamp(0.0, 1.0);
    let below = (at as usize).min(3);
    let weight = at - below as f64;
    let mix =
        |i: usize| (STOPS[below][i] * (1.0 - weight) + STOPS[below + 1][i] * weight).round() as u8;
    RGBColor(mix(0), mix(1), mix(2))
}
