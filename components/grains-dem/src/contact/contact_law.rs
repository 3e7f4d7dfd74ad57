//! The law of one contact: its springs, dashpots, friction, and whether it may pull.

use crate::contact::contact_force::ContactHistory;
use crate::contact::springs::linear_spring::LinearSpring;
use crate::contact::springs::{
    ContactSpring, Dashpot, Dashpots, Reduced, RegisteredSpring, Stiffness, ask,
};
use crate::math::damping;
use tremie_messages::scene::{ContactLaw, Damping, Spring};

/// Springs, dashpots, friction; the dashpots as functions of the pair's reduced mass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law {
    /// The springs.
    pub spring: RegisteredSpring,
    /// Coefficient of friction.
    pub mu: f64,
    /// Coefficient of rolling friction.
    pub mu_rolling: f64,
    /// True if the dashpot may pull before two bodies separate.
    pub tension: bool,
    /// Gap of the surfaces at which contact begins [m].
    pub gap: f64,
    /// The dashpots.
    pub dashpots: Dashpots,
}

impl Law {
    /// The law of a scene. With a given restitution the damping ratio is the same for all pairs.
    pub fn new(law: &ContactLaw) -> Self {
        let spring = RegisteredSpring::of(&law.spring);
        let by_mass = |zeta: f64| {
            let dashpots = spring.law().dashpots(zeta);
            dashpots.map(|per_root_mass| Dashpot { fixed: 0.0, per_root_mass })
        };
        let [normal, tangential] = match law.damping {
            Damping::Coefficients { normal, tangential } => {
                [normal, tangential].map(|fixed| Dashpot { fixed, per_root_mass: 0.0 })
            }
            Damping::Restitution(e) => by_mass(damping::damping_ratio(e, law.tension)),
            Damping::Ratio(ratio) => by_mass(ratio),
        };
        Self {
            spring,
            mu: law.friction,
            mu_rolling: law.rolling_friction,
            tension: law.tension,
            gap: spring.law().gap(),
            dashpots: Dashpots { normal, tangential },
        }
    }

    /// A law between bodies that never meet.
    pub fn none() -> Self {
        Self::new(&ContactLaw {
            spring: Spring::Linear { normal_stiffness: 0.0, tangential_stiffness: 0.0 },
            friction: 0.0,
            rolling_friction: 0.0,
            damping: Damping::Coefficients { normal: 0.0, tangential: 0.0 },
            tension: false,
        })
    }

    /// The law without friction of any kind.
    pub fn without_friction(&self) -> Self {
        Self { mu: 0.0, mu_rolling: 0.0, ..*self }
    }

    /// The law in a run with steps of a length [s].
    pub fn in_steps(&self, step: f64) -> Self {
        Self { spring: self.spring.in_steps(step), ..*self }
    }

    /// Springs and dashpots at an overlap, after `before` at the last evaluation [m].
    #[inline(always)]
    pub fn at(&self, overlap: f64, before: f64, pair: Reduced) -> Stiffness {
        ask!(&self.spring, law => law.at(overlap, before, pair, &self.dashpots))
    }

    /// Work of the elastic normal force since the overlap was 0 [J].
    #[inline(always)]
    pub fn normal_energy(&self, overlap: f64, pair: Reduced) -> f64 {
        ask!(&self.spring, law => law.normal_energy(overlap, pair))
    }

    /// Slope of the elastic normal force over the overlap [N/m].
    #[inline(always)]
    pub fn normal_slope(&self, overlap: f64, pair: Reduced) -> f64 {
        ask!(&self.spring, law => law.normal_slope(overlap, pair))
    }

    /// The springs as linear ones, if they are.
    #[inline(always)]
    pub fn as_linear(&self) -> Option<LinearSpring> {
        ask!(&self.spring, law => law.as_linear())
    }

    /// Weight of a contact in a region of contacts; see [`ContactSpring::normal_root`].
    #[inline(always)]
    pub fn normal_root(&self, overlap: f64, pair: Reduced) -> f64 {
        ask!(&self.spring, law => law.normal_root(overlap, pair))
    }

    /// True if two bodies are in contact at an overlap [m]; `touching` tells if they were before. A
    /// contact begins at the law's gap, and one that exists ends only beyond the neck.
    #[inline(always)]
    pub fn holds(&self, overlap: f64, pair: Reduced, touching: bool) -> bool {
        overlap > -self.gap || (touching && overlap > -ask!(&self.spring, law => law.neck(pair)))
    }

    /// Energy that a contact's springs hold [J], by its history.
    pub fn remembered_energy(&self, memory: &ContactHistory, pair: Reduced) -> f64 {
        let k_t = self.at(memory.overlap, memory.overlap, pair).k_t;
        let across = memory.xi.norm_squared() + memory.rolling.norm_squared();
        self.normal_energy(memory.overlap, pair) + 0.5 * k_t * across
    }

    /// Springs of a polyhedron's contact where faces touch over the whole reference area. A law
    /// without such a form is refused before a run; if it were not, a load that is no number would
    /// end the run.
    #[inline(always)]
    pub fn over_faces(&self) -> LinearSpring {
        self.as_linear().unwrap_or(LinearSpring::new(f64::NAN, f64::NAN))
    }

    /// Damping ratio of the normal dashpot; that of Hertz's law in the sense of
    /// [`crate::contact::springs::hertz_mindlin`].
    pub fn damping_ratio(&self, pair: Reduced) -> f64 {
        self.at(1.0, 1.0, pair).gamma_n / self.spring.law().critical_dashpot(pair)
    }

    /// Duration of a collision without damping at a relative speed [s].
    pub fn contact_time(&self, pair: Reduced, speed: f64) -> f64 {
        self.spring.law().contact_time(pair, speed)
    }

    /// Largest overlap of an undamped head-on collision at a relative speed [m].
    pub fn largest_overlap(&self, pair: Reduced, speed: f64) -> f64 {
        self.spring.law().largest_overlap(pair, speed)
    }
}
