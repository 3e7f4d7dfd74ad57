//! Characteristics of a valve in a finished run, for its designer: `tremie valve OUT`.
//!
//! [`valve_signals`] finds the valve's signals, [`characteristics`] reads moments, means and curves
//! out of them. [`paper`] holds runs against the statements of Mutabaruka and Kamrin.

pub mod characteristics;
pub mod debris;
pub mod paper;
pub mod valve_signals;

use characteristics::{Characteristics, Moment, Site, Stretch, characteristics, curves};
use clap::{ArgMatches, Args, FromArgMatches};
use std::f64::consts::PI;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use tremie_messages::scene::{Face, ProbeShape, Scene};
use tremie_messages::units::Length;
use tremie_results::{Chart, CommandError, Curve, FinishedRun, draw_sheet, run_name, text_columns};
use valve_signals::{Asked, Watched};

/// Points of a curve at most.
const POINTS: usize = 200;

/// Arguments of `tremie valve`, besides the folder of the run.
#[derive(Debug, Args)]
pub struct ValveArgs {
    /// The part that is the valve [default: the only one that slides]
    #[arg(long, value_name = "NAME")]
    pub part: Option<String>,
    /// Probe or reservoir of the pressure upstream [default: the only reservoir]
    #[arg(long, value_name = "NAME")]
    pub upstream: Option<String>,
    /// Probe of the pressure downstream [default: gauge pressure 0]
    #[arg(long, value_name = "NAME")]
    pub downstream: Option<String>,
    /// Probe of the rate of flow [default: the only one]
    #[arg(long, value_name = "NAME")]
    pub flow: Option<String>,
    /// Lift above which it counts as open, as "0.5 mm" [default: a tenth of its way]
    #[arg(long, value_name = "LENGTH")]
    pub open_at: Option<Length>,
    /// File of the picture [default: valve.svg in the folder; none with --paper]
    #[arg(long, value_name = "FILE.svg")]
    pub to: Option<PathBuf>,
    /// Hold runs, or all of a study, against what Mutabaruka and Kamrin say of the valve
    #[arg(long, conflicts_with_all = ["part", "upstream", "downstream", "flow", "open_at"])]
    pub paper: bool,
    /// Print one JSON document instead of a table
    #[arg(long)]
    pub json: bool,
}

/// A table, and a picture of pressure drop, rate of flow and lift over each other; or the
/// statements of the paper, held against several runs.
///
/// # Errors
/// If the run has no valve, or more than one and the arguments do not say which.
pub fn read(runs: &[FinishedRun], matches: &ArgMatches) -> Result<String, CommandError> {
    let arguments = ValveArgs::from_arg_matches(matches).map_err(CommandError::input)?;
    if arguments.paper {
        return on_paper(runs, &arguments).map_err(CommandError::input);
    }
    let [run] = runs else {
        let text = format!("{} runs are given; without --paper one is read", runs.len());
        return Err(CommandError::input(text));
    };
    answer(run, &arguments).map_err(CommandError::input)
}

fn on_paper(runs: &[FinishedRun], arguments: &ValveArgs) -> Result<String, String> {
    if let Some(path) = &arguments.to {
        let charts = paper::charts(runs);
        if charts.is_empty() {
            return Err(
                "these runs make no chart: most take two that differ in one quantity".into()
            );
        }
        draw(&charts, "statements of Mutabaruka and Kamrin, and these runs", path)?;
    }
    let statements = paper::statements(runs);
    if arguments.json {
        let all = serde_json::to_string(&statements).map_err(|error| error.to_string())?;
        return Ok(all + "\n");
    }
    Ok(paper::statements_table(&statements))
}

fn draw(charts: &[Chart], title: &str, path: &Path) -> Result<(), String> {
    draw_sheet(charts, title, path)
        .map_err(|message| format!("cannot draw {}: {message}", path.display()))
}

