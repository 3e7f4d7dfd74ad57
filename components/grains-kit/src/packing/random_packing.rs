//! Random packings of spheres, made at the start from a region, a solid fraction and a seed.

mod feeding;
mod insertion;
mod relaxation;
mod sizes;

pub use feeding::{Feeding, Upstream};
pub use sizes::{LEAST_PART, Sizes};

use crate::Vec3;
use crate::math::random::Random;
use crate::neighbours::linked_cells::LinkedCells;
use crate::space::periodic::PeriodicBox;
use crate::space::plane_walls::{self, Wall};
use crate::space::rigid_body::BoundingSphere;
use crate::space::solid_part::SolidPart;
use core::f64::consts::PI;
use tremie_messages::scene::{BodySet, BodySizes, Domain, Face, Packing};

/// Largest solid fraction at which spheres are inserted one after the other; above, insertion slows
/// down (it ends for good at 0.38) and a crowded start is relaxed instead.
const DENSEST_INSERTION: f64 = 0.25;

/// Obstacles of a packing.
pub struct PackingSurroundings<'a, P> {
    /// Parts, in whose solid no sphere may be.
    pub parts: &'a [P],
    /// The domain.
    pub bounds: PeriodicBox,
    /// Walls that may cut through the region.
    pub planes: Vec<Wall>,
    /// Bodies that are there already.
    pub balls: Vec<BoundingSphere>,
}

/// A packing could not be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("is {wanted:.4}, but only {reached:.4} was reached without overlap in this region")]
pub struct TooDense {
    wanted: f64,
    reached: f64,
}

/// A part, and the shift of a point of the region to the part's image [m].
struct Obstacle<'a, P> {
    part: &'a P,
    shift: Vec3,
}

/// The region of a packing as the two methods see it: bodies in the way, and walls all around, but
/// for axes along which it fills a periodic domain from face to face: there it wraps around.
struct PackingRegion<'a, P> {
    parts: Vec<Obstacle<'a, P>>,
    bounds: PeriodicBox,
    walls: Vec<Wall>,
    obstacles: Vec<BoundingSphere>,
}

/// Diameters [m] of the bodies of a set, or of spheres of equal volume, in the order in which a
/// packing draws them.
pub fn diameters_of(set: &BodySet) -> Vec<f64> {
    match set.placement.sizes() {
        BodySizes::Listed(diameters) => diameters,
        BodySizes::Packed(packing) => diameters(packing),
    }
}

/// Diameters [m] of a packing: as many draws as come closest to the wanted volume.
fn diameters(packing: &Packing) -> Vec<f64> {
    let size = Vec3::from(packing.max) - Vec3::from(packing.min);
    let wanted = packing.fraction * size.x * size.y * size.z;
    let sizes = Sizes::new(&packing.diameters);
    let mut volume = 0.0;
    let mut drawn = Vec::new();
    for index in 0.. {
        let d = sizes.at(Random::new(packing.seed, index).unit());
        let more = PI / 6.0 * d * d * d;
        if volume + 0.5 * more > wanted {
            break;
        }
        volume += more;
        drawn.push(d);
    }
    drawn
}

/// Makes a packing of spheres `wider` times as wide as the diameters say, which hold bodies of as
/// much volume as these have; they are ordered by place, so that neighbours have near numbers.
pub fn pack(
    packing: &Packing,
    wider: f64,
    around: &PackingSurroundings<'_, impl SolidPart>,
) -> Result<Vec<BoundingSphere>, TooDense> {
    let radii: Vec<f64> = diameters(packing).iter().map(|d| 0.5 * d * wider).collect();
    let region = PackingRegion::new(packing, around, radii.iter().fold(0.0, |a, &b| a.max(b)));
    let inserted = (packing.fraction * wider * wider * wider <= DENSEST_INSERTION)
        .then(|| insertion::insert(&region, &radii, packing.seed))
        .flatten();
    let balls = match inserted {
        Some(balls) => balls,
        None => relaxation::relax(&region, &radii, packing.seed).map_err(|scale| TooDense {
            wanted: packing.fraction,
            reached: packing.fraction * scale * scale * scale,
        })?,
    };
    Ok(by_place(&region, &balls))
}

