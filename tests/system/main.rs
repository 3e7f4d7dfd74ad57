//! Whole runs of the `tremie` program, by scenario.

mod alone;
mod answers;
mod bad_input;
mod conform;
mod coupling;
mod doctor;
mod endings;
mod examples;
mod faults;
mod fields;
mod inlets;
mod memory;
mod observers;
mod outputs;
mod polyhedra;
mod report;
mod resident;
mod rubber;
mod running;
mod same_bits;
mod scenes;
mod signals;
mod sliders;
mod starting;
mod tremie;
mod validation;
