//! A body between two steps, as it is kept.

use super::{Body, UnionShare};
use crate::bodies::mass_account::MassAccount;
use crate::lattice::layout::Layout;
use serde::{Deserialize, Serialize};
use tremie_fluid_kit::cells::grid::Grid;
use tremie_messages::BodyEvent;
use tremie_state::{StateError, StateExchange};
use tremie_team::Team;

/// All that the next steps of a body depend on. Its cells and links follow from that.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct KeptBody {
    /// What added it.
    pub event: BodyEvent,
    /// See [`Body::handle`].
    pub handle: u32,
    position: [f64; 3],
    /// Place at which the cells of a sphere were found: they hold some way from there.
    found_at: [f64; 3],
    /// Of a part or a polyhedron.
    orientation: [f64; 4],
    urged: [f64; 3],
    velocity: [f64; 3],
    spin: [f64; 3],
    given: [[f64; 3]; 2],
    change: [f64; 3],
    carried: [[f64; 3]; 2],
    account: MassAccount,
    share: Option<UnionShare>,
}

impl KeptBody {
    /// Of a body; none of a surface that deforms.
    pub fn of(body: &Body) -> Option<Self> {
        let upright = [0.0, 0.0, 0.0, 1.0];
        Some(Self {
            event: body.event?,
            handle: body.handle,
            position: body.position,
            found_at: body.spans.found_at(body.position),
            orientation: body.part.as_ref().map_or(upright, |part| part.orientation()),
            urged: body.urged,
            velocity: body.velocity,
            spin: body.spin,
            given: body.given,
            change: body.change,
            carried: body.carried,
            account: body.account,
            share: body.share,
        })
    }

    /// True if it is somewhere, and stands as a body can.
    pub fn is_placed(&self) -> bool {
        // Beyond that, cells cannot be counted.
        let is_near = |x: &f64| x.abs() < 1e9;
        let square: f64 = self.orientation.iter().map(|q| q * q).sum();
        self.position.iter().chain(&self.found_at).all(is_near) && (square - 1.0).abs() < 0.1
    }

    /// Puts a body that its event has just made where it was, and finds its cells; lines are of
    /// `line` cells.
    pub fn put_back(&self, body: &mut Body, layout: &Layout, line: usize, team: &mut Team) {
        body.position = self.position;
        body.urged = self.urged;
        body.velocity = self.velocity;
        body.spin = self.spin;
        body.given = self.given;
        body.change = self.change;
        body.carried = self.carried;
        body.account = self.account;
        body.share = self.share;
        body.placed = true;
        if let Some(part) = &mut body.part {
            part.place(self.position, self.orientation);
            part.cover(&layout.grid, team);
        } else {
            body.fit(layout, self.found_at);
            body.shell.cover(&layout.grid, &body.spans);
            body.find_lines(line);
        }
    }
}

impl Body {
    /// Keeps a surface that deforms, or puts it back with its cells.
    ///
    /// # Errors
    /// A state of another surface.
    pub fn exchange_shape(
        &mut self,
        state: &mut StateExchange<'_>,
        grid: &Grid,
        team: &mut Team,
    ) -> Result<(), StateError> {
        state.value("account", &mut self.account)?;
        let Some(part) = &mut self.part else { return Ok(()) };
        part.exchange_shape(state, grid, team)?;
        if state.restores() {
            self.radius = part.radius();
            self.placed = true;
        }
        Ok(())
    }
}
