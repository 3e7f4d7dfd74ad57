//! Watched scalars as plots: for each component and unit one of what was measured at probes, parts
//! and reservoirs, and one of what is true of the whole.

use crate::rates;
use crate::view::part;
use rerun::{RecordingStream, RecordingStreamResult, Scalars, SeriesLines};
use tremie_messages::start::{FrameContent, FrameStream, Signal};

/// Entity of a signal.
pub fn path(from: &str, name: &str) -> String {
    format!("signals/{}/{}", part(from), part(name))
}

/// Subject of a plot; the first are shown first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    /// Measured at a probe, part or reservoir that the user named.
    Measured,
    /// Of the whole.
    Whole,
    /// Pure numbers, and torques.
    Minor,
    /// [`BOOKKEEPING`].
    Books,
}

/// Signals of one component and one kind in one unit: one plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Plot {
    /// Title, as `fluid [m/s]`.
    pub title: String,
    /// Entities shown.
    pub paths: Vec<String>,
    /// True if it is shown at once, or behind the others.
    pub first: bool,
}

/// Words in the names of bookkeeping that is watched when something seems wrong, not otherwise.
const BOOKKEEPING: [&str; 10] = [
    "ledger", "impulse", "momentum", "residual", "gap", "drift", "mass", "links", "cells",
    "rebuilds",
];

/// Units of what says most: how far something has moved, and under which pressure.
const FIRST_UNITS: [&str; 2] = ["m", "Pa"];

/// Colours of lines, to be told apart also by those who see few colours (Okabe and Ito).
const PALETTE: [[u8; 3]; 7] = [
    [0, 114, 178],
    [230, 159, 0],
    [0, 158, 115],
    [204, 121, 167],
    [86, 180, 233],
    [213, 94, 0],
    [240, 228, 66],
];

/// Plots for the signals of these streams. Those of a kind take turns by component, so that the
/// first few show something of each.
pub fn plots(frames: &[FrameStream]) -> Vec<Plot> {
    let mut all = Vec::new();
    for frame in frames {
        let FrameContent::Signals(signals) = &frame.content else {
            continue;
        };
        let mut own = of_component(&frame.from, signals);
        own.sort_by_key(|(kind, unit, _)| (*kind, *unit));
        for at in 0..own.len() {
            let kind = own[at].0;
            let turn = own[..at].iter().filter(|(other, ..)| *other == kind).count();
            all.push(((kind, turn), own[at].2.clone()));
        }
    }
    all.sort_by_key(|(place, _)| *place);
    all.into_iter().map(|(_, plot)| plot).collect()
}

/// A component's plots, with kind and rank of the unit.
fn of_component(from: &str, signals: &[Signal]) -> Vec<(Kind, usize, Plot)> {
    let mut plots: Vec<(Kind, usize, Plot)> = Vec::new();
    for signal in signals {
        let kind = kind(signal);
        let of = if signal.name.contains('.') { " at probes and parts" } else { "" };
        let title = match signal.unit.as_str() {
            "1" | "" => format!("{from}{of}"),
            unit => format!("{from}{of} [{unit}]"),
        };
        let path = path(from, &signal.name);
        match plots.iter_mut().find(|(other, _, plot)| *other == kind && plot.title == title) {
            Some((.., plot)) => plot.paths.push(path),
            None => {
                let first = kind != Kind::Books;
                let unit = FIRST_UNITS.iter().position(|unit| *unit == signal.unit);
                let unit = unit.unwrap_or(FIRST_UNITS.len());
                plots.push((kind, unit, Plot { title, paths: vec![path], first }));
            }
        }
    }
    plots
}

fn kind(signal: &Signal) -> Kind {
    let measured = signal.name.contains('.');
    if !measured && BOOKKEEPING.iter().any(|word| signal.name.contains(word)) {
        return Kind::Books;
    }
    match signal.unit.as_str() {
        "1" | "" | "N m" => Kind::Minor,
        _ if measured => Kind::Measured,
        _ => Kind::Whole,
    }
}

