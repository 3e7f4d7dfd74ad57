//! Plots of a study: a column over the values of a key, with a curve for each choice of the others.

use super::StudyError;
use super::axes::value_text;
use super::columns::StudyColumn;
use super::contents::{StudyContents, StudyPlot};
use super::folder::StudyFolder;
use super::runs::StudyRun;
use super::table::RunResults;
use crate::tools::validation::picture::draw_chart;
use std::collections::BTreeMap;
use std::path::PathBuf;
use tremie_results::{Chart, Curve};

/// Draws all plots into the folder; returns the paths of those that show anything.
///
/// # Errors
/// If one cannot be drawn or written.
pub fn draw_plots(
    folder: &StudyFolder,
    contents: &StudyContents,
    columns: &[StudyColumn],
    runs: &[StudyRun],
    results: &[Option<RunResults>],
) -> Result<Vec<PathBuf>, StudyError> {
    let mut drawn = Vec::new();
    for plot in &contents.plots {
        let curves = curves(plot, contents, runs, results);
        if curves.is_empty() {
            continue;
        }
        let key = &contents.axes[plot.x.0].keys[plot.x.1];
        let unit =
            contents.axes[plot.x.0].numbers(plot.x.1).map_or(String::new(), |(_, unit)| unit);
        let column = &columns[plot.y];
        let path = folder.path().join(file_name(&column.name, key));
        let chart = Chart {
            title: format!("{} over {}", column.name, last_part(key)),
            x: if unit.is_empty() { key.clone() } else { format!("{key} [{unit}]") },
            y: column.heading(),
            log_x: contents.axes[plot.x.0].is_log,
            log_y: false,
            curves,
        };
        draw_chart(&chart, &path)
            .map_err(|message| StudyError::Plot { path: path.clone(), message })?;
        drawn.push(path);
    }
    Ok(drawn)
}

/// A curve for each choice of rows of the other axes: means over the seeds, in the order of x.
fn curves(
    plot: &StudyPlot,
    contents: &StudyContents,
    runs: &[StudyRun],
    results: &[Option<RunResults>],
) -> Vec<Curve> {
    let (axis, key) = plot.x;
    let Some((numbers, _)) = contents.axes[axis].numbers(key) else { return Vec::new() };
    // By the rows of the other axes: by the row of this one: sum and number of values.
    let mut groups: BTreeMap<Vec<usize>, BTreeMap<usize, (f64, f64)>> = BTreeMap::new();
    for (run, results) in runs.iter().zip(results) {
        let Some(Some(value)) = results.as_ref().and_then(|all| all.numbers.get(plot.y)) else {
            continue;
        };
        let mut others = run.rows.clone();
        let row = others.remove(axis);
        let (sum, count) = groups.entry(others).or_default().entry(row).or_default();
        *sum += value;
        *count += 1.0;
    }
    let curve = |(others, points): (Vec<usize>, BTreeMap<usize, (f64, f64)>)| {
        let point = |(row, (sum, count)): (usize, (f64, f64))| (numbers[row], sum / count);
        let mut points: Vec<_> = points.into_iter().map(point).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Curve { name: choice_name(contents, axis, &others), points, marks: false }
    };
    groups.into_iter().map(curve).collect()
}

/// Values of the axes other than `axis`, for a legend.
fn choice_name(contents: &StudyContents, axis: usize, others: &[usize]) -> String {
    let all = contents.axes.iter().enumerate().filter(|(index, _)| *index != axis);
    let words = all.zip(others).flat_map(|((_, other), row)| {
        let values = other.keys.iter().zip(&other.rows[*row]);
        values.map(|(key, value)| format!("{} = {}", last_part(key), value_text(value)))
    });
    let words: Vec<String> = words.collect();
    if words.is_empty() { "mean".into() } else { words.join(", ") }
}

fn last_part(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}

/// `opening-over-run-until.svg`: other letters of key and column become dashes.
fn file_name(column: &str, key: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
    let name: String = format!("{column}-over-{key}").chars().map(plain).collect();
    format!("{name}.svg")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tools::study::axes::StudyAxis;
    use crate::tools::study::file::AxisTable;
    use serde_json::Value;

    fn axis(text: &str) -> StudyAxis {
        let table: AxisTable = toml::from_str(text).unwrap();
        StudyAxis::read(&table, "axes[0]", &mut Vec::new())
    }

    #[test]
    fn a_curve_is_the_mean_over_the_seeds_in_the_order_of_x() {
        let contents = StudyContents {
            base: PathBuf::new(),
            repeats: Some(2),
            axes: vec![
                axis("key = 'a.speed'\nvalues = ['2 m/s', '1 m/s']"),
                axis("key = 'a.rate'\nvalues = [5]"),
            ],
            set: Vec::new(),
            columns: Vec::new(),
            plots: Vec::new(),
            slurm: Default::default(),
            source: Default::default(),
        };
        let run = |row| StudyRun {
            point: row + 1,
            rows: vec![row, 0],
            values: vec![Value::Null; 2],
            ..StudyRun::default()
        };
        let runs = [run(0), run(0), run(1), run(1)];
        let result = |number: Option<f64>| {
            let status = "completed".into();
            Some(RunResults { status, numbers: vec![number], wall_time: None })
        };
        let results = [result(Some(1.0)), result(Some(3.0)), result(None), result(Some(5.0))];
        let plot = StudyPlot { x: (0, 0), y: 0 };
        let found = curves(&plot, &contents, &runs, &results);
        let expected = vec![(1.0, 5.0), (2.0, 2.0)];
        assert_eq!(found, [Curve { name: "rate = 5".into(), points: expected, marks: false }]);
        assert_eq!(curves(&plot, &contents, &runs, &[None, None, None, None]), []);
    }

    #[test]
    fn plots_have_names_of_plain_letters() {
        assert_eq!(
            file_name("opening", "scene.bodies[0].density"),
            "opening-over-scene-bodies-0--density.svg"
        );
    }
}
