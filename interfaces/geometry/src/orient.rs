//! Neighbours that wind the same way, shell by shell.

use crate::edges::{Edges, ends};
use crate::{Fault, GeometryError, Mesh};

/// Connected pieces of a surface.
pub struct Shells {
    /// The shell of each triangle. Shells are numbered by their first triangle.
    pub of_triangle: Vec<u32>,
    /// Number of them.
    pub count: usize,
}

/// Turns triangles so that those of a shell wind as its first does.
pub fn agree_on_sides(mesh: &mut Mesh, edges: &Edges) -> Result<Shells, GeometryError> {
    const UNSEEN: u32 = u32::MAX;
    let mut shells = Shells { of_triangle: vec![UNSEEN; mesh.triangles.len()], count: 0 };
    let mut turned = vec![false; mesh.triangles.len()];
    let mut to_visit = Vec::new();
    for start in 0..mesh.triangles.len() {
        if shells.of_triangle[start] != UNSEEN {
            continue;
        }
        let shell = shells.count as u32;
        shells.count += 1;
        shells.of_triangle[start] = shell;
        to_visit.push(start);
        while let Some(triangle) = to_visit.pop() {
            for h in (3 * triangle as u32)..(3 * triangle as u32 + 3) {
                let twin = edges.twins[h as usize];
                let neighbour = twin as usize / 3;
                // Neighbours agree if they run along their edge in opposite directions.
                let disagree = ends(&mesh.triangles, h) == ends(&mesh.triangles, twin);
                let should = turned[triangle] ^ disagree;
                if shells.of_triangle[neighbour] == UNSEEN {
                    shells.of_triangle[neighbour] = shell;
                    turned[neighbour] = should;
                    to_visit.push(neighbour);
                } else if turned[neighbour] != should {
                    let at = ends(&mesh.triangles, h).map(|v| mesh.vertices[v as usize]);
                    return Err(GeometryError::Faults(vec![Fault::OneSided { at }]));
                }
            }
        }
    }
    for (triangle, _) in mesh.triangles.iter_mut().zip(&turned).filter(|(_, turned)| **turned) {
        turn_round(triangle);
    }
    Ok(shells)
}

/// Makes a triangle face the other way.
pub fn turn_round(triangle: &mut [u32; 3]) {
    triangle.swap(1, 2);
}