fn answer(run: &FinishedRun, arguments: &ValveArgs) -> Result<String, String> {
    let asked = Asked {
        part: arguments.part.clone(),
        upstream: arguments.upstream.clone(),
        downstream: arguments.downstream.clone(),
        flow: arguments.flow.clone(),
    };
    let watched = Watched::find(&run.signals, &asked)?;
    let site = site(&run.scene, &watched.part, arguments.open_at.map(|lift| lift.0));
    let found = characteristics(&run.signals, &watched, &site)?;
    let picture = picture(run, arguments, &watched, &site, found.open_at)?;
    if arguments.json {
        let all = serde_json::to_string(&found).map_err(|error| error.to_string())?;
        return Ok(all + "\n");
    }
    let lines = text_columns(&["", "value", "when and how"], rows(&found, &site, &watched));
    let mut text: String = lines.iter().flat_map(|line| [line.as_str(), "\n"]).collect();
    if let Some(path) = picture {
        let shown = "pressure drop, rate of flow and flow coefficient while it is open";
        let _ = writeln!(text, "\n{}: {shown}", path.display());
    }
    Ok(text)
}

/// Data of the scene about the valve.
fn site(scene: &Scene, part: &str, open_at: Option<f64>) -> Site {
    let domain = &scene.domain;
    let origin = scene.parts.iter().find(|known| known.name == part).map(|part| part.pose.position);
    // A part whose origin is on a mirror is half of one.
    let is_halved = |axis: usize| {
        let planes = [domain.min[axis], domain.max[axis]];
        (0..2).any(|side| {
            domain.faces[axis][side] == Face::Symmetry
                && origin
                    .is_some_and(|at| (at[axis] - planes[side]).abs() < 1e-9 * domain.size()[axis])
        })
    };
    let rings = scene.probes.iter().filter_map(|probe| match &probe.shape {
        ProbeShape::Ring(ring) => {
            let [inner, outer] = ring.radii;
            Some((probe.name.clone(), PI * (outer * outer - inner * inner)))
        }
        _ => None,
    });
    let sizes = scene.bodies.iter().map(|set| set.placement.sizes().extremes());
    let sizes = sizes.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]);
    Site {
        copies: (0..3).filter(|&axis| is_halved(axis)).fold(1.0, |copies, _| 2.0 * copies),
        density: scene.fluid.as_ref().map_or(1000.0, |fluid| fluid.density),
        open_at,
        rings: rings.collect(),
        diameter: sizes.map(|[least, greatest]| 0.5 * (least + greatest)),
    }
}

fn rows(found: &Characteristics, site: &Site, watched: &Watched) -> Vec<Vec<String>> {
    let mut rows = Vec::new();
    let mut row =
        |what: &str, value: String, how: String| rows.push(vec![what.to_string(), value, how]);
    let at = |m: &Moment| format!("at {:.4} ms, lift {:.4} mm", 1e3 * m.time, 1e3 * m.lift);
    let threshold = format!("a lift of {:.4} mm", 1e3 * found.open_at);
    let moment = |m: &Option<Moment>, missing: &str| match m {
        Some(m) => (format!("{:.4e} Pa", m.drop), at(m)),
        None => ("-".into(), missing.to_string()),
    };
    let never = format!("it never passes {threshold}");
    let (value, how) = moment(&found.cracking, &never);
    row("cracking pressure drop", value, how);
    let greatest = &found.greatest;
    row(
        "greatest lift",
        format!("{:.4} mm", 1e3 * greatest.lift),
        format!("at {:.4} ms", 1e3 * greatest.time),
    );
    let open = match found.cracking {
        Some(_) => {
            format!("at the end it is above {threshold}; --open-at says which lift counts as open")
        }
        None => never.clone(),
    };
    let (value, how) = moment(&found.reseating, &open);
    row("reseating pressure drop", value, how);
    if let Some(held) = &found.held {
        stretch_rows("held", held, &mut row);
        if let Some(kv) = held.kv {
            row("held: flow coefficient Kv", format!("{kv:.4} m³/h"), "at a drop of 1 bar".into());
        }
    }
    if let Some(shut) = &found.shut {
        stretch_rows("shut", shut, &mut row);
    }
    if let [Some(held), Some(shut)] =
        [&found.held, &found.shut].map(|s| s.as_ref().and_then(|s| s.flow))
    {
        row("shut: flow over that when held", format!("{:.2e}", shut / held), String::new());
    }
    for (signal, time, pressure) in &found.seals {
        row(
            "greatest seal contact pressure",
            format!("{pressure:.4e} Pa"),
            format!("at {:.4} ms, {signal}", 1e3 * time),
        );
    }
    for stuck in &found.stuck {
        row(
            "projected area of stuck grains (NASP)",
            format!("{:.4}", stuck.area_fraction),
            format!("at the end, {}", stuck.probe),
        );
        if let Some(debris) = stuck.debris {
            row(
                "debris",
                format!("{debris:.4}"),
                "cubes of a grain's diameter, if all that are stuck break".into(),
            );
        }
    }
    let downstream = watched.downstream.as_deref().unwrap_or("gauge zero");
    row("", String::new(), format!("drop: {} less {downstream}", watched.upstream));
    if let Some(flow) = &watched.flow {
        row("", String::new(), format!("flow: {} of {flow}", site.copies));
    }
    rows
}

