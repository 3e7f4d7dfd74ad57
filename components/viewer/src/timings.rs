//! Wall time that components take: of each the shares of a window as a bar, and as curves over the
//! run; windows per second.
//!
//! Frames have sums over the whole run. What is drawn is of the time since the frame before, so a
//! frame that was lost makes a longer mean and nothing else.

use crate::legend::READABLE;
use crate::stage::number;
use crate::view::part;
use rerun::components::Radius;
use rerun::{
    Color, LineStrips2D, Points2D, RecordingStream, RecordingStreamResult, Scalars, SeriesLines,
};
use tremie_messages::frame::{ComponentTiming, TimingHeader};
use tremie_messages::start::{CoupledComponent, RunCoupling};

/// Entity of the bars.
pub const BARS: &str = "coupling/window";
/// Entity of windows per second.
pub const RATE: &str = "coupling/windows_per_second";
/// Entity of curves.
const CURVES: &str = "coupling/time";

/// Parts of a component's window, as its bar and its curves stack them: name, and colour.
const PARTS: [(&str, [u8; 3]); 3] =
    [("compute", [0, 158, 115]), ("exchange", [240, 190, 30]), ("wait", [150, 156, 164])];
/// Length and height of a bar, and distance between bars.
const WIDTH: u32 = 480;
const BAR: u32 = 14;
const LANE: u32 = 40;

/// Entity of a component's curves.
pub fn curves(component: &CoupledComponent) -> String {
    format!("{CURVES}/{}", part(&component.name))
}

/// Size of the picture of bars of so many components.
pub fn size(components: usize) -> [u32; 2] {
    [WIDTH, LANE * components.max(1) as u32]
}

/// Times of a run as they were at the frame before.
#[derive(Default)]
pub struct Timings {
    before: Option<(TimingHeader, Vec<ComponentTiming>)>,
}

/// Means over the windows since a frame [ms].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares([f64; 3]);

impl Shares {
    /// Of the windows between two frames; `None` if there is none.
    pub fn between(before: &ComponentTiming, now: &ComponentTiming) -> Option<Self> {
        let windows = now.windows.checked_sub(before.windows).filter(|windows| *windows > 0)?;
        let each =
            |now: u64, before: u64| now.saturating_sub(before) as f64 * 1e-6 / windows as f64;
        Some(Self([
            each(now.compute, before.compute),
            each(now.exchange, before.exchange),
            each(now.wait, before.wait),
        ]))
    }

    /// Sums of the first one, two and all of them [ms].
    pub fn stacked(self) -> [f64; 3] {
        let [compute, exchange, wait] = self.0;
        [compute, compute + exchange, compute + exchange + wait]
    }
}

impl Timings {
    /// Draws a frame.
    pub fn log(
        &mut self,
        stream: &RecordingStream,
        coupling: &RunCoupling,
        header: &TimingHeader,
        timings: &[ComponentTiming],
    ) -> RecordingStreamResult<()> {
        let Some((begin, before)) = self.before.replace((*header, timings.to_vec())) else {
            return log_styles(stream, coupling);
        };
        let windows = header.stamp.window.saturating_sub(begin.stamp.window);
        let seconds = header.elapsed.saturating_sub(begin.elapsed) as f64 * 1e-9;
        if windows == 0 || seconds <= 0.0 {
            // Nothing has happened: the next one is compared with what came before this.
            self.before = Some((begin, before));
            return Ok(());
        }
        stream.log(RATE, &Scalars::new([windows as f64 / seconds]))?;
        let shares: Vec<Option<Shares>> =
            before.iter().zip(timings).map(|(old, new)| Shares::between(old, new)).collect();
        for (component, shares) in coupling.components.iter().zip(&shares) {
            let Some(shares) = shares else { continue };
            stream.log(format!("{}/zero", curves(component)), &Scalars::new([0.0]))?;
            for ((name, _), value) in PARTS.iter().zip(shares.stacked()) {
                stream.log(format!("{}/{name}", curves(component)), &Scalars::new([value]))?;
            }
        }
        log_bars(stream, coupling, &shares)
    }
}

