//! Boundaries of the fluid: faces of the domain and static solids, with the conditions that they
//! prescribe.

use crate::boundary::face_scheme::{FaceCell, FaceScheme};
use crate::boundary::face_schemes::{FaceSite, scheme_of};
use crate::boundary::open_area::OpenAreas;
use crate::boundary::post_collision::nearest_wall;
use crate::boundary::sheet_links::{SheetItem, SheetLinks};
use crate::boundary::static_wall_links::{self, StaticWallLinks};
use crate::boundary::virtual_piston::face::ReservoirFace;
use crate::boundary::virtual_piston::part_surface::ReservoirSurface;
use crate::boundary::wall_distances::WallDistances;
use crate::boundary::wall_mass::Patches;
use crate::domain::boundary_condition::BoundaryCondition;
use crate::domain::link_meeting::meet;
use crate::domain::parameters::{OpenFaces, Parameters, Walls};
use crate::lattice::aa_pattern::{Blocked, Reflection};
use crate::lattice::cell_list::BoundaryId;
use crate::lattice::held_blocks::HeldBlocks;
use crate::lattice::layout::Layout;
use crate::lattice::populations::Real;
use crate::lattice::units::Units;
use crate::ranks::rank_sums::Ranks;
use std::sync::Arc;
use tremie_fluid_kit::cells::centres::Centres;
use tremie_fluid_kit::cells::obstacles::Obstacles;
use tremie_fluid_kit::survey::displaced_volume::Displaced;
use tremie_fluid_kit::survey::mirrors::mirrors_of_part;
use tremie_fluid_kit::survey::solids::Solid;
use tremie_fluid_kit::survey::static_geometry::StaticGeometry;
use tremie_geometry::Surface;
use tremie_messages::scene::{Face, PartBoundary, Scene};

/// Faces of the domain and static solids.
pub struct Boundaries {
    ground: StaticGeometry,
    halfway: bool,
    /// Least wall distance of curved walls [links], see [`nearest_wall`].
    nearest: f64,
    /// The scene's faces, `2 axis + side`, and the scheme of those that prescribe velocity or
    /// pressure.
    faces: Vec<Face>,
    scheme: OpenFaces,
    units: Units,
    /// Surfaces of the parts that move, by index of the part.
    pub moving: Vec<Option<Arc<Surface>>>,
    /// For each fixture what it prescribes; `None` for a face that prescribes nothing.
    pub laws: Vec<Option<BoundaryCondition>>,
    /// For each fixture the point about which its torque counts [cells].
    pub references: Vec<[f64; 3]>,
    /// For each fixture what it displaces, about that point [cells].
    pub displaced: Vec<Displaced>,
}

/// Layout, links and faces made from the surroundings, for cells in lines of a given length.
pub struct Built<T: Real> {
    /// Cells and places.
    pub layout: Layout,
    /// Links that need no work.
    pub reflections: Vec<Reflection>,
    /// Links that do.
    pub fixed: StaticWallLinks,
    /// Their items of work.
    pub fixed_items: Vec<static_wall_links::WallItem>,
    /// Those of them that solids cut between two cells of the fluid.
    pub sheets: SheetLinks,
    pub sheet_items: Vec<SheetItem>,
    /// The patches of wall that pay back what these links take.
    pub patches: Patches,
    /// Links at walls at rest that are met half-way, by cell.
    pub halfway: Vec<Blocked>,
    /// Open faces but for those with a reservoir.
    pub faces: Vec<Box<dyn FaceScheme<T>>>,
    /// Faces with a reservoir.
    pub reservoirs: Vec<ReservoirFace>,
    /// Surfaces of parts with a reservoir.
    pub surfaces: Vec<ReservoirSurface>,
}

