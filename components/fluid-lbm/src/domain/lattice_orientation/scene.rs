//! A scene as the lattice sees it.

use super::LatticeOrientation;
use tremie_messages::scene::{
    Domain, Face, FluidMaterial, Gap, GapRegion, GapRule, GapSide, Inlet, InletVelocity, Motion,
    MotionPoint, OpenVelocity, Outlet, Part, PartBoundary, Plane, Pose, Probe, ProbeShape, Ring,
    Scene, Slider, TimedMotion,
};

impl LatticeOrientation {
    /// A scene by the lattice's axes, but for its sets of bodies: a fluid gets to know those from
    /// events.
    pub fn scene(self, scene: &Scene) -> Scene {
        Scene {
            gravity: self.to_lattice(&scene.gravity),
            domain: self.domain(&scene.domain),
            fluid: scene.fluid.as_ref().map(|fluid| self.fluid(fluid)),
            planes: scene.planes.iter().map(|plane| self.plane(plane)).collect(),
            parts: scene.parts.iter().map(|part| self.part(part)).collect(),
            // Where they are in their carriers.
            surfaces: scene.surfaces.clone(),
            // In frames of their own.
            shapes: scene.shapes.clone(),
            bodies: Vec::new(),
            unions: Vec::new(),
            inlets: scene.inlets.iter().map(|inlet| self.inlet(inlet)).collect(),
            outlets: scene.outlets.iter().map(|outlet| self.outlet(outlet)).collect(),
            // They brake grains alone.
            drag_bands: Vec::new(),
            followed: scene.followed.clone(),
            contacts: scene.contacts.clone(),
            probes: scene.probes.iter().map(|probe| self.probe(probe)).collect(),
            // Of grains alone, which do not turn.
            profiles: Vec::new(),
            gaps: scene.gaps.iter().map(|gap| self.gap(gap)).collect(),
        }
    }

    fn domain(self, domain: &Domain) -> Domain {
        Domain {
            min: self.to_lattice(&domain.min),
            max: self.to_lattice(&domain.max),
            faces: self.to_lattice(&domain.faces).map(|sides| sides.map(|face| self.face(face))),
            levels: self.to_lattice(&domain.levels),
            material: domain.material.clone(),
            across: domain.across,
        }
    }

    fn face(self, face: Face) -> Face {
        match face {
            Face::Wall { velocity, course } => {
                Face::Wall { velocity: self.to_lattice(&velocity), course }
            }
            Face::Velocity(open) => {
                Face::Velocity(OpenVelocity { velocity: self.to_lattice(&open.velocity), ..open })
            }
            Face::Periodic | Face::Symmetry | Face::Pressure { .. } | Face::Reservoir(_) => face,
        }
    }

    fn fluid(self, fluid: &FluidMaterial) -> FluidMaterial {
        let points = |points: &[[f64; 3]]| points.iter().map(|x| self.to_lattice(x)).collect();
        FluidMaterial {
            acceleration: self.to_lattice(&fluid.acceleration),
            velocity: self.to_lattice(&fluid.velocity),
            inside: points(&fluid.inside),
            outside: points(&fluid.outside),
            ..fluid.clone()
        }
    }

    fn plane(self, plane: &Plane) -> Plane {
        Plane {
            point: self.to_lattice(&plane.point),
            normal: self.to_lattice(&plane.normal),
            material: plane.material.clone(),
        }
    }

    fn part(self, part: &Part) -> Part {
        let boundary = match &part.boundary {
            PartBoundary::Velocity { velocity, course } => PartBoundary::Velocity {
                velocity: self.to_lattice(velocity),
                course: course.clone(),
            },
            other @ (PartBoundary::Wall
            | PartBoundary::Pressure { .. }
            | PartBoundary::Reservoir(_)) => other.clone(),
        };
        Part {
            pose: self.pose(&part.pose),
            motion: self.motion(&part.motion),
            boundary,
            ..part.clone()
        }
    }

