//! Interaction partners of bodies: walls, parts, laws and lubrication.

use crate::bodies::body_arrays::Bodies;
use crate::bodies::deformable_surface::DeformableSurface;
use crate::bodies::placed_parts::PlacedPart;
use crate::contact::contact_force::Steps;
use crate::contact::linear_contact::LinearLaw;
use crate::contact::lubrication::Squeeze;
use crate::contact::material_laws::{self, Laws};
use crate::contact::plane_walls::{WallLaws, any_lean, laws_of_scene};
use crate::forces::pair_forces::ContactContext;
use crate::math::parameters::Parameters;
use crate::math::tally::Other;
use crate::walls::rigid_seat_contact::Seats;
use crate::walls::surface_contacts::SurfaceSurroundings;
use tremie_grains_kit::neighbours::size_classes::Skins;
use tremie_grains_kit::space::periodic::PeriodicBox;
use tremie_grains_kit::space::plane_walls::{self, Sliding, Wall};
use tremie_messages::scene::Scene;

/// Domain, walls, parts, and the laws between all of them and the bodies.
pub(crate) struct InteractionContext {
    /// The domain.
    pub bounds: PeriodicBox,
    /// Laws of materials.
    pub laws: Laws,
    /// Faces of the domain through which spheres leave: `(lower, upper)` by axis.
    pub ways_out: [[bool; 2]; 3],
    /// The walls.
    pub walls: Vec<Wall>,
    /// Axis and side of the faces of the domain that the first of them are.
    pub faces: Vec<(usize, usize)>,
    /// True if a body may touch two of the walls as one region.
    pub walls_lean: bool,
    /// Walls that are no symmetry planes.
    pub seat_walls: Vec<Wall>,
    /// Walls whose velocities change with time.
    sliding: Vec<Sliding>,
    /// Their laws.
    pub wall_laws: WallLaws,
    /// The parts.
    pub parts: Vec<PlacedPart>,
    /// Numbers of their materials.
    pub part_materials: Vec<u16>,
    /// The law of all contacts between bodies, where it is one and linear.
    pub one_law: Option<LinearLaw>,
    /// Lubrication, if there is any.
    pub squeeze: Option<Squeeze>,
    /// Reach of forces: largest gap of surfaces at which they act [m].
    reach: f64,
    /// Names of the walls for the user, and after them those of the parts.
    names: Vec<String>,
}

impl InteractionContext {
    /// Context of a scene with its parts placed, and with surfaces; `largest` is the diameter of
    /// the largest body [m].
    pub fn of_scene(
        scene: &Scene,
        parameters: &Parameters,
        parts: Vec<PlacedPart>,
        surfaces: &[DeformableSurface],
        largest: f64,
    ) -> Self {
        let mut laws = Laws::of_scene(scene, surfaces);
        let wall_laws = laws_of_scene(scene, &mut laws);
        let walls = plane_walls::of_scene(scene);
        let squeeze = Squeeze::of(scene, parameters);
        // Where no wall resists rolling either there is no room for its history.
        let plain = squeeze.is_none() && !laws.resist_rolling();
        let materials: Vec<u16> =
            scene.bodies.iter().map(|set| laws.material(&set.material)).collect();
        Self {
            bounds: PeriodicBox::new(&scene.domain),
            names: material_laws::surfaces(scene).into_iter().map(|surface| surface.name).collect(),
            part_materials: scene.parts.iter().map(|part| laws.material(&part.material)).collect(),
            one_law: if plain { laws.only(&materials) } else { None },
            laws,
            ways_out: [0, 1, 2].map(|axis| [0, 1].map(|side| scene.is_way_out(axis, side))),
            walls_lean: any_lean(&walls),
            faces: plane_walls::faces(scene).collect(),
            walls,
            seat_walls: plane_walls::without_mirrors(scene),
            sliding: plane_walls::sliding(scene).into_iter().filter(Sliding::changes).collect(),
            wall_laws,
            parts,
            reach: squeeze
                .map_or(0.0, |s| s.cutoff)
                .max(material_laws::longest_neck(scene, largest)),
            squeeze,
        }
    }

    /// Gives walls the velocities of a time [s].
    pub fn slide(&mut self, time: f64) {
        for sliding in &self.sliding {
            sliding.set(&mut self.walls, time);
            sliding.set(&mut self.seat_walls, time);
        }
    }

    /// Name for the user of the other side of a contact of two bodies, by their ids, and the id by
    /// which the contact is reported.
    pub fn name(&self, body: u64, other: Other, id: impl Fn(u32) -> u64) -> (u64, String) {
        match other {
            Other::Wall(wall) => (body, self.names[wall as usize].clone()),
            Other::Part(part) => (body, self.names[self.walls.len() + part as usize].clone()),
            Other::Surface(part) => {
                let carrier = &self.names[self.walls.len() + part as usize];
                (body, format!("the surface on {carrier}"))
            }
            Other::Body(other) => {
                let (low, high) = (body.min(id(other)), body.max(id(other)));
                (low, format!("body {high}"))
            }
        }
    }

    /// Surroundings of surfaces that deform; `skins` are those of the bodies' lists.
    pub fn near_surfaces<'a>(
        &'a self,
        bodies: &'a Bodies,
        skins: &'a Skins,
    ) -> SurfaceSurroundings<'a> {
        let seats = Seats { parts: &self.parts, walls: &self.seat_walls };
        SurfaceSurroundings { bodies, laws: &self.laws, seats, skins }
    }

    /// Input of the forces between bodies; `crossed` is true if any body crossed a periodic face
    /// since neighbours were listed.
    pub fn scenery<'a>(
        &'a self,
        bodies: &'a Bodies,
        crossed: bool,
        steps: Steps,
    ) -> ContactContext<'a> {
        ContactContext {
            laws: self.laws.laws(),
            shifts: &self.bounds.shifts,
            bodies,
            crossed,
            steps,
            one_law: self.one_law,
            squeeze: self.squeeze,
            reach: self.reach,
        }
    }
}
