//! Layout of the views: the tab of the run, and beside it that of the coupling.

use crate::blueprint::{Container, Part, View};
use crate::coupling::Coupling;
use crate::legend::{HEIGHT, Legend, SOLIDS, SPEED, STRAIN, WIDTH};
use crate::profiles::ProfileView;
use crate::signals::{Plot, mean};
use crate::view::{Eye, single};
use rerun::blueprint::components::{
    BackgroundKind, ContainerKind, Corner2D, TextLogColumn, VisualBounds2D,
};
use rerun::datatypes::{Range2D, TimeInt, TimeRange, TimeRangeBoundary};
use rerun::external::re_sdk_types::blueprint::archetypes::{
    Background, EyeControls3D, LineGrid3D, PlotLegend, TextLogColumns, TimeAxis,
    VisualBounds2D as Bounds,
};
use rerun::external::re_sdk_types::blueprint::datatypes::{
    TextLogColumn as Column, TextLogColumnKind,
};

/// Most plots that are seen at once; more would be too small to read.
const PLOTS_AT_ONCE: usize = 4;

/// Share of a plot's width that a legend takes without names, and for each letter of the longest; and
/// the most that it gets.
const LEGEND: f64 = 0.13;
const LETTER: f64 = 0.024;
const MOST: f64 = 0.4;
/// Letters for which there is room in the tab of the coupling, whose plots are wider.
pub const CURVE_NAME: usize = 6;

/// A cut and the eye that looks straight at it.
pub struct CutView {
    /// Name of the view.
    pub name: String,
    /// Entity of the cut.
    pub path: String,
    /// Eye straight before it.
    pub eye: Eye,
}

/// A cut that a quantity colours, and its legend.
pub struct ShadeView {
    /// The cut.
    pub cut: CutView,
    /// Words for the legend.
    pub words: &'static str,
    /// The legend.
    pub legend: Legend,
}

/// Contents of the layout.
pub struct Shown<'a> {
    /// Eye that sees the whole domain.
    pub overview: Eye,
    /// Cuts seen so far.
    pub cuts: &'a [CutView],
    /// The same by other quantities than speed.
    pub shades: &'a [ShadeView],
    /// Profiles of grains.
    pub profiles: &'a [ProfileView],
    /// True if there are streamlines.
    pub streamlines: bool,
    /// True if there is rubber, coloured by strain.
    pub rubber: bool,
    /// True if there are sheets of profiles, coloured by solid fraction.
    pub sheets: bool,
    /// Plots of signals.
    pub plots: &'a [Plot],
    /// Simulated time that plots reach to [s]; as far as there are data, if it is not known.
    pub end: Option<f64>,
    /// The tab of the coupling.
    pub coupling: &'a Coupling,
}

/// The run, and the coupling in a tab behind it.
pub fn layout(shown: &Shown<'_>) -> Container {
    let run = run(shown);
    match shown.coupling.tab(shown.overview, shown.end) {
        None => run,
        Some(coupling) => Container::new(ContainerKind::Tabs, "Tremie")
            .with(run, 1.0)
            .with(coupling, 1.0)
            .open_at(usize::from(shown.coupling.opens())),
    }
}

/// The scene at the left with the legend below; cuts, words, plots and log at the right.
fn run(shown: &Shown<'_>) -> Container {
    let left = Container::new(ContainerKind::Vertical, "Scene")
        .with(scenes(shown), 10.0)
        .with(legends(shown.rubber, shown.sheets), 1.0);
    let words = [words("About this run", "about"), words("Signals", "about/signals")];
    let profiles = shown.profiles.iter().map(profile);
    let views = shown.cuts.iter().map(cut).chain(profiles).chain(words).map(Part::from);
    // What a user asked for by name comes first.
    let shades = shown.shades.iter().map(|view| Part::from(shade(view)));
    let pictures = tabs("Cuts", shades.chain(views));
    let mut right = Container::new(ContainerKind::Vertical, "Run").with(pictures, 5.0);
    for part in plot_parts(shown.plots, shown.end) {
        right = right.with(part, 3.0);
    }
    right = right.with(log(), 2.0);
    Container::new(ContainerKind::Horizontal, "Run").with(left, 3.0).with(right, 2.0)
}

