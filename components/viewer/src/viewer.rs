//! The observer.

use crate::bodies::{self, Bodies};
use crate::coupling::Coupling;
use crate::cut::{self, Cut};
use crate::field::Field;
use crate::flow::Flow;
use crate::layout::{CutView, ShadeView, Shown, layout};
use crate::parameters::Parameters;
use crate::parts::{self, Parts};
use crate::profiles::Profiles;
use crate::rates::Rates;
use crate::rubber::{self, Rubber};
use crate::running_mean::RunningMeans;
use crate::scale::{Map, Scale};
use crate::session::{REPEAT, Session};
use crate::shade::Shade;
use crate::signals::Plot;
use crate::solids::Solids;
use crate::view::{Eye, overview, up_vector};
use crate::{blueprint, legend, signals, stage};
use rerun::{
    MediaType, RecordingStream, RecordingStreamError, Scalars, TextDocument, TextLog, TextLogLevel,
};
use std::collections::{BTreeMap, BTreeSet};
use tremie_geometry::Vec3;
use tremie_messages::frame::{
    BodySample, ComponentTiming, LoadSample, LogHeader, ProfileBin, ProfileHeader, SliceHeader,
    SliceNode, SurfaceSample, TimingHeader, VolumeHeader,
};
use tremie_messages::scene::Scene;
use tremie_messages::start::{Description, FrameContent, RunCoupling, Signal};
use tremie_messages::{INTERFACE_VERSION, Problem};
use tremie_sdk::{AsObserver, ControlPipe, Moment, Observer, ObserverError, Setup};

/// Timeline of simulated seconds.
const TIME: &str = "sim_time";
/// Timeline of coupling windows.
const WINDOW: &str = "window";
/// Frames after which a file is asked whether it still takes them.
const LOOK: u64 = 16;

/// A run that ends before this share of its planned time has plots laid out anew.
const EARLY: f64 = 0.8;

/// Streams a run into Rerun. In web mode it serves the run until it is dropped, also after
/// [`Observer::close`].
pub struct Viewer {
    session: Session,
    parameters: Parameters,
    scale: Scale,
    strain: Scale,
    overview: Eye,
    up: Vec3,
    scene: Scene,
    bodies: Bodies,
    solids: Solids,
    parts: Parts,
    rubber: Rubber,
    profiles: Profiles,
    cuts: BTreeMap<(String, String), Cut>,
    shades: BTreeMap<(String, String), Vec<Shade>>,
    flows: BTreeMap<(String, String), Flow>,
    /// True if there is a view of streamlines.
    streamlines: bool,
    /// Simulated time at the end of the run, if that is known [s].
    end: Option<f64>,
    /// Simulated time of the newest frame [s].
    now: f64,
    plots: Vec<Plot>,
    coupling: Coupling,
    means: RunningMeans,
    rates: Rates,
    named: BTreeSet<String>,
    frames: u64,
    legend_age: u32,
}

fn drawn<T>(result: Result<T, RecordingStreamError>) -> Result<T, ObserverError> {
    result.map_err(|error| ObserverError::Other(format!("the viewer cannot draw a frame: {error}")))
}

fn set_moment(recording: &RecordingStream, time: f64, window: u64) {
    recording.set_duration_secs(TIME, time);
    recording.set_time_sequence(WINDOW, i64::try_from(window).unwrap_or(i64::MAX));
}

impl Viewer {
    /// Session in which the run is shown; [`Session::url`] is the address of the page.
    pub fn session(&self) -> &Session {
        &self.session
    }

    fn recording(&self) -> &RecordingStream {
        self.session.recording()
    }

    fn set_time(&mut self, at: Moment) {
        self.now = self.now.max(at.time);
        set_moment(self.recording(), at.time, at.stamp.window);
    }

