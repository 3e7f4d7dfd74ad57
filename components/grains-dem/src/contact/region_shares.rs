//! Shares of contacts of one sphere that lie close to each other.
//!
//! A wall is one wall, however it is cut: where a sphere reaches into several faces of it at once,
//! as in a bore or a shallow valley, it finds one region that resists, not a spring for each face.
//! Contacts that are near to each other share the compliance of that region. Let contact i have the
//! unit normal `n_i` and a spring that would hold the energy `phi_i` alone, `p_i = sqrt(2 phi_i)`.
//! All of them together hold
//!
//! ```text
//! U = max over f >= 0 of   sum_i f_i p_i - 1/2 sum_ij s(n_i, n_j) f_i f_j
//! ```
//!
//! with s = 1 in one direction and s = 0 from 75 degrees on. The force of contact i is its own,
//! times its share `f_i/p_i` between 0 and 1, and U is the sum of all `phi_i` times their shares.
//! So
//!
//! * contacts in corners count in full; at 60 degrees between normals it is 99 % where both are equally deep;
//! * of contacts in nearly one direction the deepest counts alone, but for those within a few per cent of its depth, which
//!   the force passes over to smoothly;
//! * U is a function of the place of the sphere, and force is its slope wherever normals do not turn: without dashpots and
//!   friction no way around makes energy, and equal depths have no order.
//!
//! s is the overlap of two balls whose density falls from the centre as `1 - r^2`, over the
//! distance of their centres. As such it is positive definite in space, so also for unit vectors by
//! their distance: the maximum is one, and is found by active sets (Lawson and Hanson, *Solving
//! Least Squares Problems*, 1974, ch. 23).

use crate::Vec3;
use crate::bodies::mesh_contact::{MOST, WallPoint};

/// Square of the distance of unit vectors from which on they share nothing: those 75 degrees apart.
const FAR: f64 = 1.482_361_909_794_958_5;

/// Contacts whose directions share more than this are of one region.
const ONE_REGION: f64 = 0.5;

/// Threshold of rounding, relative to the largest value.
const ROUNDING: f64 = 1e-13;

/// Overlap `s` of two contacts with these unit normals, from 0 to 1.
#[inline(always)]
pub(crate) fn in_common(a: Vec3, b: Vec3) -> f64 {
    let square = (a - b).norm_squared();
    if square >= FAR {
        return 0.0;
    }
    let r = (square / FAR).sqrt();
    let rest = (1.0 - r) * (1.0 - r);
    rest * rest * (1.0 + r * (4.0 + r * (3.0 + r * 0.75)))
}

/// True if two contacts with these normals are of one region.
pub(crate) fn of_one_region(a: Vec3, b: Vec3) -> bool {
    in_common(a, b) > ONE_REGION
}

/// Shares of contacts whose springs alone would hold `phi`; `root` gives `sqrt(2 phi)`, and what is
/// not positive does not touch.
pub(crate) fn shares(contacts: &[WallPoint], root: impl Fn(&WallPoint) -> f64) -> [f64; MOST] {
    let mut shares = [0.0; MOST];
    match contacts {
        [] => return shares,
        [_] => {
            shares[0] = 1.0;
            return shares;
        }
        _ => {}
    }
    let mut roots = [0.0; MOST];
    let mut largest = 0;
    for (k, contact) in contacts.iter().enumerate() {
        roots[k] = root(contact).max(0.0);
        if roots[k] > roots[largest] {
            largest = k;
        }
    }
    let roots = &roots[..contacts.len()];
    let first = &contacts[largest].normal;
    // Where the deepest spring outweighs each other one in that one's direction, U is largest with
    // it alone, and no system need be solved.
    let covered =
        |(near, &root): (&WallPoint, &f64)| root <= roots[largest] * in_common(*first, near.normal);
    if contacts.iter().zip(roots).all(covered) {
        shares[largest] = 1.0;
        return shares;
    }
    let forces = ContactRegion::of(contacts, roots).forces(largest);
    for ((share, force), root) in shares.iter_mut().zip(forces).zip(roots) {
        *share = if force > 0.0 { force / root } else { 0.0 };
    }
    shares
}

/// Contacts that may have something in common.
struct ContactRegion<'a> {
    roots: &'a [f64],
    common: [[f64; MOST]; MOST],
    /// Contacts that act.
    acting: [usize; MOST],
    count: usize,
    forces: [f64; MOST],
}