fn log_styles(stream: &RecordingStream, coupling: &RunCoupling) -> RecordingStreamResult<()> {
    let style = |name: &str, [r, g, b]: [u8; 3], width: f32| {
        let style = SeriesLines::new().with_names([name]).with_widths([width]);
        style.with_colors([Color::from_rgb(r, g, b)])
    };
    for component in &coupling.components {
        // The ground on which the others are stacked, so that the axis begins there; of the name of the
        // first, with which it shares its place in the legend.
        let zero = style(PARTS[0].0, PARTS[0].1, 1.0);
        stream.log_static(format!("{}/zero", curves(component)), &zero)?;
        for (k, (name, colour)) in PARTS.iter().enumerate() {
            let text = if k == 0 { (*name).to_string() } else { format!("+ {name}") };
            let path = format!("{}/{name}", curves(component));
            stream.log_static(path, &style(&text, *colour, 2.0))?;
        }
    }
    stream.log_static(RATE, &style("windows/s", [0, 114, 178], 2.0))
}

/// Draws the bars, all on one scale: the longest window fills the width.
fn log_bars(
    stream: &RecordingStream,
    coupling: &RunCoupling,
    shares: &[Option<Shares>],
) -> RecordingStreamResult<()> {
    let whole = |shares: &Option<Shares>| shares.map_or(0.0, |shares| shares.stacked()[2]);
    let longest = shares.iter().map(whole).fold(0.0, f64::max).max(1e-9);
    let width = WIDTH as f32;
    let middle = |lane: usize| (LANE * lane as u32 + 4 + BAR / 2) as f32;
    let (mut strips, mut colours) = (Vec::new(), Vec::new());
    for (lane, shares) in shares.iter().enumerate() {
        let Some(shares) = shares else { continue };
        let mut begin = 0.0;
        for (end, (_, [r, g, b])) in shares.stacked().into_iter().zip(PARTS) {
            let end = (end / longest) as f32 * width;
            if end > begin {
                strips.push([[begin, middle(lane)], [end, middle(lane)]]);
                colours.push(Color::from_rgb(r, g, b));
            }
            begin = end;
        }
    }
    let bars = LineStrips2D::new(strips)
        .with_colors(colours)
        .with_radii([Radius::new_scene_units(0.5 * BAR as f32)]);
    stream.log(format!("{BARS}/bars"), &bars)?;
    let text = |(component, shares): (&CoupledComponent, &Option<Shares>)| match shares {
        Some(Shares([compute, exchange, wait])) => format!(
            "{}: computes {} ms, exchanges {} ms, waits {} ms",
            component.name,
            short(*compute),
            short(*exchange),
            short(*wait),
        ),
        None => format!("{}: no window ended", component.name),
    };
    let below = |lane: usize| [0.5 * width, middle(lane) + 0.5 * BAR as f32 + 4.0];
    let names = Points2D::new((0..coupling.components.len()).map(below))
        .with_labels(coupling.components.iter().zip(shares).map(text))
        .with_show_labels(true)
        .with_radii([Radius::new_ui_points(0.5)])
        .with_colors([READABLE]);
    stream.log(format!("{BARS}/names"), &names)
}

/// Three digits at most.
fn short(value: f64) -> String {
    let digits = if value >= 100.0 {
        1.0
    } else if value >= 1.0 {
        100.0
    } else {
        1000.0
    };
    number((value * digits).round() / digits)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_means_over_the_windows_since_the_frame_before() {
        let at = |windows: u64, scale: u64| ComponentTiming {
            windows,
            compute: 3_000_000 * scale,
            wait: 1_000_000 * scale,
            exchange: 500_000 * scale,
            work: 0,
        };
        let shares = Shares::between(&at(10, 7), &at(14, 11)).unwrap();
        assert_eq!(shares.stacked(), [3.0, 3.5, 4.5]);
        assert_eq!(Shares::between(&at(10, 7), &at(10, 7)), None);
    }

    #[test]
    fn times_are_short() {
        let texts = [0.0, 0.012_34, 1.2345, 123.45].map(short);
        assert_eq!(texts, ["0", "0.012", "1.23", "123"]);
    }
}
