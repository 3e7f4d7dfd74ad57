//! Hoppers: `[[scene.hoppers]]` as fixed parts and bodies that the rest of a run knows anyway.

use super::super::document::{HopperTable, SceneTable};
use super::super::path;
use super::super::read::Findings;
use super::{parts, rough_walls};
use std::collections::BTreeSet;
use tremie_messages::finding::short;
use tremie_messages::scene::{
    BodySet, Domain, Geometry, Motion, Part, PartBoundary, Placement, Pose,
};

/// Part of a length that counts as none: rounding.
const ROUNDING: f64 = 1e-9;
const AXES: [&str; 3] = ["x", "y", "z"];

/// Shape and place of a hopper. Its plane has the coordinates `a`, from the middle across, and `h`,
/// from the slit upstream [m].
#[derive(Clone, Copy, Debug)]
pub(super) struct Hopper {
    /// Axes of the flow, across, and of the depth.
    pub axes: [usize; 3],
    /// 1 where `h` goes to larger coordinates, or -1.
    upstream: f64,
    /// Where the slit is [m], and the middle.
    exit: f64,
    centre: f64,
    /// Sine and cosine of the angle to the section.
    pub sine: f64,
    pub cosine: f64,
    /// Half the slit, and half the channel [m].
    pub half_slit: f64,
    pub half_width: f64,
    /// How far the walls reach upstream [m].
    pub height: f64,
    /// Distance from the middle to each face of the domain across, lower before upper [m].
    room: [f64; 2],
    /// Diameter of spheres on the walls; 0 where they are smooth [m].
    pub diameter: f64,
}

impl Hopper {
    /// Height of the leaning walls [m].
    fn slope(&self) -> f64 {
        (self.half_width - self.half_slit) * self.sine / self.cosine
    }

    /// The place in the world of a place in the hopper's plane, at a depth [m].
    pub fn place(&self, [a, h]: [f64; 2], depth: f64) -> [f64; 3] {
        let mut x = [0.0; 3];
        x[self.axes[0]] = self.exit + self.upstream * h;
        x[self.axes[1]] = self.centre + a;
        x[self.axes[2]] = depth;
        x
    }

    /// The section of the solid on a side, for the spheres moved back by their diameter.
    fn outline(&self, side: usize) -> Vec<[f64; 2]> {
        let back = self.diameter;
        let face = self.room[side];
        let channel = self.half_width + back;
        let tip = self.half_slit + back / self.sine;
        // The leaning wall reaches the channel's, or the face of the domain, at this height.
        let at = |a: f64| (a - tip) * self.sine / self.cosine;
        if face - channel <= ROUNDING * face {
            return vec![[tip, 0.0], [face, 0.0], [face, at(face)]];
        }
        let top = self.height;
        let mut outline = vec![[tip, 0.0], [face, 0.0], [face, top], [channel, top]];
        if top - at(channel) > ROUNDING * top {
            outline.push([channel, at(channel)]);
        }
        outline
    }

    /// The solid on a side.
    fn part(&self, side: usize, name: String, material: String, domain: &Domain) -> Part {
        let depth = self.axes[2];
        let sign = [-1.0, 1.0][side];
        let other = |axis: usize| (0..3).filter(|&a| a != depth).position(|a| a == axis);
        let outline = (self.outline(side).into_iter())
            .map(|[a, h]| {
                let x = self.place([sign * a, h], 0.0);
                let mut corner = [0.0; 2];
                for axis in [self.axes[0], self.axes[1]] {
                    corner[other(axis).unwrap_or_default()] = x[axis];
                }
                corner
            })
            .collect();
        let length = domain.size()[depth];
        let mut position = [0.0; 3];
        position[depth] = 0.5 * (domain.min[depth] + domain.max[depth]);
        Part {
            name,
            geometry: Geometry::Extruded { outline, axis: depth, length },
            pose: Pose { position, ..Pose::IDENTITY },
            cavity: false,
            material,
            motion: Motion::Fixed,
            boundary: PartBoundary::Wall,
        }
    }
}