/// The signals of these streams with their meanings, as Markdown.
pub fn meanings(frames: &[FrameStream]) -> String {
    let mut text = String::from("| signal | unit | meaning |\n| --- | --- | --- |\n");
    for frame in frames {
        let FrameContent::Signals(signals) = &frame.content else { continue };
        for (k, Signal { name, unit, meaning, .. }) in signals.iter().enumerate() {
            let plotted = if rates::is_mean(signals, k) {
                "; in plots the mean since the frame before"
            } else {
                ""
            };
            text += &format!("| {}.{name} | {unit} | {meaning}{plotted} |\n", frame.from);
        }
    }
    text
}

/// Names the lines of a component's signals.
pub fn log_names(
    stream: &RecordingStream,
    from: &str,
    signals: &[Signal],
) -> RecordingStreamResult<()> {
    for (k, signal) in signals.iter().enumerate() {
        // Lines of one plot share a unit: their colours differ by their place among those.
        let place = signals[..k].iter().filter(|other| other.unit == signal.unit).count();
        let [r, g, b] = PALETTE[place % PALETTE.len()];
        let style = SeriesLines::new()
            .with_names([signal.name.as_str()])
            .with_colors([rerun::Color::from_rgb(r, g, b)])
            .with_widths([1.5]);
        stream.log_static(path(from, &signal.name), &style)?;
    }
    Ok(())
}

/// Draws one moment; values that are not numbers leave a gap.
pub fn log(
    stream: &RecordingStream,
    from: &str,
    signals: &[Signal],
    values: &[f64],
) -> RecordingStreamResult<()> {
    for (signal, value) in signals.iter().zip(values) {
        stream.log(path(from, &signal.name), &Scalars::new([*value]))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_signal_is_explained() {
        let signal = Signal::new("outlet.pressure", "Pa", &[("pressure", "gauge pressure there")]);
        let stream = FrameStream {
            from: "fluid".into(),
            to: "viewer".into(),
            content: FrameContent::Signals(vec![signal]),
            every: 1,
            lossless: false,
            service: String::new(),
            capacity: 0,
            depth: 1,
        };
        let text = meanings(&[stream]);
        assert!(text.contains("| fluid.outlet.pressure | Pa | gauge pressure there |"), "{text}");
    }

    #[test]
    fn one_plot_for_each_component_and_unit() {
        let signal = |name: &str, unit: &str| Signal::new(name, unit, &[]);
        let stream = |from: &str, signals| FrameStream {
            from: from.into(),
            to: "viewer".into(),
            content: FrameContent::Signals(signals),
            every: 1,
            lossless: false,
            service: String::new(),
            capacity: 0,
            depth: 1,
        };
        let plots = plots(&[
            stream(
                "fluid",
                vec![
                    signal("max_speed", "m/s"),
                    signal("max_mach", "1"),
                    signal("mass", "kg"),
                    signal("mean_speed", "m/s"),
                    signal("momentum_gap", "N s"),
                    signal("outlet.mass_flow_rate", "kg/s"),
                    signal("inlet.pressure", "Pa"),
                    signal("choke.torque_x", "N m"),
                ],
            ),
            stream("grains", vec![signal("max_speed", "m/s"), signal("valve.lift", "m")]),
        ]);
        let titles: Vec<_> =
            plots.iter().map(|p| (p.title.as_str(), p.paths.len(), p.first)).collect();
        assert_eq!(
            titles,
            [
                ("fluid at probes and parts [Pa]", 1, true),
                ("grains at probes and parts [m]", 1, true),
                ("fluid at probes and parts [kg/s]", 1, true),
                ("fluid [m/s]", 2, true),
                ("grains [m/s]", 1, true),
                ("fluid", 1, true),
                ("fluid at probes and parts [N m]", 1, true),
                ("fluid [kg]", 1, false),
                ("fluid [N s]", 1, false),
            ]
        );
    }
}
