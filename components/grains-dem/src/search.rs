//! The search for contacts: linked cells and the lists made from them.

use crate::{
    Parameters, Vec3,
    bodies::{Ball, Bodies, Mobility},
    cells::Cells,
    contact_list::{ContactList, Neighbour, near_bodies},
    periodic::PeriodicBox,
    walls::Wall,
};

/// Neighbour lists and what it takes to make them.
pub(crate) struct Search {
    /// How far beyond touching neighbours are listed [m].
    pub skin: f64,
    cells: Cells,
    /// Contacts between bodies.
    pub pairs: ContactList,
    /// Contacts of bodies with walls.
    pub wall_contacts: ContactList,
    /// The buffers of the lists before.
    spare: ContactList,
    /// Positions when the lists were made.
    pub reference: Vec<Vec3>,
    /// How often they were made.
    pub rebuilds: u64,
}

impl Search {
    pub fn new(bounds: PeriodicBox, largest: f64, parameters: &Parameters, bodies: usize) -> Self {
        let skin = parameters.skin_fraction() * largest;
        // A domain without bodies still needs a cell size.
        let range = if bodies > 0 { largest + skin } else { bounds.size.max() };
        Self {
            skin,
            cells: Cells::new(bounds, range, bodies),
            pairs: ContactList::default(),
            wall_contacts: ContactList::default(),
            spare: ContactList::default(),
            reference: Vec::with_capacity(bodies),
            rebuilds: 0,
        }
    }

    /// Makes the lists anew from wrapped positions; contacts keep their history.
    pub fn rebuild(&mut self, bodies: &Bodies, walls: &[Wall], bounds: &PeriodicBox) {
        let (balls, mobility, skin) = (&bodies.balls, &bodies.mobility, self.skin);
        let n = balls.len();
        let cells = &mut self.cells;
        cells.sort(balls);
        std::mem::swap(&mut self.pairs, &mut self.spare);
        self.pairs.refill(
            &self.spare,
            n,
            |i, out| near_bodies(cells, &bounds.shifts, balls, mobility, skin, i, out),
            |i, j| root_reduced_mass(mobility[i], mobility[j]),
        );
        std::mem::swap(&mut self.wall_contacts, &mut self.spare);
        self.wall_contacts.refill(
            &self.spare,
            n,
            |i, out| {
                if mobility[i].is_free() {
                    out.extend(near_walls(walls, &balls[i], skin));
                }
            },
            |i, _| root_reduced_mass(mobility[i], Mobility::NONE),
        );
        self.reference.clear();
        self.reference.extend(balls.iter().map(|ball| ball.x));
        self.rebuilds += 1;
    }
}

fn near_walls(walls: &[Wall], ball: &Ball, skin: f64) -> impl Iterator<Item = Neighbour> {
    (0..)
        .zip(walls)
        .filter(move |(_, wall)| wall.overlap(ball) > -skin)
        .map(|(other, _)| Neighbour { other, image: 0 })
}

/// `sqrt(m*)`, where a body of given motion counts as infinitely heavy.
fn root_reduced_mass(i: Mobility, j: Mobility) -> f64 {
    (1.0 / (i.inverse_mass + j.inverse_mass)).sqrt()
}