impl Boundaries {
    /// Of a scene and its geometry in cells.
    pub fn new(
        scene: &Scene,
        mut ground: StaticGeometry,
        parameters: &Parameters,
        units: &Units,
    ) -> Self {
        let mut laws: Vec<_> = scene
            .domain
            .faces
            .iter()
            .flatten()
            .map(|face| BoundaryCondition::of_face(face, units))
            .collect();
        let mut references = vec![[0.0; 3]; laws.len()];
        let mut displaced = vec![Displaced::default(); laws.len()];
        let centres = Centres { cell: units.cell, min: units.min };
        for solid in &ground.solids {
            laws.push(Some(BoundaryCondition::of_part(&solid.boundary, units)));
            let reference = units.position_to_lattice(solid.reference);
            references.push(reference);
            let mirrors = mirrors_of_part(&ground.grid, reference);
            let Displaced { volume, moment } = solid.displaced(&ground.grid, &centres, mirrors);
            let cube = units.cell * units.cell * units.cell;
            displaced.push(Displaced {
                volume: volume.map(|v| v / cube),
                moment: moment.map(|moment| moment.map(|m| m / (cube * units.cell))),
            });
        }
        // Cells to which no way leads count as one more solid, which no link meets.
        laws.push(None);
        references.push([0.0; 3]);
        displaced.push(Displaced::default());
        let moving = std::mem::take(&mut ground.moving);
        let halfway = parameters.walls == Walls::Halfway;
        let nu = scene.fluid.as_ref().map_or(0.0, |fluid| fluid.viscosity / fluid.density);
        let nearest = nearest_wall(parameters.tau_of(units.time_step, nu));
        let units = *units;
        Self {
            ground,
            halfway,
            nearest,
            faces: scene.domain.faces.iter().flatten().cloned().collect(),
            scheme: parameters.open_faces,
            units,
            moving,
            laws,
            references,
            displaced,
        }
    }

    /// The static geometry.
    pub fn ground(&self) -> &StaticGeometry {
        &self.ground
    }

    /// The parts that stand still: number of the fixture, and index into the scene's parts.
    pub fn parts(&self) -> impl Iterator<Item = (usize, usize)> {
        let first = usize::from(BoundaryId::FACES);
        let solids = self.ground.solids.iter().enumerate();
        solids.filter_map(move |(k, solid)| Some((first + k, solid.part?)))
    }

    /// True if a fixture's links need work besides reflection half-way.
    fn is_special(&self, fixture: BoundaryId) -> bool {
        let moves = |law: &BoundaryCondition| !law.is_at_rest();
        fixture.as_solid().is_some_and(|solid| solid != self.ground.solids.len())
            || self.laws[usize::from(fixture.0)].as_ref().is_some_and(moves)
    }

    fn obstacles(&self) -> &Obstacles {
        &self.ground.voxels.obstacles
    }

    /// Lays out the cells, and finds all links and cells that need work.
    /// A rank that does not compute them alone has those of its `window`.
    pub fn build<T: Real>(&mut self, ranks: &mut Ranks, window: Option<&HeldBlocks>) -> Built<T> {
        let special = |fixture| self.is_special(fixture);
        // Cells that other ranks hold are as those to which no way leads.
        let beyond = BoundaryId::solid(self.ground.solids.len() as u16);
        let holds = |cell: u32| window.is_none_or(|window| window.holds(cell));
        let (grid, held) = (self.ground.grid.clone(), (holds, beyond));
        let (mut layout, survey) = Layout::new(grid, self.obstacles(), T::LINE, special, held);
        if let Some(window) = window {
            layout.own = window.own_cells(layout.cells.len());
        }
        let is_open = |fixture: BoundaryId| {
            fixture.as_solid().is_none()
                && !matches!(
                    self.laws[usize::from(fixture.0)],
                    Some(BoundaryCondition::Wall { .. })
                )
        };
        let (open, fixed): (Vec<_>, Vec<_>) =
            survey.blocked.into_iter().partition(|blocked| is_open(blocked.fixture));
        let met = fixed.iter().map(|blocked| {
            let (met, q) = self.meet(&layout, blocked);
            (met, if self.halfway { 0.5 } else { q.max(self.nearest) })
        });
        let met: Vec<_> = met.collect();
        // Sheets and open areas need all links at solids, so they come before `met` is split.
        let (sheets, sheet_items) =
            SheetLinks::new(&layout, &met, |fixture| self.laws[usize::from(fixture.0)].clone());
        let areas = self.open_areas(&layout, &open, &met);
        let (faces, reservoirs) = self.open_faces(&layout, &open, &areas, ranks);
        let (surfaces, met) = self.reservoir_surfaces(&layout, met, ranks);
        let is_at_rest = |met: &Blocked| {
            self.laws[usize::from(met.fixture.0)]
                .as_ref()
                .is_some_and(BoundaryCondition::is_at_rest)
        };
        let (halfway, fixed): (Vec<_>, Vec<_>) =
            met.into_iter().partition(|(met, q)| *q == 0.5 && is_at_rest(met));
        let halfway = halfway.into_iter().map(|(met, _)| met).collect();
        let is_wall = |fixture: BoundaryId| {
            let law = &self.laws[usize::from(fixture.0)];
            fixture.as_solid().is_some() && matches!(law, Some(BoundaryCondition::Wall { .. }))
        };
        let (fixed, fixed_items, mut patches) = StaticWallLinks::new(
            &layout,
            &self.references,
            &sheets.ends(),
            fixed.into_iter(),
            is_wall,
        );
        patches.share(&fixed_items, ranks);
        Built {
            layout,
            reflections: survey.reflections,
            fixed,
            fixed_items,
            sheets,
            sheet_items,
            patches,
            halfway,
            faces,
            reservoirs,
            surfaces,
        }
    }