/// The parts and the bodies of all hoppers; `None` for each that is wrong.
pub(super) fn hoppers(
    scene: &SceneTable,
    domain: Option<&Domain>,
    findings: &mut Findings,
) -> (Vec<Option<Part>>, Vec<Option<BodySet>>) {
    let (mut all_parts, mut sets) = (Vec::new(), Vec::new());
    let mut names = BTreeSet::new();
    for (i, table) in scene.hoppers.iter().enumerate() {
        let at = path::item("scene.hoppers", i);
        let name = parts::name(&table.name, "hopper", &at, &mut names, findings);
        if let Some(name) = &name {
            is_free(name, table, scene, &at, findings);
        }
        let hopper = domain.and_then(|domain| hopper(table, domain, &at, findings));
        let (Some(name), Some(hopper), Some(domain)) = (name, hopper, domain) else {
            all_parts.push(None);
            continue;
        };
        let material = table.material.clone().unwrap_or_else(|| Domain::MATERIAL.into());
        for (side, suffix) in ["lower", "upper"].into_iter().enumerate() {
            let name = format!("{name}-{suffix}");
            all_parts.push(Some(hopper.part(side, name, material.clone(), domain)));
        }
        if table.rough.is_some() {
            let spheres = rough_walls::spheres(&hopper, domain, &at, findings);
            sets.push(spheres.map(|spheres| BodySet {
                name: rough_name(&name),
                // Nothing weighs what is held.
                density: density(scene, &material),
                material,
                motion: Motion::Fixed,
                clump: None,
                placement: Placement::Listed(spheres),
            }));
        }
    }
    (all_parts, sets)
}

/// The set of the spheres on a hopper's walls.
fn rough_name(hopper: &str) -> String {
    format!("{hopper}-rough")
}

/// Density of what is made of a material [kg/m³]: its own, or that of water where it has none.
fn density(scene: &SceneTable, material: &str) -> f64 {
    let own = scene.materials.get(material).and_then(|material| material.density);
    own.filter(|density| density.0 > 0.0).map_or(1000.0, |density| density.0)
}

/// Notes a part or a set of bodies that has a name which the hopper gives to its own.
fn is_free(name: &str, table: &HopperTable, scene: &SceneTable, at: &str, findings: &mut Findings) {
    let own = ["lower", "upper"].map(|side| format!("{name}-{side}"));
    let is_own = |other: &Option<String>| own.iter().any(|own| other.as_ref() == Some(own));
    let part = scene.parts.iter().find(|part| is_own(&part.name));
    let rough = rough_name(name);
    let set = scene.bodies.iter().find(|set| set.name.as_ref() == Some(&rough));
    let taken = match (part, set.filter(|_| table.rough.is_some())) {
        (Some(part), _) => part.name.as_ref().map(|name| ("part", name)),
        (None, Some(_)) => Some(("set of bodies", &rough)),
        (None, None) => None,
    };
    if let Some((what, taken)) = taken {
        let message = format!("the hopper makes a {what} \"{taken}\", but there is one");
        findings.problem(&path::join(at, "name"), message);
    }
}

/// The shape of a hopper that fits into the domain.
fn hopper(
    table: &HopperTable,
    domain: &Domain,
    at: &str,
    findings: &mut Findings,
) -> Option<Hopper> {
    let (axes, upstream) = axes(table, domain, at, findings)?;
    let [flow, across, _] = axes;
    let angle = findings.required(&table.angle, at, "angle");
    let slit = findings.positive(&table.slit, at, "slit");
    let exit = findings.required(&table.exit, at, "exit");
    let diameter = match &table.rough {
        Some(rough) => findings.positive(&rough.diameter, &path::join(at, "rough"), "diameter"),
        None => Some(0.0),
    };
    let (angle, slit, exit, diameter) = (angle?.0, slit?, exit?.0, diameter?);
    if !(angle > 0.0 && angle < std::f64::consts::FRAC_PI_2) {
        let degrees = short(angle.to_degrees());
        let message = format!("found {degrees} deg, expected more than 0 and less than 90 deg");
        findings.problem(&path::join(at, "angle"), message);
        return None;
    }
    let [low, high] = [domain.min[across], domain.max[across]];
    let centre = table.centre.map_or(0.5 * (low + high), |centre| centre.0);
    let room = [centre - low, high - centre];
    let widest = 2.0 * (room[0].min(room[1]) - diameter);
    let width = match table.width {
        Some(_) => findings.positive(&table.width, at, "width")?,
        None => widest,
    };
    let end = if upstream > 0.0 { domain.max[flow] } else { domain.min[flow] };
    let (sine, cosine) = libm::sincos(angle);
    let hopper = Hopper {
        axes,
        upstream,
        exit,
        centre,
        sine,
        cosine,
        half_slit: 0.5 * slit,
        half_width: 0.5 * width,
        height: table.height.map_or(upstream * (end - exit), |height| height.0),
        room,
        diameter,
    };
    let fits = is_wide(table, &hopper, widest, at, findings)
        && is_long(table, &hopper, (domain, end), at, findings);
    (fits && is_covered(&hopper, domain, at, findings)).then_some(hopper)
}

