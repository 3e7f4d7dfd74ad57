//! The tab "Coupling": loads on bodies, the schedule, where the wall time goes, the impulse that
//! crosses between fluid and grains, trials of rubber. It has views of what streams of the run bring.

use crate::blueprint::{Container, Part, View};
use crate::impulse::{self, ImpulseBalance};
use crate::layout::{CURVE_NAME, curves, picture, space, time_series};
use crate::loads::{self, Loads};
use crate::parameters::{Parameters, Tab};
use crate::timings::{self, Timings};
use crate::view::{Eye, up};
use crate::{schedule, signals};
use rerun::blueprint::components::ContainerKind;
use rerun::{RecordingStream, RecordingStreamResult};
use tremie_messages::frame::{ComponentTiming, LoadSample, TimingHeader};
use tremie_messages::scene::Scene;
use tremie_messages::schedule::{Content, Schedule};
use tremie_messages::start::{CoupledComponent, FrameContent, FrameStream, RunCoupling, Signal};

/// Signals of rubber with the number of its trials, without the name of the seal.
const TRIALS: [&str; 2] = ["mean_passes", "most_passes"];

/// What the tab shows.
pub struct Coupling {
    /// Loads, if a stream brings them.
    loads: Option<Loads>,
    followed: bool,
    timings: Timings,
    /// The schedule, if a stream brings timings.
    plan: Option<RunCoupling>,
    impulse: Option<ImpulseBalance>,
    /// Entities of trials.
    trials: Vec<String>,
    /// Axis along which impulses are shown.
    axis: usize,
    /// True if it is the tab that is seen first.
    opens: bool,
}

impl Coupling {
    /// For the streams of a run; draws the schedule.
    pub fn open(
        stream: &RecordingStream,
        scene: &Scene,
        parameters: &Parameters,
        frames: &[FrameStream],
    ) -> RecordingStreamResult<Self> {
        let is_wanted = parameters.coupling;
        let has_loads = frames.iter().any(|frame| frame.content == FrameContent::Loads);
        let plan = frames.iter().find_map(|frame| match &frame.content {
            FrameContent::Timings(plan) if is_wanted => Some(plan.clone()),
            _ => None,
        });
        if let Some(plan) = &plan {
            schedule::log(stream, plan)?;
        }
        let axis = up(scene).0;
        Ok(Self {
            loads: (is_wanted && has_loads).then(|| Loads::new(scene, parameters)),
            followed: !parameters.followed.is_empty(),
            timings: Timings::default(),
            plan,
            impulse: ImpulseBalance::of_streams(frames, axis).filter(|_| is_wanted),
            trials: if is_wanted { trials(frames) } else { Vec::new() },
            axis,
            opens: parameters.tab == Tab::Coupling,
        })
    }

    /// Draws loads.
    pub fn log_loads(
        &mut self,
        stream: &RecordingStream,
        loads: &[LoadSample],
    ) -> RecordingStreamResult<()> {
        self.loads.as_mut().map_or(Ok(()), |own| own.log(stream, loads))
    }

    /// Draws timings.
    pub fn log_timings(
        &mut self,
        stream: &RecordingStream,
        coupling: &RunCoupling,
        header: &TimingHeader,
        timings: &[ComponentTiming],
    ) -> RecordingStreamResult<()> {
        if self.plan.is_none() {
            return Ok(());
        }
        self.timings.log(stream, coupling, header, timings)
    }

    /// Draws what belongs to the tab of the signals of a window.
    pub fn log_impulse(
        &mut self,
        stream: &RecordingStream,
        window: u64,
        names: &[Signal],
        values: &[f64],
    ) -> RecordingStreamResult<()> {
        self.impulse.as_mut().map_or(Ok(()), |own| own.log(stream, window, names, values))
    }

    /// True if the tab is seen first.
    pub fn opens(&self) -> bool {
        self.opens
    }

    /// The tab, if there is anything to show; curves reach to `end` [s].
    pub fn tab(&self, overview: Eye, end: Option<f64>) -> Option<Container> {
        let (left, right) = (self.left(overview), self.right(end));
        let column = |name: &str, parts: Vec<(Part, f32)>| {
            let empty = Container::new(ContainerKind::Vertical, name);
            parts.into_iter().fold(empty, |column, (part, share)| column.with(part, share))
        };
        let row = Container::new(ContainerKind::Horizontal, "Coupling");
        match (left.is_empty(), right.is_empty()) {
            (true, true) => None,
            (true, false) => Some(row.with(column("Wall time", right), 1.0)),
            (false, true) => Some(row.with(column("Loads", left), 1.0)),
            (false, false) => {
                Some(row.with(column("Loads", left), 1.0).with(column("Wall time", right), 1.0))
            }
        }
    }

