//! The plan: time steps, edges, scripts, frames and capacities, from the manifest and the
//! components' descriptions.
//!
//! [`make`] is a pure function. It assigns time steps (`steps`), wires components up by the
//! schedule ([`schedule`]), sizes channels, and hands each component its part as an
//! [`Assignment`].

mod checks;
mod profiles;
mod report;
pub mod schedule;
mod steps;
mod streams;
#[cfg(test)]
mod tests;
mod watches;

pub(crate) use report::bytes;
pub use steps::TOLERANCE;
pub(crate) use streams::copied_bytes;
pub use watches::PlannedWatch;

use crate::manifest::{ComponentSpec, Spec};
use schedule::Wiring;
use steps::{Steps, Wish};
use tremie_messages::scene::{DeformableSurface, Scene};
use tremie_messages::schedule::{Content, Edge, Schedule, Script};
use tremie_messages::start::{
    Assignment, Clock, CoupledComponent, CoupledExchange, Description, FrameContent, FrameStream,
    Injection, Resume, RunCoupling, Transport,
};
use tremie_messages::{FacetLoad, Place, PortState, Problem, Role, WatchedSignal};

/// Most reports under way: bounds how far components run ahead of the orchestrator's looks.
pub const REPORT_DEPTH: u64 = 4096;

/// Most rows in the table of signals unless the manifest says how often.
const MOST_SIGNAL_ROWS: u64 = 20_000;

/// Options of a plan besides manifest and descriptions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Faults that components shall commit on purpose: component and fault.
    pub injections: Vec<(String, Injection)>,
}

/// Plan of a run: steps, components, edges and frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Length of a coupling window [s].
    pub window: f64,
    /// Ticks and windows.
    pub clock: Clock,
    /// Windows in the run, numbered from 1.
    pub windows: u64,
    /// Order in which fluid and grains advance.
    pub schedule: Schedule,
    /// Windows between frames to most observers; each stream of `frames` has a number of its own.
    pub frames_every: u64,
    /// Windows between rows of the table of signals.
    pub signal_rows_every: u64,
    /// The components, in the order of the manifest's spec.
    pub components: Vec<PlannedComponent>,
    /// All edges between components.
    pub edges: Vec<Edge>,
    /// All streams of frames, the log's included.
    pub frames: Vec<FrameStream>,
    /// Signals that the run watches, in the order of the components.
    pub watches: Vec<PlannedWatch>,
    /// Notes on what was adapted or derived, in sentences.
    pub notes: Vec<String>,
    /// Doubtful things, with the component that reports them.
    pub warnings: Vec<String>,
}

/// Part of one component in the plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedComponent {
    /// Its name.
    pub name: String,
    /// Role that it takes.
    pub role: Role,
    /// Its program and version, from its description.
    pub program: String,
    /// Largest step that it asked for [s].
    pub largest_step: Option<f64>,
    /// Length of a substep [s].
    pub step: f64,
    /// Substeps in a window.
    pub substeps: u32,
    /// Threads, where the manifest fixes them.
    pub threads: Option<u32>,
    /// Number of its signals.
    pub signals: usize,
    /// Its signals that the run watches.
    pub watched: Vec<WatchedSignal>,
    /// Its reports have the places of these after the signals.
    pub tells_places: bool,
    /// Its own notes: resolution, dimensionless numbers, memory.
    pub notes: Vec<String>,
    clock: Clock,
    windows: u64,
    rows_every: u64,
    body_capacity: u64,
    edges: Vec<Edge>,
    script: Script,
    frames: Vec<FrameStream>,
    injections: Vec<Injection>,
}

impl PlannedComponent {
    /// The second request of the start contract; `transport` names the shared memory of the run, and
    /// `resume` the checkpoint from which it goes on.
    pub fn assignment(&self, transport: Transport, resume: Option<Resume>) -> Assignment {
        Assignment {
            clock: self.clock,
            windows: self.windows,
            substeps: self.substeps,
            step: self.step,
            rows_every: self.rows_every,
            body_capacity: self.body_capacity,
            edges: self.edges.clone(),
            script: self.script.clone(),
            watched: self.watched.clone(),
            frames: self.frames.clone(),
            transport,
            injections: self.injections.clone(),
            resume,
            timed: None,
        }
    }
}