    fn pose(self, pose: &Pose) -> Pose {
        Pose { position: self.to_lattice(&pose.position), orientation: self.turn(pose.orientation) }
    }

    fn motion(self, motion: &Motion) -> Motion {
        let point = |point: &MotionPoint| MotionPoint {
            time: point.time,
            velocity: self.to_lattice(&point.velocity),
            angular_velocity: self.to_lattice(&point.angular_velocity),
        };
        match motion {
            Motion::Prescribed(points) => Motion::Prescribed(points.iter().map(point).collect()),
            Motion::Timed(timed) => Motion::Timed(Box::new(TimedMotion {
                velocity: self.to_lattice(&timed.velocity),
                angular_velocity: self.to_lattice(&timed.angular_velocity),
                course: timed.course.clone(),
            })),
            Motion::Slider(slider) => Motion::Slider(Box::new(Slider {
                axis: self.to_lattice(&slider.axis),
                ..(**slider).clone()
            })),
            Motion::Free | Motion::Fixed => motion.clone(),
        }
    }

    fn inlet(self, inlet: &Inlet) -> Inlet {
        let velocity = match inlet.velocity {
            InletVelocity::Given(velocity) => InletVelocity::Given(self.to_lattice(&velocity)),
            InletVelocity::Face { axis, side } => {
                InletVelocity::Face { axis: self.axis_to_lattice(axis), side }
            }
        };
        Inlet {
            min: self.to_lattice(&inlet.min),
            max: self.to_lattice(&inlet.max),
            velocity,
            ..inlet.clone()
        }
    }

    fn outlet(self, outlet: &Outlet) -> Outlet {
        Outlet { axis: self.axis_to_lattice(outlet.axis), ..outlet.clone() }
    }

    fn probe(self, probe: &Probe) -> Probe {
        let at = |x: &[f64; 3]| self.to_lattice(x);
        let shape = match &probe.shape {
            ProbeShape::Point(point) => ProbeShape::Point(at(point)),
            ProbeShape::Line { from, to } => ProbeShape::Line { from: at(from), to: at(to) },
            ProbeShape::Section { axis, position, min, max } => ProbeShape::Section {
                axis: self.axis_to_lattice(*axis),
                position: *position,
                min: at(min),
                max: at(max),
            },
            ProbeShape::Profile { axis, position, min, max, along, bins } => ProbeShape::Profile {
                axis: self.axis_to_lattice(*axis),
                position: *position,
                min: at(min),
                max: at(max),
                along: self.axis_to_lattice(*along),
                bins: *bins,
            },
            ProbeShape::Region { min, max } => ProbeShape::Region { min: at(min), max: at(max) },
            ProbeShape::Ring(ring) => ProbeShape::Ring(Ring {
                axis: self.axis_to_lattice(ring.axis),
                through: at(&ring.through),
                ..ring.clone()
            }),
        };
        Probe { name: probe.name.clone(), shape }
    }

    fn gap(self, gap: &Gap) -> Gap {
        let side = |side: GapSide| match side {
            GapSide::Part(name) => GapSide::Part(name),
            GapSide::Face { axis, side } => {
                GapSide::Face { axis: self.axis_to_lattice(axis), side }
            }
        };
        let region = |region: GapRegion| match region {
            GapRegion::Box { min, max } => {
                GapRegion::Box { min: self.to_lattice(&min), max: self.to_lattice(&max) }
            }
            GapRegion::Ring { axis, through, radii } => GapRegion::Ring {
                axis: self.axis_to_lattice(axis),
                through: self.to_lattice(&through),
                radii,
            },
        };
        let pressure = match &gap.pressure {
            rule @ (GapRule::Zero | GapRule::Nearest | GapRule::Probes(_)) => rule.clone(),
        };
        Gap {
            between: gap.between.clone().map(side),
            region: gap.region.map(region),
            pressure,
            ..gap.clone()
        }
    }
}