impl<'a, P: SolidPart> PackingRegion<'a, P> {
    fn new(packing: &Packing, around: &PackingSurroundings<'a, P>, largest_radius: f64) -> Self {
        let bounds = region_bounds(packing, &around.bounds);
        let mut walls =
            plane_walls::of_box(packing.min, packing.max, |axis, _| !bounds.periodic[axis]);
        walls.extend(&around.planes);
        let (min, max) = (Vec3::from(packing.min), Vec3::from(packing.max));
        // Bodies in the way, with their images across the periodic faces that the region ends at.
        let mut obstacles = Vec::new();
        let ends_at = |shift: &Vec3| (0..3).all(|a| shift[a] == 0.0 || !bounds.periodic[a]);
        for ball in &around.balls {
            let reach = Vec3::repeat(ball.radius + largest_radius);
            let near = |x: Vec3, a: usize| {
                bounds.periodic[a] || x[a] > (min - reach)[a] && x[a] < (max + reach)[a]
            };
            for shift in around.bounds.images().filter(ends_at) {
                let x = bounds.wrap(ball.x + shift);
                if (0..3).all(|a| near(x, a)) {
                    obstacles.push(BoundingSphere { x, ..*ball });
                }
            }
        }
        let shifts: Vec<Vec3> = around.bounds.images().collect();
        let of = |part: &'a P| {
            let seen = shifts.iter().filter(|shift| part.is_seen(**shift));
            seen.map(move |&shift| Obstacle { part, shift })
        };
        let parts = around.parts.iter().flat_map(of).collect();
        Self { parts, bounds, walls, obstacles }
    }

    /// Depth of a sphere in parts [m], and the direction out of them. For a sphere clear of parts
    /// it is negative: the distance that the sphere may move before it can touch one.
    fn depth_in_parts(&self, ball: &BoundingSphere) -> (f64, Vec3) {
        let of = |obstacle: &Obstacle<'_, P>| {
            let (distance, direction) = obstacle.part.clearance(ball.x + obstacle.shift);
            (ball.radius - distance, direction)
        };
        let deeper = |a: (f64, Vec3), b: (f64, Vec3)| if b.0 > a.0 { b } else { a };
        let outside = self.parts.chunk_by(|a, b| std::ptr::eq(a.part, b.part)).map(|images| {
            if images[0].part.is_cavity() {
                // Free where it is inside any image of the cavity.
                images
                    .iter()
                    .map(of)
                    .fold((f64::INFINITY, Vec3::x()), |a, b| if b.0 < a.0 { b } else { a })
            } else {
                images.iter().map(of).fold((f64::NEG_INFINITY, Vec3::x()), deeper)
            }
        });
        outside.fold((f64::NEG_INFINITY, Vec3::x()), deeper)
    }

    /// Uniform random centre of a sphere that lies in the region's box.
    fn random_centre(&self, radius: f64, random: &mut Random) -> Vec3 {
        let PeriodicBox { min, size, periodic, .. } = &self.bounds;
        Vec3::from_fn(|a, _| {
            let margin = if periodic[a] { 0.0 } else { radius };
            let room = (size[a] - 2.0 * margin).max(0.0);
            min[a] + margin + room * random.unit()
        })
    }
}

/// The region's box; it wraps around along axes that it spans from one periodic face of the domain
/// to the other.
fn region_bounds(packing: &Packing, domain: &PeriodicBox) -> PeriodicBox {
    let faces = std::array::from_fn(|a| {
        let tolerance = 1e-9 * domain.size[a];
        let spans = packing.min[a] <= domain.min[a] + tolerance
            && packing.max[a] >= domain.min[a] + domain.size[a] - tolerance;
        let face = if spans && domain.periodic[a] { Face::Periodic } else { Face::WALL };
        [face.clone(), face]
    });
    PeriodicBox::new(&Domain::new(packing.min, packing.max, faces))
}

/// The random numbers for the place of sphere `index`: other streams than those of diameters.
fn place_stream(seed: u64, index: usize) -> Random {
    Random::new(seed, (1 << 63) | index as u64)
}

/// The spheres in the order of cells a diameter wide.
fn by_place(
    region: &PackingRegion<'_, impl SolidPart>,
    balls: &[BoundingSphere],
) -> Vec<BoundingSphere> {
    let largest = balls.iter().fold(0.0, |r: f64, ball| r.max(ball.radius));
    let mut cells = LinkedCells::over(region.bounds.clone(), 2.0 * largest);
    cells.sort(balls);
    cells.order().map(|i| balls[i as usize]).collect()
}