fn stretch_rows(name: &str, stretch: &Stretch, row: &mut impl FnMut(&str, String, String)) {
    let [mean, least, greatest] = stretch.lift.map(|lift| 1e3 * lift);
    let time = format!("mean from {:.4} to {:.4} ms", 1e3 * stretch.from, 1e3 * stretch.until);
    row(
        &format!("{name}: lift"),
        format!("{mean:.4} mm"),
        format!("{time}, {least:.4} to {greatest:.4} mm"),
    );
    row(&format!("{name}: pressure drop"), format!("{:.4e} Pa", stretch.drop), String::new());
    if let Some(flow) = stretch.flow {
        row(
            &format!("{name}: rate of flow"),
            format!("{flow:.4e} m³/s"),
            "of the whole valve".into(),
        );
    }
    for (signal, force) in &stretch.forces {
        let force_of = signal.rsplit('.').next().unwrap_or(signal).replace('_', " ");
        row(&format!("{name}: {force_of}"), format!("{force:.4} N"), String::new());
    }
}

/// Draws the curves; nothing without a rate of flow, or if it never opens.
fn picture(
    run: &FinishedRun,
    arguments: &ValveArgs,
    watched: &Watched,
    site: &Site,
    open_at: f64,
) -> Result<Option<PathBuf>, String> {
    let [drop, flow, kv] = curves(&run.signals, watched, site, open_at, POINTS)?;
    if drop.is_empty() {
        return Ok(None);
    }
    let path = arguments.to.clone().unwrap_or_else(|| run.folder.join("valve.svg"));
    let chart =
        |title: &str, [x, y]: [&str; 2], [by_x, by_y]: [f64; 2], points: Vec<(f64, f64)>| {
            let points = points.into_iter().map(|(a, b)| (by_x * a, by_y * b)).collect();
            Chart {
                title: title.into(),
                x: x.into(),
                y: y.into(),
                log_x: false,
                log_y: false,
                curves: vec![Curve { name: watched.part.clone(), points, marks: false }],
            }
        };
    let charts = [
        chart(
            "pressure drop over flow",
            ["rate of flow [m³/h]", "pressure drop [kPa]"],
            [3600.0, 1e-3],
            drop,
        ),
        chart("flow over lift", ["lift [mm]", "rate of flow [m³/h]"], [1e3, 3600.0], flow),
        chart("flow coefficient over lift", ["lift [mm]", "Kv [m³/h]"], [1e3, 1.0], kv),
    ];
    // The flow coefficient needs flow and drop in one direction, so its chart may be empty.
    let charts: Vec<Chart> =
        charts.into_iter().filter(|chart| !chart.curves[0].points.is_empty()).collect();
    draw(&charts, &run_name(&run.folder), &path)?;
    Ok(Some(path))
}
