//! What every fluid on cells of Tremie needs, so that a new one is its equations and little else.
//!
//! | room | what a fluid gets |
//! | --- | --- |
//! | [`cells`] | the box of cells, its faces, the ways from cell to cell |
//! | [`survey`] | a scene in cells: solids, what moves, leaks, displaced volume |
//! | [`checks`] | findings on what is too small for its cells |
//! | [`probes`] | the cells that probes read, means over them, signals |
//! | [`bodies`] | the moving bodies by their ids, and within a window |
//! | [`observed`] | cuts and volumes for observers |
//! | [`window`] | loads as means over substeps, loads on parts, signals of parts and walls |
//!
//! Nothing here knows how a fluid works, or how messages travel. A probe reads a made-up fluid
//! whose velocity along x is its height:
//!
//! ```
//! use tremie_fluid_kit::cells::{centres::Centres, grid::{Grid, Side}};
//! use tremie_fluid_kit::probes::probe_plan::ProbePlan;
//! use tremie_messages::scene::{Probe, ProbeShape};
//! use tremie_team::Team;
//!
//! let grid = Grid::new([4, 4, 4], [[Side::Wall; 2]; 3]);
//! let centres = Centres { cell: 0.25, min: [0.0; 3] };
//! let shape = ProbeShape::Region { min: [0.0; 3], max: [1.0, 1.0, 0.5] };
//! let probes = [Probe { name: "below".into(), shape }];
//! let stored = |at| Some(grid.index(at) as u32);
//! let mut plan = ProbePlan::new(&probes, &grid, &centres, stored);
//! let mut team = Team::new("example", 1)?;
//! plan.measure(&mut team, |samples, sum| {
//!     for &(cell, weight) in samples {
//!         let height = centres.of(grid.at(cell as usize))[2];
//!         sum.add(weight, 0.0, [height, 0.0, 0.0]);
//!     }
//! });
//! plan.tell(|_, _, sum| assert_eq!(sum.mean(sum.velocity[0]), 0.25));
//! # Ok::<(), std::io::Error>(())
//! ```

#![warn(clippy::print_stdout, clippy::print_stderr)]

pub mod bodies;
pub mod cells;
pub mod checks;
pub mod observed;
pub mod probes;
pub mod survey;
pub mod window;
