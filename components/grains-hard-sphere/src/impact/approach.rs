//! The moment at which two points come within a distance of each other, or a point of a plane.
//!
//! With constant accelerations the relative path is `X + V s + A s²/2`, and the surfaces of two
//! spheres touch where (Goetsch 2015, Sec. 2.3.3)
//!
//! ```text
//! f(s) = A.A/4 s^4 + V.A s^3 + (V.V + X.A) s^2 + 2 X.V s + X.X - R^2 = 0,  R = r1 + r2
//! ```
//!
//! A touch is the first moment with `f <= 0` and `f' < 0`: bodies that overlap by rounding and part
//! from each other do not touch, and no time is negative (Bannerman et al. 2014, stable event
//! search). Between its extrema `f` is monotone, so that no touch is passed over.

use crate::Vec3;

/// Relative path of two points, and the distance at which they touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Distance vector at the start [m].
    pub x: Vec3,
    /// Relative velocity at the start [m/s].
    pub v: Vec3,
    /// Relative acceleration [m/s²].
    pub a: Vec3,
    /// Distance at which they touch [m].
    pub reach: f64,
}

impl Approach {
    /// First moment from the start on, up to `until`, at which they touch [s].
    #[inline]
    pub fn first_touch(&self, until: f64) -> Option<f64> {
        if self.a == Vec3::zeros() { self.straight(until) } else { self.curved(until) }
    }

    /// Without acceleration: the root of a parabola.
    #[inline(always)]
    fn straight(&self, until: f64) -> Option<f64> {
        let b = self.x.dot(&self.v);
        if b >= 0.0 {
            return None;
        }
        let gap = self.x.norm_squared() - self.reach * self.reach;
        if gap <= 0.0 {
            return Some(0.0);
        }
        let square = b * b - self.v.norm_squared() * gap;
        if square < 0.0 {
            return None;
        }
        // The smaller root, without cancellation.
        let time = gap / (square.sqrt() - b);
        (time <= until).then_some(time)
    }

    #[inline(never)]
    fn curved(&self, until: f64) -> Option<f64> {
        let Self { x, v, a, reach } = self;
        let f = [
            x.norm_squared() - reach * reach,
            2.0 * x.dot(v),
            v.norm_squared() + x.dot(a),
            v.dot(a),
            0.25 * a.norm_squared(),
        ];
        first_fall(&f, until)
    }
}

/// First moment, up to `until`, at which a height `h + u s + g s²/2` is at or below zero and falls
/// [s].
#[inline]
pub fn first_landing(h: f64, u: f64, g: f64, until: f64) -> Option<f64> {
    if g == 0.0 {
        if u >= 0.0 {
            return None;
        }
        let time = (h / -u).max(0.0);
        return (time <= until).then_some(time);
    }
    first_fall(&[h, u, 0.5 * g, 0.0, 0.0], until)
}

/// First moment in `[0, until]` at which a polynomial of at most fourth order is at or below zero
/// and falls.
fn first_fall(f: &[f64; 5], until: f64) -> Option<f64> {
    if !until.is_finite() {
        // Far away the highest power rules; beyond the largest root nothing changes.
        return first_fall(f, bound(f));
    }
    let slope = [f[1], 2.0 * f[2], 3.0 * f[3], 4.0 * f[4]];
    let bend = [slope[1], 2.0 * slope[2], 3.0 * slope[3]];
    let turns = roots(&slope, &roots(&bend, &Marks::quadratic_turn(&bend, until)));
    let mut from = 0.0;
    for to in turns.list() {
        let is_falling = value(&slope, 0.5 * (from + to)) < 0.0;
        if is_falling && value(f, from) <= 0.0 {
            return Some(from);
        }
        if is_falling && value(f, *to) <= 0.0 {
            return Some(root_between(f, from, *to));
        }
        from = *to;
    }
    None
}

/// A time beyond all roots of a polynomial and of its derivatives (Cauchy's bound).
fn bound(f: &[f64; 5]) -> f64 {
    let Some(top) = (1..5).rev().find(|&k| f[k] != 0.0) else { return 0.0 };
    // Fujiwara's form of the bound, which scales with the unit of time.
    let of = |k: usize| {
        let ratio = (f[k] / f[top]).abs();
        libm::pow(ratio, 1.0 / (top - k) as f64)
    };
    let bound = 4.0 * (0..top).map(of).fold(0.0, f64::max);
    // All roots are at zero: any time lies beyond.
    if bound > 0.0 { bound } else { 1.0 }
}

/// Up to five moments in ascending order, of which the last is the end of the interval.
#[derive(Clone, Copy, Debug)]
struct Marks {
    at: [f64; 5],
    count: usize,
}

impl Marks {
    fn list(&self) -> &[f64] {
        &self.at[..self.count]
    }

    fn end(&self) -> f64 {
        self.at[self.count - 1]
    }

    fn of_end(end: f64) -> Self {
        Self { at: [end; 5], count: 1 }
    }

    /// Adds a moment before the end.
    fn insert(&mut self, moment: f64) {
        self.at[self.count] = self.end();
        self.at[self.count - 1] = moment;
        self.count += 1;
    }

    /// The extremum of a parabola, if it lies in the interval.
    fn quadratic_turn(p: &[f64; 3], end: f64) -> Self {
        let mut marks = Self::of_end(end);
        let turn = -0.5 * p[1] / p[2];
        if turn > 0.0 && turn < end {
            marks.insert(turn);
        }
        marks
    }
}

