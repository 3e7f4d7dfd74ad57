//! Hidden surface of walls and parts: pieces that lie in others are cut off. So no place counts
//! twice where several make up one wall.
//!
//! A part has solid straight below each of its triangles, as far as grains ever reach; a wall has
//! it everywhere below. What of another's surface lies there is not surface of both together. Where
//! two surfaces coincide and face one way, the one of the lower rank counts; where they face each
//! other neither does.

use super::{overlap_integrals::clip, shape::Solid};
use crate::Vec3;
use crate::bodies::mesh_contact::SAME;
use tremie_grains_kit::space::wall_triangle::Triangle;

/// Surfaces that are closer to each other than this, over the largest sphere in the body, coincide:
/// more than corners of triangles are off by when a file rounds them.
const TIE: f64 = 1e-5;

/// Depth below a triangle to which a part is taken as solid, over the largest sphere in the body:
/// more than it ever overlaps.
const DEEP: f64 = 0.25;

/// Pieces whose area is smaller than this, over the square of the same, are rounding.
const NOTHING: f64 = 1e-12;

/// Surfaces whose normals have a larger product face one way.
const ONE_WAY: f64 = 0.5;

/// Owner of a surface: place of the owner in the list, its rank among all, and whether it is a
/// wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Whose {
    pub owner: u32,
    pub rank: u32,
    pub wall: bool,
}

/// Solid below a triangle or a wall, seen from the centroid of a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cover {
    whose: Whose,
    /// Normals outward, and `x.normal` of the points: the top, the bottom and the sides; of a wall
    /// only the top.
    planes: [(Vec3, f64); 5],
    /// Ends of a box that holds it.
    ends: [Vec3; 2],
}

impl Cover {
    /// Below a wall, whose points have `x.normal = offset`, if the body reaches there.
    pub fn of_wall(whose: Whose, normal: Vec3, offset: f64, a: Solid<'_>) -> Option<Self> {
        let everywhere = [f64::NEG_INFINITY, f64::INFINITY].map(Vec3::repeat);
        let reaches = -a.support(-normal) < offset;
        reaches.then_some(Self { whose, planes: [(normal, offset); 5], ends: everywhere })
    }

    /// Below a triangle, if the body is before it and reaches there.
    pub fn of_triangle(whose: Whose, triangle: &Triangle, a: Solid<'_>) -> Option<Self> {
        let Triangle { corners, normal, .. } = *triangle;
        let top = normal.dot(&corners[0]);
        if top >= 0.0 || -a.support(-normal) >= top {
            return None;
        }
        let mut planes = [(normal, top); 5];
        planes[1] = (-normal, DEEP * a.inradius() - top);
        for k in 0..3 {
            let side = (corners[(k + 1) % 3] - corners[k]).cross(&normal);
            let side = side / side.norm_squared().sqrt();
            planes[2 + k] = (side, side.dot(&corners[k]));
            if -a.support(-side) >= planes[2 + k].1 {
                return None;
            }
        }
        let deep = normal * (DEEP * a.inradius());
        let tie = Vec3::repeat(TIE * a.inradius());
        let below = corners.map(|corner| corner - deep);
        let all = || corners.iter().chain(&below);
        let min = all().fold(corners[0], |min, x| min.inf(x)) - tie;
        let max = all().fold(corners[0], |max, x| max.sup(x)) + tie;
        Some(Self { whose, planes, ends: [min, max] })
    }

    fn planes(&self) -> &[(Vec3, f64)] {
        if self.whose.wall { &self.planes[..1] } else { &self.planes }
    }
}

/// A surface that is looked at, in the frame of a body.
#[derive(Clone, Copy, Debug)]
pub(super) struct HiddenSearch {
    pub whose: Whose,
    pub normal: Vec3,
    /// Radius of the largest sphere in the body [m].
    pub inradius: f64,
}

/// Solid regions of walls and parts near a body, and room to cut polygons.
#[derive(Clone, Debug, Default)]
pub(super) struct Covers {
    pub list: Vec<Cover>,
    /// Covers that may hide any of the polygon that is cut.
    near: Vec<u32>,
    /// Corners of the pieces that are left of the last polygon, and where each ends.
    corners: Vec<Vec3>,
    ends: Vec<u32>,
    /// Corners of pieces that are not done, where each begins, and the cover that is next for it.
    waiting: Vec<Vec3>,
    begins: Vec<(u32, u32)>,
    rest: Vec<Vec3>,
    spare: Vec<Vec3>,
}

impl Covers {
    /// Makes room for so many covers.
    pub fn reserve(&mut self, covers: usize) {
        let corners = 32 * covers.max(4);
        let lists = [&mut self.corners, &mut self.waiting, &mut self.rest, &mut self.spare];
        for list in lists {
            list.reserve(corners.saturating_sub(list.len()));
        }
        self.list.reserve(covers.saturating_sub(self.list.len()));
        self.near.reserve(covers.saturating_sub(self.near.len()));
        self.ends.reserve(corners.saturating_sub(self.ends.len()));
        self.begins.reserve(corners.saturating_sub(self.begins.len()));
    }

