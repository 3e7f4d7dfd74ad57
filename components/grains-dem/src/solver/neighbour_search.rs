//! The search for contacts: linked cells and the lists made from them.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::{Bodies, BoundingSphere};
use crate::bodies::placed_parts::PlacedPart;
use crate::neighbours::neighbour_list::NeighbourList;
use crate::neighbours::neighbour_list_build::{NeighbourListBuilder, PairSearch};
use crate::polyhedra::{self, PolyContacts, Polyhedra};
use crate::solver::interaction_context::InteractionContext;
use crate::walls::deformable_surfaces::Surfaces;
use crate::walls::part_contacts::PartContacts;
use crate::walls::part_finder;
use crate::walls::wall_contacts::{self, WallContacts};
use tremie_grains_kit::neighbours::linked_cells::LinkedCells;
use tremie_grains_kit::neighbours::size_classes::{Leash, Skins};
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_state::{StateError, StateExchange};
use tremie_team::{Cut, Team};

/// Bodies are put in order of space at every so many lists: in between they move by a diameter or
/// two.
const LISTS_PER_ORDER: u64 = 16;

/// Neighbour lists and the buffers to make them.
pub(crate) struct Search {
    /// Bodies by size and place.
    pub cells: LinkedCells,
    /// Contacts between bodies.
    pub pairs: NeighbourList,
    /// Contacts of bodies with walls.
    pub walls: WallContacts,
    /// Contacts of bodies with parts.
    pub parts: PartContacts,
    /// Surfaces that deform, and bodies near them.
    pub surfaces: Surfaces,
    /// Contacts of polyhedra.
    pub solids: PolyContacts,
    /// Number of lists made.
    pub rebuilds: u64,
    /// Forces on the walls at the last evaluation before the lists were made [N].
    on_walls: Vec<Vec3>,
    /// True if contacts were evaluated since then.
    pub evaluated: bool,
    maker: NeighbourListBuilder,
    spare_walls: WallContacts,
    spare_parts: PartContacts,
    found_walls: Vec<wall_contacts::FoundWalls>,
    found_parts: Vec<part_finder::FoundParts>,
    order: Vec<u32>,
    keys: Vec<(u64, u32)>,
    /// Places of bodies in memory when lists were made, if any body came or went since.
    pub moved: Option<Vec<u32>>,
}

/// The contacts of all bodies.
#[derive(Clone, Copy)]
pub(crate) struct Contacts<'a> {
    pub pairs: &'a NeighbourList,
    pub walls: &'a WallContacts,
    pub parts: &'a PartContacts,
    pub surfaces: &'a Surfaces,
    pub solids: &'a PolyContacts,
}

impl Search {
    /// For up to so many bodies of classes of sizes, and surfaces that deform.
    pub fn new(bounds: PeriodicBox, skins: Skins, bodies: usize, surfaces: Surfaces) -> Self {
        Self {
            cells: LinkedCells::new(bounds, skins),
            pairs: NeighbourList::default(),
            walls: WallContacts::default(),
            parts: PartContacts::default(),
            surfaces,
            solids: PolyContacts::default(),
            rebuilds: 0,
            on_walls: Vec::new(),
            evaluated: false,
            maker: NeighbourListBuilder::default(),
            spare_walls: WallContacts::default(),
            spare_parts: PartContacts::default(),
            found_walls: Vec::new(),
            found_parts: Vec::new(),
            order: Vec::with_capacity(bodies),
            keys: Vec::with_capacity(bodies),
            moved: None,
        }
    }

