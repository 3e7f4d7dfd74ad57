//! Domain, cells, velocity and duration of a flow of water through or around a part.
//!
//! The flow is laminar: the Reynolds number is [`REYNOLDS`], with which the lattice has a relaxation time
//! that it likes. Cells are as many across the bore, or across the part, as the memory and the time of a first
//! run allow.

use super::domain_face::DomainFace;
use super::file_unit::three_digits;
use super::passage::Passage;
use tremie_geometry::Bounds;

/// Reynolds number of the mean velocity and the bore, or of the inflow and the part's width.
pub const REYNOLDS: f64 = 50.0;
/// Density of water [kg/m³].
pub const DENSITY: f64 = 1000.0;
/// Dynamic viscosity of water [Pa·s].
pub const VISCOSITY: f64 = 1e-3;

/// Cells across a bore.
pub const ACROSS_BORE: f64 = 16.0;
/// Cells across the width of a part in a stream.
pub const ACROSS_PART: f64 = 16.0;
/// Most cells of fluid: memory and time of a first run.
const MOST_CELLS: f64 = 120e3;
/// Most cells in the domain's box, solid ones included.
const MOST_IN_BOX: f64 = 4e6;
/// Most cells times windows of a run: half a minute on two cores.
const MOST_WORK: f64 = 5e8;
/// Cell over time step, over the expected speed: a Mach number of 0.1, sound at a root of a third of it.
const LATTICE_SPEED: f64 = 17.320508;
/// Expected speed over the mean one in a bore, at least: room for a jet, and for a start that throws sound.
const PEAK_IN_BORE: f64 = 4.0;
/// The same for each width that the bore is long: sound so fast that the pressure drop compresses the water by no
/// more than half a per cent.
const PEAK_BY_LENGTH: f64 = 0.45;
/// Relaxation time that the expected speed may bring about, at least.
const LEAST_TAU: f64 = 0.506;
/// Time in which a flow develops, over the square of its width by the kinematic viscosity.
const DEVELOPS: f64 = 1.0 / 16.0;
/// Greatest speed over that of the stream beside a part.
const PEAK_AT_PART: f64 = 2.5;

/// Numbers of a flow through or around a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartDomain {
    /// Face at which water enters.
    pub inlet: DomainFace,
    /// Face at which it leaves.
    pub outlet: DomainFace,
    /// Lower corner [m].
    pub origin: [f64; 3],
    /// Cells along each axis.
    pub cells: [usize; 3],
    /// Edge of a cell [m].
    pub cell: f64,
    /// The length that the Reynolds number is of: bore, or the part's width [m].
    pub width: f64,
    /// Velocity at the inlet [m/s].
    pub inflow: f64,
    /// Speed that is nowhere exceeded, about [m/s].
    pub fastest: f64,
    /// Time that the water takes to pass through the domain [s].
    pub passing: f64,
    /// Duration of the run [s].
    pub until: f64,
}

impl PartDomain {
    /// Of a flow through a passage. The faces of the domain cut the part: it begins at the ends of the passage, or within
    /// them where the surface is `closed` there.
    pub fn through(passage: &Passage, closed: bool) -> Self {
        let box_volume = passage.bounds.size().product();
        let cell = (passage.bore / ACROSS_BORE)
            .max((passage.volume / MOST_CELLS).cbrt())
            .max((box_volume / MOST_IN_BOX).cbrt());
        let cell = three_digits(cell);
        let ends = if closed { 1.5 * cell } else { 0.0 };
        let (mut origin, mut cells) = ([0.0; 3], [0; 3]);
        for k in 0..3 {
            let (min, max) = (passage.bounds.min[k], passage.bounds.max[k]);
            let is_open = |is_upper| {
                let face = DomainFace::of(k, is_upper);
                face == passage.inlet || face == passage.outlet
            };
            (origin[k], cells[k]) = match (is_open(false), is_open(true)) {
                (false, false) => centred(min - 2.0 * cell, max + 2.0 * cell, cell, f64::ceil),
                (true, true) => centred(min + ends, max - ends, cell, f64::floor),
                (true, false) => {
                    (min + ends, whole((max + 2.0 * cell - min - ends) / cell, f64::ceil))
                }
                (false, true) => {
                    let count = whole((max - ends - min + 2.0 * cell) / cell, f64::ceil);
                    (max - ends - count as f64 * cell, count)
                }
            };
        }
        let mean = REYNOLDS * VISCOSITY / DENSITY / passage.bore;
        let inflow = three_digits(mean * (passage.least_area / passage.inlet_area).min(1.0));
        let fluid = passage.volume / cell.powi(3);
        let passing = passage.volume / (inflow * passage.inlet_area);
        let (inlet, outlet, width) = (passage.inlet, passage.outlet, passage.bore);
        let by_length = PEAK_BY_LENGTH * passage.length / passage.bore;
        // tau - 1/2 is three times the viscosity over cell and lattice speed.
        let by_tau = 3.0 * passage.bore / cell / (LATTICE_SPEED * REYNOLDS * (LEAST_TAU - 0.5));
        let peak = PEAK_IN_BORE.max(by_length.min(by_tau));
        let fastest = three_digits(peak * mean);
        Self { inlet, outlet, origin, cells, cell, width, inflow, fastest, passing, until: 0.0 }
            .timed(fluid)
    }

