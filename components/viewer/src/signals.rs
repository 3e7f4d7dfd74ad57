//! Watched scalars as plots: for each component and unit one of what was measured at probes, parts
//! and reservoirs, and one of what is true of the whole. A plot of many lines is split, by what was
//! measured or by where; and what all names of a plot share stands in its title, so that legends,
//! which Rerun draws over the curves, are small.

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
    /// Lines, one for each signal.
    pub lines: Vec<Line>,
    /// True if it is shown at once, or behind the others.
    pub first: bool,
}

/// A line of a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Entity shown.
    pub path: String,
    /// Name in the legend.
    pub name: String,
}

/// Most lines of a plot: the legend of more is higher than the plot.
const MOST_LINES: usize = 8;

/// Entity of the running mean of the signal at an entity.
pub fn mean(path: &str) -> String {
    format!("{path}/mean")
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
        let own = of_component(&frame.from, signals).into_iter();
        let mut own: Vec<_> = own.flat_map(split).map(shorten).collect();
        own.sort_by_key(|(kind, unit, _)| (*kind, *unit));
        for at in 0..own.len() {
            let kind = own[at].0;
            let turn = own[..at].iter().filter(|(other, ..)| *other == kind).count();
            all.push(((kind, turn), own[at].2.plot(&frame.from)));
        }
    }
    all.sort_by_key(|(place, _)| *place);
    all.into_iter().map(|(_, plot)| plot).collect()
}

/// A plot that is being made.
#[derive(Clone, Debug)]
struct Draft {
    unit: String,
    /// What all its lines are of, as ` outlet`; empty for different things.
    of: String,
    lines: Vec<Line>,
    first: bool,
}

impl Draft {
    fn plot(&self, from: &str) -> Plot {
        let unit = match self.unit.as_str() {
            "1" | "" => String::new(),
            unit => format!(" [{unit}]"),
        };
        Plot {
            title: format!("{from}{}{unit}", self.of),
            lines: self.lines.clone(),
            first: self.first,
        }
    }
}

/// A draft with kind and rank of its unit.
type Ranked = (Kind, usize, Draft);

/// Splits a plot of too many lines, by what stands before the first dot of their names or after the
/// last, whatever makes fewer plots that are small enough.
fn split((kind, rank, draft): Ranked) -> Vec<Ranked> {
    if draft.lines.len() <= MOST_LINES {
        return vec![(kind, rank, draft)];
    }
    let before = |name: &str| name.split('.').next().map(str::to_string);
    let after = |name: &str| name.rsplit('.').next().map(str::to_string);
    let ways = [groups(&draft.lines, before), groups(&draft.lines, after)];
    let helps = |groups: &Vec<Vec<Line>>| groups.len() > 1 && 2 * groups.len() <= draft.lines.len();
    let is_large = |groups: &Vec<Vec<Line>>| groups.iter().any(|lines| lines.len() > MOST_LINES);
    let best = ways.into_iter().filter(helps).min_by_key(|groups| (is_large(groups), groups.len()));
    let groups = best.unwrap_or_else(|| vec![draft.lines.clone()]);
    // The first keeps the place among the others, the rest comes later.
    let kind_of = |place: usize| if place == 0 { kind } else { kind.max(Kind::Minor) };
    let part = |(place, lines)| (kind_of(place), rank, Draft { lines, ..draft.clone() });
    groups.into_iter().enumerate().map(part).collect()
}

/// Lines in groups of an equal key, in the order of the first of each.
fn groups(lines: &[Line], key: impl Fn(&str) -> Option<String>) -> Vec<Vec<Line>> {
    let mut groups: Vec<(Option<String>, Vec<Line>)> = Vec::new();
    for line in lines {
        let own = key(&line.name);
        match groups.iter_mut().find(|(other, _)| *other == own) {
            Some((_, lines)) => lines.push(line.clone()),
            None => groups.push((own, vec![line.clone()])),
        }
    }
    groups.into_iter().map(|(_, lines)| lines).collect()
}

/// Takes what all names share at their begin or end into the title.
fn shorten((kind, rank, mut draft): Ranked) -> Ranked {
    if draft.lines.len() > 1 {
        let names: Vec<&str> = draft.lines.iter().map(|line| line.name.as_str()).collect();
        let (begin, end) = shared(&names);
        let words: Vec<String> = [&names[0][..begin], &names[0][names[0].len() - end..]]
            .iter()
            .map(|word| word.trim_matches(['.', '_']).to_string())
            .filter(|word| !word.is_empty())
            .collect();
        let short: Vec<String> =
            names.iter().map(|name| name[begin..name.len() - end].to_string()).collect();
        if !words.is_empty() {
            draft.of = format!(" {}", words.join(" "));
        }
        for (line, name) in draft.lines.iter_mut().zip(short) {
            line.name = name;
        }
    }
    (kind, rank, draft)
}

/// Lengths of what all of some names have in common at their begins and ends, whole words: each has
/// letters left between.
fn shared(names: &[&str]) -> (usize, usize) {
    let is_border = |c: char| matches!(c, '.' | '_');
    let first = names[0];
    let leaves = |begin: usize, end: usize| names.iter().all(|name| name.len() > begin + end);
    let begins =
        first.char_indices().filter(|(_, c)| is_border(*c)).map(|(at, c)| at + c.len_utf8());
    let has_begin =
        |at: &usize| names.iter().all(|name| name.starts_with(&first[..*at])) && leaves(*at, 0);
    let begin = begins.filter(has_begin).max().unwrap_or(0);
    let ends = first.char_indices().filter(|(_, c)| is_border(*c)).map(|(at, _)| first.len() - at);
    let has_end = |at: &usize| {
        names.iter().all(|name| name.ends_with(&first[first.len() - *at..])) && leaves(begin, *at)
    };
    (begin, ends.filter(has_end).max().unwrap_or(0))
}

