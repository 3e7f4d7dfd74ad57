//! Hertz's contact with adhesion by Johnson, Kendall and Roberts (*Proc. R. Soc. Lond. A* 324,
//! 1971), and Mindlin's tangential stiffness over its radius `a`.
//!
//! With the work of adhesion w, which is twice the surface energy of bodies of one material,
//!
//! ```text
//! f_n   = 4/3 E* a^3/R* - sqrt(8 pi w E* a^3)        k_t = 8 G* a
//! delta = a^2/R* - sqrt(2 pi w a/E*)
//! ```
//!
//! Bodies that touch pull at each other, and hold on until they are `3 a_c^2/R*` apart, `a_c^3 = pi
//! w R*^2/(8 E*)`: the neck. The largest pull is `3/2 pi w R*`; between touching at `delta = 0` and
//! parting the contact loses `7.09 (w^5 R*^4/E*^2)^(1/3)` (Thornton and Ning, *Powder Technol.* 99,
//! 1998), which is what slow bodies stick by. In terms of `a = a_c x^2`
//!
//! ```text
//! x^4 - 4 x = delta R*/a_c^2         f_n = pi w R* (x^6/6 - x^3)         x >= 1 on the branch that is stable
//! ```
//!
//! so that x is a root of a quartic (Ferrari's, as Parteli et al., *Sci. Rep.* 4, 2014, use it for
//! this law). Friction slips at `mu (f_n + 3 pi w R*)`, with twice the largest pull (Thornton, *J.
//! Phys. D* 24, 1991), as LAMMPS's granular JKR does; peeling by tangential forces is left out. The
//! dashpot is Hertz's, see [`super::hertz_mindlin`], with a in place of `sqrt(R* delta)`: the
//! restitution that is given is that of fast collisions.

use crate::contact::springs::{Bound, ContactSpring, Dashpots, Reduced, Stiffness};
use core::f64::consts::PI;
use tremie_messages::finding::short;

/// Moduli and adhesion of a pair of materials; see [`tremie_messages::scene::Spring::Jkr`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct HertzJkr {
    /// Effective Young's modulus [Pa].
    pub effective_modulus: f64,
    /// Effective shear modulus [Pa].
    pub effective_shear_modulus: f64,
    /// Work of adhesion [J/m²].
    pub work_of_adhesion: f64,
}

/// `x^3` where the overlap is 0, and where the force is.
const AT_TOUCH: f64 = 4.0;
const AT_REST: f64 = 6.0;

impl HertzJkr {
    /// Radius of the contact as it parts [m].
    #[inline(always)]
    fn last_radius(&self, pair: Reduced) -> f64 {
        let ratio = PI * self.work_of_adhesion / (8.0 * self.effective_modulus);
        libm::cbrt(ratio * pair.radius * pair.radius)
    }

    /// The root `x >= 1` of `x^4 - 4 x = d`; at the neck's end for what is beyond. With `q = 4/3 d`
    /// the resolvent `u^3 + 3 q u = 16` has the root `u = A - q/A`, written without its
    /// cancellation.
    #[inline(always)]
    fn root(&self, overlap: f64, pair: Reduced, last: f64) -> f64 {
        let d = (overlap * pair.radius / (last * last)).max(-3.0);
        let q = 4.0 / 3.0 * d;
        let a = libm::cbrt(8.0 + (64.0 + q * q * q).max(0.0).sqrt());
        let u = 16.0 / (a * a + q + (q / a) * (q / a));
        let p = u.sqrt();
        0.5 * (p + (8.0 / p - u).max(0.0).sqrt())
    }

    /// Overlap at a root [m].
    fn overlap_at(x: f64, pair: Reduced, last: f64) -> f64 {
        last * last / pair.radius * (x * x * x * x - 4.0 * x)
    }

    /// Work of the force from overlap 0 to that at a root [J].
    fn work_to(&self, x: f64, pair: Reduced, last: f64) -> f64 {
        let of = |x: f64| {
            let cube = x * x * x;
            x * cube * (8.0 / 15.0 * cube * cube - 16.0 / 3.0 * cube + 8.0)
        };
        let square = last * last / pair.radius;
        self.effective_modulus * square * square * last * (of(x) - of(libm::cbrt(AT_TOUCH)))
    }

    /// Slope of the force at a root [N/m].
    fn slope_at(&self, x: f64, last: f64) -> f64 {
        let cube = x * x * x;
        2.0 * self.effective_modulus * last * x * x * (cube - 3.0) / (cube - 1.0)
    }

