//! Numbering of nodes with a small envelope (Cuthill and McKee 1969, reversed).

use std::collections::{BTreeSet, VecDeque};

/// Nodes in reverse Cuthill-McKee order, starting from a node at an end of the mesh.
pub(super) fn reverse_cuthill_mckee(nodes: usize, quads: &[[usize; 4]]) -> Vec<usize> {
    let neighbours = neighbours(nodes, quads);
    let mut order = Vec::with_capacity(nodes);
    let mut taken = vec![false; nodes];
    while let Some(first) = (0..nodes).find(|node| !taken[*node]) {
        let start = end_of(first, &neighbours);
        for node in levels(start, &neighbours).0 {
            taken[node] = true;
            order.push(node);
        }
    }
    order.reverse();
    order
}

/// For each node, those that share a quadrilateral with it.
fn neighbours(nodes: usize, quads: &[[usize; 4]]) -> Vec<Vec<usize>> {
    let mut sets = vec![BTreeSet::new(); nodes];
    for quad in quads {
        for a in quad {
            sets[*a].extend(quad.iter().filter(|b| *b != a));
        }
    }
    sets.into_iter().map(|set| set.into_iter().collect()).collect()
}

/// Nodes reached from `start`, breadth first and the least connected first; and how many levels.
fn levels(start: usize, neighbours: &[Vec<usize>]) -> (Vec<usize>, usize) {
    let mut level = vec![usize::MAX; neighbours.len()];
    level[start] = 0;
    let mut order = Vec::new();
    let mut queue = VecDeque::from([start]);
    while let Some(node) = queue.pop_front() {
        order.push(node);
        let mut next: Vec<usize> =
            neighbours[node].iter().copied().filter(|n| level[*n] == usize::MAX).collect();
        next.sort_by_key(|n| (neighbours[*n].len(), *n));
        for n in next {
            level[n] = level[node] + 1;
            queue.push_back(n);
        }
    }
    let deepest = order.last().map_or(0, |last| level[*last]);
    (order, deepest)
}

/// A node from which the mesh is as long as can be (Gibbs, Poole and Stockmeyer 1976).
fn end_of(first: usize, neighbours: &[Vec<usize>]) -> usize {
    let (mut start, mut depth) = (first, 0);
    loop {
        let (order, deepest) = levels(start, neighbours);
        match order.last() {
            Some(&last) if deepest > depth => (start, depth) = (last, deepest),
            _ => return start,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::mesh::rectangle;

    /// Along the longer side, a node's neighbours are at most two rows of the shorter side away.
    #[test]
    fn a_long_rectangle_has_a_narrow_envelope() {
        let mesh = rectangle(1.0, 5.0, 1.0, [20, 4]).unwrap();
        let order = mesh.order();
        let mut place = vec![usize::MAX; order.len()];
        for (at, node) in order.iter().enumerate() {
            place[*node] = at;
        }
        assert!(place.iter().all(|at| *at < order.len()), "a node is missing");
        let reach = mesh.quads().iter().map(|quad| {
            let at = quad.map(|node| place[node]);
            at.iter().max().unwrap() - at.iter().min().unwrap()
        });
        assert!(reach.max().unwrap() <= 2 * 5 + 1);
    }
}
