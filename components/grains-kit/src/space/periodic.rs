//! The box of the domain: which axes wrap around, and the images of a body across its faces.

use crate::Vec3;
use tremie_messages::scene::Domain;

/// The domain's box as the search for neighbours sees it.
#[derive(Clone, Debug)]
pub struct PeriodicBox {
    /// Lower corner [m].
    pub min: Vec3,
    /// Edge lengths [m].
    pub size: Vec3,
    /// True for each axis that wraps around.
    pub periodic: [bool; 3],
    /// Displacement of each image [m], see [`image`].
    pub shifts: [Vec3; 27],
    /// Bounds of wrapped coordinates [m]; infinite along axes that do not wrap around.
    low: Vec3,
    high: Vec3,
}

/// The image that is the body itself.
#[cfg(any(test, target_arch = "x86_64"))]
pub const SELF_IMAGE: u32 = 13;

/// Number of the image displaced by `offset` domain lengths (-1, 0 or 1 an axis).
pub fn image(offset: [i32; 3]) -> u32 {
    ((offset[0] + 1) + 3 * (offset[1] + 1) + 9 * (offset[2] + 1)) as u32
}

impl PeriodicBox {
    /// The box of a domain.
    pub fn new(domain: &Domain) -> Self {
        let size = Vec3::from(domain.size());
        let mut shifts = [Vec3::zeros(); 27];
        for x in -1..=1 {
            for y in -1..=1 {
                for z in -1..=1 {
                    let offset = Vec3::new(x.into(), y.into(), z.into());
                    shifts[image([x, y, z]) as usize] = offset.component_mul(&size);
                }
            }
        }
        let min = Vec3::from(domain.min);
        let bound = |wraps: f64, a: usize, beyond: f64| {
            if domain.is_periodic(a) { wraps } else { beyond }
        };
        Self {
            min,
            size,
            periodic: std::array::from_fn(|a| domain.is_periodic(a)),
            shifts,
            low: Vec3::from_fn(|a, _| bound(min[a], a, f64::NEG_INFINITY)),
            high: Vec3::from_fn(|a, _| bound(min[a] + size[a], a, f64::INFINITY)),
        }
    }

    /// `x`, which moved by less than a domain length, moved back across the periodic faces that it
    /// crossed: by the displacement returned besides, and the difference of image numbers.
    #[inline(always)]
    pub fn cross(&self, x: Vec3) -> Option<(Vec3, Vec3, i32)> {
        let inside = |a: usize| x[a] >= self.low[a] && x[a] < self.high[a];
        if inside(0) && inside(1) && inside(2) { None } else { Some(self.crossing(x)) }
    }

    #[cold]
    fn crossing(&self, mut x: Vec3) -> (Vec3, Vec3, i32) {
        let (mut shift, mut crossed) = (Vec3::zeros(), 0);
        for (a, weight) in [(0, 1), (1, 3), (2, 9)] {
            if !self.periodic[a] {
                continue;
            }
            // A place below the lower face is seen one domain length further up from now on; its
            // old image is one length down.
            let sign = i32::from(x[a] < self.low[a]) - i32::from(x[a] >= self.high[a]);
            shift[a] = f64::from(sign) * self.size[a];
            crossed -= sign * weight;
            x[a] += shift[a];
            if sign != 0 && !(self.low[a]..self.high[a]).contains(&x[a]) {
                // Rounding may land a hair beyond either face.
                x[a] = if x[a].is_finite() { self.low[a] } else { x[a] };
            }
        }
        (x, shift, crossed)
    }

    /// `x` moved by whole domain lengths into the domain, along periodic axes.
    pub fn wrap(&self, mut x: Vec3) -> Vec3 {
        for a in 0..3 {
            let (low, size) = (self.min[a], self.size[a]);
            if self.periodic[a] && !(low..low + size).contains(&x[a]) {
                let inside = x[a] - size * libm::floor((x[a] - low) / size);
                // Rounding may land a hair beyond either face.
                x[a] = if inside < low || inside >= low + size { low } else { inside };
            }
        }
        x
    }

    /// The shortest of the ways between two places that `way` is one of.
    pub fn shortest(&self, way: Vec3) -> Vec3 {
        Vec3::from_fn(|a, _| {
            if !self.periodic[a] {
                return way[a];
            }
            let size = self.size[a];
            way[a] - size * libm::floor(way[a] / size + 0.5)
        })
    }

    /// Displacements of all images of a body, its own place included.
    pub fn images(&self) -> impl Iterator<Item = Vec3> + '_ {
        self.numbered_images().map(|(_, shift)| shift)
    }

    /// All images of a body, its own place included: number and displacement.
    pub fn numbered_images(&self) -> impl Iterator<Item = (u32, Vec3)> + '_ {
        let step = |a: usize| if self.periodic[a] { -1..=1 } else { 0..=0 };
        let offsets = move |z| step(1).flat_map(move |y| step(0).map(move |x| [x, y, z]));
        step(2).flat_map(offsets).map(image).map(|image| (image, self.shifts[image as usize]))
    }

    /// True if `x` lies in the box, or beyond a face that is a way out. False for numbers that are
    /// not finite.
    pub fn contains_but_for(&self, ways_out: [[bool; 2]; 3], x: Vec3) -> bool {
        (0..3).all(|a| {
            let [low, high] = ways_out[a];
            let size = self.size[a];
            x[a].is_finite() && (low || x[a] >= self.min[a]) && (high || x[a] <= self.min[a] + size)
        })
    }

    /// True if `x` lies in the closed box. False for numbers that are not finite.
    pub fn contains(&self, x: Vec3) -> bool {
        (0..3).all(|a| x[a] >= self.min[a] && x[a] <= self.min[a] + self.size[a])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::scene::Face;

    #[test]
    fn wrapping_lands_inside_and_keeps_what_is_inside() {
        let periodic = || [Face::Periodic, Face::Periodic];
        let domain = Domain::new(
            [-1.0, 0.0, 0.5],
            [1.0, 3.0, 0.7],
            [periodic(), [Face::WALL, Face::WALL], periodic()],
        );
        let bounds = PeriodicBox::new(&domain);
        let x = Vec3::new(0.3, 2.0, 0.6);
        assert_eq!(bounds.wrap(x), x);
        let far = bounds.wrap(Vec3::new(-5.25, 4.0, 0.5 - 1e-18));
        assert!((far.x - 0.75).abs() < 1e-12 && far.y == 4.0);
        assert!(far.z >= 0.5 && far.z < 0.7);
        let way = bounds.shortest(Vec3::new(1.75, 2.0, -0.15));
        assert!((way - Vec3::new(-0.25, 2.0, 0.05)).norm() < 1e-12, "{way}");
        assert_eq!(bounds.shifts[SELF_IMAGE as usize], Vec3::zeros());
        assert_eq!(bounds.shifts[image([1, 0, -1]) as usize], Vec3::new(2.0, 0.0, 0.5 - 0.7));
    }
}
