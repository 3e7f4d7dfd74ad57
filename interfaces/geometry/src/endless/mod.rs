//! Parts that go through periodic faces: one rule, for fluid and grains alike.
//!
//! A part that reaches to both faces of a periodic axis, or beyond them, is *endless* along that
//! axis. Of its surface counts what lies between the faces; it goes on beyond them as the domain
//! does, from one period to the next. What the part has beyond the faces, its ends above all, is no
//! wall. So its cross-sections at the two faces must be the same.
//!
//! The surface of such a part is made anew ([`Surface::in_domain`]): cut at the faces (`patch`),
//! its two cross-sections joined (`seams`), three periods of it in a row, and closed far beyond the
//! faces (`ends`), so that what is inside stays decided by winding numbers. The triangles that
//! close it come last; no question about what is near finds them.
//!
//! A part that reaches beyond one face only comes in again at the other.

mod ends;
mod fault;
mod patch;
mod seams;

pub use fault::EndlessFault;

use crate::{Bounds, Frame, GeometryError, Mesh, Surface, Vec3};
use patch::Patch;
use tremie_messages::Problem;
use tremie_messages::scene::{Domain, Motion, Part, Pose};

/// Tolerance of ends and cross-sections, over the size of the domain and the part: files hold
/// numbers of single precision.
const TOLERANCE: f64 = 1e-6;

/// Axes along which a part goes on through periodic faces, and its places there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Endless {
    /// Along which axes of the world it has no ends.
    pub axes: [bool; 3],
    /// Along which of these its cross-section is the same everywhere.
    pub straight: [bool; 3],
    /// Origin of its frame as the scene places it, brought into the domain along the axes [m].
    origin: Vec3,
    /// Edge lengths of the domain [m].
    period: Vec3,
}

impl Endless {
    /// Place of the surface when the part's origin is at `position` [m]: along an axis on which the
    /// part is straight always at the same place, along another endless one within half a period of
    /// where the scene has it.
    pub fn place(&self, position: impl Into<Vec3>) -> Vec3 {
        let mut position = position.into();
        for a in (0..3).filter(|&a| self.axes[a]) {
            let away = position[a] - self.origin[a];
            let periods = libm::round(away / self.period[a]);
            // At home no bit changes.
            if self.straight[a] || away == 0.0 {
                position[a] = self.origin[a];
            } else if periods != 0.0 {
                position[a] -= periods * self.period[a];
            }
        }
        position
    }

    /// Edge lengths of the domain [m].
    pub fn period(&self) -> Vec3 {
        self.period
    }

    /// True if it is endless along any axis.
    pub fn is_any(&self) -> bool {
        self.axes != [false; 3]
    }
}

/// Properties of one period of an endless surface.
#[derive(Clone, Debug)]
pub(crate) struct Period {
    pub endless: Endless,
    /// Its triangles that are walls; those that close it come after them.
    pub walls: u32,
    /// Number of periods of the domain among them.
    pub copies: f64,
    /// Volume of one period [m³] and its centre in the part's frame.
    pub volume: f64,
    pub centroid: Vec3,
    /// Distance of the farthest point from the origin, across the axes [m].
    pub radius: f64,
}

