//! The static geometry of a scene in cells, checked.

use crate::cells::centres::Centres;
use crate::cells::grid::{Grid, Side};
use crate::cells::links::Links;
use crate::probes::sampling::samples;
use crate::survey::leak::narrowest;
use crate::survey::solids::{Solid, moving_solids, moving_surfaces, solids};
use crate::survey::voxels::Voxels;
use std::sync::Arc;
use tremie_geometry::Surface;
use tremie_messages::Problem;
use tremie_messages::finding::short;
use tremie_messages::scene::{Face, Scene};

/// Axes of a box of cells whose scene was turned so that they lie along others than the world's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridAxes {
    /// The axes in the order of the world's.
    pub order: [usize; 3],
    /// Orientation of a frame that is not turned in the world, a unit quaternion `(x, y, z, w)`.
    pub upright: [f64; 4],
}

impl GridAxes {
    /// Along the world's.
    pub const WORLD: Self = Self { order: [0, 1, 2], upright: [0.0, 0.0, 0.0, 1.0] };
}

/// The static geometry of a scene in cells.
pub struct StaticGeometry {
    /// The box.
    pub grid: Grid,
    /// Its solids.
    pub solids: Vec<Solid>,
    /// Cells that the solids cover.
    pub voxels: Voxels,
    /// Surfaces of the parts that move, by index of the part.
    pub moving: Vec<Option<Arc<Surface>>>,
    /// Orientation of a frame that is not turned in the world, a unit quaternion `(x, y, z, w)`.
    pub upright: [f64; 4],
    centres: Centres,
    /// Number of links that surfaces cut between two cells of the fluid, at the start, and the
    /// names of what cuts them.
    cut: (usize, Vec<String>),
}

/// Kinds of the faces of the box of cells.
pub fn sides(scene: &Scene) -> [[Side; 2]; 3] {
    scene.domain.faces.each_ref().map(|faces| {
        faces.each_ref().map(|face| match face {
            Face::Periodic => Side::Periodic,
            Face::Wall { .. } => Side::Wall,
            Face::Symmetry => Side::Symmetry,
            Face::Velocity(_) | Face::Pressure { .. } | Face::Reservoir(_) => Side::Open,
        })
    })
}

impl StaticGeometry {
    /// Of a scene in a box of `cells` cells with edges of `cell` [m], both by the given axes; fluid
    /// gets from cell to cell by `links`.
    ///
    /// # Errors
    /// Surfaces that cannot be had, points inside that are not in the fluid, leaks.
    pub fn new(
        scene: &Scene,
        axes: GridAxes,
        links: Links,
        cells: [usize; 3],
        cell: f64,
    ) -> Result<Self, Vec<Problem>> {
        let grid = Grid::new(cells, sides(scene)).ordered(axes.order);
        let centres = Centres { cell, min: scene.domain.min };
        let (solids, moving) = match (solids(scene, cell), moving_surfaces(scene)) {
            (Ok(solids), Ok(moving)) => (solids, moving),
            (still, moving) => {
                let problems = [still.err(), moving.err()];
                return Err(problems.into_iter().flatten().flatten().collect());
            }
        };
        let fluid = scene.fluid.as_ref().expect("a scene that was checked has a fluid");
        let mut problems = Vec::new();
        let mut points = |key: &str, points: &[[f64; 3]]| -> Vec<[i32; 3]> {
            let mut found = Vec::new();
            for (k, point) in points.iter().enumerate() {
                match cell_of(&grid, &centres, *point) {
                    Some(at) => found.push(at),
                    None => problems.push(Problem::new(
                        format!("scene.fluid.{key}[{k}]"),
                        format!("{} lies outside the domain", text(*point)),
                    )),
                }
            }
            found
        };
        let (inside, outside) =
            (points("inside", &fluid.inside), points("outside", &fluid.outside));
        // A point outside the domain has no cell that could be asked below.
        if !problems.is_empty() {
            return Err(problems);
        }
        let voxels = Voxels::new(&grid, links, &centres, &solids, &inside);
        let of_moving = moving_solids(scene, cell, &moving);
        let cut = cut_links(&grid, &centres, &voxels, [&solids, &of_moving]);
        let own = Self { grid, solids, voxels, moving, upright: axes.upright, centres, cut };
        for (k, at) in inside.iter().enumerate() {
            if !own.voxels.is_fluid(&own.grid, *at) {
                problems.push(own.not_fluid(k, fluid.inside[k], *at));
            }
        }
        for (k, at) in outside.iter().enumerate() {
            problems.extend(own.leak(k, fluid.outside[k], &inside, *at));
        }
        for (k, probe) in scene.probes.iter().enumerate() {
            let cells = samples(&own.grid, &own.centres, &probe.shape);
            if !cells.iter().any(|&(at, _)| own.voxels.is_fluid(&own.grid, at)) {
                problems.push(
                    Problem::new(
                        format!("scene.probes[{k}]"),
                        format!("{} lies on no cell of the fluid", probe.name),
                    )
                    .help("move it into the fluid, or make it larger than a cell"),
                );
            }
        }
        if own.voxels.fluid == 0 {
            problems.push(
                Problem::new("scene.fluid", "no cell is left for the fluid: solids cover them all")
                    .help("a part that is a hollow needs `cavity`"),
            );
        }
        if problems.is_empty() { Ok(own) } else { Err(problems) }
    }