    /// Keeps the lists with what contacts remember, or puts them back, for bodies and
    /// parts that are back already.
    pub fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        team: &mut Team,
        (bodies, around): (&Bodies, &InteractionContext),
    ) -> Result<(), StateError> {
        self.pairs.forget_ended();
        state.value("pairs", &mut self.pairs)?;
        state.value("walls", &mut self.walls)?;
        state.value("parts", &mut self.parts)?;
        state.value("solids", &mut self.solids)?;
        state.value("lists_made", &mut self.rebuilds)?;
        state.value("on_walls", &mut self.on_walls)?;
        state.value("evaluated", &mut self.evaluated)?;
        state.value("moved", &mut self.moved)?;
        if state.restores() {
            // Classes of sizes are those of the bodies in their order in memory.
            self.cells.sort(&bodies.balls);
            self.pairs.find_acting(team);
        }
        self.surfaces.exchange(state, &around.near_surfaces(bodies, self.cells.skins()))
    }

    /// Classes of sizes, and their skins.
    pub fn skins(&self) -> &Skins {
        self.cells.skins()
    }

    /// Limit of the displacements of bodies until lists are due.
    pub fn leash(&self) -> Leash<'_> {
        Leash::new(self.cells.skins(), self.cells.classes())
    }

    /// The lists.
    pub fn contacts(&self) -> Contacts<'_> {
        let Self { pairs, walls, parts, surfaces, solids, .. } = self;
        Contacts { pairs, walls, parts, surfaces, solids }
    }

    /// Says whether the virials of contacts with parts are ever asked for.
    pub fn measure_parts(&mut self, is_measurable: bool) {
        for list in [&mut self.parts, &mut self.spare_parts] {
            list.measure(is_measurable);
        }
    }

    /// Forces on all walls, so many, at the last evaluation [N].
    pub fn wall_forces(&self, walls: usize, out: &mut Vec<Vec3>) {
        out.clear();
        if self.evaluated {
            out.resize(walls, Vec3::zeros());
            self.walls.add_forces(out);
            self.parts.add_wall_forces(out);
            self.solids.add_wall_forces(out);
        } else {
            out.extend(&self.on_walls);
            out.resize(walls, Vec3::zeros());
        }
    }

    /// Puts bodies into the order of memory that serves best, now and then, and tells where each
    /// stood when the lists at hand were made; whether any had come or gone since.
    fn order(&mut self, bodies: &mut Bodies) -> bool {
        self.cells.sort(&bodies.balls);
        if self.rebuilds.is_multiple_of(LISTS_PER_ORDER) {
            self.cells.curve(&bodies.balls, &mut self.keys, &mut self.order);
            bodies.reorder(&self.order);
            self.cells.sort(&bodies.balls);
        } else {
            self.order.clear();
            self.order.extend(0..bodies.len() as u32);
        }
        let Some(moved) = self.moved.take() else { return false };
        self.order.iter_mut().for_each(|place| *place = moved[*place as usize]);
        true
    }

    /// Makes the lists anew; contacts keep their history.
    pub fn rebuild(
        &mut self,
        team: &mut Team,
        bodies: &mut Bodies,
        polyhedra: &mut Polyhedra,
        around: &mut InteractionContext,
    ) {
        let mut on_walls = std::mem::take(&mut self.on_walls);
        // New lists hold no forces on walls: those of the last evaluation are kept.
        if self.evaluated {
            self.wall_forces(around.walls.len(), &mut on_walls);
        }
        (self.on_walls, self.evaluated) = (on_walls, false);
        let moved = self.order(bodies);
        start_anew(team, bodies);
        let near = PairSearch {
            cells: &self.cells,
            shifts: &around.bounds.shifts,
            laws: &around.laws,
            previous: &self.order,
        };
        self.maker.make(&mut self.pairs, team, bodies, &near);
        let skins = self.cells.skins();
        std::mem::swap(&mut self.walls, &mut self.spare_walls);
        std::mem::swap(&mut self.parts, &mut self.spare_parts);
        let (walls, laws) = (&around.walls[..], &around.wall_laws);
        let near = part_finder::PartSearch {
            parts: &around.parts,
            walls,
            wall_laws: laws,
            walls_lean: around.walls_lean,
            surfaces: &self.surfaces,
            laws: &around.laws,
            materials: &around.part_materials,
            bounds: &around.bounds,
            skins,
            previous: &self.order,
        };
        // Parts before walls: a body near a part has its walls in the list of parts.
        let before = (&self.spare_parts, &self.spare_walls);
        self.parts.make(before, &mut self.found_parts, team, bodies, &near);
        let near = wall_contacts::WallSearch { walls, laws, skins, previous: &self.order };
        let (before, found) = ((&self.spare_walls, &self.spare_parts), &mut self.found_walls);
        self.walls.make(before, &self.parts, found, team, bodies, &near);
        let near = polyhedra::SolidSearch {
            walls,
            wall_laws: laws,
            parts: &around.parts,
            part_materials: &around.part_materials,
            laws: &around.laws,
            bounds: &around.bounds,
            skins,
        };
        self.solids.make(self.maker.solids(), polyhedra, bodies, &near);
        if moved {
            self.surfaces.follow(&self.order, &bodies.ids);
        }
        self.surfaces.spoil();
        around.parts.iter_mut().for_each(PlacedPart::begin_list);
        self.rebuilds += 1;
    }
}

/// Distances and crossings count from here on.
fn start_anew(team: &mut Team, bodies: &mut Bodies) {
    let pieces = (Cut::every(&mut bodies.reference, BLOCK), Cut::every(&mut bodies.crossed, BLOCK));
    let balls = &bodies.balls;
    team.for_pieces(pieces, |b, (reference, crossed): (&mut [Vec3], &mut [i32])| {
        crossed.fill(0);
        let balls: &[BoundingSphere] = &balls[b * BLOCK..b * BLOCK + reference.len()];
        for (reference, ball) in reference.iter_mut().zip(balls) {
            *reference = ball.x;
        }
    });
}
