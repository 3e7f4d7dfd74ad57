//! A tree of boxes over triangles.
//!
//! Built by the binned surface area heuristic (Wald, *IEEE Symp. Interactive Ray Tracing* 2007, 33).
//! Nodes lie in depth-first order: the left child follows its parent.

use crate::exact::Corners;
use crate::{Bounds, Vec3};

/// Most triangles of a leaf.
const LEAF: usize = 4;
/// Bins in which the heuristic counts triangles.
const BINS: usize = 16;
/// From this depth on nodes are split in equal halves, so that a stack of fixed size suffices:
/// 2^32 triangles are 32 halvings.
const UNEVEN_DEPTH: usize = 32;
const STACK: usize = 64;

/// Triangles in leaves, boxes around them.
#[derive(Clone, Debug)]
pub struct Tree {
    nodes: Vec<Node>,
    /// Triangles in the order of leaves: their numbers.
    numbers: Vec<u32>,
    /// And their corners.
    corners: Vec<Corners>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Bounds,
    /// Triangles of a leaf; zero for an inner node.
    count: u32,
    /// The first triangle of a leaf, or the right child.
    next: u32,
}

/// Whether a walk goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Walk {
    /// It does.
    On,
    /// Enough is known.
    Stop,
}

impl Tree {
    /// The tree of triangles, numbered in the order given.
    pub fn of(triangles: impl Iterator<Item = Corners>) -> Self {
        let corners: Vec<Corners> = triangles.collect();
        let items: Vec<Item> = corners.iter().enumerate().map(Item::of).collect();
        let mut builder = Builder { items, nodes: Vec::with_capacity(corners.len()) };
        if !corners.is_empty() {
            builder.build(0..corners.len(), 0);
        }
        let numbers: Vec<u32> = builder.items.iter().map(|item| item.number).collect();
        let corners = numbers.iter().map(|&t| corners[t as usize]).collect();
        Self { nodes: builder.nodes, numbers, corners }
    }

    /// The box around everything.
    pub fn bounds(&self) -> Bounds {
        self.nodes.first().map_or(Bounds::EMPTY, |root| root.bounds)
    }

    /// Visits triangles in all leaves whose boxes, and those around them, `enter` accepts.
    pub fn walk(
        &self,
        mut enter: impl FnMut(&Bounds) -> bool,
        mut visit: impl FnMut(u32, &Corners) -> Walk,
    ) {
        let mut stack = [0u32; STACK];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let mut at = stack[depth] as usize;
            while enter(&self.nodes[at].bounds) {
                let node = self.nodes[at];
                if node.count == 0 {
                    stack[depth] = node.next;
                    depth += 1;
                    at += 1;
                    continue;
                }
                for i in node.next as usize..(node.next + node.count) as usize {
                    if visit(self.numbers[i], &self.corners[i]) == Walk::Stop {
                        return;
                    }
                }
                break;
            }
        }
    }

    /// Visits triangles in boxes no farther from a point than a squared distance that `visit` returns:
    /// the nearest found so far. Nearer boxes come first.
    pub fn approach(
        &self,
        point: Vec3,
        mut farthest: f64,
        mut visit: impl FnMut(u32, &Corners) -> f64,
    ) {
        let mut stack = [(0u32, 0.0f64); STACK];
        let mut depth = 0;
        if let Some(root) = self.nodes.first() {
            stack[0].1 = root.bounds.distance_squared(point);
            depth = 1;
        }
        while depth > 0 {
            depth -= 1;
            let (mut at, mut distance) = stack[depth];
            while distance <= farthest {
                let node = &self.nodes[at as usize];
                if node.count > 0 {
                    for i in node.next as usize..(node.next + node.count) as usize {
                        farthest = visit(self.numbers[i], &self.corners[i]);
                    }
                    break;
                }
                let away = |child: u32| self.nodes[child as usize].bounds.distance_squared(point);
                let (left, right) = (at + 1, node.next);
                let (to_left, to_right) = (away(left), away(right));
                let (near, far) = if to_left <= to_right {
                    ((left, to_left), (right, to_right))
                } else {
                    ((right, to_right), (left, to_left))
                };
                stack[depth] = far;
                depth += 1;
                (at, distance) = near;
            }
        }
    }
}