    /// A point inside that is in a solid.
    fn not_fluid(&self, k: usize, point: [f64; 3], at: [i32; 3]) -> Problem {
        let solid = usize::from(self.voxels.obstacles.solid[self.grid.index(at)]) - 1;
        let name = self.solids.get(solid).map_or("nothing", |solid| solid.name.as_str());
        Problem::new(
            format!("scene.fluid.inside[{k}]"),
            format!("{} is not in the fluid: the cell there is in {name}", text(point)),
        )
        .help("move the point, or make the part a `cavity` if its inside is the space of the fluid")
    }

    /// A leak to the point outside, if there is one.
    fn leak(&self, k: usize, point: [f64; 3], from: &[[i32; 3]], to: [i32; 3]) -> Option<Problem> {
        let start: Vec<usize> = from.iter().map(|&at| self.grid.index(at)).collect();
        let end = self.grid.index(to);
        if from.is_empty() || self.voxels.obstacles.solid[end] != 0 {
            return None;
        }
        let found =
            narrowest(&self.grid, self.voxels.links, &self.voxels.obstacles, &start, &[end])?;
        let place = self.centres.of(found.at);
        let mut near: Vec<(f64, &str)> =
            self.solids.iter().map(|solid| (solid.distance(place), solid.name.as_str())).collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        let between = match near.as_slice() {
            [] => String::new(),
            [(_, one)] => format!(", at {one}"),
            [(_, one), (_, other), ..] => format!(", between {one} and {other}"),
        };
        Some(
            Problem::new(
                format!("scene.fluid.outside[{k}]"),
                format!(
                    "the fluid leaks to {}; the widest way there is narrowest at {}, about {:.0} {} \
                     ({} m) wide{between}",
                    text(point),
                    text(place),
                    found.width,
                    if found.width.round() == 1.0 { "cell" } else { "cells" },
                    short(found.width * self.centres.cell)
                ),
            )
            .help("close the gap in the geometry, or choose cells larger than it"),
        )
    }

    /// Of a scene in cells of 1 m that fluid crosses by their faces.
    #[cfg(test)]
    pub fn in_unit_cells(scene: &Scene) -> Self {
        let cells = scene.domain.size().map(|length| length.round() as usize);
        let made = Self::new(scene, GridAxes::WORLD, Links::FACES, cells, 1.0);
        made.unwrap_or_else(|problems| panic!("{problems:?}"))
    }