/// True if the spheres of rough walls have room on them.
fn is_covered(hopper: &Hopper, domain: &Domain, at: &str, findings: &mut Findings) -> bool {
    let (diameter, depth) = (hopper.diameter, domain.size()[hopper.axes[2]]);
    let key = path::join(&path::join(at, "rough"), "diameter");
    // The solid behind them begins beyond the slit by this much.
    let back = diameter / hopper.sine - diameter;
    if domain.across.is_none() && diameter > depth {
        let message = format!(
            "found {} m, more than the depth of the domain, {} m",
            short(diameter),
            short(depth)
        );
        findings.problem(&key, message);
        return false;
    }
    let leaning = hopper.half_width - hopper.half_slit;
    if diameter > 0.0 && back >= leaning {
        let message = format!(
            "found {} m, too much for walls that lean over {} m only",
            short(diameter),
            short(leaning)
        );
        findings.problem(&key, message);
        return false;
    }
    true
}

/// Axes of the flow, across and of the depth, and the sign of the way upstream.
fn axes(
    table: &HopperTable,
    domain: &Domain,
    at: &str,
    findings: &mut Findings,
) -> Option<([usize; 3], f64)> {
    let flow = findings.required(&table.flow, at, "flow");
    let across = findings.required(&table.across, at, "across");
    let ((flow, sign), across) = (flow?.axis_and_sign(), across?.number());
    let key = path::join(at, "across");
    if flow == across {
        let message = format!("found {}, the axis of the flow, expected another", AXES[across]);
        findings.problem(&key, message);
        return None;
    }
    let depth = 3 - flow - across;
    if domain.is_periodic(across) {
        let message = format!(
            "found {}, along which the domain wraps around: a hopper narrows a space between walls",
            AXES[across]
        );
        findings.problem_with_help(&key, message, "make the domain's faces there walls");
        return None;
    }
    if domain.across.is_some_and(|plane| plane != depth) {
        let message = format!(
            "makes {} the depth of the hopper, but the scene is plane across {}",
            AXES[depth],
            AXES[domain.across.unwrap_or_default()]
        );
        findings.problem(&key, message);
        return None;
    }
    Some(([flow, across, depth], -sign))
}

/// True if the channel fits into the domain, and the slit into the channel.
fn is_wide(
    table: &HopperTable,
    hopper: &Hopper,
    widest: f64,
    at: &str,
    findings: &mut Findings,
) -> bool {
    let [width, slit] = [hopper.half_width, hopper.half_slit].map(|half| 2.0 * half);
    let spheres = if hopper.diameter > 0.0 { " beside the spheres on its walls" } else { "" };
    if hopper.room.iter().any(|room| *room <= 0.0) {
        let message = format!("found {} m, outside the domain", short(hopper.centre));
        findings.problem(&path::join(at, "centre"), message);
    } else if width > widest * (1.0 + ROUNDING) {
        let message = format!(
            "found {} m, but the domain has room for {} m{spheres}",
            short(width),
            short(widest)
        );
        findings.problem(&path::join(at, "width"), message);
    } else if slit >= width {
        let whose = if table.width.is_some() { "" } else { ", for which the domain has room" };
        let message = format!(
            "found {} m, expected less than the width of the channel, {} m{whose}",
            short(slit),
            short(width)
        );
        findings.problem(&path::join(at, "slit"), message);
    } else {
        return true;
    }
    false
}

/// True if the leaning walls and what lies above them fit into the domain.
fn is_long(
    table: &HopperTable,
    hopper: &Hopper,
    (domain, end): (&Domain, f64),
    at: &str,
    findings: &mut Findings,
) -> bool {
    let flow = hopper.axes[0];
    let (room, slope) = (hopper.upstream * (end - hopper.exit), hopper.slope());
    let slack = ROUNDING * domain.size()[flow];
    if hopper.exit < domain.min[flow] || hopper.exit > domain.max[flow] {
        let message = format!(
            "found {} m, outside the domain, which reaches from {} to {} m there",
            short(hopper.exit),
            short(domain.min[flow]),
            short(domain.max[flow])
        );
        findings.problem(&path::join(at, "exit"), message);
    } else if slope > room + slack {
        let message = format!(
            "the hopper is {} m long, but from its exit upstream the domain has {} m",
            short(slope),
            short(room)
        );
        let help = "make the domain longer, or angle or width smaller";
        findings.problem_with_help(at, message, help);
    } else if hopper.height > room + slack {
        let message = format!(
            "found {} m, but from the exit upstream the domain has {} m",
            short(hopper.height),
            short(room)
        );
        findings.problem(&path::join(at, "height"), message);
    } else if table.height.is_some() && hopper.height < slope - slack {
        let message = format!(
            "found {} m, expected at least the height of the leaning walls, {} m",
            short(hopper.height),
            short(slope)
        );
        findings.problem(&path::join(at, "height"), message);
    } else {
        return true;
    }
    false
}