impl PlannedComponent {
    /// Number of values in its reports after the signals: places of what the run watches.
    pub fn values_of_places(&self) -> usize {
        if self.tells_places { Place::VALUES * self.watched.len() } else { 0 }
    }
}

impl Plan {
    /// True if all physics keeps its state, so that checkpoints can be made.
    pub fn can_be_kept(&self, descriptions: &[Description]) -> bool {
        let mut described = self.components.iter().zip(descriptions);
        described.all(|(component, description)| {
            component.role == Role::Observer || description.state.is_some()
        })
    }

    /// Ends the run with a window, if it does not end before.
    pub fn end_at(&mut self, window: u64) {
        let components = self.components.iter_mut().map(|component| &mut component.windows);
        for windows in components.chain([&mut self.windows]) {
            *windows = window.min(*windows);
        }
    }

    /// Indices of the components that must not lose a frame.
    pub fn lossless_observers(&self) -> Vec<usize> {
        let must = |c: &PlannedComponent| {
            let frames = self.frames.iter().filter(|stream| !stream.content.is_of_orchestrator());
            frames.filter(|stream| stream.lossless).any(|stream| stream.to == c.name)
        };
        (0..self.components.len()).filter(|index| must(&self.components[*index])).collect()
    }
}

/// Plans a run. `descriptions` names the components as the manifest does.
///
/// # Errors
/// Every problem found, with keys of the manifest; `--inject` where an injection is wrong.
pub fn make(
    spec: &Spec,
    descriptions: &[(String, Description)],
    options: &Options,
) -> Result<Plan, Vec<Problem>> {
    let described = pair(spec, descriptions)?;
    let mut problems = checks::stops(spec, &described);
    let steps =
        steps::assign(&wishes(&described), spec.run.until).map_err(|more| problems.extend(more));
    // Without steps the last window is not known: no injection may be refused for being late.
    let windows = steps.as_ref().map_or(u64::MAX, |steps| steps.windows);
    problems.extend(checks::injections(spec, options, windows));
    let members: Vec<_> = spec.components.iter().map(|c| (c.name.as_str(), c.role)).collect();
    let mut wiring = schedule::wire(spec.run.schedule, &members);
    if !PortState::all(&spec.scene).is_empty() {
        problems.extend(checks::ports(&spec.scene, &described));
        wiring = wiring.with_ports();
    }
    problems.extend(checks::profiles(&spec.scene, &described));
    if let Err(error) = schedule::check(&wiring) {
        problems.push(Problem::new("run.schedule", error.to_string()));
    }
    match steps {
        Ok(steps) if problems.is_empty() => Ok(assemble(spec, &described, steps, &wiring, options)),
        _ => Err(problems),
    }
}

/// A component with its description.
type Described<'a> = (&'a ComponentSpec, &'a Description);

fn pair<'a>(
    spec: &'a Spec,
    descriptions: &'a [(String, Description)],
) -> Result<Vec<Described<'a>>, Vec<Problem>> {
    let mut problems = Vec::new();
    let mut described = Vec::new();
    for component in &spec.components {
        match descriptions.iter().find(|(name, _)| *name == component.name) {
            Some((_, description)) => described.push((component, description)),
            None => problems
                .push(Problem::new(component.key(), "this component did not describe itself")),
        }
    }
    if problems.is_empty() { Ok(described) } else { Err(problems) }
}

/// Largest steps of the physics, in the order of the components. A role that makes the steps of
/// another has none of its own: its bound is a bound on the other's.
fn wishes(described: &[Described<'_>]) -> Vec<Wish> {
    let bound = |role: Role| {
        let mut with = described.iter().filter(|(spec, _)| spec.role.steps_with() == Some(role));
        with.find_map(|(_, description)| description.step)
    };
    let wish = |(spec, description): &Described<'_>| Wish {
        name: spec.name.clone(),
        key: spec.key(),
        step: match (description.step, bound(spec.role)) {
            (Some(step), Some(bound)) => Some(step.min(bound)),
            (step, bound) => step.or(bound),
        },
        limit: description.step_limit.clone(),
        sync_iter: spec.sync_iter,
    };
    described.iter().filter(|(spec, _)| spec.role.has_steps()).map(wish).collect()
}

