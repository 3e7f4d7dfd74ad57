//! The force in a contact of a polyhedron, from the pressure on it.
//!
//! The elastic load `F, T` comes from [`super::press`]; n is its direction, seen from the body, x_c
//! its middle, `k_n` the stiffness of the law, reached where faces touch over the area of the
//! largest face (the smaller of two). Dashpots, friction and what resists spinning are those that
//! springs and dashpots spread over the loaded surface have together, scaled with its part of that
//! area, s (of a contact that shares a region with others, of areas S in all, `sqrt(s)` is
//! `s/sqrt(S)`, so that all of them damp as one):
//!
//! ```text
//! v_n   = -(F.v + T.w)/|F|                          rate at which the bodies approach, w their relative spin
//! f_n   = max(0, |F| + sqrt(s) gamma_n v_n)         the whole load in proportion, torque about x_c too
//! T_r   = -sqrt(s) gamma_n <(r x n)((r x n).w)>     against rocking, at most f_n r; r from x_c
//! F_t   as for spheres, with s k_t, sqrt(s) gamma_t, at x_c
//! T_n   the same for spinning about n, with s k_t <r^2>; at most 0.94 mu f_n sqrt(<r^2>), exact for a disc
//! ```
//!
//! In slip, spring and dashpot give way alike: the spring of a soft contact that begins must not be
//! stretched against the dashpot. If a loaded surface grows, springs keep their forces; if it
//! shrinks, their displacements: either way no energy is made (see [`Law::at`]). For a face that
//! stays whole this is a linear spring.

use super::overlap_integrals::Press;
use crate::Vec3;
use crate::bodies::body_arrays::Wrench;
use crate::contact::contact_force::Steps;
use crate::contact::contact_law::Law;
use crate::contact::friction::{FrameMotion, TangentialSpring, time_since_touch};
use crate::contact::springs::Dashpot;
use crate::math::simd::lanes::Lane3;
use serde::{Deserialize, Serialize};

/// History of a contact of a polyhedron.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct OverlapHistory {
    /// Tangential displacement [m]; see
    /// [`ContactHistory::xi`](crate::contact::contact_force::ContactHistory::xi).
    pub xi: Vec3,
    /// Angle about the normal [rad], likewise.
    pub turn: f64,
    /// Normal at the last evaluation, away from the body; and normal and overlap for contacts with
    /// spheres.
    pub normal: Vec3,
    pub overlap: f64,
    /// Rolling displacement of contacts with spheres [m].
    pub rolling: Vec3,
    /// Tangential stiffness at the last evaluation [N/m], and that against spinning [N·m].
    pub k_t: f64,
    pub k_turn: f64,
    /// Energy in the springs of friction at the last evaluation [J].
    pub energy: f64,
    /// Rank of the wall or part that it is of.
    pub owner: u32,
}

impl OverlapHistory {
    pub const NONE: Self = Self {
        xi: Vec3::new(0.0, 0.0, 0.0),
        turn: 0.0,
        normal: Vec3::new(0.0, 0.0, 0.0),
        overlap: 0.0,
        rolling: Vec3::new(0.0, 0.0, 0.0),
        k_t: 0.0,
        k_turn: 0.0,
        energy: 0.0,
        owner: 0,
    };
}

/// Two bodies that press on each other: mass and stiffness.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    /// `sqrt(m*)` [kg^(1/2)].
    pub root_mass: f64,
    /// Load over the integral of the depth [N/m³].
    pub kappa: f64,
    /// Part of the reference area that is loaded in the whole region, if that is more than this
    /// contact.
    pub region: Option<f64>,
}

/// Response of a contact: its load, and the parts to share it among owners.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Response {
    /// Force on the body and torque about its centroid.
    pub load: Wrench,
    /// Normal force over the elastic one.
    scale: f64,
    /// Friction, at the middle of the load, and torque besides.
    sliding: Vec3,
    turning: Vec3,
}

impl Response {
    const NONE: Self = Self {
        load: Wrench { force: Vec3::new(0.0, 0.0, 0.0), torque: Vec3::new(0.0, 0.0, 0.0) },
        scale: 0.0,
        sliding: Vec3::new(0.0, 0.0, 0.0),
        turning: Vec3::new(0.0, 0.0, 0.0),
    };

    /// Load of one share of the pressure: its normal forces at their places, the rest of the load
    /// by its weight. The middle of the whole is the mean of the middles of the shares, by weight.
    pub fn of_share(&self, share: &Press, whole: &Press, kappa: f64) -> Wrench {
        let weight = share.weight() / whole.weight();
        let (normal, sliding) = (kappa * self.scale, self.sliding * weight);
        let torque = share.torque * normal + self.turning * weight;
        Wrench {
            force: share.force * normal + sliding,
            torque: torque + share.centre().cross(&sliding),
        }
    }
}

/// Relative motion: of the body at its centroid, less what the other would do there; spins.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Relative {
    /// Velocity of the body at its centroid less that of the other there [m/s].
    pub v: Vec3,
    /// Angular velocity of the body less that of the other [rad/s].
    pub w: Vec3,
    /// Sum of both angular velocities [rad/s].
    pub both: Vec3,
}