    /// The pieces that the last [`cut`](Self::cut) left.
    pub fn pieces(&self) -> impl Iterator<Item = &[Vec3]> {
        let begins = std::iter::once(0).chain(self.ends.iter().copied());
        begins.zip(&self.ends).map(|(begin, &end)| &self.corners[begin as usize..end as usize])
    }

    /// Cuts the hidden pieces away from a polygon; false if none is hidden.
    pub fn cut(&mut self, polygon: &[Vec3], looked: &HiddenSearch) -> bool {
        self.corners.clear();
        self.ends.clear();
        self.find_near(polygon, looked);
        if self.near.is_empty() {
            return false;
        }
        self.waiting.clear();
        self.waiting.extend(polygon);
        self.begins.clear();
        self.begins.push((0, 0));
        let mut any = false;
        // A stack: the piece on top meets the covers from `next` on. Those before did not hide any
        // of it.
        while let Some((begin, next)) = self.begins.pop() {
            let begin = begin as usize;
            let hider = (next as usize..self.near.len()).find(|&k| self.hides(k, begin, looked));
            let Some(next) = hider else {
                self.corners.extend(&self.waiting[begin..]);
                self.ends.push(self.corners.len() as u32);
                self.waiting.truncate(begin);
                continue;
            };
            any = true;
            let cover = &self.list[self.near[next] as usize];
            self.rest.clear();
            self.rest.extend(&self.waiting[begin..]);
            self.waiting.truncate(begin);
            // The piece beyond a plane stays, the rest goes on to the next plane. The last rest is
            // hidden.
            for plane in cover.planes() {
                let within = looked.within(cover, plane);
                clip(&self.rest, |x| -within(x), &mut self.spare);
                if area(&self.spare, looked.normal) > looked.nothing() {
                    self.begins.push((self.waiting.len() as u32, next as u32 + 1));
                    self.waiting.extend(&self.spare);
                }
                clip(&self.rest, within, &mut self.spare);
                std::mem::swap(&mut self.rest, &mut self.spare);
            }
        }
        any
    }

    /// Finds the covers that may hide any of a polygon, by boxes.
    fn find_near(&mut self, polygon: &[Vec3], looked: &HiddenSearch) {
        self.near.clear();
        let Some(&first) = polygon.first() else { return };
        let min = polygon.iter().fold(first, |min, x| min.inf(x));
        let max = polygon.iter().fold(first, |max, x| max.sup(x));
        let meets = |[low, high]: &[Vec3; 2]| (0..3).all(|a| max[a] > low[a] && min[a] < high[a]);
        let near = |cover: &Cover| looked.may_lie_in(cover) && meets(&cover.ends);
        let near = (0..).zip(&self.list).filter(|(_, cover)| near(cover));
        self.near.extend(near.map(|(k, _)| k));
    }

    /// True if cover `k` of those near the polygon hides any of the piece that waits last.
    fn hides(&mut self, k: usize, begin: usize, looked: &HiddenSearch) -> bool {
        let cover = &self.list[self.near[k] as usize];
        self.rest.clear();
        self.rest.extend(&self.waiting[begin..]);
        for plane in cover.planes() {
            clip(&self.rest, looked.within(cover, plane), &mut self.spare);
            std::mem::swap(&mut self.rest, &mut self.spare);
            if area(&self.rest, looked.normal) <= looked.nothing() {
                return false;
            }
        }
        true
    }
}

impl HiddenSearch {
    fn nothing(&self) -> f64 {
        NOTHING * self.inradius * self.inradius
    }

    fn may_lie_in(&self, cover: &Cover) -> bool {
        let (own, other) = (self.whose, cover.whose);
        let along = self.normal.dot(&cover.planes[0].0);
        let elsewhere = own.owner != other.owner;
        // Walls that meet at an edge are half spaces by themselves.
        let both_walls = own.wall && other.wall && along < SAME;
        elsewhere && !both_walls
    }

    /// Depth of a point behind a plane of a cover [m]. A tolerance decides for surfaces that just
    /// coincide: one side counts as outside.
    fn within(
        &self,
        cover: &Cover,
        &(normal, offset): &(Vec3, f64),
    ) -> impl Fn(Vec3) -> f64 + use<> {
        let along = self.normal.dot(&normal);
        let gives_way = along > ONE_WAY && self.whose.rank > cover.whose.rank;
        let outside = TIE * self.inradius * if gives_way { -along } else { along };
        move |x| offset - normal.dot(&x) - outside
    }
}

/// Area of a polygon with a normal.
fn area(polygon: &[Vec3], normal: Vec3) -> f64 {
    let Some((&first, rest)) = polygon.split_first() else { return 0.0 };
    let fan = rest.windows(2).map(|pair| (pair[0] - first).cross(&(pair[1] - first)));
    0.5 * fan.map(|cross| cross.dot(&normal)).sum::<f64>().abs()
}
