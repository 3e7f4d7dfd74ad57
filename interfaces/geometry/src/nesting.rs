//! Nesting of shells: those inside others, and the side to which each must face.

use crate::inside::winding;
use crate::moments::signed_volume;
use crate::orient::{Shells, turn_round};
use crate::tree::Tree;
use crate::{Bounds, Fault, GeometryError, Mesh, Vec3};

/// One shell, with normals outward as if it were alone.
struct Shell {
    triangles: Vec<u32>,
    vertices: Vec<Vec3>,
    bounds: Bounds,
    tree: Tree,
}

/// Turns every shell outward, or inward if it bounds a hollow: if an odd number of other shells
/// hold it. A shell that crosses another is not inside it: the solid is the union of both.
pub fn orient_shells(mesh: &mut Mesh, shells: &Shells) -> Result<(), GeometryError> {
    let mut members = vec![Vec::new(); shells.count];
    for (triangle, &shell) in shells.of_triangle.iter().enumerate() {
        members[shell as usize].push(triangle as u32);
    }
    let mut faults = Vec::new();
    for triangles in &members {
        if let Err(fault) = turn_outward(mesh, triangles) {
            faults.push(fault);
        }
    }
    if !faults.is_empty() {
        return Err(GeometryError::Faults(faults));
    }
    if shells.count == 1 {
        return Ok(());
    }
    let alone: Vec<Shell> =
        members.into_iter().map(|triangles| Shell::of(mesh, triangles)).collect();
    for (i, shell) in alone.iter().enumerate() {
        let around = |(j, other): &(usize, &Shell)| *j != i && other.holds(shell);
        if alone.iter().enumerate().filter(around).count() % 2 == 1 {
            shell.triangles.iter().for_each(|&t| turn_round(&mut mesh.triangles[t as usize]));
        }
    }
    Ok(())
}

/// Turns a shell so that its volume is positive.
fn turn_outward(mesh: &mut Mesh, triangles: &[u32]) -> Result<(), Fault> {
    let corners = || triangles.iter().map(|&t| mesh.corners(t as usize));
    let bounds = Bounds::of(corners().flatten());
    let volume = signed_volume(corners(), bounds.centre());
    // Less than the volume that rounding can feign.
    let least = f64::EPSILON * triangles.len() as f64 * bounds.magnitude() * bounds.half_area();
    if volume.abs() <= least {
        return Err(Fault::Flat { triangles: triangles.len(), bounds });
    }
    if volume < 0.0 {
        triangles.iter().for_each(|&t| turn_round(&mut mesh.triangles[t as usize]));
    }
    Ok(())
}

impl Shell {
    fn of(mesh: &Mesh, triangles: Vec<u32>) -> Self {
        let mut names: Vec<u32> =
            triangles.iter().flat_map(|&t| mesh.triangles[t as usize]).collect();
        names.sort_unstable();
        names.dedup();
        let vertices: Vec<Vec3> = names.iter().map(|&v| mesh.vertices[v as usize]).collect();
        let tree = Tree::of(triangles.iter().map(|&t| mesh.corners(t as usize)));
        Self { bounds: Bounds::of(vertices.iter().copied()), triangles, vertices, tree }
    }

    /// True if all of another shell's vertices are inside this one, or on it.
    fn holds(&self, other: &Self) -> bool {
        self.bounds.contains(other.bounds.min)
            && self.bounds.contains(other.bounds.max)
            && other.vertices.iter().all(|&v| winding(&self.tree, v).is_solid(0))
    }
}
