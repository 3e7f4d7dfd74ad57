//! One force from the loads on a ring's surface (Mutabaruka and Kamrin, section 2.4, with the signs that
//! it lacks).

use crate::table::{FacetKind, Surface};
use tremie_geometry::Vec3;

/// Form of the load where the ring touches its seat.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Form {
    /// Its component along the axis, less the pressure around over the projected area: conjugate to
    /// the table's force, also where the surface is curved.
    #[default]
    Axial,
    /// Its pressure, less the pressure around, times the area, as published: |A| (P_A - P_B).
    Pressure,
}

/// The force that compresses a ring, and what it is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EffectiveForce {
    /// Towards the carrier [N].
    pub force: f64,
    /// Mean pressure on what touches the seat [Pa].
    pub seat_pressure: f64,
    /// Mean pressure on what is exposed [Pa].
    pub exposed_pressure: f64,
    /// Area of what touches the seat [m²].
    pub seat_area: f64,
    /// Area of what is exposed [m²].
    pub exposed_area: f64,
}

/// The force of `loads`, the resultant [N] on each triangle of `surface`, whose vertices are at
/// `places` [m]; both as seen along the ring's axis z. Shear on what is exposed does not count: a
/// pressure all around changes no shape, and only what differs from it compresses. What is bonded
/// to steel or lies against it does not count at all.
pub fn effective_force(
    form: Form,
    surface: &Surface,
    places: &[Vec3],
    loads: &[Vec3],
) -> EffectiveForce {
    let mut sums = Sums::default();
    for ((triangle, kind), load) in surface.triangles.iter().zip(&surface.kinds).zip(loads) {
        let facet = Facet::new(triangle.map(|vertex| places[vertex as usize]));
        sums.add_area(*kind, &facet, 1.0);
        sums.add_load(*kind, facet.inward(*load), load.z);
    }
    sums.force(form)
}

/// Areas and loads of a ring, collected triangle by triangle, in any order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sums {
    seat: Sum,
    exposed: Sum,
}

impl Sums {
    /// Adds the area of `times` triangles that are all turned about the axis from this one.
    pub(super) fn add_area(&mut self, kind: FacetKind, facet: &Facet, times: f64) {
        if let Some(sum) = self.of(kind) {
            sum.area += times * facet.area;
            sum.projected -= times * facet.area * facet.outward.z;
        }
    }

    /// Adds a load [N] on a triangle: what presses on it, and what acts along the axis.
    pub(super) fn add_load(&mut self, kind: FacetKind, inward: f64, axial: f64) {
        if let Some(sum) = self.of(kind) {
            sum.inward += inward;
            sum.axial += axial;
        }
    }

    /// The force of all loads.
    pub fn force(&self, form: Form) -> EffectiveForce {
        let Self { seat, exposed } = self;
        let (seat_pressure, exposed_pressure) = (seat.pressure(), exposed.pressure());
        let force = match form {
            Form::Axial => seat.axial - exposed_pressure * seat.projected,
            Form::Pressure => seat.area * (seat_pressure - exposed_pressure),
        };
        EffectiveForce {
            force,
            seat_pressure,
            exposed_pressure,
            seat_area: seat.area,
            exposed_area: exposed.area,
        }
    }

    fn of(&mut self, kind: FacetKind) -> Option<&mut Sum> {
        match kind {
            FacetKind::Seat => Some(&mut self.seat),
            FacetKind::Exposed => Some(&mut self.exposed),
            FacetKind::Covered | FacetKind::Bonded => None,
        }
    }
}

/// Sums over the triangles of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Sum {
    area: f64,
    /// Area as seen from the seat.
    projected: f64,
    /// Load inwards [N].
    inward: f64,
    /// Load along the axis [N].
    axial: f64,
}

impl Sum {
    fn pressure(&self) -> f64 {
        if self.area > 0.0 { self.inward / self.area } else { 0.0 }
    }
}

/// A triangle of a ring.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    /// Its area [m²].
    pub area: f64,
    /// The unit vector outwards; zero where it has no area.
    outward: Vec3,
}

impl Facet {
    /// With these corners [m].
    pub fn new([a, b, c]: [Vec3; 3]) -> Self {
        let normal = (b - a).cross(&(c - a));
        let outward = normal.try_normalize(0.0).unwrap_or_default();
        Self { area: 0.5 * normal.norm(), outward }
    }

    /// The part of a load [N] that presses on it.
    pub fn inward(&self, load: Vec3) -> f64 {
        -self.outward.dot(&load)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Table, example};

    /// A ring with a tilted foot.
    fn ring() -> (Surface, Vec<Vec3>) {
        let mut contents = example();
        contents.vertices.iter_mut().for_each(|frame| frame[1] = [2.0, 0.3 + frame[0][1]]);
        let rest = contents.vertices[0].clone();
        let table = Table::new(contents).unwrap();
        let surface = table.surface(16);
        let places = surface.places(&rest);
        (surface, places)
    }

    /// Normal of each triangle times its area.
    fn normals(surface: &Surface, places: &[Vec3]) -> Vec<Vec3> {
        let cross = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|vertex| places[vertex as usize]);
            (b - a).cross(&(c - a)) * 0.5
        };
        surface.triangles.iter().map(cross).collect()
    }

    #[test]
    fn a_pressure_all_around_compresses_nothing() {
        let (surface, places) = ring();
        let loads: Vec<Vec3> = normals(&surface, &places).iter().map(|n| n * -4.65e5).collect();
        for form in [Form::Axial, Form::Pressure] {
            let found = effective_force(form, &surface, &places, &loads);
            assert!(found.force.abs() < 1e-12 * 4.65e5 * found.seat_area, "{form:?}: {found:?}");
            assert!((found.exposed_pressure / 4.65e5 - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_push_along_the_axis_counts_whole_and_its_pressure_with_the_slope() {
        let (surface, places) = ring();
        let mut loads = vec![Vec3::zeros(); surface.triangles.len()];
        loads[3] = Vec3::z() * 7.0;
        let axial = effective_force(Form::Axial, &surface, &places, &loads);
        assert!((axial.force - 7.0).abs() < 1e-12);
        let pressure = effective_force(Form::Pressure, &surface, &places, &loads);
        // Of 16 sectors' flat facets, the foot's slope is steeper than the section's.
        let normal = normals(&surface, &places)[3];
        assert!(
            (pressure.force + 7.0 * normal.z / normal.norm()).abs() < 1e-12 && pressure.force < 7.0
        );
    }

    #[test]
    fn loads_on_steel_and_shear_around_count_nothing() {
        let (surface, places) = ring();
        let mut loads = vec![Vec3::zeros(); surface.triangles.len()];
        for (load, kind) in loads.iter_mut().zip(&surface.kinds) {
            match kind {
                FacetKind::Covered | FacetKind::Bonded => *load = Vec3::new(3.0, 1.0, -5.0),
                FacetKind::Exposed => *load = Vec3::z() * 2.0,
                FacetKind::Seat => {}
            }
        }
        for form in [Form::Axial, Form::Pressure] {
            assert!(effective_force(form, &surface, &places, &loads).force.abs() < 1e-12);
        }
    }
}