impl Surface {
    /// The surface of a part as the domain has it, in the part's frame; of a cavity that of the
    /// space inside, as [`Surface::of`] gives it.
    ///
    /// # Errors
    /// As [`load`](crate::load), and parts that cannot go on through periodic faces.
    pub fn in_domain(part: &Part, domain: &Domain) -> Result<Self, GeometryError> {
        let whole = Self::of(&part.geometry)?;
        let frame = Frame::of(&part.pose);
        let bounds = Bounds::of(whole.mesh().vertices.iter().map(|&v| frame.to_world(v)));
        let axes = endless_axes(&bounds, domain)?;
        if axes == [false; 3] {
            return Ok(whole);
        }
        let tolerance = TOLERANCE * bounds.size().sup(&domain.size().into()).max().max(0.0);
        let mut patch = Patch::of(whole.mesh(), |v| frame.to_world(v));
        for a in (0..3).filter(|&a| axes[a]) {
            patch.cut(a, domain.min[a], 1.0, tolerance);
            patch.cut(a, domain.max[a], -1.0, tolerance);
        }
        if patch.faces.is_empty() {
            return Err(EndlessFault::NoWall { axes }.into());
        }
        let origin = home(part.pose.position.into(), axes, domain);
        let frame = Frame::of(&Pose { position: origin.into(), ..part.pose });
        let endless = Endless {
            axes,
            straight: [0, 1, 2].map(|a| axes[a] && patch.is_straight(a, tolerance)),
            origin,
            period: domain.size().into(),
        };
        let ([volume, area], centroid) = one_period(&patch, axes);
        for a in (0..3).filter(|&a| axes[a]) {
            seams::join(
                &mut patch,
                a,
                [domain.min[a], domain.max[a]],
                endless.straight[a],
                tolerance,
            )?;
        }
        let walls = patch.triangles();
        let radius = radius_across(&patch, axes, origin);
        let mesh = ends::closed(patch, walls.clone(), endless.axes, domain)?;
        let copies = mesh_area(&mesh, walls.len()) / area;
        let vertices = mesh.vertices.iter().map(|&v| frame.to_part(v)).collect();
        let period = Period {
            endless,
            walls: walls.len() as u32,
            copies,
            volume,
            centroid: frame.to_part(centroid),
            radius,
        };
        let mesh = Mesh { vertices, triangles: mesh.triangles };
        let mut own = Self::of_period(mesh, period, &whole)?;
        own.far = difference([&whole, &own], [Frame::of(&part.pose), frame], domain);
        Ok(own)
    }

    /// Its way through periodic faces.
    pub fn endless(&self) -> Endless {
        self.period.as_ref().map_or_else(Endless::default, |period| period.endless)
    }
}

/// The axes along which a part of such bounds is endless.
fn endless_axes(bounds: &Bounds, domain: &Domain) -> Result<[bool; 3], GeometryError> {
    let mut axes = [false; 3];
    for (a, endless) in axes.iter_mut().enumerate().filter(|(a, _)| domain.is_periodic(*a)) {
        let length = domain.size()[a];
        let near = TOLERANCE * length;
        let [below, above] =
            [bounds.min[a] <= domain.min[a] + near, bounds.max[a] >= domain.max[a] - near];
        *endless = below && above;
        let found = bounds.max[a] - bounds.min[a];
        if !*endless && found > length + near {
            return Err(EndlessFault::Longer { axis: a, found, length, below }.into());
        }
    }
    Ok(axes)
}

/// An origin brought into the domain along the axes, by whole periods.
fn home(origin: Vec3, axes: [bool; 3], domain: &Domain) -> Vec3 {
    Vec3::from_fn(|a, _| {
        let (away, length) = (origin[a] - domain.min[a], domain.size()[a]);
        let periods = libm::floor(away / length);
        if axes[a] && periods != 0.0 { origin[a] - periods * length } else { origin[a] }
    })
}

/// Volume and area of what a patch bounds in one period, and the centre of that volume; by Gauss,
/// along an axis that is not endless. Zero where all are.
fn one_period(patch: &Patch, axes: [bool; 3]) -> ([f64; 2], Vec3) {
    let triangles: Vec<[Vec3; 3]> =
        patch.triangles().iter().map(|t| t.map(|v| patch.vertices[v as usize])).collect();
    let twice = |[a, b, c]: &[Vec3; 3]| (*b - *a).cross(&(*c - *a));
    let area = 0.5 * triangles.iter().map(|t| twice(t).norm()).sum::<f64>();
    let origin = Bounds::of(triangles.iter().flatten().copied()).centre();
    let Some(axis) = (0..3).find(|&a| !axes[a]) else { return ([0.0, area], origin) };
    let (mut volume, mut first) = (0.0, [0.0; 3]);
    for corners in &triangles {
        let weight = twice(corners)[axis] / 6.0;
        for i in 0..3 {
            let (p, q) = (corners[i] - origin, corners[(i + 1) % 3] - origin);
            let middle: Vec3 = Vec3::from_fn(|k, _| 0.5 * (p[k] + q[k]));
            volume += weight * middle[axis];
            for (k, sum) in first.iter_mut().enumerate() {
                let half = if k == axis { 0.5 } else { 1.0 };
                *sum += weight * half * middle[axis] * middle[k];
            }
        }
    }
    ([volume, area], Vec3::from_fn(|k, _| origin[k] + first[k] / volume))
}

