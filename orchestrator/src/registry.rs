//! The built-in components: the one place where the orchestrator names them.

use crate::bench::idle::{IdleFluid, IdleGrains};
use schemars::{Schema, SchemaGenerator};
use tremie_messages::Role;
use tremie_sdk::ControlPipe;

/// A component that `tremie` carries in its own executable.
pub struct BuiltIn {
    /// What manifests call it.
    pub name: &'static str,
    /// What it can stand for.
    pub role: Role,
    /// What it is, in a line.
    pub about: &'static str,
    /// What can be set of it.
    pub settings: fn(&mut SchemaGenerator) -> Schema,
    /// Takes part in a run.
    pub run: fn(ControlPipe) -> Result<(), String>,
}

/// All built-in components.
pub const BUILT_IN: &[BuiltIn] = &[
    BuiltIn {
        name: "fluid-lbm",
        role: Role::Fluid,
        about: "lattice Boltzmann, D3Q19: parts, open faces, moving spheres and parts",
        settings: SchemaGenerator::subschema_for::<tremie_fluid_lbm::Parameters>,
        run: tremie_sdk::run_fluid::<tremie_fluid_lbm::component::LbmComponent>,
    },
    BuiltIn {
        name: "grains-dem",
        role: Role::Grains,
        about: "discrete elements: spheres, walls and parts, friction",
        settings: SchemaGenerator::subschema_for::<tremie_grains_dem::Parameters>,
        run: tremie_sdk::run_grains::<tremie_grains_dem::component::SoftSpheres>,
    },
    BuiltIn {
        name: "rubber-table",
        role: Role::Rubber,
        about: "seals of rubber by a table of force and shapes",
        settings: SchemaGenerator::subschema_for::<tremie_rubber_table::Parameters>,
        run: tremie_sdk::run_rubber::<tremie_rubber_table::component::Seals>,
    },
    BuiltIn {
        name: "viewer",
        role: Role::Observer,
        about: "streams the run into the Rerun viewer",
        settings: SchemaGenerator::subschema_for::<tremie_viewer::Parameters>,
        run: tremie_sdk::run_observer::<tremie_viewer::Viewer>,
    },
    BuiltIn {
        name: "recorder",
        role: Role::Observer,
        about: "writes the run to an MCAP file",
        settings: SchemaGenerator::subschema_for::<tremie_recorder::Parameters>,
        run: tremie_sdk::run_observer::<tremie_recorder::Recorder>,
    },
    BuiltIn {
        name: "fields",
        role: Role::Observer,
        about: "writes whole fields, bodies and parts for ParaView (VTK)",
        settings: SchemaGenerator::subschema_for::<tremie_fields::Parameters>,
        run: tremie_sdk::run_observer::<tremie_fields::Fields>,
    },
];

/// Components that compute nothing, for `tremie bench`.
const IDLE: &[BuiltIn] = &[
    BuiltIn {
        name: "idle-fluid",
        role: Role::Fluid,
        about: "finds no loads",
        settings: SchemaGenerator::subschema_for::<()>,
        run: tremie_sdk::run_fluid::<IdleFluid>,
    },
    BuiltIn {
        name: "idle-grains",
        role: Role::Grains,
        about: "never move",
        settings: SchemaGenerator::subschema_for::<()>,
        run: tremie_sdk::run_grains::<IdleGrains>,
    },
];

/// The built-in component of that name.
pub fn built_in(name: &str) -> Option<&'static BuiltIn> {
    BUILT_IN.iter().chain(IDLE).find(|component| component.name == name)
}