    /// Lets the scale follow the speeds of a frame, and keeps the legend true.
    fn follow(&mut self, mut speeds: Vec<f32>) -> Result<(), ObserverError> {
        self.frames += 1;
        self.legend_age += 1;
        if self.frames.is_multiple_of(LOOK) {
            self.session.check()?;
        }
        if self.scale.follow(&mut speeds) || self.frames == 1 || self.legend_age >= REPEAT {
            self.legend_age = 0;
            drawn(legend::SPEED.log_numbers(self.recording(), &self.scale))?;
            if !self.rubber.is_empty() {
                drawn(legend::STRAIN.log_numbers(self.recording(), &self.strain))?;
            }
            if self.profiles.has_sheets() {
                drawn(legend::SOLIDS.log_numbers(self.recording(), self.profiles.scale()))?;
            }
        }
        Ok(())
    }

    fn send_layout(&self) -> Result<(), ObserverError> {
        let view = |((from, name), cut): (&(String, String), &Cut)| CutView {
            name: format!("{from}: {name}"),
            path: cut.path().to_string(),
            eye: cut.eye(self.up, self.overview.position),
        };
        let cuts: Vec<_> = self.cuts.iter().map(view).collect();
        let shades: Vec<_> = (self.shades.iter())
            .filter_map(|(key, shades)| Some((key, self.cuts.get(key)?, shades)))
            .flat_map(|((from, _), cut, shades)| {
                let eye = cut.eye(self.up, self.overview.position);
                shades.iter().map(move |shade| ShadeView {
                    cut: CutView {
                        name: format!("{from}: {}", shade.quantity.name()),
                        path: shade.path.clone(),
                        eye,
                    },
                    words: shade.quantity.words(),
                    legend: shade.legend.clone(),
                })
            })
            .collect();
        let profiles = self.profiles.views(self.up, self.overview.position);
        let shown = Shown {
            overview: self.overview,
            cuts: &cuts,
            shades: &shades,
            profiles: &profiles,
            streamlines: self.streamlines,
            rubber: !self.rubber.is_empty(),
            sheets: self.profiles.has_sheets(),
            plots: &self.plots,
            end: self.end,
            coupling: &self.coupling,
        };
        drawn(blueprint::send(self.recording(), &layout(&shown), TIME))
    }

    /// Draws running means of signals that ring, where they belong in time.
    fn log_means(
        &mut self,
        from: &str,
        at: Moment,
        names: &[Signal],
        values: &[f64],
    ) -> Result<(), ObserverError> {
        let means = self.means.of_signals(from, (at.time, at.stamp.window), names, values);
        let recording = self.session.recording();
        for (path, mean) in means {
            if mean.is_first {
                drawn(signals::log_mean_style(recording, &self.plots, &path))?;
            }
            set_moment(recording, mean.time, mean.window);
            drawn(recording.log(signals::mean(&path), &Scalars::new([mean.value])))?;
        }
        Ok(())
    }

    /// Draws a cut through the flow.
    fn draw_cut(
        &mut self,
        key: (String, String),
        header: &SliceHeader,
        nodes: &[SliceNode],
    ) -> Result<(), ObserverError> {
        self.open_cut(&key, header)?;
        self.follow(cut::speeds(nodes))?;
        if let Some(cut) = self.cuts.get(&key) {
            drawn(cut.log(self.session.recording(), nodes, &self.scale))?;
        }
        for shade in self.shades.get_mut(&key).into_iter().flatten() {
            drawn(shade.log(self.session.recording(), header, nodes))?;
        }
        Ok(())
    }

    /// Draws a cut's shape when it is seen first; the layout then has a view for it.
    fn open_cut(
        &mut self,
        key: &(String, String),
        header: &SliceHeader,
    ) -> Result<(), ObserverError> {
        if self.cuts.get(key).is_some_and(|cut| cut.fits(header)) {
            return Ok(());
        }
        let (from, name) = key;
        let (arrows, eye) = (self.parameters.arrows, self.overview.position);
        let cut = drawn(Cut::open(
            self.recording(),
            from,
            name,
            header,
            arrows,
            eye,
            &self.scene.domain,
        ))?;
        let open = |quantity| {
            let place = (from.as_str(), name.as_str());
            Shade::open(self.recording(), place, quantity, header, &self.scene.domain)
        };
        let quantities = self.parameters.quantities_in(&self.scene).into_iter();
        let shades = drawn(quantities.map(open).collect())?;
        self.shades.insert(key.clone(), shades);
        if self.cuts.insert(key.clone(), cut).is_none() {
            self.send_layout()?;
        }
        Ok(())
    }
}

