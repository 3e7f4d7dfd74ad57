//! Whole runs of the `tremie` program, by scenario.

/// Tests of damaged input look at the memory that reading takes.
#[global_allocator]
static COUNTING: tremie_test_support::Counting = tremie_test_support::Counting;

mod alone;
mod answers;
mod bad_input;
mod branches;
mod cluster;
mod compare;
mod compressible_gas;
mod conform;
mod copied_inputs;
mod coupling;
mod damaged_manifests;
mod doctor;
mod endings;
mod endless;
mod endurance;
mod examples;
mod faults;
mod fields;
mod guide;
mod hard_spheres;
mod hazards;
mod inlets;
mod memory;
mod mounts;
mod new_scenes;
mod observers;
mod outputs;
mod particle_fluid;
mod polyhedra;
mod profiles;
mod ranks;
mod ranks_on_two_hosts;
mod replay;
mod report;
mod resident;
mod resume;
mod rubber;
mod running;
mod same_bits;
mod scenes;
mod several_studies;
mod signals;
mod sliders;
mod starting;
mod steering;
mod study;
mod tremie;
mod two_hosts;
mod validation;
mod watchdogs;
mod wrong;
