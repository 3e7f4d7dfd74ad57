//! The impulse between two rough bodies that collide (Crowe et al. 1998; Goetsch 2015,
//! Eqs. 2.14 to 2.25; Walton 1993 for the tangential restitution).
//!
//! ```text
//! G = v1 - v2        Gc = G + r1 w1 x n + r2 w2 x n        Gt = Gc - (Gc.n) n
//! J_n = m* (G.n + u)                    u = e G.n, the speed at which they part
//! J_t = min( mu J_n, (1 + beta) lambda m* |Gt| )       lambda = kappa/(1 + kappa)
//! v1 -= (J_n n + J_t t)/m1              w1 -= J_t (n x t)/(kappa m1 r1)
//! v2 += (J_n n + J_t t)/m2              w2 -= J_t (n x t)/(kappa m2 r2)
//! ```
//!
//! `n` points from body 1 to body 2, `t` along `Gt`; `kappa` is 2/5 of spheres and 1/2 of discs.

use crate::Vec3;

/// A body in a collision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collider {
    /// Velocity of the centre [m/s].
    pub v: Vec3,
    /// Angular velocity [rad/s].
    pub w: Vec3,
    /// Radius [m]; 0 of a wall, whose `v` is that of the point that is touched.
    pub radius: f64,
    /// Distance of its centre from the point where both touch [m]: the radius, unless they overlap.
    pub lever: f64,
    /// `1/m` [1/kg]; 0 of what no force moves.
    pub inverse_mass: f64,
}

impl Collider {
    /// A wall that stands still.
    pub const STILL: Self = Self {
        v: Vec3::new(0.0, 0.0, 0.0),
        w: Vec3::new(0.0, 0.0, 0.0),
        radius: 0.0,
        lever: 0.0,
        inverse_mass: 0.0,
    };
}

/// Surfaces of two bodies as an impact finds them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImpactLaw {
    /// Coefficient of restitution.
    pub restitution: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Coefficient of tangential restitution, -1 to 1: 0 of surfaces that stick, 1 of perfectly
    /// rough ones that give back all.
    pub tangential_restitution: f64,
}

/// Impulse that body 2 receives; body 1 receives the opposite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impulse {
    /// Along the normal [N·s].
    pub normal: f64,
    /// Across it [N·s].
    pub tangential: Vec3,
}

impl ImpactLaw {
    /// The impulse of a collision in which `one` and `other`, in the direction `n` from it, part at
    /// the speed `parting` [m/s]; `kappa` is that of both.
    pub fn impulse(
        &self,
        n: Vec3,
        [one, other]: [&Collider; 2],
        parting: f64,
        kappa: f64,
    ) -> Impulse {
        let reduced = 1.0 / (one.inverse_mass + other.inverse_mass);
        let g = one.v - other.v;
        let normal = reduced * (g.dot(&n) + parting);
        let slip = g + (one.w * one.lever + other.w * other.lever).cross(&n);
        let slip = slip - n * slip.dot(&n);
        let speed = slip.norm_squared().sqrt();
        let stick = (1.0 + self.tangential_restitution) * kappa / (1.0 + kappa) * reduced * speed;
        let size = stick.min(self.friction * normal);
        let tangential = if speed > 0.0 { slip * (size / speed) } else { Vec3::zeros() };
        Impulse { normal, tangential }
    }
}

impl Impulse {
    /// The whole impulse on body 2 in the direction `n` from body 1 [N·s].
    pub fn vector(&self, n: Vec3) -> Vec3 {
        n * self.normal + self.tangential
    }

    /// Gives velocities to a body: `sign` is -1 of body 1 and 1 of body 2.
    pub fn kick(&self, body: &mut Collider, n: Vec3, sign: f64, kappa: f64) {
        if body.inverse_mass > 0.0 {
            body.v += self.vector(n) * (sign * body.inverse_mass);
            let inertia = kappa * body.radius * body.radius;
            body.w -= n.cross(&self.tangential) * (body.lever * body.inverse_mass / inertia);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    pub const SPHERE: f64 = 0.4;
    pub const DISC: f64 = 0.5;

    fn law(restitution: f64, friction: f64, tangential_restitution: f64) -> ImpactLaw {
        ImpactLaw { restitution, friction, tangential_restitution }
    }

    fn vector() -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-1.0f64..1.0).prop_map(Vec3::from)
    }

    fn collider() -> impl Strategy<Value = Collider> {
        (vector(), vector(), 0.1f64..2.0, 0.1f64..10.0).prop_map(|(v, w, radius, inverse_mass)| {
            Collider { v, w, radius, lever: radius, inverse_mass }
        })
    }

    /// The direction, or its opposite, along which two approach.
    fn towards(one: &Collider, other: &Collider, n: Vec3) -> Vec3 {
        let n = n.normalize();
        if (one.v - other.v).dot(&n) < 0.0 { -n } else { n }
    }

    fn energy(body: &Collider, kappa: f64) -> f64 {
        let inertia = kappa * body.radius * body.radius;
        0.5 / body.inverse_mass * (body.v.norm_squared() + inertia * body.w.norm_squared())
    }

    fn angular(body: &Collider, place: Vec3, kappa: f64) -> Vec3 {
        let spin = body.w * (kappa * body.radius * body.radius);
        (place.cross(&body.v) + spin) / body.inverse_mass
    }

