//! The schedule as a picture: a lane for each component, its advances from left to right, and the
//! messages for which others wait. All advances are drawn of equal length, through windows k, k+1 and
//! k+2.

use rerun::components::Radius;
use rerun::{
    Arrows2D, Boxes2D, Color, LineStrips2D, Points2D, RecordingStream, RecordingStreamResult,
};
use tremie_messages::Role;
use tremie_messages::schedule::Content;
use tremie_messages::start::{CoupledExchange, RunCoupling};

/// Entity of the picture.
pub const PATH: &str = "coupling/schedule";
/// Windows in the picture.
const WINDOWS: usize = 3;
/// Length and height of an advance, and distances between lanes.
const LENGTH: f32 = 40.0;
const HEIGHT: f32 = 12.0;
const LANE: f32 = 36.0;
/// Share of its length at which an advance ends: the rest is room for arrows.
const WORK: f32 = 0.72;

/// Colours of roles: fluid, grains, rubber.
pub fn role_colour(role: Role) -> Color {
    match role {
        Role::Fluid => Color::from_rgb(86, 180, 233),
        Role::Grains => Color::from_rgb(230, 159, 0),
        _ => Color::from_rgb(204, 121, 167),
    }
}

/// Times at which advances begin, in lengths of one: by component, then by window.
pub fn begins(coupling: &RunCoupling) -> Vec<[usize; WINDOWS]> {
    let count = coupling.components.len();
    let mut begins = vec![[0; WINDOWS]; count];
    for window in 0..WINDOWS {
        // As often as there are components: then every chain of waits has come to its end.
        for _ in 0..=count {
            for component in 0..count {
                let own = if window > 0 { begins[component][window - 1] + 1 } else { 0 };
                let waits = coupling.exchanges.iter().filter(|e| e.to == component);
                let after = |exchange: &CoupledExchange| match exchange.delay as usize {
                    // Together, substep by substep.
                    _ if exchange.content.is_inside_window() => begins[exchange.from][window],
                    delay if delay <= window => begins[exchange.from][window - delay] + 1,
                    _ => 0,
                };
                begins[component][window] = waits.map(after).fold(own, usize::max);
            }
        }
    }
    begins
}

fn left(begin: usize) -> f32 {
    begin as f32 * LENGTH
}

/// Size of the picture: to the right, and down.
pub fn size(coupling: &RunCoupling) -> [f32; 2] {
    let last = begins(coupling).iter().map(|own| own[WINDOWS - 1]).max().unwrap_or(0);
    [left(last + 1), LANE * coupling.components.len().max(1) as f32]
}

/// Draws it, once.
pub fn log(stream: &RecordingStream, coupling: &RunCoupling) -> RecordingStreamResult<()> {
    let begins = begins(coupling);
    let lane = |component: usize| LANE * component as f32 + 0.5 * LANE;
    let all: Vec<(usize, usize)> = (0..coupling.components.len())
        .flat_map(|component| (0..WINDOWS).map(move |window| (component, window)))
        .collect();
    let half = [0.5 * WORK * LENGTH, 0.5 * HEIGHT];
    let centre = |&(component, window): &(usize, usize)| {
        [left(begins[component][window]) + half[0], lane(component)]
    };
    let colour =
        |&(component, _): &(usize, usize)| role_colour(coupling.components[component].role);
    let text = |&(_, window): &(usize, usize)| match window {
        0 => "k".to_string(),
        more => format!("k+{more}"),
    };
    let boxes =
        Boxes2D::from_centers_and_half_sizes(all.iter().map(centre), all.iter().map(|_| half))
            .with_colors(all.iter().map(colour))
            .with_radii([Radius::new_ui_points(2.0)])
            .with_labels(all.iter().map(text))
            .with_show_labels(true);
    stream.log_static(format!("{PATH}/advances"), &boxes)?;
    let name = |component: usize| {
        let own = &coupling.components[component];
        let plural = if own.substeps == 1 { "" } else { "s" };
        format!("{}: {} substep{plural}", own.name, own.substeps)
    };
    let lanes = 0..coupling.components.len();
    let names = Points2D::new(lanes.clone().map(|component| [-0.9 * LENGTH, lane(component)]))
        .with_labels(lanes.clone().map(name))
        .with_show_labels(true)
        .with_radii([Radius::new_ui_points(2.5)])
        .with_colors(
            lanes.clone().map(|component| role_colour(coupling.components[component].role)),
        );
    stream.log_static(format!("{PATH}/names"), &names)?;
    let right = size(coupling)[0];
    let lines = lanes.map(|component| [[-0.2 * LENGTH, lane(component)], [right, lane(component)]]);
    let lines = LineStrips2D::new(lines)
        .with_colors([Color::from_rgb(70, 76, 84)])
        .with_radii([Radius::new_ui_points(0.5)])
        .with_draw_order(-1.0);
    stream.log_static(format!("{PATH}/lanes"), &lines)?;
    log_arrows(stream, coupling, &begins, lane)
}