/// Roots of a polynomial from 0 to the end, between whose `turns` it is monotone; the end last.
fn roots<const N: usize>(p: &[f64; N], turns: &Marks) -> Marks {
    let mut found = Marks::of_end(turns.end());
    let mut from = 0.0;
    for &to in turns.list() {
        let (low, high) = (value(p, from), value(p, to));
        if (low < 0.0) != (high < 0.0) {
            let root = root_between(p, from, to);
            if root > 0.0 && root < found.end() {
                found.insert(root);
            }
        }
        from = to;
    }
    found
}

/// Value of a polynomial, by Horner's rule.
#[inline(always)]
fn value<const N: usize>(p: &[f64; N], s: f64) -> f64 {
    p.iter().rev().fold(0.0, |sum, c| sum * s + c)
}

/// The root of a polynomial that is monotone between two moments and changes its sign there, by
/// Newton's method, held in a bracket by bisection.
fn root_between<const N: usize>(p: &[f64; N], mut low: f64, mut high: f64) -> f64 {
    let falls = value(p, high) < value(p, low);
    let mut s = 0.5 * (low + high);
    for _ in 0..MOST_STEPS {
        let (mut f, mut slope) = (0.0, 0.0);
        for c in p.iter().rev() {
            slope = slope * s + f;
            f = f * s + c;
        }
        if f == 0.0 {
            return s;
        }
        if (f > 0.0) == falls {
            low = s
        } else {
            high = s
        }
        let newton = s - f / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if next == s || next == low || next == high {
            return next;
        }
        s = next;
    }
    s
}

/// More steps than bisection needs to halve an interval down to rounding.
const MOST_STEPS: usize = 200;

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector() -> impl Strategy<Value = Vec3> {
        prop::array::uniform3(-1.0f64..1.0).prop_map(Vec3::from)
    }

    /// The first touch by looking at ten thousand moments.
    fn by_search(approach: &Approach, until: f64) -> Option<f64> {
        let f = |s: f64| {
            let d = approach.x + approach.v * s + approach.a * (0.5 * s * s);
            d.norm_squared() - approach.reach * approach.reach
        };
        let steps = 10_000;
        let at = |k: usize| until * k as f64 / f64::from(steps);
        (0..steps as usize).find(|&k| f(at(k + 1)) <= 0.0 && f(at(k + 1)) < f(at(k))).map(at)
    }

    proptest! {
        #[test]
        fn the_first_touch_is_that_of_a_search(
            x in vector(), v in vector(), a in vector(), reach in 0.05f64..0.4,
        ) {
            let approach = Approach { x: x * 2.0, v: v * 3.0, a: a * 4.0, reach };
            prop_assume!(approach.x.norm() > reach);
            let (found, searched) = (approach.first_touch(2.0), by_search(&approach, 2.0));
            match (found, searched) {
                (Some(s), Some(t)) => prop_assert!((s - t).abs() < 1e-3, "{} {}", s, t),
                (None, None) => {}
                // A grazing touch may fall between two moments of the search.
                (Some(s), None) => {
                    let d = approach.x + approach.v * s + approach.a * (0.5 * s * s);
                    prop_assert!((d.norm() - reach).abs() < 1e-9);
                }
                (None, Some(t)) => prop_assert!(false, "missed the touch at {}", t),
            }
        }

        #[test]
        fn an_acceleration_that_is_next_to_nothing_changes_nothing(
            x in vector(), v in vector(), reach in 0.05f64..0.4,
        ) {
            let still = Approach { x: x * 2.0, v: v * 3.0, a: Vec3::zeros(), reach };
            let moved = Approach { a: Vec3::new(1e-13, 0.0, 0.0), ..still };
            if let (Some(s), Some(t)) = (still.first_touch(2.0), moved.first_touch(2.0)) {
                prop_assert!((s - t).abs() < 1e-4, "{} {}", s, t);
            }
        }
    }

    #[test]
    fn those_that_overlap_touch_at_once_if_they_approach_and_not_if_they_part() {
        let overlapping = |v: f64, a: f64| Approach {
            x: Vec3::new(0.5, 0.0, 0.0),
            v: Vec3::new(v, 0.0, 0.0),
            a: Vec3::new(a, 0.0, 0.0),
            reach: 1.0,
        };
        assert_eq!(overlapping(-1.0, 0.0).first_touch(9.0), Some(0.0));
        assert_eq!(overlapping(-1.0, 1.0).first_touch(9.0), Some(0.0));
        assert_eq!(overlapping(1.0, 0.0).first_touch(9.0), None);
        assert_eq!(overlapping(1.0, 1.0).first_touch(9.0), None);
        // It parts, turns round and comes back.
        let back = overlapping(1.0, -1.0).first_touch(9.0).unwrap();
        assert!((back - 1.0).abs() < 1e-12 || back > 1.0, "{back}");
    }

    #[test]
    fn a_ball_that_falls_lands_when_it_should() {
        let fall = first_landing(1.0, 0.0, -9.81, 10.0).unwrap();
        assert!((fall - (2.0f64 / 9.81).sqrt()).abs() < 1e-15);
        assert_eq!(first_landing(1.0, 0.0, -9.81, 0.1), None);
        assert_eq!(first_landing(0.0, 1.0, 0.0, 10.0), None);
        assert_eq!(first_landing(2.0, -1.0, 0.0, 10.0), Some(2.0));
        // Thrown up from the floor, a hair in it: it comes back, and does not touch at once.
        let flight = first_landing(-1e-18, 1.0, -2.0, f64::INFINITY).unwrap();
        assert!((flight - 1.0).abs() < 1e-12, "{flight}");
        // At rest on the floor it touches at once.
        assert_eq!(first_landing(0.0, 0.0, -2.0, f64::INFINITY), Some(0.0));
        assert_eq!(first_landing(1.0, 0.5, 2.0, f64::INFINITY), None);
    }
}
