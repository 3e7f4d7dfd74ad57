//! Contacts of linear springs side by side: the formulae of [`crate::contact`] and
//! [`crate::contact::contact_force::touch_of_balls`] in the same order of operations, so that the
//! bits are the same.

use crate::contact::contact_force::Steps;
use crate::contact::contact_law::Law;
use crate::contact::friction::{FrameMotion, TangentialSpring, time_since_touch};
use crate::contact::springs::{Dashpot, Dashpots};
use crate::math::simd::lanes::{Lane3, Plain};
use tremie_team::Variant;
use tremie_team::simd::SimdLane;

#[cfg(target_arch = "x86_64")]
use crate::math::simd::lanes::Both;

/// Input of the formula for contacts side by side.
#[derive(Clone, Copy)]
pub(crate) struct Batch<L> {
    /// Vector from centre to centre [m].
    pub d: Lane3<L>,
    /// Radii [m].
    pub radius_i: L,
    pub radius_j: L,
    /// Velocity of i relative to j [m/s], angular velocities [rad/s].
    pub v: Lane3<L>,
    pub w_i: Lane3<L>,
    pub w_j: Lane3<L>,
    /// History: displacement [m], normal, and 1 where they touched before, else 0.
    pub xi: Lane3<L>,
    pub old: Lane3<L>,
    pub touching: L,
    /// `sqrt(m*)` [kg^(1/2)].
    pub root_mass: L,
}

/// Output of the formula for these contacts.
#[derive(Clone, Copy)]
pub(crate) struct Outcome<L> {
    pub normal: Lane3<L>,
    pub tangential: Lane3<L>,
    pub force: L,
    pub overlap: L,
    /// Overlap over the smaller radius.
    pub ratio: L,
    /// Displacement to remember [m].
    pub xi: Lane3<L>,
}

/// The law of all contacts of a run, where it is one and a linear one without rolling friction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinearLaw {
    k_n: f64,
    k_t: f64,
    inverse_k_t: f64,
    mu: f64,
    tension: bool,
    dashpots: Dashpots,
    /// With which instructions.
    pub variant: Variant,
}

impl LinearLaw {
    /// The law in this form, if it has it.
    pub fn of(law: &Law) -> Option<Self> {
        let spring = law.as_linear().filter(|_| law.mu_rolling <= 0.0)?;
        Some(Self {
            k_n: spring.normal_stiffness,
            k_t: spring.tangential_stiffness,
            inverse_k_t: spring.inverse_k_t,
            mu: law.mu,
            tension: law.tension,
            dashpots: law.dashpots,
            variant: Variant::widest(),
        })
    }

    /// Forces and histories of a batch.
    #[inline(always)]
    pub fn forces<L: SimdLane>(&self, b: &Batch<L>, steps: Steps) -> Outcome<L> {
        // A batch of some kind makes all others of that kind.
        let like = b.root_mass;
        let (zero, half, one) = (like.all(0.0), like.all(0.5), like.all(1.0));
        let distance = b.d.dot(b.d).sqrt();
        let n = b.d * (one / distance);
        let overlap = b.radius_i + b.radius_j - distance;
        let (arm_i, arm_j) = (b.radius_i - half * overlap, b.radius_j - half * overlap);
        let velocity = b.v + (b.w_i * arm_i + b.w_j * arm_j).cross(n);
        let twist = half * (b.w_i + b.w_j).dot(n);

        let v_n = velocity.dot(n);
        let elastic = like.all(self.k_n) * overlap;
        let mut f_n = elastic + gamma(self.dashpots.normal, b.root_mass) * v_n;
        if !self.tension {
            f_n = f_n.positive();
        }
        let smaller = b.radius_i.less(b.radius_j, b.radius_i, b.radius_j);
        let mut out = Outcome {
            normal: n,
            tangential: Lane3::repeat(zero),
            force: f_n,
            overlap,
            ratio: overlap / smaller,
            xi: b.xi,
        };
        if self.mu > 0.0 {
            let motion = FrameMotion {
                n,
                old: b.old,
                twist,
                touching: b.touching,
                since: time_since_touch(overlap, v_n, steps.before),
                steps,
            };
            let spring = TangentialSpring {
                k_t: like.all(self.k_t),
                inverse_k_t: like.all(self.inverse_k_t),
                gamma_t: gamma(self.dashpots.tangential, b.root_mass),
                remembered: one,
            };
            let limit = like.all(self.mu) * f_n.positive();
            (out.tangential, out.xi) = spring.resist(limit, b.xi, velocity - n * v_n, &motion);
        }
        out
    }
}

/// Coefficient of a dashpot.
#[inline(always)]
fn gamma<L: SimdLane>(dashpot: Dashpot, root_mass: L) -> L {
    root_mass.all(dashpot.fixed) + root_mass.all(dashpot.per_root_mass) * root_mass
}