/// Distance of the farthest corner from an origin, across the axes.
fn radius_across(patch: &Patch, axes: [bool; 3], origin: Vec3) -> f64 {
    let axes = if axes == [true; 3] { [false; 3] } else { axes };
    let across = |v: &Vec3| {
        let d = *v - origin;
        Vec3::from_fn(|a, _| if axes[a] { 0.0 } else { d[a] }).norm()
    };
    patch.vertices.iter().map(across).fold(0.0, f64::max)
}

fn mesh_area(mesh: &Mesh, count: usize) -> f64 {
    let area = |t: usize| {
        let [a, b, c] = mesh.corners(t);
        0.5 * (b - a).cross(&(c - a)).norm()
    };
    (0..count).map(area).sum()
}

/// The problem of a part's motion in a domain, if there is one; its surface is that of
/// [`Surface::in_domain`], `key` the part's.
pub fn motion_problem(
    key: &str,
    part: &Part,
    surface: &Surface,
    domain: &Domain,
) -> Option<Problem> {
    let spins: Vec<Vec3> = match &part.motion {
        Motion::Free | Motion::Fixed | Motion::Slider(_) => Vec::new(),
        Motion::Prescribed(points) => {
            points.iter().map(|point| point.angular_velocity.into()).collect()
        }
        Motion::Timed(timed) => vec![timed.angular_velocity.into()],
    };
    if part.motion == Motion::Fixed {
        return None;
    }
    // Whether it turns so that its extent along an axis changes.
    let turns = |a: usize| spins.iter().any(|w| (0..3).any(|b| b != a && w[b] != 0.0));
    let endless = surface.endless();
    let fault = match (0..3).find(|&a| endless.axes[a] && turns(a)) {
        Some(axis) => EndlessFault::Turns { axis },
        None => {
            let axis = (0..3)
                .filter(|&a| domain.is_periodic(a) && !endless.axes[a] && turns(a))
                .find(|&a| 2.0 * surface.bounding_radius() > domain.size()[a])?;
            let (found, length) = (2.0 * surface.bounding_radius(), domain.size()[axis]);
            EndlessFault::TurnsIntoItself { axis, found, length }
        }
    };
    Some(Problem::new(format!("{key}.motion"), fault.to_string()).help(fault.help()))
}

/// Winding number of the whole part less that of its endless surface; the same everywhere in the
/// domain. Along an axis that is not endless both surfaces leave the space far away along it
/// outside.
fn difference([whole, period]: [&Surface; 2], frames: [Frame; 2], domain: &Domain) -> i32 {
    if period.endless().axes != [true; 3] {
        return 0;
    }
    // Points that lie on no surface that a person would draw.
    let points = (1..100).map(|k| {
        let part = |s: f64| (f64::from(k) * s).fract();
        let parts = [part(0.754_877_666_2), part(0.569_840_291_0), part(0.430_159_709_0)];
        let size = domain.size();
        Vec3::from_fn(|a, _| domain.min[a] + parts[a] * size[a])
    });
    let number = |surface: &Surface, frame: Frame, at| surface.winding_number(frame.to_part(at));
    let mut of = points
        .filter_map(|at| Some(number(whole, frames[0], at)? - number(period, frames[1], at)?));
    of.next().unwrap_or(0)
}

/// True if three corners that follow each other leave the middle one on the line between the
/// others.
fn in_line(a: Vec3, b: Vec3, c: Vec3, tolerance: f64) -> bool {
    let (along, to) = (c - a, b - a);
    let length = along.norm();
    length > 0.0
        && along.cross(&to).norm() <= tolerance * length
        && along.dot(&to) > 0.0
        && along.dot(&to) < length * length
}