/// A message between two components, for the arrow: several contents go together.
fn arrows(coupling: &RunCoupling) -> Vec<(CoupledExchange, String)> {
    let mut all: Vec<(CoupledExchange, String)> = Vec::new();
    for exchange in &coupling.exchanges {
        // Events come with every state, and say nothing here.
        if exchange.content == Content::Events {
            continue;
        }
        let word = match exchange.content.is_inside_window() {
            // There and back, as often as it takes.
            true if exchange.content == Content::Trial => "each substep: trials",
            true => "",
            false => word(exchange.content),
        };
        let is_same = |other: &CoupledExchange| {
            let same = other.content.is_inside_window() == exchange.content.is_inside_window();
            same && (other.from, other.to, other.delay)
                == (exchange.from, exchange.to, exchange.delay)
        };
        match all.iter_mut().find(|(other, _)| is_same(other)) {
            Some((_, words)) if !word.is_empty() => *words += &format!(", {word}"),
            Some(_) => {}
            None => all.push((exchange.clone(), word.to_string())),
        }
    }
    all
}

fn word(content: Content) -> &'static str {
    match content {
        Content::Events => "events",
        Content::State => "poses",
        Content::Load => "loads",
        Content::Ports => "velocities at inlets",
        Content::Surface => "surfaces",
        Content::SurfaceLoad => "loads on surfaces",
        Content::Carrier | Content::Trial | Content::Contact | Content::Resultant => "trials",
    }
}

fn log_arrows(
    stream: &RecordingStream,
    coupling: &RunCoupling,
    begins: &[[usize; WINDOWS]],
    lane: impl Fn(usize) -> f32,
) -> RecordingStreamResult<()> {
    let (mut origins, mut vectors, mut colours, mut labels) =
        (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for (exchange, words) in arrows(coupling) {
        let CoupledExchange { from, to, delay, .. } = exchange;
        let delay = delay as usize;
        let down = (lane(to) - lane(from)).signum();
        let edge = [lane(from) + down * 0.5 * HEIGHT, lane(to) - down * 0.5 * HEIGHT];
        for window in 0..WINDOWS - delay.min(WINDOWS) {
            let is_inside = exchange.content.is_inside_window();
            let (out, into) = (left(begins[from][window]), left(begins[to][window + delay]));
            // Inside a window there and back all the time: beside each other.
            let shift = if down > 0.0 { 0.3 } else { 0.42 } * LENGTH;
            let x = if is_inside { [out + shift; 2] } else { [out + WORK * LENGTH, into] };
            origins.push([x[0], edge[0]]);
            vectors.push([x[1] - x[0], edge[1] - edge[0]]);
            colours.push(role_colour(coupling.components[from].role));
            labels.push(if window == 0 { words.clone() } else { String::new() });
        }
    }
    let arrows = Arrows2D::from_vectors(vectors)
        .with_origins(origins)
        .with_colors(colours)
        .with_labels(labels)
        .with_radii([Radius::new_ui_points(1.2)])
        .with_show_labels(true);
    stream.log_static(format!("{PATH}/messages"), &arrows)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use tremie_messages::schedule::Schedule;
    use tremie_messages::start::CoupledComponent;

    /// Fluid and grains.
    pub(crate) fn pair(schedule: Schedule) -> RunCoupling {
        let own = |name: &str, role| CoupledComponent { name: name.into(), role, substeps: 1 };
        let sent = |from, to, content, delay| CoupledExchange { from, to, content, delay };
        let late = u64::from(schedule == Schedule::Parallel);
        RunCoupling {
            schedule,
            components: vec![own("fluid", Role::Fluid), own("grains", Role::Grains)],
            exchanges: vec![
                sent(1, 0, Content::Events, late),
                sent(1, 0, Content::State, late),
                sent(0, 1, Content::Load, 1),
            ],
        }
    }

    #[test]
    fn in_turns_one_waits_for_the_other_and_in_parallel_none() {
        assert_eq!(begins(&pair(Schedule::Serial)), [[1, 3, 5], [0, 2, 4]]);
        assert_eq!(begins(&pair(Schedule::Parallel)), [[0, 1, 2], [0, 1, 2]]);
    }

    #[test]
    fn grains_and_rubber_advance_together() {
        let mut coupling = pair(Schedule::Serial);
        coupling.components.push(CoupledComponent {
            name: "rubber".into(),
            role: Role::Rubber,
            substeps: 4,
        });
        for (from, to, content) in [(1, 2, Content::Carrier), (2, 1, Content::Trial)] {
            coupling.exchanges.push(CoupledExchange { from, to, content, delay: 0 });
        }
        coupling.exchanges.push(CoupledExchange {
            from: 0,
            to: 2,
            content: Content::SurfaceLoad,
            delay: 1,
        });
        let begins = begins(&coupling);
        assert_eq!(begins[1], begins[2]);
        assert_eq!(begins[0], [1, 3, 5]);
        let words: Vec<_> = arrows(&coupling).into_iter().map(|(_, words)| words).collect();
        assert_eq!(words, ["poses", "loads", "", "each substep: trials", "loads on surfaces"]);
    }
}