/// A text, without those below it: Rerun shows one text in a view, or none.
fn words(name: &str, path: &str) -> View {
    View::new("TextDocument", name, path).contents(["$origin".to_string()])
}

/// The scene with streamlines, where there are any, and behind it with cuts, which hide what is
/// behind them.
fn scenes(shown: &Shown<'_>) -> Part {
    let hidden = |what: &str| format!("- /scene/{what}/**");
    let without = |what: &str| {
        vec!["+ /scene/**".to_string(), hidden("profiles"), hidden("loads"), hidden(what)]
    };
    let with_cuts = |name| space(name, shown.overview, without("streamlines"));
    if !shown.streamlines {
        return with_cuts("Scene").into();
    }
    tabs("Scene", [space("Scene", shown.overview, without("cuts")), with_cuts("Cuts")]).into()
}

fn log() -> View {
    let column = |kind| TextLogColumn(Column { kind, visible: true.into() });
    let columns = TextLogColumns::new().with_text_log_columns([
        column(TextLogColumnKind::LogLevel),
        column(TextLogColumnKind::Body),
    ]);
    View::new("TextLog", "Log", "log").property("TextLogColumns", columns)
}

fn tabs(name: &str, views: impl IntoIterator<Item = impl Into<Part>>) -> Container {
    views
        .into_iter()
        .fold(Container::new(ContainerKind::Tabs, name), |tabs, view| tabs.with(view, 1.0))
}

/// A view of the scene from an eye.
pub fn space(name: &str, eye: Eye, contents: Vec<String>) -> View {
    let controls = EyeControls3D::new()
        .with_position(single(eye.position))
        .with_look_target(single(eye.target))
        .with_eye_up(single(eye.up));
    View::new("3D", name, "scene")
        .contents(contents)
        .property("EyeControls3D", controls)
        .property("LineGrid3D", LineGrid3D::new().with_visible(false))
        .property(
            "Background",
            Background::new(BackgroundKind::SolidColor)
                .with_color(rerun::Color::from_rgb(22, 24, 28)),
        )
}

fn cut(cut: &CutView) -> View {
    space(&cut.name, cut.eye, vec![format!("/{}/**", cut.path)])
}

/// A cut with its legend below.
fn shade(view: &ShadeView) -> Container {
    Container::new(ContainerKind::Vertical, &view.cut.name)
        .with(cut(&view.cut), 5.0)
        .with(legend(view.words, &view.legend), 2.0)
}

fn profile(view: &ProfileView) -> View {
    match view {
        ProfileView::Sheet { name, path, eye } => space(name, *eye, vec![format!("/{path}/**")]),
        ProfileView::Bars { name, path } => View::new("BarChart", name.as_str(), path),
    }
}

fn legends(rubber: bool, sheets: bool) -> Container {
    let row = Container::new(ContainerKind::Horizontal, "Legends");
    let views = legend_names(rubber, sheets).into_iter();
    views.fold(row, |row, (name, scale)| row.with(legend(name, &scale), 1.0))
}

/// A legend for each scale in use, with words that tell them apart.
fn legend_names(rubber: bool, sheets: bool) -> Vec<(&'static str, Legend)> {
    let mut all = vec![("Speed of bodies and fluid", SPEED)];
    all.extend(rubber.then_some(("Equivalent shear strain of rubber", STRAIN)));
    all.extend(sheets.then_some(("Solid fraction of profiles", SOLIDS)));
    all
}

fn legend(name: &str, legend: &Legend) -> View {
    let [width, height] = [WIDTH as f32, HEIGHT as f32];
    let corners = [[-0.08 * width, -0.3 * height], [1.08 * width, 2.6 * height]];
    picture(name, &legend.path, corners)
}

