//! Scenes that are built from numbers: their parts as meshes, and a manifest to start from.
//!
//! Nothing about them is known to the solvers: what comes out is parts and a manifest like any other.

pub mod pressure_valve;