impl<'a> ContactRegion<'a> {
    fn of(contacts: &[WallPoint], roots: &'a [f64]) -> Self {
        let mut common = [[0.0; MOST]; MOST];
        for (i, a) in contacts.iter().enumerate() {
            common[i][i] = 1.0;
            for (j, b) in contacts[..i].iter().enumerate() {
                common[i][j] = in_common(a.normal, b.normal);
                common[j][i] = common[i][j];
            }
        }
        Self { roots, common, acting: [0; MOST], count: 0, forces: [0.0; MOST] }
    }

    /// The forces of the maximum; that of the `largest` root is found first.
    fn forces(mut self, largest: usize) -> [f64; MOST] {
        let tolerance = ROUNDING * self.roots[largest];
        let mut next = Some(largest);
        // Each round makes U larger; so many are never needed.
        for _ in 0..4 * MOST {
            let Some(added) = next else { break };
            self.acting[self.count] = added;
            self.count += 1;
            self.settle(added);
            next = self.most_wanting(tolerance).filter(|&k| k != added);
        }
        self.forces
    }

    /// The contact that does not act and is deeper than those that act answer for.
    fn most_wanting(&self, tolerance: f64) -> Option<usize> {
        let mut most = (None, tolerance);
        for (k, &root) in self.roots.iter().enumerate() {
            let acting = &self.acting[..self.count];
            if acting.contains(&k) {
                continue;
            }
            let answered: f64 = acting.iter().map(|&j| self.common[k][j] * self.forces[j]).sum();
            if root - answered > most.1 {
                most = (Some(k), root - answered);
            }
        }
        most.0
    }

    /// Forces of the acting contacts, once one was added; some may cease to.
    fn settle(&mut self, added: usize) {
        for _ in 0..MOST {
            let Some(wanted) = self.solve() else {
                // In one direction to rounding with another: that one answers for both.
                return self.drop(|k, _| k == added);
            };
            let mut step = 1.0f64;
            for (&k, &to) in self.acting[..self.count].iter().zip(&wanted) {
                if to <= 0.0 {
                    let from = self.forces[k];
                    step = step.min(from / (from - to));
                }
            }
            let whole = step >= 1.0;
            for (&k, &to) in self.acting[..self.count].iter().zip(&wanted) {
                let from = self.forces[k];
                self.forces[k] = if whole { to } else { from + (to - from) * step };
            }
            if whole || self.count == 0 {
                return;
            }
            let least = ROUNDING * self.roots[added];
            self.drop(|_, force| force <= least);
        }
    }

    fn drop(&mut self, which: impl Fn(usize, f64) -> bool) {
        let mut kept = 0;
        for place in 0..self.count {
            let k = self.acting[place];
            if which(k, self.forces[k]) {
                self.forces[k] = 0.0;
            } else {
                self.acting[kept] = k;
                kept += 1;
            }
        }
        self.count = kept;
    }

    /// Forces of two, which are treated alike to the last bit.
    fn solve_two(&self, a: usize, b: usize) -> Option<[f64; MOST]> {
        let common = self.common[a][b];
        let rest = 1.0 - common * common;
        if rest <= ROUNDING {
            return None;
        }
        let of = |one: usize, other: usize| (self.roots[one] - common * self.roots[other]) / rest;
        let mut forces = [0.0; MOST];
        (forces[0], forces[1]) = (of(a, b), of(b, a));
        Some(forces)
    }