/// A component's plots, with kind and rank of the unit.
fn of_component(from: &str, signals: &[Signal]) -> Vec<Ranked> {
    let mut plots: Vec<Ranked> = Vec::new();
    for signal in signals {
        let kind = kind(signal);
        let of = if signal.name.contains('.') { " at probes and parts" } else { "" };
        let unit = if signal.unit == "1" { "" } else { signal.unit.as_str() };
        let line = Line { path: path(from, &signal.name), name: signal.name.clone() };
        let is_its =
            |(other, _, plot): &&mut Ranked| *other == kind && plot.unit == unit && plot.of == of;
        match plots.iter_mut().find(is_its) {
            Some((.., plot)) => plot.lines.push(line),
            None => {
                let first = kind != Kind::Books;
                let rank = FIRST_UNITS.iter().position(|first| *first == unit);
                let rank = rank.unwrap_or(FIRST_UNITS.len());
                let (unit, of) = (unit.to_string(), of.to_string());
                plots.push((kind, rank, Draft { unit, of, lines: vec![line], first }));
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

/// Names the lines of a component's signals, and colours them by their places in their plots.
pub fn log_names(
    stream: &RecordingStream,
    plots: &[Plot],
    from: &str,
    signals: &[Signal],
) -> RecordingStreamResult<()> {
    for signal in signals {
        let path = path(from, &signal.name);
        let (name, [r, g, b]) = look(plots, &path).unwrap_or((&signal.name, PALETTE[0]));
        let style = SeriesLines::new()
            .with_names([name])
            .with_colors([rerun::Color::from_rgb(r, g, b)])
            .with_widths([1.5]);
        stream.log_static(path, &style)?;
    }
    Ok(())
}

/// Name and colour of the line of an entity.
fn look<'a>(plots: &'a [Plot], path: &str) -> Option<(&'a str, [u8; 3])> {
    plots.iter().find_map(|plot| {
        let place = plot.lines.iter().position(|line| line.path == path)?;
        Some((plot.lines[place].name.as_str(), PALETTE[place % PALETTE.len()]))
    })
}

/// Makes the line of a signal that rings thin, and that of its mean wide.
pub fn log_mean_style(
    stream: &RecordingStream,
    plots: &[Plot],
    path: &str,
) -> RecordingStreamResult<()> {
    let Some((name, [r, g, b])) = look(plots, path) else { return Ok(()) };
    // Of one name and one colour: the two share their place in the legend.
    let style =
        SeriesLines::new().with_names([name]).with_colors([rerun::Color::from_rgb(r, g, b)]);
    stream.log_static(path, &style.clone().with_widths([0.6]))?;
    stream.log_static(mean(path), &style.with_widths([2.5]))
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
            plots.iter().map(|p| (p.title.as_str(), p.lines.len(), p.first)).collect();
        assert_eq!(
            titles,
            [
                ("fluid at probes and parts [Pa]", 1, true),
                ("grains at probes and parts [m]", 1, true),
                ("fluid at probes and parts [kg/s]", 1, true),
                ("fluid speed [m/s]", 2, true),
                ("grains [m/s]", 1, true),
                ("fluid", 1, true),
                ("fluid at probes and parts [N m]", 1, true),
                ("fluid [kg]", 1, false),
                ("fluid [N s]", 1, false),
            ]
        );
    }

    fn of_names(names: &[&str]) -> Vec<(String, Vec<String>)> {
        let signals = names.iter().map(|name| Signal::new(*name, "N", &[])).collect();
        let stream = FrameStream {
            from: "fluid".into(),
            to: "viewer".into(),
            content: FrameContent::Signals(signals),
            every: 1,
            lossless: false,
            service: String::new(),
            capacity: 0,
            depth: 1,
        };
        let names = |plot: Plot| plot.lines.into_iter().map(|line| line.name).collect();
        plots(&[stream]).into_iter().map(|plot| (plot.title.clone(), names(plot))).collect()
    }

    #[test]
    fn what_names_share_stands_in_the_title() {
        let axes = ["post.force_x", "post.force_y", "post.force_z"];
        let short = of_names(&axes);
        assert_eq!(
            short,
            [("fluid post.force [N]".to_string(), ["x", "y", "z"].map(String::from).to_vec())]
        );
        let whole = of_names(&["drag", "lift"]);
        assert_eq!(whole[0].0, "fluid [N]");
        assert_eq!(whole[0].1, ["drag", "lift"]);
        assert_eq!(of_names(&["a.b"])[0].1, ["a.b"]);
        // Nothing would be left of the first.
        assert_eq!(of_names(&["a.b", "a.b_c"])[0].1, ["b", "b_c"]);
    }

    #[test]
    fn many_lines_are_split_into_few_plots() {
        let sides = ["x_lower", "x_upper", "y_lower", "y_upper", "z_lower", "z_upper"];
        let axes = ["force_x", "force_y", "force_z"];
        let names: Vec<String> =
            sides.iter().flat_map(|side| axes.map(|axis| format!("{side}.{axis}"))).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let plots = of_names(&names);
        let titles: Vec<_> = plots.iter().map(|(title, _)| title.as_str()).collect();
        assert_eq!(titles, ["fluid force_x [N]", "fluid force_y [N]", "fluid force_z [N]"]);
        assert_eq!(plots[0].1, sides);
        let many: Vec<String> = (0..40).map(|k| format!("a{}.b{k}", k % 2)).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        assert_eq!(of_names(&many).len(), 2, "a plot for each line would be no help");
    }
}
