//! Readers of other programs' files: a table's from CSV or CalculiX, a section's mesh from Gmsh.

pub mod csv;
pub mod frd;
pub mod gmsh;