    fn left(&self, overview: Eye) -> Vec<(Part, f32)> {
        let mut parts = Vec::new();
        if self.loads.as_ref().is_some_and(Loads::are_drawn) {
            let hidden = ["bodies", "cuts", "streamlines", "isosurfaces", "profiles"];
            let hidden = hidden.map(|what| format!("- /scene/{what}/**"));
            let contents = [vec!["+ /scene/**".to_string()], hidden.to_vec()].concat();
            parts.push((space("Loads on bodies", overview, contents).into(), 7.0));
        }
        if let Some(plan) = &self.plan {
            let [width, height] = schedule::size(plan);
            let name = match plan.schedule {
                Schedule::Serial => "Schedule: serial, windows k to k+2",
                Schedule::Parallel => "Schedule: parallel, windows k to k+2",
            };
            let corners = [[-62.0, 2.0], [width + 2.0, height + 2.0]];
            parts.push((picture(name, schedule::PATH, corners).into(), 3.0));
        }
        parts
    }

    fn right(&self, end: Option<f64>) -> Vec<(Part, f32)> {
        let mut parts = Vec::new();
        let row = |views: Vec<View>| {
            let row = Container::new(ContainerKind::Horizontal, "Curves");
            Part::from(views.into_iter().fold(row, |row, view| row.with(view, 1.0)))
        };
        let below = |path: &str| vec![format!("/{path}/**")];
        if let Some(plan) = &self.plan {
            let [width, height] = timings::size(plan.components.len()).map(|x| x as f32);
            let corners = [[-8.0, -4.0], [width + 8.0, height + 4.0]];
            let bars = picture("A window: computes, exchanges, waits", timings::BARS, corners);
            parts.push((bars.into(), 2.2));
            let of = |component: &CoupledComponent| {
                let title = format!("{} [ms/window]", component.name);
                let letters = if plan.components.len() > 2 { 10 } else { CURVE_NAME };
                time_series(title, below(&timings::curves(component)), end, letters)
            };
            parts.push((row(plan.components.iter().map(of).collect()), 2.6));
        }
        let mut more = Vec::new();
        if self.plan.is_some() {
            more.push(curves("Windows per second of wall time", below(timings::RATE), end));
        }
        if !self.trials.is_empty() {
            let paths = self.trials.iter().map(|path| format!("/{path}")).collect();
            more.push(curves("Trials of rubber in a substep", paths, end));
        }
        if !more.is_empty() {
            parts.push((row(more), 2.2));
        }
        if self.impulse.is_some() {
            let axis = ["x", "y", "z"][self.axis];
            let title = format!("Impulse fluid to bodies, {axis} [N s]");
            let sums = curves(title, below(impulse::SUMS), end);
            let lag = match self.delay() {
                Some(1) => "On its way: 1 window [N s]".to_string(),
                Some(windows) => format!("On its way: {windows} windows [N s]"),
                None => "On its way [N s]".to_string(),
            };
            parts.push((row(vec![sums, curves(lag, below(impulse::ON_THE_WAY), end)]), 2.6));
        }
        if self.followed && self.loads.is_some() {
            let followed = curves("Loads on followed bodies [N]", below(loads::FOLLOWED), end);
            parts.push((followed.into(), 2.6));
        }
        parts
    }

    /// Windows after which grains apply a load.
    fn delay(&self) -> Option<u64> {
        let exchanges = &self.plan.as_ref()?.exchanges;
        let load = exchanges.iter().find(|exchange| exchange.content == Content::Load)?;
        Some(load.delay)
    }
}

fn trials(frames: &[FrameStream]) -> Vec<String> {
    let of = |frame: &FrameStream| match &frame.content {
        FrameContent::Signals(signals) => {
            let is_one = |name: &str| TRIALS.contains(&name.rsplit('.').next().unwrap_or_default());
            let names = signals.iter().map(|signal| &signal.name).filter(|name| is_one(name));
            names.map(|name| signals::path(&frame.from, name)).collect()
        }
        _ => Vec::new(),
    };
    frames.iter().flat_map(of).collect()
}