/// A triangle while the tree is built.
#[derive(Clone, Copy)]
struct Item {
    bounds: Bounds,
    number: u32,
}

impl Item {
    fn of((number, corners): (usize, &Corners)) -> Self {
        Self { bounds: Bounds::of(*corners), number: number as u32 }
    }

    /// Twice the coordinate of its middle along an axis.
    fn middle(&self, axis: usize) -> f64 {
        self.bounds.min[axis] + self.bounds.max[axis]
    }
}

struct Builder {
    items: Vec<Item>,
    nodes: Vec<Node>,
}

impl Builder {
    fn build(&mut self, range: std::ops::Range<usize>, depth: usize) {
        let items = &mut self.items[range.clone()];
        let bounds = items.iter().fold(Bounds::EMPTY, |b, item| b.union(&item.bounds));
        let at = self.nodes.len();
        let (count, next) = (items.len() as u32, range.start as u32);
        self.nodes.push(Node { bounds, count, next });
        if items.len() <= LEAF {
            return;
        }
        let split = if depth < UNEVEN_DEPTH { split_by_area(items) } else { None };
        let middle = range.start + split.unwrap_or_else(|| split_in_half(items, &bounds));
        self.build(range.start..middle, depth + 1);
        self.nodes[at].count = 0;
        self.nodes[at].next = self.nodes.len() as u32;
        self.build(middle..range.end, depth + 1);
    }
}

/// Sorts items into two parts such that the areas of their boxes, weighted by their numbers, are
/// least; returns the size of the first. `None` where all middles coincide.
fn split_by_area(items: &mut [Item]) -> Option<usize> {
    let middles = |axis: usize| {
        items.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), item| {
            (low.min(item.middle(axis)), high.max(item.middle(axis)))
        })
    };
    let mut best: Option<(f64, usize, f64, f64, usize)> = None;
    for axis in 0..3 {
        let (low, high) = middles(axis);
        let scale = BINS as f64 / (high - low);
        if !(high > low && scale.is_finite()) {
            continue;
        }
        let (cost, bin) = cheapest_bin(items, axis, low, scale);
        if best.is_none_or(|(least, ..)| cost < least) {
            best = Some((cost, axis, low, scale, bin));
        }
    }
    let (_, axis, low, scale, bin) = best?;
    items.sort_by_key(|item| bin_of(item, axis, low, scale) > bin);
    Some(items.partition_point(|item| bin_of(item, axis, low, scale) <= bin))
}

fn bin_of(item: &Item, axis: usize, low: f64, scale: f64) -> usize {
    (((item.middle(axis) - low) * scale) as usize).min(BINS - 1)
}

/// The last bin of the first part for the cheapest split along an axis, and its cost.
fn cheapest_bin(items: &[Item], axis: usize, low: f64, scale: f64) -> (f64, usize) {
    let mut bins = [(Bounds::EMPTY, 0usize); BINS];
    for item in items {
        let (bounds, count) = &mut bins[bin_of(item, axis, low, scale)];
        *bounds = bounds.union(&item.bounds);
        *count += 1;
    }
    let mut from_right = [0.0; BINS];
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    for bin in (1..BINS).rev() {
        bounds = bounds.union(&bins[bin].0);
        count += bins[bin].1;
        from_right[bin] = cost(&bounds, count);
    }
    let mut best = (f64::INFINITY, 0);
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    for bin in 0..BINS - 1 {
        bounds = bounds.union(&bins[bin].0);
        count += bins[bin].1;
        let total = cost(&bounds, count) + from_right[bin + 1];
        // The extreme middles are in the extreme bins: neither part is empty.
        if total < best.0 {
            best = (total, bin);
        }
    }
    best
}

fn cost(bounds: &Bounds, count: usize) -> f64 {
    if count == 0 { 0.0 } else { bounds.half_area() * count as f64 }
}

/// Sorts items into halves along the longest side; returns the size of the first.
fn split_in_half(items: &mut [Item], bounds: &Bounds) -> usize {
    let size = bounds.size();
    let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
    let half = items.len() / 2;
    items.select_nth_unstable_by(half, |a, b| {
        a.middle(axis).total_cmp(&b.middle(axis)).then(a.number.cmp(&b.number))
    });
    half
}
