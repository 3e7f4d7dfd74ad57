//! Settings of a user.

use crate::quantity::CutQuantity;
use rerun::MemoryLimit;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use tremie_messages::Problem;
use tremie_messages::scene::Scene;
use tremie_messages::start::{VolumeWish, Watches};
use tremie_messages::units::{Force, Length, Pressure, Velocity};

/// Streamlines where nothing else is said.
const STREAMLINES: u32 = 120;

fn is_gas(scene: &Scene) -> bool {
    scene.fluid.as_ref().is_some_and(|fluid| fluid.gas.is_some())
}

fn has_free_surface(scene: &Scene) -> bool {
    scene.fluid.as_ref().is_some_and(|fluid| !fluid.fill.is_empty())
}

/// Where the run is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// A page for the browser, served by this program on loopback.
    #[default]
    Web,
    /// The `rerun` program, which must be installed.
    Native,
    /// A recording that `rerun` opens later.
    File,
}

/// A tab of the viewer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Tab {
    /// The scene, cuts, curves and the log.
    #[default]
    Run,
    /// Loads on bodies, the schedule, and where the wall time goes.
    Coupling,
}

/// A kind of loads on bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum LoadKind {
    /// Force of the fluid, buoyancy included.
    Fluid,
    /// Force of contacts with bodies, walls and parts.
    Contact,
}

/// A plane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneSetting {
    /// A point on it.
    pub point: [Length; 3],
    /// Its normal, of any length.
    pub normal: [f64; 3],
}

/// Parameters of the viewer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Where the run is shown.
    pub mode: Mode,
    /// The recording of mode `file`, relative to the run's output folder.
    pub file: PathBuf,
    /// Port of the page; another free one is taken if it is in use.
    pub web_port: u16,
    /// Port of the data; another free one is taken if it is in use.
    pub grpc_port: u16,
    /// Whether to open the page in the browser.
    pub open: bool,
    /// Most memory that the server keeps of the run, as "512 MB" or "25 %"; the oldest frames go
    /// first.
    pub memory_limit: String,
    /// Speed at the upper end of the colour scale; follows the run if unset.
    pub max_speed: Option<Velocity>,
    /// Equivalent shear strain of rubber at the upper end of its colour scale; follows the run if
    /// unset.
    pub max_strain: Option<f64>,
    /// Whether to draw cuts.
    pub cuts: bool,
    /// About how many arrows to draw on a cut; 0 for none.
    pub arrows: u32,
    /// Planes along which to cut the flow, instead of the fluid's own cut.
    pub slices: Vec<PlaneSetting>,
    /// Quantities that colour each cut once more, in views of their own before that of speed (default:
    /// none; of a gas `schlieren`, `vorticity` and `level`).
    pub quantities: Option<Vec<CutQuantity>>,
    /// Number of streamlines; 0 for none (default: 120, but none where the fluid has a free
    /// surface or is a gas).
    pub streamlines: Option<u32>,
    /// Plane on which streamlines begin; all over the fluid, if there is none.
    pub seeds: Option<PlaneSetting>,
    /// Draws the surface where the fluid has this speed.
    pub iso_speed: Option<Velocity>,
    /// Draws the surface where the fluid has this gauge pressure.
    pub iso_pressure: Option<Pressure>,
    /// Whether to draw the free surface of a fluid that has one.
    pub free_surface: bool,
    /// Most nodes of the fluid that streamlines, slices and surfaces are made from; a finer lattice
    /// is thinned.
    pub volume_nodes: u64,
    /// Whether there is a tab "Coupling": loads on bodies, the schedule, the wall time of components,
    /// the impulse between fluid and grains.
    pub coupling: bool,
    /// The tab that is seen first.
    pub tab: Tab,
    /// Loads on bodies that are drawn as arrows in the tab "Coupling"; none for no arrows.
    pub loads: Vec<LoadKind>,
    /// Force of the scale of these arrows: that of an arrow of 6 % of the domain's diagonal; follows the
    /// run if unset.
    pub max_load: Option<Force>,
    /// About how many bodies have arrows of their loads; 0 for none but parts.
    pub load_arrows: u32,
    /// Ids of bodies whose loads are drawn over time in the tab "Coupling". A sphere that is hovered
    /// over shows its id.
    pub followed: Vec<u64>,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            mode: Mode::Web,
            file: "run.rrd".into(),
            web_port: 9090,
            grpc_port: 9876,
            open: false,
            memory_limit: "1 GB".into(),
            max_speed: None,
            max_strain: None,
            cuts: true,
            arrows: 400,
            slices: Vec::new(),
            quantities: None,
            streamlines: None,
            seeds: None,
            iso_speed: None,
            iso_pressure: None,
            free_surface: true,
            volume_nodes: 200_000,
            coupling: true,
            tab: Tab::Run,
            loads: vec![LoadKind::Fluid, LoadKind::Contact],
            max_load: None,
            load_arrows: 1000,
            followed: Vec::new(),
        }
    }
}

