//! Surfaces by scenario: shapes against formulas, files, what is mended and what is refused,
//! questions against brute force, edges and corners.

mod bodies;
mod cavities;
mod convex;
mod endless;
mod features;
mod files;
mod mending;
mod questions;
mod shapes;
mod texts;
mod turned;
mod union;
