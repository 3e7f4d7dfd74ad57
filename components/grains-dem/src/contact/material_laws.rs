//! The contact laws of a scene as a table by materials.

use crate::bodies::deformable_surface::DeformableSurface;
use crate::bodies::mirrors;
use crate::contact::contact_law::Law;
use crate::contact::linear_contact::LinearLaw;
use crate::contact::springs::{Reduced, RegisteredSpring};
use tremie_grains_kit::space::plane_walls;
use tremie_messages::scene::{Face, Motion, Scene};

/// Materials of a scene by number, and the law of each pair of them.
#[derive(Clone, Debug)]
pub(crate) struct Laws {
    materials: Vec<String>,
    /// The laws; the first is that of materials that never meet.
    laws: Vec<Law>,
    /// `of_pair[a * materials + b]` is an index of `laws`.
    of_pair: Vec<u16>,
}

/// Wall or part that a body may touch.
pub(crate) struct Surface<'a> {
    /// Name for the user.
    pub name: String,
    /// Its material.
    pub material: &'a str,
    /// True for a symmetry plane, which has no friction.
    pub mirror: bool,
    /// Effective mass against a push [kg]: infinite, except for sliders, whose mirrored half takes
    /// its part of the mass.
    pub mass: f64,
}

impl Laws {
    /// The table of a scene, and of surfaces besides.
    pub fn of_scene(scene: &Scene, others: &[DeformableSurface]) -> Self {
        let mut materials: Vec<String> = Vec::new();
        let mut add = |name: &str| {
            if !materials.iter().any(|known| known == name) {
                materials.push(name.into());
            }
        };
        add(&scene.domain.material);
        scene.planes.iter().for_each(|plane| add(&plane.material));
        scene.parts.iter().for_each(|part| add(&part.material));
        scene.bodies.iter().for_each(|set| add(&set.material));
        others.iter().for_each(|surface| add(&surface.material));
        let mut laws = vec![Law::none()];
        let mut of_pair = vec![0; materials.len() * materials.len()];
        for pair in &scene.contacts {
            let number = |name: &String| materials.iter().position(|known| known == name);
            if let (Some(a), Some(b)) = (number(&pair.between[0]), number(&pair.between[1])) {
                let place = [a * materials.len() + b, b * materials.len() + a];
                if of_pair[place[0]] == 0 {
                    for place in place {
                        of_pair[place] = laws.len() as u16;
                    }
                    laws.push(Law::new(&pair.law));
                }
            }
        }
        Self { materials, laws, of_pair }
    }

    /// Number of a material of the scene.
    pub fn material(&self, name: &str) -> u16 {
        // Every material of the scene is in the table; another would meet nothing.
        self.materials.iter().position(|known| known == name).unwrap_or(0) as u16
    }

    /// Number of materials.
    pub fn materials(&self) -> u16 {
        self.materials.len() as u16
    }

    /// Number of the law between two materials.
    #[inline(always)]
    pub fn between(&self, a: u16, b: u16) -> u16 {
        self.of_pair[a as usize * self.materials.len() + b as usize]
    }

    /// The laws by number.
    pub fn laws(&self) -> &[Law] {
        &self.laws
    }

    /// The law between bodies of these materials, if it is one for all, and linear.
    pub fn only(&self, materials: &[u16]) -> Option<LinearLaw> {
        let first = *materials.first()?;
        let only = self.between(first, first);
        let mut pairs = materials.iter().flat_map(|&a| materials.iter().map(move |&b| (a, b)));
        let same = pairs.all(|(a, b)| self.between(a, b) == only);
        same.then(|| LinearLaw::of(&self.laws[only as usize])).flatten()
    }

    /// Number of a law that is `law` without friction, added at the end.
    pub fn add_mirror(&mut self, law: u16) -> u16 {
        self.laws.push(self.laws[law as usize].without_friction());
        (self.laws.len() - 1) as u16
    }

    /// Gives the laws the length of the steps of a run [s].
    pub fn set_steps(&mut self, step: f64) {
        self.laws.iter_mut().for_each(|law| *law = law.in_steps(step));
    }

    /// True if any law has rolling friction.
    pub fn resist_rolling(&self) -> bool {
        self.laws.iter().any(|law| law.mu_rolling > 0.0)
    }
}

/// The largest gap of surfaces in contact, of bodies of a scene, the largest of a diameter, or of
/// these with walls [m]: the longest neck, and the largest gap at which contact begins.
pub(crate) fn longest_neck(scene: &Scene, largest: f64) -> f64 {
    let pair = Reduced { radius: 0.5 * largest, ..Reduced::NONE };
    let necks = scene.contacts.iter().map(|contact| {
        let spring = RegisteredSpring::of(&contact.law.spring);
        spring.law().neck(pair).max(spring.law().gap())
    });
    necks.fold(0.0, f64::max)
}

/// Everything but bodies that grains may meet.
pub(crate) fn surfaces(scene: &Scene) -> Vec<Surface<'_>> {
    let (domain, mass) = (&scene.domain, f64::INFINITY);
    let mut found = Vec::new();
    for (axis, faces) in domain.faces.iter().enumerate() {
        for (side, face) in faces.iter().enumerate() {
            if plane_walls::holds(scene, axis, side) {
                let (side, axis) = (["lower", "upper"][side], ["x", "y", "z"][axis]);
                let name = format!("the domain's {side} face in {axis}");
                let mirror = *face == Face::Symmetry;
                found.push(Surface { name, material: &domain.material, mirror, mass });
            }
        }
    }
    for (i, plane) in scene.planes.iter().enumerate() {
        let name = format!("plane {i}");
        found.push(Surface { name, material: &plane.material, mirror: false, mass });
    }
    for part in &scene.parts {
        let name = format!("part \"{}\"", part.name);
        let mass = match &part.motion {
            Motion::Slider(slider) => {
                slider.mass / mirrors::whole(mirrors::of_part(domain, part.pose.position))
            }
            _ => mass,
        };
        found.push(Surface { name, material: &part.material, mirror: false, mass });
    }
    found
}
