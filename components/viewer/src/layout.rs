//! What is seen where.

use crate::blueprint::{Container, View};
use crate::legend::{HEIGHT, WIDTH};
use crate::signals::Plot;
use crate::view::{Eye, single};
use rerun::blueprint::components::{BackgroundKind, ContainerKind, Corner2D, VisualBounds2D};
use rerun::datatypes::Range2D;
use rerun::external::re_sdk_types::blueprint::archetypes::{
    Background, EyeControls3D, LineGrid3D, PlotLegend, VisualBounds2D as Bounds,
};

/// Most plots that are seen at once; more would be too small to read.
const PLOTS_AT_ONCE: usize = 4;

/// A cut and the eye that looks straight at it.
pub struct CutView {
    /// Name of the view.
    pub name: String,
    /// Entity of the cut.
    pub path: String,
    /// Eye straight before it.
    pub eye: Eye,
}

/// The scene at the left with the legend below; cuts, plots, log and words at the right.
pub fn layout(overview: Eye, cuts: &[CutView], plots: &[Plot]) -> Container {
    let left = Container::new(ContainerKind::Vertical, "Scene")
        .with(space("Scene", overview, vec!["/scene/**".into()]), 10.0)
        .with(legend(), 1.0);
    let mut right = Container::new(ContainerKind::Vertical, "Run");
    if !cuts.is_empty() {
        right = right.with(tabs("Cuts", cuts.iter().map(cut)), 5.0);
    }
    for part in plot_parts(plots) {
        right = right.with(part, 3.0);
    }
    let words = Container::new(ContainerKind::Horizontal, "Words")
        .with(View::new("TextLog", "Log", "log"), 1.0)
        .with(View::new("TextDocument", "About this run", "about"), 1.0);
    right = right.with(words, 3.0);
    Container::new(ContainerKind::Horizontal, "Tremie").with(left, 3.0).with(right, 2.0)
}

fn tabs(name: &str, views: impl IntoIterator<Item = View>) -> Container {
    views
        .into_iter()
        .fold(Container::new(ContainerKind::Tabs, name), |tabs, view| tabs.with(view, 1.0))
}

fn space(name: &str, eye: Eye, contents: Vec<String>) -> View {
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

fn legend() -> View {
    let [width, height] = [f64::from(WIDTH), f64::from(HEIGHT)];
    let range = Range2D {
        x_range: [-0.08 * width, 1.08 * width].into(),
        y_range: [-0.3 * height, 2.6 * height].into(),
    };
    View::new("2D", "Speed of bodies and fluid", "legend")
        .property("VisualBounds2D", Bounds::new(VisualBounds2D(range)))
}

/// The first plots, two in a row, and the others in tabs behind the last.
fn plot_parts(plots: &[Plot]) -> Vec<Container> {
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

fn plot_view(plot: &Plot) -> View {
    View::new("TimeSeries", plot.title.as_str(), "signals")
        .contents(plot.paths.iter().map(|path| format!("/{path}")))
        .property("PlotLegend", PlotLegend::new().with_corner(Corner2D::LeftTop))
}