fn assemble(
    spec: &Spec,
    described: &[Described<'_>],
    steps: Steps,
    wiring: &Wiring,
    options: &Options,
) -> Plan {
    let window = steps.clock.window();
    let body_capacity = body_capacity(described);
    let frames_every = windows_in(spec.outputs.frames, window, steps.windows);
    let rows_every = signal_rows_every(spec, window, steps.windows);
    let substeps = substeps_of_all(described, &steps);
    let edges = edges(wiring, &substeps, |content| capacity(content, body_capacity, &spec.scene));
    let vertices = capacity(Content::Surface, body_capacity, &spec.scene);
    let room = streams::Room { bodies: body_capacity, vertices };
    let coupling = coupling(spec, wiring, &substeps);
    let frames = streams::streams(described, room, (&edges, &coupling), |observer, content| {
        frame_windows(spec, (observer, content), window, steps.windows)
    });
    let (notes, more_warnings) = notes(spec, described, &frames, &steps);
    let watches = watches::watches(spec, described);
    let component = |(index, (spec, description)): (usize, &Described<'_>)| PlannedComponent {
        name: spec.name.clone(),
        role: spec.role,
        program: description.program.clone(),
        largest_step: description.step,
        step: steps.step(substeps[index]),
        substeps: substeps[index],
        threads: spec.threads,
        signals: description.signals.len(),
        watched: watches::of(&spec.name, &watches),
        tells_places: description.tells_places,
        notes: description.notes.clone(),
        clock: steps.clock,
        windows: steps.windows,
        rows_every,
        body_capacity,
        // In the order of the member's links: its script holds indices into them.
        edges: wiring.members[index].links.iter().map(|link| edges[*link].clone()).collect(),
        script: Script { resume: wiring.resume(index), ..wiring.members[index].script.clone() },
        frames: frames
            .iter()
            .filter(|s| s.from == spec.name || s.to == spec.name)
            .cloned()
            .collect(),
        injections: options
            .injections
            .iter()
            .filter(|(name, _)| *name == spec.name)
            .map(|(_, i)| i.clone())
            .collect(),
    };
    Plan {
        window,
        clock: steps.clock,
        windows: steps.windows,
        schedule: spec.run.schedule,
        frames_every,
        signal_rows_every: rows_every,
        components: described.iter().enumerate().map(component).collect(),
        warnings: described.iter().flat_map(own_warnings).chain(more_warnings).collect(),
        notes: steps.notes.into_iter().chain(notes).collect(),
        edges,
        frames,
        watches,
    }
}

/// Doubtful things that a component says of itself.
fn own_warnings((spec, description): &Described<'_>) -> Vec<String> {
    let warnings = description.warnings.iter();
    warnings.map(|warning| format!("{}: {warning}", spec.name)).collect()
}

/// The physics and its exchanges, as observers are told.
fn coupling(spec: &Spec, wiring: &Wiring, substeps: &[u32]) -> RunCoupling {
    let is_physics = |index: &usize| spec.components[*index].role != Role::Observer;
    let physics: Vec<usize> = (0..spec.components.len()).filter(is_physics).collect();
    let place = |member: usize| physics.iter().position(|index| *index == member);
    let component = |index: &usize| CoupledComponent {
        name: spec.components[*index].name.clone(),
        role: spec.components[*index].role,
        substeps: substeps[*index],
    };
    let exchange = |(index, link): (usize, &schedule::Link)| {
        let (from, to) = (place(link.from)?, place(link.to)?);
        Some(CoupledExchange { from, to, content: link.content, delay: wiring.delay_of(index) })
    };
    RunCoupling {
        schedule: spec.run.schedule,
        components: physics.iter().map(component).collect(),
        exchanges: wiring.links.iter().enumerate().filter_map(exchange).collect(),
    }
}

/// Windows between frames of a content to an observer.
fn frame_windows(
    spec: &Spec,
    (observer, content): (&ComponentSpec, &FrameContent),
    window: f64,
    windows: u64,
) -> u64 {
    match content {
        FrameContent::Profile(name) => profiles::windows_between(spec, name, window, windows),
        FrameContent::Messages(_) => 1,
        FrameContent::Hashes(_) => {
            windows_in(spec.outputs.frames, window, windows).min(FrameContent::MOST_HASHED_WINDOWS)
        }
        _ => windows_in(spec.interval(observer), window, windows),
    }
}

/// Notes on what observers get, and warnings for what they wish and do not.
fn notes(
    spec: &Spec,
    described: &[Described<'_>],
    frames: &[FrameStream],
    steps: &Steps,
) -> (Vec<String>, Vec<String>) {
    let (mut notes, mut warnings) = streams::notes(described, frames, steps.windows);
    if spec.run.checkpoints.keep > 0 {
        let physics = described.iter().filter(|(spec, _)| spec.role != Role::Observer);
        let stateless = physics.filter(|(_, description)| description.state.is_none());
        notes.extend(stateless.map(|(spec, description)| {
            format!(
                "{} ({}) keeps no state: the run cannot be resumed",
                spec.name, description.program
            )
        }));
    }
    notes.extend(watches::notes(spec, described));
    let profiles = profiles::notes(&spec.scene, steps.clock.window(), steps.windows);
    notes.extend(profiles.0);
    warnings.extend(profiles.1);
    (notes, warnings)
}

/// Most bodies that live at once: the number that the grains give, room for inlets included.
fn body_capacity(described: &[Described<'_>]) -> u64 {
    let grains = described.iter().filter(|(spec, _)| spec.role == Role::Grains);
    grains.map(|(_, description)| description.bodies).max().unwrap_or(0)
}

/// Substeps of all components. Some make another's substeps; an observer counts in windows.
fn substeps_of_all(described: &[Described<'_>], steps: &Steps) -> Vec<u32> {
    let with_steps = described.iter().map(|(spec, _)| spec.role).filter(|role| role.has_steps());
    let substeps = |role: Role| {
        let mut all = with_steps.clone().zip(&steps.substeps);
        all.find(|(of, _)| *of == role).map_or(1, |(_, substeps)| *substeps)
    };
    let of = |(spec, _): &Described<'_>| substeps(spec.role.steps_with().unwrap_or(spec.role));
    described.iter().map(of).collect()
}

/// Most values in a message. Shared memory is never of size zero, even where a scene has no bodies.
fn capacity(content: Content, bodies: u64, scene: &Scene) -> u64 {
    let sum = |of: fn(&DeformableSurface) -> usize| -> u64 {
        scene.surfaces.iter().map(|surface| of(surface) as u64).sum()
    };
    let values = match content {
        Content::Events | Content::State | Content::Load => bodies,
        Content::Ports => PortState::all(scene).len() as u64,
        Content::Carrier | Content::Resultant => scene.surfaces.len() as u64,
        Content::Surface | Content::Trial => sum(DeformableSurface::vertex_count),
        Content::SurfaceLoad | Content::Contact => {
            FacetLoad::MOST_PER_FACET as u64 * sum(DeformableSurface::facet_count)
        }
    };
    values.max(1)
}

fn edges(wiring: &Wiring, substeps: &[u32], capacity: impl Fn(Content) -> u64) -> Vec<Edge> {
    let edge = |link: &schedule::Link| {
        let (from, to) = (&wiring.members[link.from].name, &wiring.members[link.to].name);
        Edge {
            from: from.clone(),
            to: to.clone(),
            content: link.content,
            service: format!("{from}/{}/{to}", link.content.name()),
            capacity: capacity(link.content),
            depth: link.depth,
            sender_substeps: substeps[link.from],
            events_lag: link.events_lag,
        }
    };
    wiring.links.iter().map(edge).collect()
}

/// The whole number of windows nearest to `time` [s], at least one and at most the run.
fn windows_in(time: f64, window: f64, windows: u64) -> u64 {
    ((time / window).round() as u64).clamp(1, windows.max(1))
}

fn signal_rows_every(spec: &Spec, window: f64, windows: u64) -> u64 {
    match spec.outputs.signals {
        Some(time) => windows_in(time, window, windows),
        None => windows.div_ceil(MOST_SIGNAL_ROWS).max(1),
    }
}