    /// Of a stream around a part: as much room beside it and before it as it is wide, and twice as much behind.
    pub fn around(bounds: &Bounds, inlet: DomainFace) -> Self {
        let along = inlet.axis();
        let size = bounds.size();
        let width = (0..3).filter(|k| *k != along).map(|k| size[k]).fold(0.0, f64::max);
        let (mut min, mut max) = (bounds.min.add_scalar(-width), bounds.max.add_scalar(width));
        match inlet.is_upper() {
            true => min[along] -= width,
            false => max[along] += width,
        }
        let volume = (max - min).product();
        let cell = three_digits((width / ACROSS_PART).max((volume / MOST_CELLS).cbrt()));
        let placed: [(f64, usize); 3] =
            std::array::from_fn(|k| centred(min[k], max[k], cell, f64::ceil));
        let inflow = three_digits(REYNOLDS * VISCOSITY / DENSITY / width);
        Self {
            inlet,
            outlet: inlet.opposite(),
            origin: placed.map(|(origin, _)| origin),
            cells: placed.map(|(_, count)| count),
            cell,
            width,
            inflow,
            fastest: three_digits(PEAK_AT_PART * inflow),
            passing: (max[along] - min[along]) / inflow,
            until: 0.0,
        }
        .timed(volume / cell.powi(3))
    }

    /// With the duration of a first run: the water passes once, and the flow develops, if that is not too much work
    /// for so many cells of fluid.
    fn timed(self, fluid: f64) -> Self {
        let window = self.cell / (LATTICE_SPEED * self.fastest);
        let affordable = MOST_WORK / fluid.max(1.0) * window;
        let develops = DEVELOPS * self.width * self.width * DENSITY / VISCOSITY;
        Self { until: two_digits(self.passing.max(develops).min(affordable)), ..self }
    }

    /// Cells across the width.
    pub fn across(&self) -> f64 {
        self.width / self.cell
    }

    /// Edges of the domain [m].
    pub fn size(&self) -> [f64; 3] {
        self.cells.map(|count| count as f64 * self.cell)
    }

    /// A place so many cells inside a face, on its axis [m].
    pub fn within(&self, face: DomainFace, cells: f64) -> f64 {
        let k = face.axis();
        match face.is_upper() {
            true => self.origin[k] + self.size()[k] - cells * self.cell,
            false => self.origin[k] + cells * self.cell,
        }
    }

    /// Velocity at the inlet, into the domain [m/s].
    pub fn velocity(&self) -> [f64; 3] {
        let mut velocity = [0.0; 3];
        velocity[self.inlet.axis()] =
            if self.inlet.is_upper() { -self.inflow } else { self.inflow };
        velocity
    }
}

/// Lower end and number of cells of a row of cells with the middle of a span.
fn centred(min: f64, max: f64, cell: f64, round: fn(f64) -> f64) -> (f64, usize) {
    let count = whole((max - min) / cell, round);
    (0.5 * (min + max - count as f64 * cell), count)
}

