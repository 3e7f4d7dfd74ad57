//! Description of the folder's files in words.

use std::fmt::Write;
use tremie_messages::scene::Scene;

/// The text of `about.txt`.
pub fn text(scene: &Scene) -> String {
    let mut text = String::from(
        "Open the .pvd files in ParaView: each is a series of the files beside it.\n\
         World frame, SI units; _NNNNNN in a name is the coupling window.\n\n\
         lattice  velocity [m/s], pressure [Pa] (gauge, without its hydrostatic part), fill (share of fluid), solid (1 in a solid)\n\
         bodies   id, set, motion (0 free, 1 fixed, 2 prescribed, 3 slider), radius [m], mass [kg], velocity [m/s],\n         \
         angular_velocity [rad/s], orientation (unit quaternion x, y, z, w from body to world)\n         \
         Spheres: filter Glyph, glyph type Sphere, scale array radius, scale factor 2; cylinders of a plane scene: glyph type Cylinder.\n\
         parts    velocity [m/s] of points, part (index) of cells\n\
         polyhedra  velocity [m/s] of points, id, set and shape (indices) of cells\n\
         rubber   velocity [m/s] and strain (equivalent shear strain) of points, surface (index) and\n         \
         kind (0 touches the seat, 2 is bonded, 1 is neither) of cells\n",
    );
    let mut list = |title: &str, names: &mut dyn Iterator<Item = &String>| {
        for (k, name) in names.enumerate() {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{}{title} {k} = {name}", if k == 0 { "\n" } else { "" });
        }
    };
    list("set", &mut scene.bodies.iter().map(|set| &set.name));
    list("shape", &mut scene.shapes.iter().map(|shape| &shape.name));
    list("part", &mut scene.parts.iter().map(|part| &part.name));
    list("surface", &mut scene.surfaces.iter().map(|surface| &surface.name));
    text
}