#[cfg(target_arch = "x86_64")]
impl<L> Batch<L> {
    /// These contacts, and others.
    #[inline(always)]
    pub fn beside(self, other: Self) -> Batch<Both<L>> {
        let (a, b) = (self, other);
        Batch {
            d: a.d.beside(b.d),
            radius_i: Both(a.radius_i, b.radius_i),
            radius_j: Both(a.radius_j, b.radius_j),
            v: a.v.beside(b.v),
            w_i: a.w_i.beside(b.w_i),
            w_j: a.w_j.beside(b.w_j),
            xi: a.xi.beside(b.xi),
            old: a.old.beside(b.old),
            touching: Both(a.touching, b.touching),
            root_mass: Both(a.root_mass, b.root_mass),
        }
    }
}

#[cfg(target_arch = "x86_64")]
impl<L> Outcome<Both<L>> {
    /// Outcomes of either half.
    #[inline(always)]
    pub fn halves(self) -> [Outcome<L>; 2] {
        let [normal, later_normal] = self.normal.halves();
        let [tangential, later_tangential] = self.tangential.halves();
        let [xi, later_xi] = self.xi.halves();
        let (Both(force, later_force), Both(overlap, later_overlap)) = (self.force, self.overlap);
        let Both(ratio, later_ratio) = self.ratio;
        [
            Outcome { normal, tangential, force, overlap, ratio, xi },
            Outcome {
                normal: later_normal,
                tangential: later_tangential,
                force: later_force,
                overlap: later_overlap,
                ratio: later_ratio,
                xi: later_xi,
            },
        ]
    }
}

impl Batch<Plain> {
    pub const ZERO: Self = Self {
        d: Lane3::ZERO,
        radius_i: Plain::ZERO,
        radius_j: Plain::ZERO,
        v: Lane3::ZERO,
        w_i: Lane3::ZERO,
        w_j: Lane3::ZERO,
        xi: Lane3::ZERO,
        old: Lane3::ZERO,
        touching: Plain::ZERO,
        root_mass: Plain::ZERO,
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::parameters::Parameters;
    use crate::solver::dem_solver::GrainsDem;
    use tremie_messages::{
        body::BodyState,
        scene::{
            BodySet, ContactLaw, Damping, Diameters, Domain, Face, Motion, Packing, PairLaw,
            Placement, Scene, Spring,
        },
    };

    /// Grains that fall askew through periodic sides onto a floor.
    fn crowd(tension: bool) -> Scene {
        let law = ContactLaw {
            spring: Spring::Linear { normal_stiffness: 1e3, tangential_stiffness: 800.0 },
            friction: 0.5,
            rolling_friction: 0.0,
            damping: Damping::Restitution(0.6),
            tension,
        };
        let sides = [0.012, 0.01, 0.03];
        let periodic = || [Face::Periodic, Face::Periodic];
        let faces = [periodic(), periodic(), [Face::WALL, Face::WALL]];
        Scene {
            // Through the sides either way: towards lower images too.
            gravity: if tension { [-90.0, -70.0, -100.0] } else { [20.0, 7.0, -100.0] },
            bodies: vec![BodySet {
                name: "grains".into(),
                density: 2500.0,
                material: "grains".into(),
                motion: Motion::Free,
                clump: None,
                placement: Placement::Packed(Packing {
                    min: [0.0; 3],
                    max: [0.012, 0.01, 6e-3],
                    fraction: 0.4,
                    diameters: Diameters::Uniform { min: 0.8e-3, max: 1e-3 },
                    seed: 3,
                }),
            }],
            contacts: ["grains", "wall"]
                .map(|other| PairLaw { between: ["grains".into(), other.into()], law: law.clone() })
                .to_vec(),
            ..Scene::empty(Domain::new([0.0; 3], sides, faces))
        }
    }

    fn run(scene: &Scene, variant: Variant) -> Vec<BodyState> {
        let mut dem = GrainsDem::new(scene, &Parameters::default(), 4e-6, 1).unwrap();
        dem.around.one_law.as_mut().unwrap().variant = variant;
        dem.advance(1500, &[]).unwrap();
        let seen = dem.diagnostics();
        assert!(seen.list_rebuilds > 2 && seen.contacts > 500, "{seen:?}");
        let mut states = vec![BodyState::at_rest(0, [0.0; 3]); dem.body_count()];
        dem.write_state(&mut states);
        states
    }

    #[test]
    fn every_variant_gives_the_same_bits() {
        for scene in [crowd(false), crowd(true)] {
            let portable = run(&scene, Variant::Portable);
            for variant in Variant::ALL.into_iter().filter(|v| v.available()) {
                assert_eq!(run(&scene, variant), portable, "{variant:?}");
            }
        }
    }
}
