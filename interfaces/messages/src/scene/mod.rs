//! The scene: geometry, materials, boundaries, bodies. One description, read by all components.
//!
//! All numbers are SI; the manifest's units were resolved before.

mod bodies;
mod contacts;
mod course;
mod domain;
mod drag_bands;
mod fill;
mod gaps;
mod gas;
mod inlets;
mod input_files;
mod parts;
mod polyhedra;
mod probes;
mod profiles;
mod reservoir;
mod ring;
mod slider;
mod surfaces;

pub use bodies::{
    BodySet, BodySizes, Diameters, Motion, MotionPoint, Packing, Placement, SievePoint, Sphere,
    TimedMotion,
};
pub use contacts::{ContactLaw, Damping, PairLaw, Spring, Tangential};
pub use course::{Course, Sine};
pub use domain::{Domain, Face, FluidMaterial, OpenVelocity, Outflow, Plane, Profile};
pub use drag_bands::DragBand;
pub use fill::Fill;
pub use gaps::{Gap, GapRegion, GapRule, GapSide, GapWeight};
pub use gas::{GasMaterial, GasRegion, Shock, Vortex};
pub use inlets::{Inlet, InletVelocity, Outlet};
pub use input_files::{INPUTS, InputFiles};
pub use parts::{Geometry, Part, PartBoundary, Pose};
pub use polyhedra::{Polyhedra, Polyhedron, PolyhedronPlacement, Shape};
pub use probes::{Probe, ProbeShape};
pub use profiles::{BinnedAxis, GrainProfile, ProfileSchedule, ProfileVelocity};
pub use reservoir::{Reservoir, ReservoirMode};
pub use ring::Ring;
pub use slider::{Slider, SliderSpring, Stops};
pub use surfaces::{DeformableSurface, FacetKind, Section, SectionEdge, SurfaceStart};

use serde::{Deserialize, Serialize};

/// The scene: the system that is simulated, independent of the method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Acceleration of gravity [m/s²]. Grains apply it to their mass; a fluid includes buoyancy.
    pub gravity: [f64; 3],
    /// The box in which everything happens.
    pub domain: Domain,
    /// The fluid's material; `None` for a dry run.
    pub fluid: Option<FluidMaterial>,
    /// Plane walls besides the domain's faces, seen by grains; a fluid that cannot honour them
    /// refuses.
    pub planes: Vec<Plane>,
    /// Surfaces of rigid parts: walls, things that move, regions with boundary conditions.
    pub parts: Vec<Part>,
    /// Surfaces that change their shape: seals of rubber, each carried by a part.
    #[serde(default)]
    pub surfaces: Vec<DeformableSurface>,
    /// Shapes of polyhedra.
    #[serde(default)]
    pub shapes: Vec<Shape>,
    /// Spheres and polyhedra, in sets of one material and motion.
    pub bodies: Vec<BodySet>,
    /// Clumps, by name, whose mass, centre, inertia and displaced volume are those of the union of
    /// their bodies. All others are as heavy as their bodies together, and displace as much, also
    /// where these overlap. In a union each place has the mean density of the bodies that hold it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unions: Vec<String>,
    /// Inlets, which add spheres during the run.
    #[serde(default)]
    pub inlets: Vec<Inlet>,
    /// Outlets, which remove spheres.
    #[serde(default)]
    pub outlets: Vec<Outlet>,
    /// Boxes in which grains are braked.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drag_bands: Vec<DragBand>,
    /// Names of sets of bodies, and of clumps, whose motion and loads are to be signals, body by
    /// body, besides those that are anyway.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub followed: Vec<String>,
    /// Contact laws, one for each pair of materials that may touch.
    pub contacts: Vec<PairLaw>,
    /// Probes: places where the run measures.
    pub probes: Vec<Probe>,
    /// Profiles: tables of what the grains do in the bins of a box.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub profiles: Vec<GrainProfile>,
    /// Gaps that open and close.
    #[serde(default)]
    pub gaps: Vec<Gap>,
}

impl Scene {
    /// An empty dry box without weight.
    pub fn empty(domain: Domain) -> Self {
        Self {
            gravity: [0.0; 3],
            domain,
            fluid: None,
            planes: Vec::new(),
            parts: Vec::new(),
            surfaces: Vec::new(),
            shapes: Vec::new(),
            bodies: Vec::new(),
            unions: Vec::new(),
            inlets: Vec::new(),
            outlets: Vec::new(),
            drag_bands: Vec::new(),
            followed: Vec::new(),
            contacts: Vec::new(),
            probes: Vec::new(),
            profiles: Vec::new(),
            gaps: Vec::new(),
        }
    }

    /// Names and units of the signals of all probes, `probe.value` in their order. `values` gives
    /// the values and units that a component measures at a probe of a shape.
    pub fn probe_signals(
        &self,
        values: impl Fn(&ProbeShape) -> &'static [(&'static str, &'static str)],
    ) -> Vec<(String, &'static str)> {
        let named = |probe: &Probe| {
            let of =
                |(value, unit): &(&str, &'static str)| (format!("{}.{value}", probe.name), *unit);
            values(&probe.shape).iter().map(of).collect::<Vec<_>>()
        };
        self.probes.iter().flat_map(named).collect()
    }

    /// True if any body is a polyhedron.
    pub fn has_polyhedra(&self) -> bool {
        self.bodies.iter().any(|set| matches!(set.placement, Placement::Polyhedra(_)))
    }

    /// True if spheres leave the run through a face of the domain: the face is open, and an outlet
    /// removes spheres whose centre has come that far.
    pub fn is_way_out(&self, axis: usize, side: usize) -> bool {
        let domain = &self.domain;
        let before = |outlet: &Outlet| match side {
            0 => outlet.at >= domain.min[axis],
            _ => outlet.at <= domain.max[axis],
        };
        let of = |outlet: &&Outlet| outlet.axis == axis && outlet.side == side && before(outlet);
        domain.faces[axis][side].is_open() && self.outlets.iter().any(|outlet| of(&outlet))
    }

    /// The contact law between two materials, in either order.
    pub fn law(&self, one: &str, other: &str) -> Option<&ContactLaw> {
        let of = |pair: &&PairLaw| {
            let [a, b] = &pair.between;
            (a == one && b == other) || (a == other && b == one)
        };
        self.contacts.iter().find(of).map(|pair| &pair.law)
    }
}
