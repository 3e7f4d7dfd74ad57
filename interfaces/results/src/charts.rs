//! Curves and marks in a chart, drawn as SVG.

use crate::colour_map::ColourMap;
use crate::ticks::{decade, tick_numbers};
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;
use std::iter::repeat_n;
use std::ops::Range;
use std::path::Path;

/// Colours that differ also for those who see red and green alike (Okabe and Ito).
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(128, 128, 128),
];

/// One curve or set of marks.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Its points; points that are not finite are not drawn.
    pub points: Vec<(f64, f64)>,
    /// Marks instead of a line: a reference.
    pub marks: bool,
}

impl Curve {
    /// Its points on the chart's axes: on a line some between them, a mark as often as a whole
    /// piece of line, because all of it is lost where a legend covers it.
    fn drawn_points(&self, axes: impl Fn((f64, f64)) -> (f64, f64)) -> Vec<(f64, f64)> {
        const BETWEEN: u32 = 8;
        let finite = self.points.iter().map(|p| axes(*p)).filter(|p| (p.0 + p.1).is_finite());
        let points: Vec<_> = finite.collect();
        if self.marks {
            return points.iter().flat_map(|p| repeat_n(*p, BETWEEN as usize)).collect();
        }
        let within = points.windows(2).flat_map(|ends| {
            let [a, b] = [ends[0], ends[1]];
            (1..BETWEEN).map(move |k| {
                let part = f64::from(k) / f64::from(BETWEEN);
                (a.0 + part * (b.0 - a.0), a.1 + part * (b.1 - a.1))
            })
        });
        within.chain(points.iter().copied()).collect()
    }
}

/// A chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// Above it.
    pub title: String,
    /// Label of the horizontal axis, with its unit.
    pub x: String,
    /// Label of the vertical axis, with its unit.
    pub y: String,
    /// Logarithmic horizontal axis.
    pub log_x: bool,
    /// Logarithmic vertical axis.
    pub log_y: bool,
    /// Curves and marks of the chart.
    pub curves: Vec<Curve>,
}

/// The number at a tick of an axis.
type TickText<'a> = &'a dyn Fn(&f64) -> String;
/// A sheet or part of it to draw on.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

impl Chart {
    /// Draws it.
    ///
    /// # Errors
    /// A sentence, if it cannot be drawn or written.
    pub fn draw(&self, area: &Area<'_>) -> Result<(), String> {
        let points = || self.curves.iter().flat_map(|curve| curve.points.iter().copied());
        let x = range(points().map(|p| p.0), 0.02);
        let y = range(points().map(|p| p.1), 0.05);
        // A logarithmic axis begins a tenth below the least point, not at a margin that may be below 0.
        let log = |values: &mut dyn Iterator<Item = f64>, end: f64| {
            let least = values.filter(|v| *v > 0.0).fold(f64::INFINITY, f64::min);
            (0.9 * least..1.1 * end).log_scale()
        };
        let (log_x, log_y) =
            (log(&mut points().map(|p| p.0), x.end), log(&mut points().map(|p| p.1), y.end));
        let (of_x, of_y) = (tick_numbers(&x), tick_numbers(&y));
        let ticks: [TickText<'_>; 2] =
            [if self.log_x { &decade } else { &of_x }, if self.log_y { &decade } else { &of_y }];
        match [self.log_x, self.log_y] {
            [false, false] => self.draw_within(area, x, y, ticks),
            [true, false] => self.draw_within(area, log_x, y, ticks),
            [false, true] => self.draw_within(area, x, log_y, ticks),
            [true, true] => self.draw_within(area, log_x, log_y, ticks),
        }
    }

    /// Corner of the chart in which a legend covers least of its curves.
    fn emptiest_corner(&self) -> SeriesLabelPosition {
        let axes = |p: (f64, f64)| {
            let [x, y] = [(self.log_x, p.0), (self.log_y, p.1)]
                .map(|(is_log, value)| if is_log { value.ln() } else { value });
            (x, y)
        };
        let drawn: Vec<_> = self.curves.iter().flat_map(|curve| curve.drawn_points(axes)).collect();
        let xs = range(drawn.iter().map(|p| p.0), 0.0);
        let ys = range(drawn.iter().map(|p| p.1), 0.0);
        let part =
            |range: &Range<f64>, value: f64| (value - range.start) / (range.end - range.start);
        let covered = |right: bool, upper: bool| {
            // A legend covers about a third of the width and of the height.
            let beyond = |part: f64, far: bool| if far { part > 0.65 } else { part < 0.35 };
            let is_in =
                |p: &&(f64, f64)| beyond(part(&xs, p.0), right) && beyond(part(&ys, p.1), upper);
            drawn.iter().filter(is_in).count()
        };
        [
            (SeriesLabelPosition::UpperRight, covered(true, true)),
            (SeriesLabelPosition::LowerRight, covered(true, false)),
            (SeriesLabelPosition::UpperLeft, covered(false, true)),
            (SeriesLabelPosition::LowerLeft, covered(false, false)),
        ]
        .into_iter()
        .min_by_key(|(_, points)| *points)
        .map_or(SeriesLabelPosition::UpperRight, |(corner, _)| corner)
    }

    fn draw_within<X, Y>(
        &self,
        area: &Area<'_>,
        x: X,
        y: Y,
        ticks: [TickText<'_>; 2],
    ) -> Result<(), String>
    where
        X: AsRangedCoord<Value = f64>,
        X::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y: AsRangedCoord<Value = f64>,
        Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let wrong = |error: DrawingAreaErrorKind<std::io::Error>| error.to_string();
        area.fill(&WHITE).map_err(wrong)?;
        let mut chart = ChartBuilder::on(area)
            .caption(&self.title, ("sans-serif", 18))
            .margin(10)
            .x_label_area_size(42)
            .y_label_area_size(70)
            .build_cartesian_2d(x, y)
            .map_err(wrong)?;
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .light_line_style(WHITE)
            .x_label_formatter(ticks[0])
            .y_label_formatter(ticks[1])
            .draw()
            .map_err(wrong)?;
        // Marks count their colours apart: the k-th reference has the colour of the k-th line.
        let lines = self.curves.iter().filter(|curve| !curve.marks).count().max(1);
        let mut colours = [0; 2];
        for curve in &self.curves {
            let place = &mut colours[usize::from(curve.marks)];
            let colour = COLOURS[*place % lines.min(COLOURS.len())];
            *place += 1;
            let finite: Vec<_> = curve
                .points
                .iter()
                .copied()
                .filter(|p| p.0.is_finite() && p.1.is_finite())
                .collect();
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
        // One curve needs no legend: the title says what it is.
        if self.curves.len() < 2 {
            return Ok(());
        }
        chart
            .configure_series_labels()
            .position(self.emptiest_corner())
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3))
            .draw()
            .map_err(wrong)?;
        Ok(())
    }
}

