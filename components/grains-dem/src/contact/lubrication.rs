//! The fluid squeezed out between two surfaces that approach.
//!
//! Two spheres, or a sphere and a wall, of reduced radius `R*` and gap `h` repel each other with
//!
//! ```text
//! F = 6 pi eta R*^2 v_n (1/h - 1/h_c)        for h < h_c, with h at least the roughness
//! ```
//!
//! while they approach at `v_n`, and hold each other back while they separate: the leading term of
//! lubrication theory (Jeffrey & Onishi, *J. Fluid Mech.* 139, 1984), cut off where the fluid
//! solver resolves the gap itself (Nguyen & Ladd, *Phys. Rev. E* 66, 2002), and bounded where
//! asperities meet. On bodies in contact the contact alone acts (Biegert, Vowinckel & Meiburg, *J.
//! Comput. Phys.* 340, 2017): a collision of the soft bodies of a simulation lasts much longer than
//! a real one, and a film between them would take the energy of the rebound.
//!
//! Each way through the gap costs `ln(h_c/h_r)` of the Stokes number `m* v/(6 pi eta R*^2)`.

use crate::math::parameters::Parameters;
use core::f64::consts::PI;
use tremie_messages::scene::Scene;

/// The law between all surfaces of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Squeeze {
    /// `6 pi eta` [Pa·s].
    factor: f64,
    /// Gap from which on there is none [m].
    pub cutoff: f64,
    roughness: f64,
}

impl Squeeze {
    /// Lubrication of a scene with a fluid, where the parameters ask for it.
    pub fn of(scene: &Scene, parameters: &Parameters) -> Option<Self> {
        let (lubrication, fluid) = (parameters.lubrication?, scene.fluid.as_ref()?);
        Some(Self {
            factor: 6.0 * PI * fluid.viscosity,
            cutoff: lubrication.cutoff.0,
            roughness: lubrication.roughness.0,
        })
    }

    /// Force over the speed of approach at a gap [kg/s]; a gap that is not positive is a contact.
    #[inline(always)]
    pub fn resistance(&self, gap: f64, radius: f64) -> f64 {
        if gap <= 0.0 || gap >= self.cutoff {
            return 0.0;
        }
        self.factor * radius * radius * (1.0 / gap.max(self.roughness) - 1.0 / self.cutoff)
    }

    /// The largest resistance [kg/s].
    pub fn largest(&self, radius: f64) -> f64 {
        self.resistance(self.roughness, radius)
    }
}