    /// The surfaces of parts with a reservoir, and the links that end at something else.
    fn reservoir_surfaces(
        &self,
        layout: &Layout,
        met: Vec<(Blocked, f64)>,
        ranks: &mut Ranks,
    ) -> (Vec<ReservoirSurface>, Vec<(Blocked, f64)>) {
        let is_reservoir = |(met, _): &(Blocked, f64)| {
            let law = &self.laws[usize::from(met.fixture.0)];
            matches!(law, Some(BoundaryCondition::Reservoir))
        };
        let (links, met): (Vec<_>, Vec<_>) = met.into_iter().partition(is_reservoir);
        let mirrors = self.faces.chunks(2).filter(|pair| pair.contains(&Face::Symmetry)).count();
        let mut surface = |(number, solid): (usize, &Solid)| {
            let PartBoundary::Reservoir(reservoir) = &solid.boundary else { return None };
            let fixture = BoundaryId::solid(number as u16);
            let own = |&(link, _): &(Blocked, f64)| (link.fixture == fixture).then_some(link);
            let links: Vec<Blocked> = links.iter().filter_map(own).collect();
            let own = (solid.part?, fixture);
            let reservoir = (reservoir, mirrors);
            Some(ReservoirSurface::new(layout, own, &links, reservoir, (&self.units, ranks)))
        };
        (self.ground.solids.iter().enumerate().filter_map(&mut surface).collect(), met)
    }

    /// Open areas of the cells at faces that prescribe a velocity, from the links that open faces
    /// block and those that meet a solid at rest. Walls half-way between cells cross no cell: the
    /// list is empty then.
    fn open_areas(&self, layout: &Layout, open: &[Blocked], met: &[(Blocked, f64)]) -> OpenAreas {
        if self.halfway {
            return OpenAreas::default();
        }
        let at_velocity = open.chunk_by(|a, b| a.cell == b.cell).filter_map(|links| {
            let cell = links[0].cell;
            let (axis, side) = layout.grid.open_faces(layout.at(cell)).next()?;
            let law = &self.laws[2 * axis + side];
            matches!(law, Some(BoundaryCondition::Velocity { .. })).then_some((cell, axis))
        });
        OpenAreas::new(&self.ground, layout, at_velocity, met)
    }

    /// Fixture that a blocked link meets first, and the wall distance `q`.
    fn meet(&self, layout: &Layout, blocked: &Blocked) -> (Blocked, f64) {
        match blocked.fixture.as_solid() {
            None => (*blocked, 0.5),
            Some(_) => meet(&self.ground, layout.at(blocked.cell), blocked),
        }
    }

    /// Wall distances of the links of cells to solids at rest.
    pub fn wall_distances(
        &self,
        layout: &Layout,
        ends: impl Iterator<Item = (u32, u8)>,
    ) -> WallDistances {
        let solid = BoundaryId::solid(self.ground.solids.len() as u16);
        let mut ends: Vec<_> = ends.collect();
        ends.sort_unstable();
        let links = ends.into_iter().map(|(cell, dir)| Blocked { cell, dir, fixture: solid });
        WallDistances::new(links.map(|link| self.meet(layout, &link)))
    }

    /// The schemes of open faces, and those with a reservoir, of the links that open faces block.
    fn open_faces<T: Real>(
        &self,
        layout: &Layout,
        blocked: &[Blocked],
        areas: &OpenAreas,
        ranks: &mut Ranks,
    ) -> (Vec<Box<dyn FaceScheme<T>>>, Vec<ReservoirFace>) {
        let (mut schemes, mut reservoirs) = (Vec::new(), Vec::new());
        for (number, face) in self.faces.iter().enumerate().filter(|(_, face)| face.is_open()) {
            let cells = FaceCell::of_face(layout, number, blocked);
            if let Face::Reservoir(reservoir) = face {
                let with = (&self.units, &mut *ranks);
                reservoirs.push(ReservoirFace::new(layout, number, cells, reservoir, with));
                continue;
            }
            let condition = self.laws[number].as_ref();
            let site = FaceSite { layout, number, cells, condition, areas, scheme: self.scheme };
            schemes.push(scheme_of(face, site));
        }
        (schemes, reservoirs)
    }
}
