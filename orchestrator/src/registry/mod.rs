//! The registry: components in the program's own executable, and commands of packages. No other
//! room names one.

/// Plays the recording of a run to an observer, and compares two of them.
pub use tremie_recorder::{
    Comparison as RecordingComparison, ReadError, Recording, compare as compare_recordings,
};
/// A seal's table, which a manifest names.
pub use tremie_rubber_table::table::Table as SealTable;
/// Shows a run, live or recorded.
pub use tremie_viewer::Viewer;

use clap::{ArgMatches, Args, Command, Subcommand};
use schemars::{Schema, SchemaGenerator};
use tremie_messages::Role;
use tremie_pressure_valve as pressure_valve;
use tremie_results::{CommandError, FinishedRun};
use tremie_sdk::ControlPipe;
use tremie_sdk::benchmark::{Benchmark, BenchmarkSizes};

/// Filter of log lines that a user sees of components that are threads: warnings, and the viewer's
/// address.
pub const LOGS_SHOWN: &str = "warn,tremie_viewer=info";

/// A component that `tremie` carries in its own executable.
pub struct BuiltIn {
    /// Its name in manifests.
    pub name: &'static str,
    /// Role that it can take.
    pub role: Role,
    /// Description, in a line.
    pub about: &'static str,
    /// The schema of its settings.
    pub settings: fn(&mut SchemaGenerator) -> Schema,
    /// Takes part in a run.
    pub run: fn(ControlPipe) -> Result<(), String>,
    /// Benchmarks that it brings along.
    pub benchmarks: fn(&BenchmarkSizes) -> Vec<Benchmark>,
}

/// All built-in components.
pub const BUILT_IN: &[BuiltIn] = &[
    BuiltIn {
        name: "fluid-lbm",
        role: Role::Fluid,
        about: "lattice Boltzmann, D3Q19: parts, open faces, moving spheres and parts",
        settings: SchemaGenerator::subschema_for::<tremie_fluid_lbm::Parameters>,
        run: tremie_fluid_lbm::component::run,
        benchmarks: tremie_fluid_lbm::benchmarks,
    },
    BuiltIn {
        name: "fluid-pic",
        role: Role::Fluid,
        about: "particle in cell: free surface, cut cells, bodies in the pressure's solution",
        settings: SchemaGenerator::subschema_for::<tremie_fluid_pic::Parameters>,
        run: tremie_fluid_pic::component::run,
        benchmarks: tremie_fluid_pic::benchmarks,
    },
    BuiltIn {
        name: "fluid-wavelet",
        role: Role::Fluid,
        about: "compressible gas on adaptive wavelets: shocks, wakes, moving bodies",
        settings: SchemaGenerator::subschema_for::<tremie_fluid_wavelet::Parameters>,
        run: tremie_fluid_wavelet::component::run,
        benchmarks: tremie_fluid_wavelet::benchmarks,
    },
    BuiltIn {
        name: "grains-dem",
        role: Role::Grains,
        about: "discrete elements: spheres, walls and parts, friction",
        settings: SchemaGenerator::subschema_for::<tremie_grains_dem::Parameters>,
        run: tremie_grains_dem::component::run,
        benchmarks: tremie_grains_dem::benchmarks,
    },
    BuiltIn {
        name: "grains-hard-sphere",
        role: Role::Grains,
        about: "hard spheres: collisions without duration, from event to event or from step to step",
        settings: SchemaGenerator::subschema_for::<tremie_grains_hard_sphere::Parameters>,
        run: tremie_grains_hard_sphere::component::run,
        benchmarks: tremie_grains_hard_sphere::benchmarks,
    },
    BuiltIn {
        name: "rubber-table",
        role: Role::Rubber,
        about: "seals of rubber by a table of force and shapes",
        settings: SchemaGenerator::subschema_for::<tremie_rubber_table::Parameters>,
        run: tremie_rubber_table::component::run,
        benchmarks: no_benchmarks,
    },
    BuiltIn {
        name: "viewer",
        role: Role::Observer,
        about: "streams the run into the Rerun viewer",
        settings: SchemaGenerator::subschema_for::<tremie_viewer::Parameters>,
        run: tremie_viewer::run,
        benchmarks: no_benchmarks,
    },
    BuiltIn {
        name: "recorder",
        role: Role::Observer,
        about: "writes the run to an MCAP file",
        settings: SchemaGenerator::subschema_for::<tremie_recorder::Parameters>,
        run: tremie_recorder::run,
        benchmarks: no_benchmarks,
    },
    BuiltIn {
        name: "fields",
        role: Role::Observer,
        about: "writes whole fields, bodies and parts for ParaView (VTK)",
        settings: SchemaGenerator::subschema_for::<tremie_fields::Parameters>,
        run: tremie_fields::run,
        benchmarks: no_benchmarks,
    },
    BuiltIn {
        name: "profiles",
        role: Role::Observer,
        about: "writes the tables of profiles of grains (CSV, NumPy)",
        settings: SchemaGenerator::subschema_for::<tremie_profiles::Parameters>,
        run: tremie_profiles::run,
        benchmarks: no_benchmarks,
    },
];