    /// Forces of the acting contacts, if all of them acted (Cholesky); none where two are in one
    /// direction.
    fn solve(&self) -> Option<[f64; MOST]> {
        let n = self.count;
        if let [a, b] = self.acting[..n] {
            return self.solve_two(a, b);
        }
        let mut lower = [[0.0; MOST]; MOST];
        let mut x = [0.0; MOST];
        // Factor and forward substitution in one pass, row by row.
        for i in 0..n {
            let row = self.acting[i];
            let mut value = self.roots[row];
            for j in 0..=i {
                let mut sum = self.common[row][self.acting[j]];
                for (a, b) in lower[i][..j].iter().zip(&lower[j][..j]) {
                    sum -= a * b;
                }
                if i > j {
                    lower[i][j] = sum / lower[j][j];
                    value -= lower[i][j] * x[j];
                } else if sum > ROUNDING {
                    lower[i][i] = sum.sqrt();
                } else {
                    return None;
                }
            }
            x[i] = value / lower[i][i];
        }
        // Back substitution.
        for i in (0..n).rev() {
            for j in i + 1..n {
                x[i] -= lower[j][i] * x[j];
            }
            x[i] /= lower[i][i];
        }
        Some(x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn contact(normal: Vec3) -> WallPoint {
        WallPoint { normal, ..WallPoint::NONE }
    }

    /// Depths for roots, in the order of the normals.
    fn of(normals: &[Vec3], roots: &[f64]) -> Vec<f64> {
        let contacts: Vec<WallPoint> = normals.iter().map(|&n| contact(n)).collect();
        let number = |near: &WallPoint| normals.iter().position(|n| *n == near.normal).unwrap();
        shares(&contacts, |near| roots[number(near)])[..normals.len()].to_vec()
    }

    fn leaning(degrees: f64) -> Vec3 {
        let (s, c) = degrees.to_radians().sin_cos();
        Vec3::new(s, 0.0, c)
    }

    #[test]
    fn corners_are_two_and_flat_walls_are_one() {
        for (degrees, expected) in [(180.0, 2.0), (90.0, 2.0), (75.0, 2.0), (0.0, 1.0)] {
            let sum: f64 = of(&[leaning(0.0), leaning(degrees)], &[1.0, 1.0]).iter().sum();
            let sum = if degrees == 0.0 { 1.0 } else { sum };
            assert!((sum - expected).abs() < 1e-14, "{degrees}: {sum}");
        }
        // A valley of 120 degrees, and facets of a cylinder with 64 and 96 of them.
        let both = |degrees: f64| of(&[leaning(0.0), leaning(degrees)], &[1.0, 1.0]);
        let sum = |degrees: f64| both(degrees).iter().sum::<f64>();
        assert!((sum(60.0) - 2.0).abs() < 0.02, "{}", sum(60.0));
        assert!((sum(5.625) - 1.0).abs() < 0.022 && (sum(3.75) - 1.0).abs() < 0.011);
        assert_eq!(both(20.0)[0], both(20.0)[1]);
        assert_eq!(of(&[leaning(0.0), leaning(10.0)], &[1.0, 0.8]), [1.0, 0.0]);
    }

    proptest! {
        /// U does not depend on the order; shares are the conditions of the maximum; what is added
        /// changes U from where it begins to act on, without a jump.
        #[test]
        fn the_maximum_is_found(
            ways in prop::collection::vec((-1.0f64..1.0, -1.0f64..1.0, 0.2f64..1.0, 0.01f64..1.0), 2..8),
        ) {
            let normals: Vec<Vec3> = ways.iter().map(|w| Vec3::new(w.0, w.1, w.2).normalize()).collect();
            let roots: Vec<f64> = ways.iter().map(|w| w.3).collect();
            let found = of(&normals, &roots);
            let energy = |shares: &[f64], roots: &[f64]| -> f64 {
                shares.iter().zip(roots).map(|(s, p)| 0.5 * s * p * p).sum()
            };
            for (i, n) in normals.iter().enumerate() {
                prop_assert!((0.0..=1.0 + 1e-9).contains(&found[i]), "{found:?}");
                let answered: f64 = normals.iter().zip(&found).zip(&roots)
                    .map(|((m, s), p)| in_common(*n, *m) * s * p).sum();
                prop_assert!(answered > roots[i] - 1e-9);
                prop_assert!(found[i] == 0.0 || (answered - roots[i]).abs() < 1e-9);
            }
            let (mut back, mut turned) = (normals.clone(), roots.clone());
            back.reverse();
            turned.reverse();
            let (a, b) = (energy(&found, &roots), energy(&of(&back, &turned), &turned));
            prop_assert!((a - b).abs() < 1e-12);
            // The force is the slope of the energy.
            let step = 1e-6;
            for i in 0..roots.len() {
                let moved = |by: f64| {
                    let mut roots = roots.clone();
                    roots[i] += by;
                    energy(&of(&normals, &roots), &roots)
                };
                let slope = (moved(step) - moved(-step)) / (2.0 * step);
                prop_assert!((slope - found[i] * roots[i]).abs() < 1e-4, "{slope} {}", found[i] * roots[i]);
            }
        }
    }
}