    /// The root of the deepest overlap in a collision at a speed: where the work is the kinetic
    /// energy.
    fn deepest(&self, pair: Reduced, speed: f64, last: f64) -> f64 {
        let energy = 0.5 * pair.root_mass * pair.root_mass * speed * speed;
        let (mut low, mut high) = (libm::cbrt(AT_REST), 2.0 * libm::cbrt(AT_REST));
        while self.work_to(high, pair, last) < energy {
            high *= 2.0;
        }
        for _ in 0..100 {
            let x = 0.5 * (low + high);
            if self.work_to(x, pair, last) < energy { low = x } else { high = x }
        }
        high
    }
}

impl ContactSpring for HertzJkr {
    // Never inlined: two roots to take are long, and would stretch the loops of all other laws.
    /// Remembered displacements shrink as the contact grows, as under Mindlin's law without
    /// adhesion.
    #[inline(never)]
    fn at(&self, overlap: f64, before: f64, pair: Reduced, dashpots: &Dashpots) -> Stiffness {
        let last = self.last_radius(pair);
        let x = self.root(overlap, pair, last);
        let radius = last * x * x;
        let cube = x * x * x;
        let pull = PI * self.work_of_adhesion * pair.radius;
        let damping = pair.root_mass * (4.0 / 3.0 * self.effective_modulus * radius).sqrt();
        let k_t = 8.0 * self.effective_shear_modulus * radius;
        let grew = || {
            let x_before = self.root(before, pair, last);
            x_before * x_before / (x * x)
        };
        Stiffness {
            elastic: pull * (cube * cube / 6.0 - cube),
            gamma_n: dashpots.normal.at(damping),
            k_t,
            inverse_k_t: if k_t > 0.0 { 1.0 / k_t } else { 0.0 },
            gamma_t: dashpots.tangential.at(damping),
            remembered: if before < overlap { grew() } else { 1.0 },
            pull_off: 1.5 * pull,
        }
    }

    #[inline(never)]
    fn normal_energy(&self, overlap: f64, pair: Reduced) -> f64 {
        let last = self.last_radius(pair);
        self.work_to(self.root(overlap, pair, last), pair, last)
    }

    #[inline(never)]
    fn normal_slope(&self, overlap: f64, pair: Reduced) -> f64 {
        let last = self.last_radius(pair);
        self.slope_at(self.root(overlap, pair, last), last)
    }

    #[inline(never)]
    fn neck(&self, pair: Reduced) -> f64 {
        let last = self.last_radius(pair);
        3.0 * last * last / pair.radius
    }

    /// That of Hertz's energy over the same radius, for the work of adhesion is negative where
    /// bodies rest.
    #[inline(never)]
    fn normal_root(&self, overlap: f64, pair: Reduced) -> f64 {
        if overlap <= -self.neck(pair) {
            return 0.0;
        }
        let last = self.last_radius(pair);
        let x = self.root(overlap, pair, last);
        let radius = last * x * x;
        let square = radius * radius / pair.radius;
        (16.0 / 15.0 * self.effective_modulus * square * square * radius).sqrt()
    }

    fn dashpots(&self, zeta: f64) -> [f64; 2] {
        let normal = 5f64.sqrt() * zeta;
        let ratio = 4.0 * self.effective_shear_modulus / self.effective_modulus;
        [normal, normal * ratio.sqrt()]
    }

    fn critical_dashpot(&self, pair: Reduced) -> f64 {
        let last = self.last_radius(pair);
        let x = self.root(1.0, pair, last);
        let stiffness = 4.0 / 3.0 * self.effective_modulus * last * x * x;
        5f64.sqrt() * pair.root_mass * stiffness.sqrt()
    }

    fn exponent(&self) -> f64 {
        1.5
    }

    fn overlap_under(&self, force: f64, pair: Reduced) -> f64 {
        let pull = 3.0 * PI * self.work_of_adhesion * pair.radius;
        let whole = force + pull + (2.0 * force * pull + pull * pull).sqrt();
        let radius = libm::cbrt(0.75 * pair.radius / self.effective_modulus * whole);
        let last = self.last_radius(pair);
        Self::overlap_at((radius / last).sqrt(), pair, last)
    }

    fn largest_overlap(&self, pair: Reduced, speed: f64) -> f64 {
        let last = self.last_radius(pair);
        Self::overlap_at(self.deepest(pair, speed, last), pair, last)
    }