/// A number of cells, one at least. A length that is whole but for rounding stays.
fn whole(cells: f64, round: fn(f64) -> f64) -> usize {
    let near = cells.round();
    let whole = if (cells - near).abs() < 1e-6 { near } else { round(cells) };
    whole.max(1.0) as usize
}

/// A number with two digits that count.
fn two_digits(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;
    use tremie_geometry::Vec3;

    /// A straight bore along x, from zero on.
    fn bore(width: f64, length: f64) -> Passage {
        let (half, area) = (0.5 * width, 0.25 * PI * width * width);
        Passage {
            inlet: DomainFace::XMin,
            outlet: DomainFace::XMax,
            inside: Vec3::zeros(),
            bounds: Bounds::of([[0.0, -half, -half], [length, half, half]]),
            bore: width,
            length,
            inlet_area: area,
            least_area: area,
            volume: area * length,
        }
    }

    #[test]
    fn a_bore_has_sixteen_cells_and_a_laminar_flow() {
        let domain = PartDomain::through(&bore(8e-3, 40e-3), false);
        assert_eq!((domain.cell, domain.cells), (5e-4, [80, 20, 20]));
        assert_eq!(domain.origin, [0.0, -5e-3, -5e-3]);
        assert!((domain.inflow / 6.25e-3 - 1.0).abs() < 1e-2, "{domain:?}");
        assert_eq!(domain.velocity()[0], domain.inflow);
        assert!((domain.passing / 6.4 - 1.0).abs() < 1e-2, "{domain:?}");
        // Within 1.5 cells of the ends of a surface that is closed there.
        let closed = PartDomain::through(&bore(8e-3, 40e-3), true);
        assert_eq!(closed.cells[0], 77);
        assert!((closed.origin[0] - 7.5e-4).abs() < 1e-12, "{closed:?}");
    }

    #[test]
    fn a_long_bore_has_wider_cells_and_a_short_run() {
        let domain = PartDomain::through(&bore(8e-3, 4.0), false);
        let fluid = 0.25 * PI * 64e-6 * 4.0 / domain.cell.powi(3);
        assert!(fluid < 1.01 * MOST_CELLS && domain.across() < ACROSS_BORE, "{domain:?}");
        assert!(domain.until < domain.passing, "{domain:?}");
    }

    /// Water that is fast in a throat enters slowly.
    #[test]
    fn a_throat_sets_the_velocity() {
        let wide = Passage { inlet_area: 4.0 * bore(8e-3, 40e-3).inlet_area, ..bore(8e-3, 40e-3) };
        let [through, wide] = [bore(8e-3, 40e-3), wide].map(|p| PartDomain::through(&p, false));
        assert!((4.0 * wide.inflow / through.inflow - 1.0).abs() < 1e-2);
        assert_eq!(wide.fastest, through.fastest);
    }

    #[test]
    fn a_bend_is_cut_at_its_ends() {
        let bend = Passage { outlet: DomainFace::ZMax, ..bore(8e-3, 40e-3) };
        let domain = PartDomain::through(&bend, false);
        assert_eq!(domain.origin[0], 0.0);
        let upper = domain.origin[2] + domain.size()[2];
        assert!((upper - 4e-3).abs() < 1e-12, "{domain:?}");
        assert_eq!(domain.cells[0], 82);
        assert!((domain.within(DomainFace::ZMax, 1.5) - (4e-3 - 7.5e-4)).abs() < 1e-12);
    }

    #[test]
    fn a_part_has_room_around() {
        let ball = Bounds::of([[-5e-3; 3], [5e-3; 3]]);
        let domain = PartDomain::around(&ball, DomainFace::YMax);
        assert_eq!(domain.outlet, DomainFace::YMin);
        assert!((domain.across() - ACROSS_PART).abs() < 1.5, "{domain:?}");
        let cells: usize = domain.cells.iter().product();
        assert!((cells as f64) < 1.1 * MOST_CELLS, "{domain:?}");
        // One width before it, two behind.
        assert!((domain.origin[1] + 25e-3).abs() < domain.cell, "{domain:?}");
        assert!(domain.velocity()[1] < 0.0);
    }
}
