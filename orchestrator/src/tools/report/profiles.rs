//! Profiles of grains in a report: curves over the bins of one axis, coloured maps of two.

use super::scale::Scale;
use tremie_results::{Chart, ColourMap, Curve, ProfileTables, SheetPanel};

/// Tables of a profile at most in a panel: evenly chosen, the last among them.
const TABLES: usize = 5;

/// A profile of a run.
pub struct RunProfile<'a> {
    /// Name of the run; empty where there is one.
    pub run: &'a str,
    /// Its tables.
    pub tables: &'a ProfileTables,
}

/// The panels of a profile, which several runs may have: solid fraction, streamwise velocity and
/// its fluctuation.
pub fn panels(of_runs: &[RunProfile<'_>]) -> Vec<SheetPanel> {
    let Some(first) = of_runs.iter().find(|of_run| !of_run.tables.times.is_empty()) else {
        return Vec::new();
    };
    let along = streamwise(first.tables);
    let shown = [
        ("solid_fraction".to_string(), "solid fraction".to_string(), "1"),
        (format!("velocity_{along}"), format!("velocity {along}"), "m/s"),
        (format!("fluctuation_{along}"), format!("fluctuation {along}"), "m/s"),
    ];
    match first.tables.axes.len() {
        1 => shown.iter().map(|column| SheetPanel::Chart(chart(of_runs, column))).collect(),
        _ => {
            let seen = of_runs.iter().filter(|of_run| !of_run.tables.times.is_empty());
            // A map of the fluctuation says less than its room is worth.
            let maps = seen.flat_map(|of_run| shown[..2].iter().map(|column| map(of_run, column)));
            maps.map(SheetPanel::Map).collect()
        }
    }
}

/// The axis along which grains are fastest, in the mean of the bins of the last table.
fn streamwise(tables: &ProfileTables) -> &'static str {
    let last = tables.times.len() - 1;
    let speed = |axis: &&str| -> f64 {
        let values = tables.of_table(&format!("velocity_{axis}"), last);
        values.iter().filter(|value| value.is_finite()).map(|value| value.abs()).sum()
    };
    let axes = ["z", "y", "x"];
    axes.into_iter().max_by(|a, b| speed(a).total_cmp(&speed(b))).unwrap_or("z")
}