    /// Half a period at the stiffness of the deepest overlap, which is less than bodies take.
    fn contact_time(&self, pair: Reduced, speed: f64) -> f64 {
        let last = self.last_radius(pair);
        let stiffest = self.slope_at(self.deepest(pair, speed, last), last);
        PI * pair.root_mass / stiffest.sqrt()
    }

    fn name(&self) -> &'static str {
        "Johnson, Kendall and Roberts' law"
    }

    fn numbers(&self) -> Vec<(&'static str, f64, Bound)> {
        vec![
            ("effective_modulus", self.effective_modulus, Bound::Positive),
            ("effective_shear_modulus", self.effective_shear_modulus, Bound::NotNegative),
            ("work_of_adhesion", self.work_of_adhesion, Bound::Positive),
        ]
    }

    fn stiffness_in_words(&self) -> String {
        let [modulus, work] = [self.effective_modulus, self.work_of_adhesion].map(short);
        format!("an effective modulus of {modulus} Pa, a work of adhesion of {work} J/m2")
    }

    fn remedy(&self, factor: f64) -> String {
        format!("Young's moduli {} times as large make it", short(factor))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vec3;
    use crate::contact::contact_force::{Contact, ContactHistory, Steps, force};
    use crate::contact::contact_law::Law;
    use crate::contact::springs::Dashpot;
    use crate::contact::springs::hertz_mindlin::HertzMindlin;
    use tremie_messages::scene::{ContactLaw, Damping, Spring};

    const GLASS: HertzJkr = HertzJkr {
        effective_modulus: 3.7e10,
        effective_shear_modulus: 1e10,
        work_of_adhesion: 0.05,
    };
    const GELATINE: HertzJkr =
        HertzJkr { effective_modulus: 1e5, effective_shear_modulus: 3e4, work_of_adhesion: 0.02 };
    const PAIR: Reduced = Reduced { root_mass: 1e-3, radius: 50e-6, mean_mass: 2e-6 };
    const NONE: Dashpots = {
        let none = Dashpot { fixed: 0.0, per_root_mass: 0.0 };
        Dashpots { normal: none, tangential: none }
    };

    fn pull(law: &HertzJkr, overlap: f64) -> f64 {
        law.at(overlap, overlap, PAIR, &NONE).elastic
    }

    /// Force and overlap over the contact radius, as the paper has them.
    fn by_radius(law: &HertzJkr, a: f64) -> [f64; 2] {
        let HertzJkr { effective_modulus: e, work_of_adhesion: w, .. } = *law;
        [
            4.0 / 3.0 * e * a * a * a / PAIR.radius - (8.0 * PI * w * e * a * a * a).sqrt(),
            a * a / PAIR.radius - (2.0 * PI * w * a / e).sqrt(),
        ]
    }

    #[test]
    fn force_and_overlap_are_those_over_the_contact_radius() {
        for law in [GLASS, GELATINE] {
            let last = law.last_radius(PAIR);
            for k in 0..400 {
                let a = last * libm::pow(1.02, f64::from(k)) * (1.0 + 1e-6);
                let [force, overlap] = by_radius(&law, a);
                let scale = force.abs().max(PI * law.work_of_adhesion * PAIR.radius);
                let found = pull(&law, overlap);
                assert!((found - force).abs() < 2e-7 * scale, "{k}: {found} {force}");
                let k_t = law.at(overlap, overlap, PAIR, &NONE).k_t;
                assert!((k_t / (8.0 * law.effective_shear_modulus * a) - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn the_largest_pull_is_that_of_the_theory() {
        for law in [GLASS, GELATINE] {
            let neck = law.neck(PAIR);
            let of = |k: i32| pull(&law, -neck * f64::from(k) / 1e5);
            let least = (0..=100_000).map(of).fold(0.0, f64::min);
            let expected = -1.5 * PI * law.work_of_adhesion * PAIR.radius;
            assert!((least / expected - 1.0).abs() < 1e-8, "{least} {expected}");
            // As the bodies part at a given distance, 5/9 of it are left.
            assert!((pull(&law, -neck) / expected - 5.0 / 9.0).abs() < 1e-7);
        }
    }

    #[test]
    fn bodies_rest_where_the_theory_has_it() {
        for law in [GLASS, GELATINE] {
            let HertzJkr { effective_modulus: e, work_of_adhesion: w, .. } = law;
            let radius = libm::cbrt(4.5 * PI * w * PAIR.radius * PAIR.radius / e);
            let rest = radius * radius / (3.0 * PAIR.radius);
            assert!((law.overlap_under(0.0, PAIR) / rest - 1.0).abs() < 1e-12);
            assert!(pull(&law, rest).abs() < 1e-12 * w * PAIR.radius * 1e2);
            let load = 3.0 * w * PAIR.radius;
            assert!((pull(&law, law.overlap_under(load, PAIR)) / load - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn work_is_the_integral_of_force_and_slope_its_derivative() {
        let law = GLASS;
        let rest = law.overlap_under(0.0, PAIR);
        for overlap in [-0.9 * law.neck(PAIR), -0.1 * rest, 0.3 * rest, rest, 5.0 * rest] {
            let h = 1e-4 * rest;
            let energy = |x: f64| law.normal_energy(x, PAIR);
            let force = (energy(overlap + h) - energy(overlap - h)) / (2.0 * h);
            let scale = PI * law.work_of_adhesion * PAIR.radius;
            assert!((force - pull(&law, overlap)).abs() < 1e-6 * scale, "{overlap}");
            let slope = (pull(&law, overlap + h) - pull(&law, overlap - h)) / (2.0 * h);
            let found = law.normal_slope(overlap, PAIR);
            assert!((slope / found - 1.0).abs() < 1e-5, "{slope} {found}");
        }
        assert!(law.normal_energy(0.0, PAIR).abs() < -1e-12 * law.normal_energy(rest, PAIR));
    }

    /// Thornton and Ning 1998, Eq. 39 and before.
    #[test]
    fn what_a_contact_loses_is_that_of_the_theory() {
        let HertzJkr { effective_modulus: e, work_of_adhesion: w, .. } = GLASS;
        let lost = GLASS.normal_energy(-GLASS.neck(PAIR), PAIR);
        let r = PAIR.radius;
        let expected = 7.09 * libm::cbrt(w * w * w * w * w * r * r * r * r / (e * e));
        assert!((lost / expected - 1.0).abs() < 1e-3, "{lost} {expected}");
    }

    #[test]
    fn without_much_adhesion_it_is_hertz() {
        let law = HertzJkr { work_of_adhesion: 1e-18, ..GLASS };
        let HertzJkr { effective_modulus, effective_shear_modulus, .. } = law;
        let hertz = HertzMindlin { effective_modulus, effective_shear_modulus };
        for overlap in [1e-9, 1e-7, 1e-6] {
            let (a, b) = (
                law.at(overlap, 0.5 * overlap, PAIR, &NONE),
                hertz.at(overlap, 0.5 * overlap, PAIR, &NONE),
            );
            assert!((a.elastic / b.elastic - 1.0).abs() < 1e-6, "{a:?} {b:?}");
            assert!((a.k_t / b.k_t - 1.0).abs() < 1e-6, "{a:?} {b:?}");
            assert!((a.remembered / b.remembered - 1.0).abs() < 1e-6, "{a:?} {b:?}");
        }
        let speeds = [law.largest_overlap(PAIR, 1.0), hertz.largest_overlap(PAIR, 1.0)];
        assert!((speeds[0] / speeds[1] - 1.0).abs() < 1e-6, "{speeds:?}");
    }

    /// Thornton 1991: without any load friction holds twice the largest pull.
    #[test]
    fn friction_slips_with_twice_the_largest_pull() {
        let HertzJkr { effective_modulus, effective_shear_modulus, work_of_adhesion } = GLASS;
        let law = Law::new(&ContactLaw {
            spring: Spring::Jkr { effective_modulus, effective_shear_modulus, work_of_adhesion },
            friction: 0.4,
            rolling_friction: 0.0,
            damping: Damping::Restitution(1.0),
            tension: false,
        });
        let contact = Contact {
            normal: Vec3::z(),
            overlap: GLASS.overlap_under(0.0, PAIR),
            velocity: Vec3::new(3.0, 4.0, 0.0),
            twist: 0.0,
            rolling: Vec3::zeros(),
        };
        let (mut memory, steps) = (ContactHistory::default(), Steps { before: 1e-3, after: 1e-3 });
        let found = force(&law, PAIR, &contact, &mut memory, false, steps).tangential.norm();
        let expected = 0.4 * 3.0 * PI * work_of_adhesion * PAIR.radius;
        assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
    }
}