    fn collide(law: &ImpactLaw, n: Vec3, pair: &mut [Collider; 2], kappa: f64) -> Impulse {
        let approach = (pair[0].v - pair[1].v).dot(&n);
        let impulse = law.impulse(n, [&pair[0], &pair[1]], law.restitution * approach, kappa);
        impulse.kick(&mut pair[0], n, -1.0, kappa);
        impulse.kick(&mut pair[1], n, 1.0, kappa);
        impulse
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        #[test]
        fn a_collision_keeps_momenta_and_gives_no_energy(
            one in collider(), other in collider(), n in vector(),
            e in 0.0f64..1.0, mu in 0.0f64..2.0, beta in -1.0f64..1.0, disc in any::<bool>(),
        ) {
            prop_assume!(n.norm() > 0.1);
            let kappa = if disc { DISC } else { SPHERE };
            let n = towards(&one, &other, n);
            let mut pair = [one, other];
            let approach = (one.v - other.v).dot(&n);
            let before = pair;
            collide(&law(e, mu, beta), n, &mut pair, kappa);
            let places = [Vec3::zeros(), n * (one.radius + other.radius)];
            let sum = |pair: &[Collider; 2]| {
                let p = pair[0].v / pair[0].inverse_mass + pair[1].v / pair[1].inverse_mass;
                let l = angular(&pair[0], places[0], kappa) + angular(&pair[1], places[1], kappa);
                (p, l, energy(&pair[0], kappa) + energy(&pair[1], kappa))
            };
            let ((p0, l0, e0), (p1, l1, e1)) = (sum(&before), sum(&pair));
            prop_assert!((p1 - p0).norm() < 1e-13 * (1.0 + p0.norm()) * 10.0);
            prop_assert!((l1 - l0).norm() < 1e-12 * (1.0 + l0.norm()));
            prop_assert!(e1 <= e0 * (1.0 + 1e-13));
            let parting = (pair[1].v - pair[0].v).dot(&n);
            prop_assert!((parting - e * approach).abs() < 1e-13);
            // Without friction the loss is m* (1 - e^2) (G.n)^2/2 exactly.
            let mut smooth = before;
            collide(&law(e, 0.0, 0.0), n, &mut smooth, kappa);
            let reduced = 1.0 / (one.inverse_mass + other.inverse_mass);
            let loss = 0.5 * reduced * (1.0 - e * e) * approach * approach;
            prop_assert!((sum(&before).2 - sum(&smooth).2 - loss).abs() < 1e-12 * (1.0 + e0));
        }

        #[test]
        fn it_slides_throughout_where_the_angle_is_flat(
            one in collider(), other in collider(), n in vector(),
            e in 0.0f64..1.0, mu in 0.01f64..1.0,
        ) {
            prop_assume!(n.norm() > 0.1);
            let n = towards(&one, &other, n);
            let g = one.v - other.v;
            prop_assume!(g.dot(&n) > 0.01);
            let slip = |pair: &[Collider; 2]| {
                let g = pair[0].v - pair[1].v;
                let all = g + (pair[0].w * one.radius + pair[1].w * other.radius).cross(&n);
                all - n * all.dot(&n)
            };
            let mut pair = [one, other];
            let before = slip(&pair);
            let lambda = SPHERE / (1.0 + SPHERE);
            let slides = g.dot(&n) / before.norm() < lambda / (mu * (1.0 + e));
            collide(&law(e, mu, 0.0), n, &mut pair, SPHERE);
            let after = slip(&pair);
            if slides {
                // It falls by mu (1 + e) v_n (1 + 1/kappa), in its direction.
                let fall = mu * (1.0 + e) * g.dot(&n) * (1.0 + 1.0 / SPHERE);
                prop_assert!((before.norm() - after.norm() - fall).abs() < 1e-11);
            } else {
                prop_assert!(after.norm() < 1e-12);
            }
        }

        #[test]
        fn elastic_and_perfectly_rough_ones_keep_their_energy_and_turn_the_slip_round(
            one in collider(), other in collider(), n in vector(),
        ) {
            prop_assume!(n.norm() > 0.1);
            let n = towards(&one, &other, n);
            let mut pair = [one, other];
            let before = energy(&one, SPHERE) + energy(&other, SPHERE);
            collide(&law(1.0, f64::INFINITY, 1.0), n, &mut pair, SPHERE);
            let after = energy(&pair[0], SPHERE) + energy(&pair[1], SPHERE);
            prop_assert!((after / before - 1.0).abs() < 1e-12);
        }
    }

    /// A wall takes everything: `e_t = 1 - mu (1 + e)/tan(angle)` of the centre while it slides.
    #[test]
    fn the_centre_keeps_its_part_of_the_tangential_speed_on_a_wall() {
        let wall = Collider::STILL;
        for (angle, kappa) in [(1.2f64, SPHERE), (1.4, SPHERE), (1.3, DISC)] {
            let (e, mu) = (0.8, 0.1);
            let v = Vec3::new(angle.sin(), 0.0, -angle.cos());
            let ball =
                Collider { v, radius: 0.5, lever: 0.5, inverse_mass: 2.0, ..Collider::STILL };
            let mut pair = [ball, wall];
            collide(&law(e, mu, 0.0), -Vec3::z(), &mut pair, kappa);
            let kept = pair[0].v.x / v.x;
            assert!((kept - (1.0 - mu * (1.0 + e) / angle.tan())).abs() < 1e-14);
            assert!((pair[0].v.z + e * v.z).abs() < 1e-15);
            assert_eq!(pair[1], wall);
        }
    }
}
