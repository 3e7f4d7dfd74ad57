//! Contacts with a surface that deforms, kept at a window's end and put back.

use super::{SphereAtSurface, SurfaceContacts, SurfaceSurroundings};
use crate::Vec3;
use crate::bodies::mesh_contact::WallPoints;
use crate::walls::surface_contacts::facet_lists::Box3;
use tremie_state::{StateError, StateExchange};

impl SurfaceContacts {
    /// Keeps the lists with what contacts remember, or puts them back, beside bodies and seats that
    /// are back already.
    pub fn exchange(
        &mut self,
        state: &mut StateExchange<'_>,
        around: &SurfaceSurroundings<'_>,
    ) -> Result<(), StateError> {
        if self.stale && !state.restores() {
            self.forget_lists();
        }
        state.array("listed", &mut self.listed)?;
        state.value("stale", &mut self.stale)?;
        state.value("entries", &mut self.entries)?;
        state.list("start", &mut self.start)?;
        state.list("facets", &mut self.facets)?;
        // Where there are several surfaces, trials of the others look at these.
        state.value("found", &mut self.found)?;
        state.value("seat_energy", &mut self.seat.energy)?;
        if !state.restores() {
            return Ok(());
        }
        if !self.is_sound(around) {
            return state.unfit("the contacts of the state are not those of this surface");
        }
        self.find_the_rest(around);
        Ok(())
    }

    /// Empties lists that do not hold: they are made anew before anything is looked up in them.
    fn forget_lists(&mut self) {
        self.start.truncate(1);
        self.facets.clear();
        self.found.clear();
        self.begin_looks();
    }

    /// True if everything that lists refer to is there.
    fn is_sound(&self, around: &SurfaceSurroundings<'_>) -> bool {
        let laws = around.laws.laws().len();
        let bodies = around.bodies.len();
        let fits = |entry: &SphereAtSurface| {
            let body = self.stale || (entry.body as usize) < bodies;
            body && usize::from(entry.law) < laws && entry.history.is_sound(laws)
        };
        let ids = self.entries.is_sorted_by(|a, b| a.id < b.id);
        ids && self.entries.iter().all(fits) && self.has_whole_rows()
    }

    /// True if each entry has its facets, and its contact points are of these; none where lists do
    /// not hold.
    fn has_whole_rows(&self) -> bool {
        let rows = if self.stale { 0 } else { self.entries.len() };
        let ends = (self.start.first(), self.start.last().map(|&end| end as usize));
        let whole = self.start.len() == rows + 1
            && self.found.len() == rows
            && ends == (Some(&0), Some(self.facets.len()))
            && self.start.is_sorted();
        let known = |&facet: &u32| (facet as usize) < self.triangles.len();
        let of_row = |(row, found): (&[u32], &WallPoints)| {
            found.contacts().iter().all(|near| near.triangle < row[1] - row[0])
        };
        whole && self.facets.iter().all(known) && self.start.windows(2).zip(&self.found).all(of_row)
    }

    /// What follows from the lists. How far facets were from spheres is found by the next look.
    fn find_the_rest(&mut self, around: &SurfaceSurroundings<'_>) {
        self.shape.copy_from_slice(&self.listed);
        self.travel = 0.0;
        self.bounds = Box3::of(self.listed.iter().map(|&x| Vec3::from(x)));
        self.begin_looks();
        if !self.stale {
            self.seat.list(&self.listed, self.skin, around.seats);
        }
    }
}