/// Program that stands for a component where another is replayed.
pub const PLAYER: &str = "player";

/// Components that no manifest names: the player, which takes any role of the physics, and those that
/// compute nothing, for `tremie bench`.
const HIDDEN: &[BuiltIn] = &[
    BuiltIn {
        name: PLAYER,
        role: Role::Fluid,
        about: "sends what a component sent in a recorded run",
        settings: SchemaGenerator::subschema_for::<()>,
        run: tremie_recorder::run_player,
        benchmarks: no_benchmarks,
    },
    BuiltIn {
        name: "idle-fluid",
        role: Role::Fluid,
        about: "finds no loads",
        settings: SchemaGenerator::subschema_for::<()>,
        run: tremie_sdk::idle::run_fluid,
        benchmarks: no_benchmarks,
    },
    BuiltIn {
        name: "idle-grains",
        role: Role::Grains,
        about: "never move",
        settings: SchemaGenerator::subschema_for::<()>,
        run: tremie_sdk::idle::run_grains,
        benchmarks: no_benchmarks,
    },
];

fn no_benchmarks(_: &BenchmarkSizes) -> Vec<Benchmark> {
    Vec::new()
}

/// A program of the project that is not part of this one.
struct Fellow {
    name: &'static str,
    /// Component whose settings are its own, too.
    settings_of: &'static str,
    /// Words on how to get it.
    how_to_build: &'static str,
}

const FELLOWS: &[Fellow] = &[Fellow {
    name: "fluid-lbm-mpi",
    settings_of: "fluid-lbm",
    how_to_build: "it needs an MPI and libclang (Debian: libopenmpi-dev openmpi-bin libclang-dev); then \
                   cargo build --release -p tremie-fluid-lbm-mpi --features mpi",
}];

/// Component whose settings are also those of a program, if there is one.
pub fn settings_shared_with(program: &str) -> Option<&'static str> {
    FELLOWS.iter().find(|fellow| fellow.name == program).map(|fellow| fellow.settings_of)
}

/// Words on how to get a program of the project that is not there.
pub fn how_to_build(program: &str) -> Option<&'static str> {
    FELLOWS.iter().find(|fellow| fellow.name == program).map(|fellow| fellow.how_to_build)
}

/// The built-in component of that name.
pub fn built_in(name: &str) -> Option<&'static BuiltIn> {
    BUILT_IN.iter().chain(HIDDEN).find(|component| component.name == name)
}

/// A command that a package adds to the program.
pub struct PackageCommand<Work> {
    /// Its name on the command line.
    pub name: &'static str,
    /// Description, in a line.
    pub about: &'static str,
    /// Adds its arguments.
    pub arguments: fn(Command) -> Command,
    /// Carries the command out, and gives the text for standard output.
    pub work: Work,
}

/// Work on arguments alone.
pub type OnArguments = fn(&ArgMatches) -> Result<String, CommandError>;
/// Work on runs that have ended, one or more, and arguments.
pub type OnRuns = fn(&[FinishedRun], &ArgMatches) -> Result<String, CommandError>;

/// Scenes that are built from numbers: `tremie scene NAME FOLDER`.
pub const SCENES: &[PackageCommand<OnArguments>] = &[
    PackageCommand {
        name: "pressure-valve",
        about: "A spring-loaded valve with a rubber seal, beside a conduit",
        arguments: pressure_valve::scene::SceneArgs::augment_args,
        work: pressure_valve::scene::build_pressure_valve,
    },
    PackageCommand {
        name: "safety-valve",
        about: "The same valve beside a conduit that goes on, behind an orifice: it opens at high flow rates",
        arguments: pressure_valve::scene::SceneArgs::augment_args,
        work: pressure_valve::scene::build_safety_valve,
    },
];

/// Readers of finished runs: `tremie NAME OUT...`.
pub const READERS: &[PackageCommand<OnRuns>] = &[PackageCommand {
    name: "valve",
    about: "Read a valve out of a finished run: when it cracks and reseats, its flow coefficient, forces, what is stuck",
    arguments: pressure_valve::results::ValveArgs::augment_args,
    work: pressure_valve::results::read,
}];

/// Commands of components: `tremie NAME ...`.
pub const TOOLS: &[PackageCommand<OnArguments>] = &[PackageCommand {
    name: "rubber",
    about: "Make or import the table of a rubber seal",
    arguments: tremie_rubber_table::commands::RubberCommand::augment_subcommands,
    work: tremie_rubber_table::commands::rubber,
}];
