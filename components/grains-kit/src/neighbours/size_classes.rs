//! Classes of sizes: bodies of about one size share a level of cells, and a skin.
//!
//! A class reaches from its largest body down to half of that, and the next one begins at the
//! largest body that is smaller. Bodies within a factor of two are one class, so that a bed of
//! nearly equal spheres has one level and one skin. With a single skin for all, a small grain among
//! large ones would list all grains around that a large one could reach; with a single size of
//! cells it would look at all in a cell of the large ones.

/// So many classes hold diameters over seven orders of magnitude; the last one takes whatever is
/// smaller still.
const MOST: usize = 24;

/// The classes of a set of bodies, and the skins beyond the reach of forces within which pairs are
/// listed.
#[derive(Clone, Debug, PartialEq)]
pub struct Skins {
    /// Largest diameter of each class [m], descending; there is at least one class.
    largest: Vec<f64>,
    /// Skin of each class [m].
    skins: Vec<f64>,
    /// Reach of forces: largest gap of surfaces at which they act [m].
    pub reach: f64,
}

impl Skins {
    /// For bodies whose diameters lie in the spans `[smallest, largest]` [m]; a skin is a
    /// `fraction` of its class's largest diameter. Without any body the skin is infinite: lists of
    /// nothing are never due.
    pub fn new(spans: impl Iterator<Item = [f64; 2]> + Clone, fraction: f64, reach: f64) -> Self {
        let mut largest: Vec<f64> = Vec::new();
        while largest.len() < MOST {
            let below = largest.last().map_or(f64::INFINITY, |d| 0.5 * d);
            let rest = spans.clone().filter(|[low, _]| *low < below);
            let next = rest.fold(0.0, |top: f64, [_, high]| top.max(high.min(below)));
            if next <= 0.0 {
                break;
            }
            largest.push(next);
        }
        if largest.is_empty() {
            return Self { largest: vec![0.0], skins: vec![f64::INFINITY], reach };
        }
        let skins = largest.iter().map(|d| fraction * d).collect();
        Self { largest, skins, reach }
    }

    /// Of one class, for bodies of at most this diameter [m], without a skin.
    pub fn one(largest: f64) -> Self {
        Self { largest: vec![largest], skins: vec![0.0], reach: 0.0 }
    }

    /// Number of classes.
    pub fn count(&self) -> usize {
        self.largest.len()
    }

    /// The class of a body: the last one that is wide enough.
    #[inline(always)]
    pub fn class(&self, radius: f64) -> usize {
        self.largest[1..].iter().take_while(|&&largest| largest >= 2.0 * radius).count()
    }

    /// Largest diameter of a class [m].
    pub fn largest(&self, class: usize) -> f64 {
        self.largest[class]
    }

    /// Largest gap of two bodies of these classes that is listed [m].
    #[inline(always)]
    pub fn between(&self, a: usize, b: usize) -> f64 {
        self.reach + 0.5 * (self.skins[a] + self.skins[b])
    }

    /// Largest gap between a body and a wall or a part that is listed [m].
    #[inline(always)]
    pub fn gap(&self, radius: f64) -> f64 {
        self.reach + self.skins[self.class(radius)]
    }

    /// Skin of a body [m].
    pub fn of(&self, radius: f64) -> f64 {
        self.skins[self.class(radius)]
    }

    /// Largest displacement of a body of a class until lists are due [m]: half of its skin.
    pub fn slack(&self, class: usize) -> f64 {
        0.5 * self.skins[class]
    }

    /// Largest displacement of any body, wall or part until lists are due [m].
    pub fn least_slack(&self) -> f64 {
        self.skins.iter().fold(f64::INFINITY, |least, skin| least.min(0.5 * skin))
    }
}

/// Limit of the displacements of bodies until lists are due.
#[derive(Clone, Copy)]
pub struct Leash<'a> {
    skins: &'a Skins,
    /// Class of each body, in the order of memory; nothing where there is but one.
    classes: &'a [u8],
    least: f64,
}

impl<'a> Leash<'a> {
    /// Leash of bodies of these classes.
    pub fn new(skins: &'a Skins, classes: &'a [u8]) -> Self {
        Self { skins, classes, least: skins.least_slack() }
    }

    /// True if lists are due. `squares` are squared displacements of the bodies from `first` on
    /// [m²], and `farthest` is the largest of them. A body is due at half of the skin of its class;
    /// NaN is due.
    #[inline(always)]
    pub fn is_due(
        &self,
        farthest: f64,
        first: usize,
        mut squares: impl Iterator<Item = f64>,
    ) -> bool {
        let within = |square: f64, slack: f64| square < slack * slack;
        if within(farthest, self.least) {
            return false;
        }
        // Where no classes are told, all bodies are of one.
        let mut classes = self.classes.get(first..).unwrap_or_default().iter();
        squares.any(|square| {
            let class = classes.next().map_or(0, |&class| class as usize);
            !within(square, self.skins.slack(class))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn classes(spans: &[[f64; 2]]) -> Vec<f64> {
        Skins::new(spans.iter().copied(), 0.1, 0.0).largest
    }

    #[test]
    fn classes_begin_at_bodies() {
        let point = |d: f64| [d, d];
        assert_eq!(classes(&[[0.5, 1.0]]), [1.0]);
        assert_eq!(classes(&[point(0.5), point(1.0), point(0.8)]), [1.0]);
        assert_eq!(classes(&[point(0.2), point(12.0), point(0.19)]), [12.0, 0.2]);
        assert_eq!(classes(&[point(12.0), [0.1, 0.3], point(1.5)]), [12.0, 1.5, 0.3, 0.15]);
        assert_eq!(classes(&[[1.0, 5.0]]), [5.0, 2.5, 1.25]);
        assert_eq!(classes(&[[1e-30, 1.0]]).len(), MOST);
    }

    #[test]
    fn a_body_belongs_to_the_last_class_that_is_wide_enough() {
        let skins = Skins::new([[0.1, 0.2], [12.0, 12.0]].into_iter(), 0.1, 0.5);
        assert_eq!([6.0, 0.11, 0.1, 0.05, 0.001].map(|r| skins.class(r)), [0, 0, 1, 1, 1]);
        assert_eq!(skins.gap(0.1), 0.5 + 0.1 * 0.2);
        assert_eq!(skins.between(0, 1), 0.5 + 0.5 * (0.1 * 12.0 + 0.1 * 0.2));
        assert_eq!(skins.least_slack(), 0.5 * (0.1 * 0.2));
        let none = Skins::new(std::iter::empty(), 0.1, 0.0);
        assert_eq!((none.count(), none.least_slack()), (1, f64::INFINITY));
    }
}