    /// Surfaces of all parts, with the index of each: first those that stand still.
    pub fn part_surfaces(&self) -> impl Iterator<Item = (usize, &Surface)> {
        let still = self.solids.iter().filter_map(|solid| Some((solid.part?, solid.surface()?)));
        let moving = self.moving.iter().enumerate();
        still.chain(moving.filter_map(|(part, surface)| Some((part, surface.as_deref()?))))
    }

    /// Number of triangles of all parts.
    pub fn triangles(&self) -> u64 {
        self.part_surfaces().map(|(_, surface)| surface.mesh().triangles.len() as u64).sum()
    }

    /// The centres of its cells.
    pub fn centres(&self) -> Centres {
        self.centres
    }

    /// True if no solid covers the cell at a place [m], which may lie beyond periodic faces; false
    /// outside the domain.
    pub fn is_fluid_at(&self, place: [f64; 3]) -> bool {
        let at: [i32; 3] = std::array::from_fn(|a| {
            let k = ((place[a] - self.centres.min[a]) / self.centres.cell).floor();
            self.grid.wrap(a, k.clamp(-1e9, 1e9) as i32)
        });
        self.grid.contains(at) && self.voxels.is_fluid(&self.grid, at)
    }

    /// Notes for a user on the geometry; sentences.
    pub fn notes(&self) -> Vec<String> {
        let Voxels { fluid, unreached, regions, .. } = &self.voxels;
        let mut notes = Vec::new();
        if *fluid < self.grid.len() {
            let percent = 100.0 * *fluid as f64 / self.grid.len() as f64;
            notes.push(format!("{fluid} cells of {} are fluid ({percent:.0} %)", self.grid.len()));
        }
        if *unreached > 0 {
            notes.push(format!("{unreached} cells are no part of the fluid: no way leads there"));
        }
        if regions.len() > 1 {
            let rest: usize = regions[1..].iter().sum();
            notes.push(format!(
                "{} pockets of {rest} cells in all have no way to the rest of the fluid; \
                 points in `fluid.inside` would leave them out",
                regions.len() - 1
            ));
        }
        let (cut, names) = &self.cut;
        if *cut > 0 {
            notes.push(format!(
                "{cut} links between cells pass through walls or edges thinner than a cell, of {}; they end there",
                names.join(", ")
            ));
        }
        notes
    }
}

/// Number of links that solids at rest or moving cut between two cells of the fluid, and the names
/// of these solids.
fn cut_links(
    grid: &Grid,
    centres: &Centres,
    voxels: &Voxels,
    [still, moving]: [&[Solid]; 2],
) -> (usize, Vec<String>) {
    let of_moving =
        if moving.is_empty() { Vec::new() } else { voxels.sheets_of(grid, centres, moving) };
    let of_still = &voxels.obstacles.sheets;
    let mut names: Vec<_> = [(still, of_still), (moving, &of_moving)]
        .into_iter()
        .flat_map(|(solids, sheets)| {
            sheets.iter().map(|sheet| solids[usize::from(sheet.solid)].name.as_str())
        })
        .collect();
    names.sort_unstable();
    names.dedup();
    let mut ends: Vec<_> =
        of_still.iter().chain(&of_moving).map(|sheet| (sheet.cell, sheet.dir)).collect();
    ends.sort_unstable();
    ends.dedup();
    // Each link is there from both of its ends.
    (ends.len() / 2, names.into_iter().map(String::from).collect())
}

/// The cell that holds a point, if it is in the domain.
fn cell_of(grid: &Grid, centres: &Centres, point: [f64; 3]) -> Option<[i32; 3]> {
    let at = std::array::from_fn(|a| {
        let k = ((point[a] - centres.min[a]) / centres.cell).floor();
        // The upper face belongs to the last cell.
        if k == f64::from(grid.n[a]) { grid.n[a] - 1 } else { k.clamp(-1.0, 2e9) as i32 }
    });
    (point.iter().all(|x| x.is_finite()) && grid.contains(at)).then_some(at)
}

/// A point as text.
fn text([x, y, z]: [f64; 3]) -> String {
    format!("({}, {}, {}) m", short(x), short(y), short(z))
}