/// Load on the body. The history in `memory` counts only if the contact was `touching`.
pub(crate) fn load(
    law: &Law,
    pair: Pair,
    press: &Press,
    relative: &Relative,
    memory: &mut OverlapHistory,
    (touching, steps): (bool, Steps),
) -> Response {
    let elastic = press.force * pair.kappa;
    let strength = elastic.norm_squared().sqrt();
    if !(press.acts() && strength > 0.0) {
        return Response::NONE;
    }
    let n = elastic / -strength;
    let centre = press.centre();
    let spring = law.over_faces();
    // Loaded part of the reference area. Springs grow with it, dashpots with its root.
    let part = pair.kappa * press.area.norm_squared().sqrt() / spring.normal_stiffness;
    let root = pair.region.map_or(part.sqrt(), |region| part / region.sqrt());
    let gamma = |dashpot: Dashpot| root * dashpot.at(pair.root_mass);
    let (gamma_n, gamma_t) = (gamma(law.dashpots.normal), gamma(law.dashpots.tangential));

    let torque = press.torque * pair.kappa;
    let about_centre = torque - centre.cross(&elastic);
    let velocity = relative.v + relative.w.cross(&centre);
    let approach = -(elastic.dot(&velocity) + about_centre.dot(&relative.w)) / strength;
    let mut f_n = strength + gamma_n * approach;
    if !law.tension {
        f_n = f_n.max(0.0);
    }
    let scale = f_n / strength;
    let mut force = elastic * scale;
    let mut friction = Vec3::zeros();

    let pushing = f_n.max(0.0);
    let square = press.square_radius(centre, n);
    let mut turning = -rocking(press, centre, n, relative.w, gamma_n, pushing * square.sqrt());

    let old = std::mem::replace(&mut memory.normal, n);
    memory.overlap = press.deepest;
    if law.mu > 0.0 {
        let along = velocity.dot(&n);
        let motion = FrameMotion {
            n: n.into(),
            old: old.into(),
            twist: 0.5 * relative.both.dot(&n),
            touching: f64::from(u8::from(touching)),
            since: if touching {
                0.0
            } else {
                time_since_touch(press.deepest, along, steps.before)
            },
            steps,
        };
        let (k_t, limit) = (spring.tangential_stiffness * part, law.mu * pushing);
        let over_face = FaceFriction { k_t, gamma_t, square, limit };
        let twisting;
        (friction, twisting) =
            over_face.resist(velocity - n * along, relative.w.dot(&n), memory, &motion);
        force += friction;
        turning += n * twisting;
    }
    let torque = about_centre * scale + turning + centre.cross(&force);
    Response { load: Wrench { force, torque }, scale, sliding: friction, turning }
}

/// Springs and dashpots of friction over a loaded surface.
struct FaceFriction {
    k_t: f64,
    gamma_t: f64,
    /// Mean square distance of the surface from its middle [m²].
    square: f64,
    /// Largest force [N].
    limit: f64,
}

impl FaceFriction {
    /// The force against sliding `across` the normal, and the torque about it against spinning at a
    /// rate.
    fn resist(
        &self,
        across: Vec3,
        rate: f64,
        memory: &mut OverlapHistory,
        motion: &FrameMotion<f64>,
    ) -> (Vec3, f64) {
        let Self { k_t, gamma_t, square, limit } = *self;
        let remembered = kept(memory.k_t, k_t);
        let tangential = TangentialSpring { k_t, inverse_k_t: 0.0, gamma_t, remembered };
        let across = Lane3::from(across);
        let (sliding, xi) = tangential.resist_alike(limit, memory.xi.into(), across, motion);
        let spin = Spin { rate, k: k_t * square, gamma: gamma_t * square, since: motion.since };
        let most = OF_DISC * limit * square.sqrt();
        let twisting = spin.resist(memory, most, motion.touching > 0.0, motion.steps);
        memory.energy = 0.5 * (k_t * xi.dot(xi) + spin.k * memory.turn * memory.turn);
        memory.turn += spin.rate * (0.5 * motion.steps.after);
        (memory.xi, memory.k_t) = (motion.ahead(xi, across).into(), k_t);
        (sliding.into(), twisting)
    }
}

/// Moment that friction of a pressed disc can bear against spinning, over friction and the root of
/// the mean square radius: `2/3 R` over `R/sqrt 2`.
const OF_DISC: f64 = 0.942_809_041_582_063_4;

/// Factor of a displacement as a spring goes from one stiffness to another.
fn kept(before: f64, now: f64) -> f64 {
    if before < now { before / now } else { 1.0 }
}

/// Torque of dashpots over the loaded surface against rocking, no more than pressure can bear.
fn rocking(press: &Press, centre: Vec3, n: Vec3, w: Vec3, gamma: f64, most: f64) -> Vec3 {
    let lever = n.cross(&w);
    let torque = press.spread(centre, lever).cross(&n) * gamma;
    let size = torque.norm_squared().sqrt();
    if size > most { torque * (most / size) } else { torque }
}

/// Spinning about the normal.
struct Spin {
    rate: f64,
    k: f64,
    gamma: f64,
    since: f64,
}

impl Spin {
    /// The torque against it: spring, dashpot and slider.
    fn resist(&self, memory: &mut OverlapHistory, most: f64, touching: bool, steps: Steps) -> f64 {
        let mut turn = if touching {
            memory.turn * kept(memory.k_turn, self.k) + self.rate * (0.5 * steps.before)
        } else {
            self.rate * self.since
        };
        let trial = -(self.k * turn + self.gamma * self.rate);
        let slip = if trial.abs() > most { most / trial.abs() } else { 1.0 };
        turn *= slip;
        (memory.turn, memory.k_turn) = (turn, self.k);
        trial * slip
    }
}
