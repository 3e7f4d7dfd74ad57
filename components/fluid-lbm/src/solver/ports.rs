//! Velocities at the open faces on which inlets of grains sit: means over the cells that are fluid
//! in the layer at the face.

use crate::lattice::layout::Layout;
use crate::lattice::populations::Real;
use crate::ranks::rank_sums::Ranks;
use crate::solver::execution::Execution;
use crate::solver::lattice_state::LatticeState;
use crate::solver::probes::Probes;
use tremie_fluid_kit::cells::centres::Centres;
use tremie_messages::PortState;
use tremie_messages::scene::{Probe, ProbeShape, Scene};

/// Such faces, each with a probe of its layer of cells.
#[derive(Clone, Debug, Default)]
pub struct PortFaces {
    faces: Vec<PortState>,
    layers: Probes,
    /// Room for what the probes measure.
    values: Vec<f64>,
}

/// Values of the probe of a layer: pressure, three velocities, solid fraction.
const VALUES: usize = 5;

impl PortFaces {
    /// Of a scene, in stored cells.
    pub fn new(scene: &Scene, layout: &Layout, centres: &Centres, ranks: &mut Ranks) -> Self {
        let faces = PortState::all(scene);
        let layer = |face: &PortState| {
            let axis = face.axis as usize;
            let (mut min, mut max) = (scene.domain.min, scene.domain.max);
            match face.side {
                0 => max[axis] = min[axis] + centres.cell,
                _ => min[axis] = max[axis] - centres.cell,
            }
            Probe { name: face.to_string(), shape: ProbeShape::Region { min, max } }
        };
        let layers: Vec<_> = faces.iter().map(layer).collect();
        Self {
            layers: Probes::new(&layers, layout, centres, ranks),
            values: Vec::with_capacity(VALUES * faces.len()),
            faces,
        }
    }

    /// See [`crate::LbmFluid::ports`].
    pub fn measure<T: Real>(
        &mut self,
        lattice: &LatticeState<T>,
        exec: &mut Execution,
    ) -> &[PortState] {
        let Self { faces, layers, values } = self;
        values.clear();
        let with = (&mut exec.team, &mut exec.ranks);
        layers.read(with, &lattice.before(), &lattice.flags, &lattice.units, values);
        for (face, values) in faces.iter_mut().zip(values.chunks(VALUES)) {
            let inward = if face.side == 0 { 1.0 } else { -1.0 };
            face.velocity = inward * values[1 + face.axis as usize];
        }
        faces
    }
}