/// A column's name, its words, and its unit.
type Column = (String, String, &'static str);

fn chart(of_runs: &[RunProfile<'_>], (column, words, unit): &Column) -> Chart {
    let tables = || of_runs.iter().map(|of_run| of_run.tables);
    let axis = || tables().filter_map(|tables| tables.axes.first());
    let places = Scale::of(largest(axis().flat_map(|(_, middles)| middles)), "m");
    let values = tables().filter_map(|tables| tables.columns.get(column)).flatten();
    let scale = Scale::of(largest(values), unit);
    let curves = of_runs.iter().flat_map(|of_run| {
        let middles = of_run.tables.axes.first().map_or(&[][..], |(_, middles)| middles);
        chosen(of_run.tables.times.len()).into_iter().map(|table| {
            let values = of_run.tables.of_table(column, table);
            let points = middles.iter().zip(values).filter(|(_, value)| value.is_finite());
            Curve {
                name: legend(of_run, table),
                points: points.map(|(x, value)| (x / places.by, value / scale.by)).collect(),
                marks: false,
            }
        })
    });
    let name = tables().next().map_or("", |tables| &tables.name);
    Chart {
        title: format!("{name}: {words}"),
        x: format!("{} [{}]", axis().next().map_or("", |(axis, _)| axis), places.unit),
        y: format!("{words} [{}]", scale.unit),
        log_x: false,
        log_y: false,
        curves: curves.collect(),
    }
}

fn map(of_run: &RunProfile<'_>, (column, words, unit): &Column) -> ColourMap {
    let RunProfile { run, tables } = of_run;
    let table = tables.times.len() - 1;
    let values = tables.of_table(column, table);
    let scale = Scale::of(largest(values.iter()), unit);
    let axes = &tables.axes;
    let places = Scale::of(largest(axes.iter().flat_map(|(_, middles)| middles)), "m");
    // The axis that comes later stands upright: z, in most scenes.
    let upright = usize::from(axes[1].0 >= axes[0].0);
    let order = [1 - upright, upright];
    let count = order.map(|a| axes[a].1.len());
    let cell = |k: usize| {
        let place = [k / count[1], k % count[1]];
        let (i, j) = if upright == 1 { (place[0], place[1]) } else { (place[1], place[0]) };
        values[i * axes[1].1.len() + j] / scale.by
    };
    let label = |a: usize| format!("{} [{}]", axes[a].0, places.unit);
    let of_run = if run.is_empty() { String::new() } else { format!("{run}, ") };
    ColourMap {
        title: format!(
            "{}: {words} [{}], {of_run}{}",
            tables.name,
            scale.unit,
            span(tables.times[table])
        ),
        x: label(order[0]),
        y: label(order[1]),
        extent: order.map(|a| extent(&axes[a].1).map(|x| x / places.by)),
        count,
        values: (0..values.len()).map(cell).collect(),
    }
}

/// Extent of bins of equal width, from their middles.
fn extent(middles: &[f64]) -> [f64; 2] {
    let (first, last) = (middles[0], middles[middles.len() - 1]);
    // Of a single bin the width is not known from its middle.
    let half = match middles.len() {
        1 => 0.5 * first.abs() + 1e-30,
        bins => 0.5 * (last - first) / (bins - 1) as f64,
    };
    [first - half, last + half]
}

/// Tables to be shown of so many.
fn chosen(tables: usize) -> Vec<usize> {
    let shown = tables.min(TABLES);
    (1..=shown).map(|k| k * tables / shown - 1).collect()
}

fn legend(of_run: &RunProfile<'_>, table: usize) -> String {
    let several = of_run.tables.times.len() > 1;
    match (of_run.run, several) {
        ("", _) => span(of_run.tables.times[table]),
        (run, false) => run.to_string(),
        (run, true) => format!("{run}: {}", span(of_run.tables.times[table])),
    }
}

fn span([begin, end]: [f64; 2]) -> String {
    use tremie_messages::finding::short;
    format!("{} to {} s", short(begin), short(end))
}

fn largest<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    values.filter(|value| value.is_finite()).fold(0.0, |most, value| most.max(value.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tables(axes: Vec<(String, Vec<f64>)>, times: usize) -> ProfileTables {
        let bins: usize = axes.iter().map(|(_, middles)| middles.len()).product();
        let column = |by: f64| (0..bins * times).map(|k| by * k as f64).collect();
        ProfileTables {
            name: "channel".into(),
            axes,
            times: (0..times).map(|k| [k as f64, k as f64 + 1.0]).collect(),
            columns: [
                ("solid_fraction".to_string(), column(0.02)),
                ("velocity_x".to_string(), column(-0.2)),
                ("velocity_z".to_string(), column(0.1)),
                ("fluctuation_x".to_string(), column(0.05)),
            ]
            .into(),
        }
    }

    fn axis(name: &str, bins: usize) -> (String, Vec<f64>) {
        (name.into(), (0..bins).map(|k| 0.001 * (k as f64 + 0.5)).collect())
    }

    #[test]
    fn one_axis_makes_curves_of_some_tables() {
        let tables = tables(vec![axis("y", 4)], 12);
        let panels = panels(&[RunProfile { run: "", tables: &tables }]);
        let [SheetPanel::Chart(fraction), SheetPanel::Chart(velocity), SheetPanel::Chart(_)] =
            &panels[..]
        else {
            panic!("{panels:?}")
        };
        assert_eq!(fraction.x, "y [mm]");
        let names: Vec<&str> = fraction.curves.iter().map(|curve| curve.name.as_str()).collect();
        assert_eq!(names, ["1 to 2 s", "3 to 4 s", "6 to 7 s", "8 to 9 s", "11 to 12 s"]);
        assert_eq!(fraction.curves[0].points[1], (1.5, 0.1));
        assert_eq!(velocity.title, "channel: velocity x", "the faster one");
    }

    #[test]
    fn two_axes_make_maps_of_the_last_table_with_the_later_axis_upright() {
        for axes in [[axis("x", 2), axis("z", 3)], [axis("z", 3), axis("x", 2)]] {
            let swapped = axes[0].0 == "z";
            let tables = tables(axes.to_vec(), 2);
            let panels = panels(&[RunProfile { run: "a", tables: &tables }]);
            let [SheetPanel::Map(map), SheetPanel::Map(_)] = &panels[..] else {
                panic!("{panels:?}")
            };
            assert_eq!((map.x.as_str(), map.y.as_str(), map.count), ("x [mm]", "z [mm]", [2, 3]));
            assert_eq!(map.extent, [[0.0, 2.0], [0.0, 3.0]]);
            let expected: [usize; 6] =
                if swapped { [6, 8, 10, 7, 9, 11] } else { [6, 7, 8, 9, 10, 11] };
            let found: Vec<f64> = map.values.iter().map(|value| (value * 50.0).round()).collect();
            assert_eq!(found, expected.map(|k| k as f64), "{}", map.title);
        }
    }

    #[test]
    fn nothing_is_drawn_without_tables() {
        let empty = tables(vec![axis("y", 0)], 0);
        assert!(panels(&[RunProfile { run: "", tables: &empty }]).is_empty());
    }
}