/// A view of what is drawn in a plane between two corners.
pub fn picture(name: &str, path: &str, [low, high]: [[f32; 2]; 2]) -> View {
    let range = |a: usize| [f64::from(low[a]), f64::from(high[a])].into();
    let range = Range2D { x_range: range(0), y_range: range(1) };
    View::new("2D", name, path).property("VisualBounds2D", Bounds::new(VisualBounds2D(range)))
}

/// The first plots, two in a row, and the others in tabs behind the last.
fn plot_parts(plots: &[Plot], end: Option<f64>) -> Vec<Container> {
    let plot_view = |plot: &Plot| plot_view(plot, end);
    let (shown, hidden): (Vec<_>, Vec<_>) = plots.iter().partition(|plot| plot.first);
    let (shown, rest) = shown.split_at(shown.len().min(PLOTS_AT_ONCE));
    let behind: Vec<View> = rest.iter().chain(&hidden).map(|plot| plot_view(plot)).collect();
    let mut behind = Some(behind).filter(|views| !views.is_empty());
    let mut rows = Vec::new();
    let count = shown.len().div_ceil(2);
    for (k, pair) in shown.chunks(2).enumerate() {
        let mut row = Container::new(ContainerKind::Horizontal, "Signals");
        for (side, plot) in pair.iter().enumerate() {
            let is_last = k + 1 == count && side + 1 == pair.len();
            row = match behind.take_if(|_| is_last) {
                Some(views) => {
                    row.with(tabs("Signals", std::iter::once(plot_view(plot)).chain(views)), 1.0)
                }
                None => row.with(plot_view(plot), 1.0),
            };
        }
        rows.push(row);
    }
    rows.extend(behind.map(|views| tabs("Signals", views)));
    rows
}

/// A plot whose time runs to the end of the run and on: so that the legend, which Rerun draws over
/// the curves, has a place where there are none.
fn plot_view(plot: &Plot, end: Option<f64>) -> View {
    let lines = plot.lines.iter();
    let paths = lines
        .clone()
        .flat_map(|line| [format!("/{}", line.path), format!("/{}", mean(&line.path))]);
    let longest = lines.map(|line| line.name.chars().count()).max().unwrap_or(0);
    time_series(plot.title.as_str(), paths, end, longest)
}

/// Curves over time, by the contents of their view; their names have a few letters.
pub fn curves(title: impl Into<String>, contents: Vec<String>, end: Option<f64>) -> View {
    time_series(title, contents, end, CURVE_NAME)
}

/// The same, with room for a legend of names of so many letters.
pub fn time_series(
    title: impl Into<String>,
    contents: impl IntoIterator<Item = String>,
    end: Option<f64>,
    letters: usize,
) -> View {
    let view = View::new("TimeSeries", title, "/")
        .contents(contents)
        .property("PlotLegend", PlotLegend::new().with_corner(Corner2D::RightTop));
    let Some(end) = end.filter(|end| *end > 0.0) else { return view };
    let at = |seconds: f64| TimeRangeBoundary::Absolute(TimeInt((seconds * 1e9) as i64));
    let room = 1.0 / (1.0 - (LEGEND + LETTER * letters as f64).min(MOST));
    let range = TimeRange { start: at(0.0), end: at(room * end) };
    view.property("TimeAxis", TimeAxis::new().with_view_range(range))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_view_of_words_shows_one_text() {
        // Rerun shows none where a view takes in the texts below as well: `about/signals` is one.
        assert_eq!(words("About this run", "about").contents, ["$origin"]);
    }

    #[test]
    fn each_scale_has_a_legend_of_its_own() {
        let paths = |rubber, sheets| -> Vec<_> {
            legend_names(rubber, sheets).into_iter().map(|(_, legend)| legend.path).collect()
        };
        assert_eq!(paths(false, false), ["legend/speed"]);
        assert_eq!(paths(false, true), ["legend/speed", "legend/solid_fraction"]);
        assert_eq!(paths(true, false), ["legend/speed", "legend/strain"]);
    }
}