impl Parameters {
    /// Checks what the types cannot.
    ///
    /// # Errors
    /// Every problem found.
    pub fn check(&self) -> Result<(), Vec<Problem>> {
        let mut problems = Vec::new();
        if let Err(message) = self.memory() {
            problems.push(
                Problem::of_parameter("memory_limit", message)
                    .help("give an amount as \"512 MB\" or a share as \"25 %\""),
            );
        }
        if self.max_speed.is_some_and(|speed| speed.0 <= 0.0) {
            problems.push(Problem::of_parameter("max_speed", "must be positive"));
        }
        if self.max_strain.is_some_and(|strain| strain.is_nan() || strain <= 0.0) {
            problems.push(Problem::of_parameter("max_strain", "must be positive"));
        }
        if self.max_load.is_some_and(|force| force.0 <= 0.0) {
            problems.push(Problem::of_parameter("max_load", "must be positive"));
        }
        if self.mode == Mode::Web && self.web_port != 0 && self.web_port == self.grpc_port {
            problems.push(Problem::of_parameter(
                "grpc_port",
                "is the port of the page too; the two must differ",
            ));
        }
        let planes =
            self.slices.iter().enumerate().map(|(k, plane)| (format!("slices[{k}]"), plane));
        for (key, plane) in planes.chain(self.seeds.iter().map(|plane| ("seeds".into(), plane))) {
            if !plane.normal.iter().all(|x| x.is_finite()) || plane.normal == [0.0; 3] {
                let message = format!("found {:?}, expected a direction", plane.normal);
                problems.push(Problem::of_parameter(&format!("{key}.normal"), message));
            }
        }
        if self.iso_speed.is_some_and(|speed| speed.0 <= 0.0) {
            problems.push(Problem::of_parameter("iso_speed", "must be positive"));
        }
        if self.volume_nodes == 0 {
            problems.push(Problem::of_parameter("volume_nodes", "found 0, expected 1 or more"));
        }
        if problems.is_empty() { Ok(()) } else { Err(problems) }
    }

    /// Quantities that colour each cut of a scene once more.
    pub(crate) fn quantities_in(&self, scene: &Scene) -> Vec<CutQuantity> {
        use CutQuantity::{Level, Schlieren, Vorticity};
        let usual = || if is_gas(scene) { vec![Schlieren, Vorticity, Level] } else { Vec::new() };
        self.quantities.clone().unwrap_or_else(usual)
    }

    /// Number of streamlines in a scene.
    pub(crate) fn streamlines_in(&self, scene: &Scene) -> u32 {
        let usual = if has_free_surface(scene) || is_gas(scene) { 0 } else { STREAMLINES };
        self.streamlines.unwrap_or(usual)
    }

    /// True if the fluid of a scene has a free surface, and it is drawn.
    pub(crate) fn draws_free_surface(&self, scene: &Scene) -> bool {
        self.free_surface && has_free_surface(scene)
    }

