//! The built-in components: the one place where the orchestrator names them.

use tremie_messages::Role;
use tremie_sdk::Line;

/// A component that `tremie` carries in its own executable.
pub struct BuiltIn {
    /// What manifests call it.
    pub name: &'static str,
    /// What it can stand for.
    pub role: Role,
    /// What it is, in a line.
    pub about: &'static str,
    /// Takes part in a run.
    pub run: fn(Line) -> Result<(), String>,
}

/// All built-in components.
pub const BUILT_IN: &[BuiltIn] = &[
    BuiltIn {
        name: "fluid-lbm",
        role: Role::Fluid,
        about: "lattice Boltzmann, D3Q19, moving spheres",
        run: tremie_sdk::run_fluid::<tremie_fluid_lbm::component::LatticeFluid>,
    },
    BuiltIn {
        name: "grains-dem",
        role: Role::Grains,
        about: "discrete elements, spheres with friction",
        run: tremie_sdk::run_grains::<tremie_grains_dem::component::SoftSpheres>,
    },
    BuiltIn {
        name: "viewer",
        role: Role::Observer,
        about: "streams the run into the Rerun viewer",
        run: tremie_sdk::run_observer::<tremie_viewer::Viewer>,
    },
    BuiltIn {
        name: "recorder",
        role: Role::Observer,
        about: "writes the run to an MCAP file",
        run: tremie_sdk::run_observer::<tremie_recorder::Recorder>,
    },
    BuiltIn {
        name: "fields",
        role: Role::Observer,
        about: "writes whole fields, bodies and parts for ParaView (VTK)",
        run: tremie_sdk::run_observer::<tremie_fields::Fields>,
    },
];

/// The built-in component of that name.
pub fn built_in(name: &str) -> Option<&'static BuiltIn> {
    BUILT_IN.iter().find(|component| component.name == name)
}