/// The range of all numbers, with a margin.
fn range(values: impl Iterator<Item = f64>, margin: f64) -> Range<f64> {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    match high - low {
        span if span > 0.0 => low - margin * span..high + margin * span,
        // One value: half of it to each side, and a little more in case it is 0.
        _ if low.is_finite() => low - 0.5 * low.abs() - 1e-30..high + 0.5 * high.abs() + 1e-30,
        _ => 0.0..1.0,
    }
}

/// Width and height of a panel.
const PANEL: (u32, u32) = (560, 340);
/// Height of the line with the title.
const HEAD: u32 = 36;
/// Panels side by side.
const PANELS_ABREAST: usize = 3;

/// A panel of a sheet.
#[derive(Clone, Debug, PartialEq)]
pub enum SheetPanel {
    /// Curves and marks.
    Chart(Chart),
    /// A coloured map.
    Map(ColourMap),
}

impl SheetPanel {
    /// Draws it.
    fn draw(&self, area: &Area<'_>) -> Result<(), String> {
        match self {
            Self::Chart(chart) => chart.draw(area),
            Self::Map(map) => map.draw(area),
        }
    }
}

/// Draws charts under a title, as SVG.
///
/// # Errors
/// A sentence, if they cannot be drawn or written.
pub fn draw_sheet(charts: &[Chart], title: &str, path: &Path) -> Result<(), String> {
    let panels: Vec<_> = charts.iter().cloned().map(SheetPanel::Chart).collect();
    draw_panels(&panels, title, path)
}

/// Draws panels under a title, as SVG.
///
/// # Errors
/// A sentence, if they cannot be drawn or written.
pub fn draw_panels(panels: &[SheetPanel], title: &str, path: &Path) -> Result<(), String> {
    let said = |error: &dyn std::fmt::Display| error.to_string();
    let columns = panels.len().clamp(1, PANELS_ABREAST);
    let rows = panels.len().div_ceil(columns);
    let size = (PANEL.0 * columns as u32, PANEL.1 * rows as u32 + HEAD);
    let sheet = SVGBackend::new(path, size).into_drawing_area();
    sheet.fill(&WHITE).map_err(|error| said(&error))?;
    let (head, body) = sheet.split_vertically(HEAD);
    head.titled(title, ("sans-serif", 22)).map_err(|error| said(&error))?;
    for (panel, area) in panels.iter().zip(body.split_evenly((rows, columns))) {
        panel.draw(&area)?;
    }
    sheet.present().map_err(|error| said(&error))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line across the upper right corner, with its ends beside it; marks in two other corners.
    #[test]
    fn a_legend_keeps_off_lines_between_their_points() {
        let curve = |points: &[(f64, f64)], marks| Curve {
            name: String::new(),
            points: points.to_vec(),
            marks,
        };
        let across = curve(&[(0.5, 1.0), (1.0, 0.5)], false);
        let corners = curve(&[(1.0, 0.0), (0.0, 1.0)], true);
        let chart = Chart { curves: vec![across, corners], ..Chart::default() };
        assert!(matches!(chart.emptiest_corner(), SeriesLabelPosition::LowerLeft));
    }
}
