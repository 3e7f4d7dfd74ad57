//! Sheet of a report: panels side by side.

use super::Report;
use super::panels::Panel;
use super::scale::Scale;
use std::path::Path;
use tremie_results::{Chart, Curve, SheetPanel, draw_panels};

/// Points of a curve at most: about one for each pixel, and each with its extremes.
const POINTS: usize = 600;

/// Draws a report.
pub(super) fn draw(report: &Report, title: &str, path: &Path) -> Result<(), String> {
    let chart = if report.has_spectra { spectrum_chart } else { chart };
    let of_signals = report.panels.iter().map(|panel| SheetPanel::Chart(chart(panel)));
    let all: Vec<_> = report.profiles.iter().cloned().chain(of_signals).collect();
    draw_panels(&all, title, path)
}

fn chart(panel: &Panel) -> Chart {
    let points = || panel.curves.iter().flat_map(|curve| &curve.points);
    let largest = |values: &mut dyn Iterator<Item = f64>| {
        values.filter(|value| value.is_finite()).fold(0.0, |a: f64, b| a.max(b.abs()))
    };
    let time = Scale::of(largest(&mut points().map(|p| p.0)), "s");
    let value = Scale::of(largest(&mut points().map(|p| p.1)), &panel.unit);
    let curve = |curve: &super::panels::PanelCurve| Curve {
        name: curve.name.clone(),
        points: thinned(&curve.points).map(|(t, v)| (t / time.by, v / value.by)).collect(),
        marks: false,
    };
    Chart {
        title: panel.title.clone(),
        x: format!("time [{}]", time.unit),
        y: format!("{} [{}]", panel.title, value.unit),
        log_x: false,
        log_y: false,
        curves: panel.curves.iter().map(curve).collect(),
    }
}

fn spectrum_chart(panel: &Panel) -> Chart {
    let curve = |curve: &super::panels::PanelCurve| Curve {
        name: curve.name.clone(),
        points: curve.points.iter().map(|&(f, value)| (1e-3 * f, value)).collect(),
        marks: false,
    };
    let unit = &panel.unit;
    Chart {
        title: panel.title.clone(),
        x: "frequency [kHz]".into(),
        y: format!("{} [{unit}/Hz^½]", panel.title),
        log_x: true,
        log_y: true,
        curves: panel.curves.iter().map(curve).collect(),
    }
}

/// Least and greatest point of each stretch of a long curve, so that no peak is lost; all points of
/// a short one. Points that were not measured are left out.
fn thinned(points: &[(f64, f64)]) -> impl Iterator<Item = (f64, f64)> {
    let stretch = points.len().div_ceil(POINTS).max(1);
    points.chunks(stretch).flat_map(move |part| {
        let by_value = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let measured = || part.iter().filter(|point| !point.1.is_nan());
        let least = measured().min_by(by_value).copied();
        let greatest = measured().max_by(by_value).copied().filter(|_| stretch > 1);
        let mut both: Vec<_> = least.into_iter().chain(greatest).collect();
        // In the order of time again: a line is drawn through them.
        both.sort_by(|a, b| a.0.total_cmp(&b.0));
        both
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_peaks_and_order() {
        let mut points: Vec<_> = (0..100_000).map(|i| (f64::from(i), 0.0)).collect();
        points[77_777].1 = 5.0;
        points[12_345].1 = -5.0;
        let few: Vec<_> = thinned(&points).collect();
        assert!(few.len() <= 2 * POINTS);
        assert!(few.contains(&(77_777.0, 5.0)) && few.contains(&(12_345.0, -5.0)));
        assert!(few.windows(2).all(|pair| pair[0].0 <= pair[1].0));
        let unmeasured: Vec<_> = thinned(&[(0.0, 1.0), (1.0, f64::NAN)]).collect();
        assert_eq!(unmeasured, [(0.0, 1.0)]);
        let short: Vec<_> = thinned(&points[..50]).collect();
        assert_eq!(short, points[..50]);
    }
}
