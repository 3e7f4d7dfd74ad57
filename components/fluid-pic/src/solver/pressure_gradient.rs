//! The gradient of the pressure, as it is taken from the velocities of faces.

use crate::grid::near_rows::NearRows;
use crate::solids::open_fractions::OpenFractions;
use crate::solver::extrapolation::FaceState;
use crate::solver::pic_settings::PicSettings;

/// Open fraction of a face below which its velocity says nothing of the fluid around: through a
/// crevice beside a body it may be many times the body's.
pub(super) const CREVICE: f64 = 0.2;

/// The pressure, as its gradient is taken from velocities.
pub(super) struct PressureGradient<'a, const D: usize> {
    pub stride: [usize; D],
    pub fractions: &'a OpenFractions<D>,
    pub settings: &'a PicSettings<D>,
    pub q: &'a [f64],
    pub depth: &'a [f64],
}

impl<const D: usize> PressureGradient<'_, D> {
    /// Difference of `q` across a face, where the wet cells beside it have one, and there is one.
    pub fn known(&self, axis: usize, at: usize) -> Option<f64> {
        let Self { fractions, q, depth, .. } = *self;
        let below = at - self.stride[axis];
        let to_surface = |wet: usize, air: usize| {
            self.settings.surface.distance(depth[wet], depth[air].min(0.0))
        };
        if fractions.open[axis][at] == 0.0 {
            return None;
        }
        match (depth[below] > 0.0, depth[at] > 0.0) {
            (true, true) if q[below] != 0.0 && q[at] != 0.0 => Some(q[at] - q[below]),
            (true, false) if q[below] != 0.0 => Some(-q[below] / to_surface(below, at)),
            (false, true) if q[at] != 0.0 => Some(q[at] / to_surface(at, below)),
            _ => None,
        }
    }

    /// Takes it from the faces across an axis, and says what is known of each.
    pub fn take(
        &self,
        axis: usize,
        near: &NearRows,
        is_carried: &[bool],
        velocity: &mut [f64],
        state: &mut [FaceState],
    ) {
        let Self { fractions, q, depth, .. } = *self;
        let stride = self.stride[axis];
        for at in near.spans().flatten() {
            if at < stride {
                state[at] = FaceState::Unknown;
                continue;
            }
            let below = at - stride;
            if fractions.is_wall(axis, at) {
                velocity[at] = 0.0;
                state[at] = FaceState::Wall;
                continue;
            }
            let to_surface = |wet: usize, air: usize| {
                self.settings.surface.distance(depth[wet], depth[air].min(0.0))
            };
            let open = fractions.open[axis][at];
            let is_solid = |cell: usize| fractions.volume[cell] == 0.0;
            state[at] = match (depth[below] > 0.0, depth[at] > 0.0) {
                _ if open < CREVICE => FaceState::Unknown,
                // There is no surface towards a cell without room.
                (true, false) if is_solid(at) => FaceState::Unknown,
                (false, true) if is_solid(below) => FaceState::Unknown,
                (true, true) => {
                    velocity[at] -= q[at] - q[below];
                    FaceState::Fluid
                }
                (true, false) => {
                    velocity[at] += q[below] / to_surface(below, at);
                    FaceState::Fluid
                }
                (false, true) => {
                    velocity[at] -= q[at] / to_surface(at, below);
                    FaceState::Fluid
                }
                // Spray: what particles carry there flies on.
                (false, false) if is_carried[at] => FaceState::Fluid,
                (false, false) => FaceState::Unknown,
            };
        }
    }
}