    /// Loads that are drawn as arrows, each once.
    pub(crate) fn load_kinds(&self) -> Vec<LoadKind> {
        let all = [LoadKind::Fluid, LoadKind::Contact];
        all.into_iter().filter(|kind| self.loads.contains(kind)).collect()
    }

    /// Frames that the viewer needs for its drawings.
    pub(crate) fn watches(&self, scene: &Scene) -> Watches {
        let volumes = self.streamlines_in(scene) > 0
            || self.draws_free_surface(scene)
            || !self.slices.is_empty()
            || self.iso_speed.is_some()
            || self.iso_pressure.is_some();
        let wish = VolumeWish { most_nodes: Some(self.volume_nodes), ..VolumeWish::default() };
        Watches {
            surfaces: true,
            loads: self.coupling && !(self.loads.is_empty() && self.followed.is_empty()),
            timings: self.coupling,
            profiles: !scene.profiles.is_empty(),
            slices: self.cuts && self.slices.is_empty(),
            volumes: volumes.then_some(wish),
            ..Watches::default()
        }
    }

    /// Most memory that the server keeps.
    pub(crate) fn memory(&self) -> Result<MemoryLimit, String> {
        let compact: String = self.memory_limit.split_whitespace().collect();
        MemoryLimit::parse(&compact)
            .map_err(|_| format!("\"{}\" is not an amount of memory", self.memory_limit))
    }

    /// The recording of mode `file`.
    pub(crate) fn recording(&self, output: &str) -> PathBuf {
        Path::new(output).join(&self.file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::{Domain, Face};

    #[test]
    fn amounts_and_shares_of_memory_are_read() {
        for text in ["512 MB", "1GB", "25 %", "50%", "2GiB"] {
            let parameters = Parameters { memory_limit: text.into(), ..Default::default() };
            assert!(parameters.check().is_ok(), "{text}");
        }
        let wrong = Parameters { memory_limit: "much".into(), ..Default::default() };
        assert_eq!(wrong.check().unwrap_err()[0].key, "@memory_limit");
    }

    #[test]
    fn unknown_keys_are_refused() {
        assert!(serde_json::from_str::<Parameters>(r#"{"mode": "web", "prot": 1}"#).is_err());
        let parameters: Parameters = serde_json::from_str(r#"{"mode": "file"}"#).unwrap();
        assert_eq!(parameters.recording("/out"), Path::new("/out/run.rrd"));
    }

    #[test]
    fn only_what_is_drawn_is_asked_for() {
        let box_of = |size: f64| Domain::new([0.0; 3], [size; 3], Face::WALLS);
        let scene = Scene::empty(box_of(1.0));
        let of = |text: &str| serde_json::from_str::<Parameters>(text).unwrap().watches(&scene);
        let usual = Parameters::default().watches(&scene);
        assert!(usual.slices && usual.volumes.is_some());
        assert!(of(r#"{"streamlines": 0}"#).volumes.is_none());
        assert!(!of(r#"{"cuts": false}"#).slices);
        assert!(usual.loads && usual.timings);
        assert!(!of(r#"{"loads": []}"#).loads && of(r#"{"loads": [], "followed": [7]}"#).loads);
        let alone = of(r#"{"coupling": false}"#);
        assert!(!alone.loads && !alone.timings);
        let plane = r#"{"streamlines": 0, "slices": [{"point": ["1 mm", "0 m", "0 m"], "normal": [1, 0, 1]}]}"#;
        let own = of(plane);
        assert!(!own.slices && own.volumes.is_some());
    }

    #[test]
    fn a_plane_needs_a_direction() {
        let text = r#"{"slices": [{"point": ["0 m", "0 m", "0 m"], "normal": [0, 0, 0]}], "iso_speed": "0 m/s"}"#;
        let parameters: Parameters = serde_json::from_str(text).unwrap();
        let keys: Vec<_> = parameters.check().unwrap_err().into_iter().map(|p| p.key).collect();
        assert_eq!(keys, ["@slices[0].normal", "@iso_speed"]);
    }
}