impl Observer for Viewer {
    const PROGRAM: &'static str = concat!("viewer ", env!("CARGO_PKG_VERSION"));

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        let parameters: Parameters = setup.parameters()?;
        parameters.check()?;
        parts::meshes(&setup.hello.scene)?;
        Ok(Description {
            interface: INTERFACE_VERSION,
            program: Self::PROGRAM.into(),
            watches: parameters.watches(&setup.hello.scene),
            ..Description::default()
        })
    }

    fn open(setup: &Setup) -> Result<Self, ObserverError> {
        let parameters: Parameters = setup.parameters()?;
        parameters.check()?;
        let scene = &setup.hello.scene;
        let meshes = parts::meshes(scene)?;
        let session = Session::open(&parameters, &setup.hello.output)?;
        let recording = session.recording();
        recording.set_log_time_enabled(false);
        recording.set_log_tick_enabled(false);
        drawn(stage::log(recording, scene, setup.assignment.as_ref()))?;
        drawn(legend::SPEED.log_bar(recording, Map::Viridis))?;
        let rubber = Rubber::new(scene);
        if !rubber.is_empty() {
            drawn(legend::STRAIN.log_bar(recording, Map::Plasma))?;
        }
        recording.set_duration_secs(TIME, 0.0);
        recording.set_time_sequence(WINDOW, 0);
        let parts = drawn(Parts::open(recording, scene, &meshes))?;
        let frames = setup.assignment.as_ref().map_or(&[][..], |assignment| &assignment.frames);
        let profiles = drawn(Profiles::open(recording, scene, frames))?;
        let expected = scene.fluid.as_ref().and_then(|fluid| fluid.expected_speed);
        let words = TextDocument::new(signals::meanings(frames));
        let words = words.with_media_type(MediaType::MARKDOWN);
        drawn(recording.log_static("about/signals", &words))?;
        let viewer = Self {
            scale: Scale::new(Map::Viridis, parameters.max_speed.map(|speed| speed.0), expected),
            strain: Scale::new(Map::Plasma, parameters.max_strain, None),
            overview: overview(scene),
            up: up_vector(scene),
            scene: scene.clone(),
            bodies: Bodies::new(scene),
            solids: Solids::new(scene),
            parts,
            rubber,
            profiles,
            cuts: BTreeMap::new(),
            shades: BTreeMap::new(),
            flows: BTreeMap::new(),
            streamlines: parameters.streamlines_in(scene) > 0
                && frames.iter().any(|stream| matches!(stream.content, FrameContent::Volume(_))),
            end: setup.assignment.as_ref().map(|a| a.clock.window() * a.windows as f64),
            now: 0.0,
            plots: signals::plots(frames),
            coupling: drawn(Coupling::open(recording, scene, &parameters, frames))?,
            means: RunningMeans::default(),
            rates: Rates::default(),
            named: BTreeSet::new(),
            frames: 0,
            legend_age: 0,
            session,
            parameters,
        };
        viewer.send_layout()?;
        Ok(viewer)
    }

    fn bodies(
        &mut self,
        _from: &str,
        at: Moment,
        bodies: &[BodySample],
    ) -> Result<(), ObserverError> {
        self.set_time(at);
        self.follow(bodies::speeds(bodies))?;
        drawn(self.parts.log(self.session.recording(), bodies))?;
        drawn(self.solids.log(self.session.recording(), bodies))?;
        drawn(self.bodies.log(self.session.recording(), bodies, &self.scale))
    }

    fn surfaces(
        &mut self,
        _from: &str,
        at: Moment,
        samples: &[SurfaceSample],
    ) -> Result<(), ObserverError> {
        self.set_time(at);
        if self.strain.follow(&mut rubber::strains(samples)) {
            drawn(legend::STRAIN.log_numbers(self.recording(), &self.strain))?;
        }
        drawn(self.rubber.log(self.session.recording(), samples, &self.strain))
    }

    fn slice(
        &mut self,
        from: &str,
        name: &str,
        at: Moment,
        header: &SliceHeader,
        nodes: &[SliceNode],
    ) -> Result<(), ObserverError> {
        if !self.parameters.cuts {
            return Ok(());
        }
        self.set_time(at);
        self.draw_cut((from.to_string(), name.to_string()), header, nodes)
    }

    fn volume(
        &mut self,
        from: &str,
        name: &str,
        at: Moment,
        header: &VolumeHeader,
        nodes: &[SliceNode],
    ) -> Result<(), ObserverError> {
        let Some(field) = Field::new(header, nodes) else { return Ok(()) };
        self.set_time(at);
        let key = (from.to_string(), name.to_string());
        let make = || Flow::new(from, name, &self.scene, &self.parameters);
        let flow = self.flows.entry(key).or_insert_with(make);
        let cuts = flow.cuts(&field);
        for (plane, header, nodes) in cuts {
            self.draw_cut((from.to_string(), plane), &header, &nodes)?;
        }
        if self.cuts.is_empty() && !self.parameters.cuts {
            self.follow(cut::speeds(nodes))?;
        }
        let key = (from.to_string(), name.to_string());
        match self.flows.get_mut(&key) {
            Some(flow) => drawn(flow.log(self.session.recording(), &field, &self.scale)),
            None => Ok(()),
        }
    }

    fn profile(
        &mut self,
        _from: &str,
        name: &str,
        at: Moment,
        _header: &ProfileHeader,
        bins: &[ProfileBin],
    ) -> Result<(), ObserverError> {
        self.set_time(at);
        drawn(self.profiles.log(self.session.recording(), name, bins))
    }

    fn signals(
        &mut self,
        from: &str,
        at: Moment,
        names: &[Signal],
        values: &[f64],
    ) -> Result<(), ObserverError> {
        self.set_time(at);
        if self.named.insert(from.to_string()) {
            drawn(signals::log_names(self.recording(), &self.plots, from, names))?;
        }
        let values = self.rates.shown(from, at.time, names, values);
        drawn(signals::log(self.recording(), from, names, &values))?;
        let (stream, window) = (self.session.recording(), at.stamp.window);
        drawn(self.coupling.log_impulse(stream, window, names, &values))?;
        self.log_means(from, at, names, &values)
    }

    fn loads(
        &mut self,
        _from: &str,
        at: Moment,
        loads: &[LoadSample],
    ) -> Result<(), ObserverError> {
        self.set_time(at);
        drawn(self.coupling.log_loads(self.session.recording(), loads))
    }

    fn timings(
        &mut self,
        at: Moment,
        coupling: &RunCoupling,
        header: &TimingHeader,
        timings: &[ComponentTiming],
    ) -> Result<(), ObserverError> {
        self.set_time(at);
        drawn(self.coupling.log_timings(self.session.recording(), coupling, header, timings))
    }

    fn log(&mut self, at: Moment, header: &LogHeader, text: &str) -> Result<(), ObserverError> {
        self.set_time(at);
        let level = match header.level {
            LogHeader::ERROR => TextLogLevel::ERROR,
            LogHeader::WARNING => TextLogLevel::WARN,
            _ => TextLogLevel::INFO,
        };
        drawn(self.recording().log("log", &TextLog::new(text).with_level(level)))
    }

    /// Sends what is under way. The page and its data are served until the viewer is dropped.
    fn close(&mut self, _last_common_window: u64) -> Result<String, ObserverError> {
        if self.end.is_some_and(|end| self.now < EARLY * end) {
            // The plots were laid out for a longer run.
            self.end = Some(self.now);
            self.send_layout()?;
        }
        self.session.complete()?;
        Ok(format!("{} frames, {}", self.frames, self.session.note()))
    }
}

/// Takes part in a run, over `line`.
///
/// # Errors
/// A sentence for standard error.
pub fn run(line: ControlPipe) -> Result<(), String> {
    tremie_sdk::run::<AsObserver<Viewer>>(line)
}
