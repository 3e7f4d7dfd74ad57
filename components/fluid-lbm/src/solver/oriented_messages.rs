//! Messages on bodies by the lattice's axes, and results of the fluid by the world's.

use crate::boundary::virtual_piston::reservoir_state::ReservoirState;
use crate::domain::lattice_orientation::LatticeOrientation;
use crate::lattice::d3q19::{Q, each};
use crate::lattice::error::FluidError;
use crate::lattice::ledger::Ledger;
use crate::lattice::reservoir_place::ReservoirPlace;
use crate::solver::diagnostics::SliceNode;
use tremie_fluid_kit::probes::probe_signals::{count, first_velocity};
use tremie_messages::scene::ProbeShape;
use tremie_messages::{BodyState, FacetLoad, Load, PortState, SurfaceVertex};

impl LatticeOrientation {
    /// States of bodies; `room` takes them where they differ from the world's.
    pub fn bodies<'a>(
        self,
        of_world: &'a [BodyState],
        room: &'a mut Vec<BodyState>,
    ) -> &'a [BodyState] {
        self.each(of_world, room, |body| self.body(body))
    }

    /// Vertices of deformable surfaces, likewise.
    pub fn vertices<'a>(
        self,
        of_world: &'a [SurfaceVertex],
        room: &'a mut Vec<SurfaceVertex>,
    ) -> &'a [SurfaceVertex] {
        self.each(of_world, room, |vertex| self.vertex(vertex))
    }

    fn each<'a, T>(
        self,
        of_world: &'a [T],
        room: &'a mut Vec<T>,
        turn: impl Fn(&T) -> T,
    ) -> &'a [T] {
        if self == Self::WORLD {
            return of_world;
        }
        room.clear();
        room.extend(of_world.iter().map(turn));
        room
    }

    /// The state of a body.
    fn body(self, state: &BodyState) -> BodyState {
        BodyState {
            id: state.id,
            position: self.to_lattice(&state.position),
            orientation: self.turn(state.orientation),
            velocity: self.to_lattice(&state.velocity),
            angular_velocity: self.to_lattice(&state.angular_velocity),
        }
    }

    /// A vertex of a deformable surface.
    fn vertex(self, vertex: &SurfaceVertex) -> SurfaceVertex {
        SurfaceVertex {
            position: self.to_lattice(&vertex.position),
            velocity: self.to_lattice(&vertex.velocity),
        }
    }

    /// Turns loads back.
    pub fn turn_back_loads(self, loads: &mut [Load]) {
        if self == Self::WORLD {
            return;
        }
        for load in loads {
            load.force = self.to_world(&load.force);
            load.torque = self.to_world(&load.torque);
        }
    }

    /// Turns loads on facets back.
    pub fn turn_back_facets(self, loads: &mut [FacetLoad]) {
        if self == Self::WORLD {
            return;
        }
        for load in loads {
            load.force = self.to_world(&load.force);
            load.point = self.to_world(&load.point);
        }
    }

    /// Turns back what probes of some shapes measured, given as `probes` lists it.
    pub fn turn_back_probes(self, shapes: &[ProbeShape], values: &mut [f64]) {
        let mut rest = values;
        for shape in shapes {
            let (own, others) = rest.split_at_mut(count(shape));
            rest = others;
            if let Some(first) = first_velocity(shape) {
                let velocity = self.to_world(&[own[first], own[first + 1], own[first + 2]]);
                own[first..first + 3].copy_from_slice(&velocity);
            }
        }
    }

    /// Turns back ports; they are in the order of the world's faces then.
    pub fn turn_back_ports(self, of_lattice: &[PortState], ports: &mut Vec<PortState>) {
        ports.clear();
        ports.extend(of_lattice.iter().map(|port| PortState {
            axis: self.axis_to_world(port.axis as usize) as u32,
            ..*port
        }));
        ports.sort_unstable_by_key(|port| (port.axis, port.side));
    }

    /// Turns back what reservoirs are like; they are in the order of the world's faces then, and of the
    /// parts.
    pub fn turn_back_reservoirs(self, states: &mut [ReservoirState]) {
        for state in states.iter_mut() {
            state.place = self.place_to_world(state.place);
        }
        states.sort_unstable_by_key(|state| state.place);
    }

    fn place_to_world(self, place: ReservoirPlace) -> ReservoirPlace {
        match place {
            ReservoirPlace::Face { axis, side } => {
                ReservoirPlace::Face { axis: self.axis_to_world(axis), side }
            }
            ReservoirPlace::Part(_) => place,
        }
    }

    /// Values of a cell, by the world's axes.
    pub fn node(self, node: SliceNode) -> SliceNode {
        SliceNode { velocity: self.to_world(&node.velocity), ..node }
    }

    /// The populations of a cell, in the order of the world's directions.
    pub fn populations(self, of_lattice: [f64; Q]) -> [f64; Q] {
        each(|i| of_lattice[self.direction_to_lattice(i)])
    }

    /// The balance.
    pub fn ledger(self, ledger: &Ledger) -> Ledger {
        ledger.with(|v| self.to_world(&v), 1.0)
    }

    /// Error of the fluid, by the world's axes.
    pub fn error(self, error: FluidError) -> FluidError {
        use FluidError::*;
        match error {
            NonFinite { cell, position, value } => {
                NonFinite { cell: self.to_world(&cell), position: self.to_world(&position), value }
            }
            Mach { cell, position, speed, mach, limit, remedy } => Mach {
                cell: self.to_world(&cell),
                position: self.to_world(&position),
                speed,
                mach,
                limit,
                remedy,
            },
            ReservoirSpent { place, left, volume, time } => {
                ReservoirSpent { place: self.place_to_world(place), left, volume, time }
            }
            ReservoirFlow { place, speed, limit, pressure } => {
                ReservoirFlow { place: self.place_to_world(place), speed, limit, pressure }
            }
            // Each by its name, so that a new error with an axis is not forgotten.
            other @ (Bodies { .. }
            | Room { .. }
            | NonFiniteBody { .. }
            | AddedTwice { .. }
            | NotThere { .. }
            | UnknownEvent { .. }
            | UnknownPart { .. }
            | UnknownShape { .. }
            | Radius { .. }
            | TooWide { .. }
            | Vertices { .. }
            | NonFiniteVertex { .. }
            | Surface { .. }) => other,
        }
    }
}
