//! Things that never move: the box, its walls, inner planes, and the run in words.

use crate::parts;
use crate::patch::{corner, corner_pairs, polygon};
use crate::view::{coordinates, single};
use rerun::components::{AlbedoFactor, MeshFaceRendering, Radius};
use rerun::{
    LineStrips3D, MediaType, Mesh3D, RecordingStream, RecordingStreamResult, TextDocument,
};
use tremie_geometry::Vec3;
use tremie_messages::scene::{
    BodySet, Domain, Face, Motion, Part, PartBoundary, Placement, Plane, PolyhedronPlacement, Scene,
};
use tremie_messages::start::Assignment;

const EDGE: u32 = 0xA8B0_B8FF;
const FLOOR: [u8; 4] = [120, 140, 165, 90];
const WALL: [u8; 4] = [120, 140, 165, 34];
const PLANE: [u8; 4] = [200, 160, 110, 80];

/// Logs everything static.
pub fn log(
    stream: &RecordingStream,
    scene: &Scene,
    assignment: Option<&Assignment>,
) -> RecordingStreamResult<()> {
    stream.log_static("scene", &rerun::ViewCoordinates::new(coordinates(scene)))?;
    stream.log_static("scene/domain/edges", &edges(&scene.domain))?;
    for axis in 0..3 {
        for side in 0..2 {
            let kind = match scene.domain.faces[axis][side] {
                Face::Wall { .. } => "wall",
                Face::Velocity(_) | Face::Pressure { .. } | Face::Reservoir(_) => "open",
                Face::Periodic | Face::Symmetry => continue,
            };
            let (axis_name, side_name) = (["x", "y", "z"][axis], ["0", "1"][side]);
            let name = format!("scene/domain/{kind}_{axis_name}{side_name}");
            stream.log_static(name, &face(scene, axis, side))?;
        }
    }
    for (k, plane) in scene.planes.iter().enumerate() {
        if let Some(mesh) = inner_plane(&scene.domain, plane) {
            stream.log_static(format!("scene/domain/plane_{k}"), &mesh)?;
        }
    }
    let text = TextDocument::new(about(scene, assignment)).with_media_type(MediaType::MARKDOWN);
    stream.log_static("about", &text)
}

fn edges(domain: &Domain) -> LineStrips3D {
    let strip = |(k, l)| [single(corner(domain, k)), single(corner(domain, l))];
    LineStrips3D::new(corner_pairs().map(strip))
        .with_colors([rerun::Color::from_u32(EDGE)])
        .with_radii([Radius::new_ui_points(0.8)])
}

/// A face of the box, seen from inside only: those between the eye and the scene stay out of sight.
fn face(scene: &Scene, axis: usize, side: usize) -> Mesh3D {
    let domain = &scene.domain;
    let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
    let base = side << axis;
    let corners = [base, base | 1 << b, base | 1 << b | 1 << c, base | 1 << c];
    let positions = corners.map(|k| single(corner(domain, k)));
    // Counter-clockwise around the inward normal, which is +axis on the lower side.
    let triangles = if side == 0 { [[0, 1, 2], [0, 2, 3]] } else { [[0, 2, 1], [0, 3, 2]] };
    let pull = scene.gravity[axis] * if side == 0 { -1.0 } else { 1.0 };
    let colour = match domain.faces[axis][side] {
        Face::Velocity(_) | Face::Reservoir(_) => parts::VELOCITY,
        Face::Pressure { .. } => parts::PRESSURE,
        _ if pull > 0.0 => FLOOR,
        _ => WALL,
    };
    surface(positions, triangles, colour).with_face_rendering(MeshFaceRendering::Front)
}

fn surface(
    positions: impl IntoIterator<Item = [f32; 3]>,
    triangles: impl IntoIterator<Item = [u32; 3]>,
    [r, g, b, a]: [u8; 4],
) -> Mesh3D {
    Mesh3D::new(positions)
        .with_triangle_indices(triangles)
        .with_albedo_factor(AlbedoFactor(rerun::Rgba32::from_unmultiplied_rgba(r, g, b, a)))
}

/// The part of a plane that lies in the box; `None` if it misses the box.
fn inner_plane(domain: &Domain, plane: &Plane) -> Option<Mesh3D> {
    let points = polygon(domain, plane.point.into(), plane.normal.into());
    let fan = (1..(points.len() as u32).checked_sub(1)?).map(|k| [0, k, k + 1]);
    Some(surface(points.into_iter().map(single), fan, PLANE))
}

/// The run in words, as Markdown.
fn about(scene: &Scene, assignment: Option<&Assignment>) -> String {
    let size = scene.domain.size();
    let mut rows = vec![(
        "Domain".to_string(),
        format!("{} x {} x {}", length(size[0]), length(size[1]), length(size[2])),
    )];
    rows.push(("Faces".into(), faces(&scene.domain)));
    rows.push(("Gravity".into(), format!("{} m/s²", number(Vec3::from(scene.gravity).norm()))));
    if let Some(fluid) = &scene.fluid {
        rows.push((
            "Fluid".into(),
            format!("{} kg/m³, {} Pa·s", number(fluid.density), number(fluid.viscosity)),
        ));
        let drive = Vec3::from(fluid.acceleration).norm();
        if drive > 0.0 {
            rows.push(("Drive".into(), format!("{} m/s²", number(drive))));
        }
    }
    rows.extend(
        scene.bodies.iter().map(|set| (format!("Bodies `{}`", set.name), describe_set(set))),
    );
    rows.extend(
        scene.parts.iter().map(|part| (format!("Part `{}`", part.name), describe_part(part))),
    );
    if let Some(assignment) = assignment {
        let window = assignment.clock.window();
        rows.push(("Window".into(), format!("{} s", number(window))));
        rows.push((
            "Run".into(),
            format!(
                "{} windows, {} s",
                assignment.windows,
                number(window * assignment.windows as f64)
            ),
        ));
    }
    let table: String =
        rows.iter().map(|(name, value)| format!("| {name} | {value} |\n")).collect();
    format!("| | |\n| --- | --- |\n{table}")
}

fn faces(domain: &Domain) -> String {
    let axis = |a: usize| match domain.faces[a].each_ref().map(kind) {
        [low, high] if low == high => format!("{low} both"),
        [low, high] => format!("{low} to {high}"),
    };
    if (0..3).all(|a| domain.faces[a].each_ref().map(kind) == ["wall"; 2]) {
        return "walls all around".into();
    }
    format!("x {}, y {}, z {}", axis(0), axis(1), axis(2))
}

fn kind(face: &Face) -> &'static str {
    match face {
        Face::Periodic => "periodic",
        Face::Wall { velocity, .. } if *velocity == [0.0; 3] => "wall",
        Face::Wall { .. } => "moving wall",
        Face::Symmetry => "symmetry",
        Face::Velocity(_) => "velocity",
        Face::Pressure { .. } => "pressure",
        Face::Reservoir(_) => "reservoir",
    }
}

fn describe_part(part: &Part) -> String {
    let motion = match part.motion {
        Motion::Free => "free",
        Motion::Fixed => "fixed",
        Motion::Prescribed(_) | Motion::Timed(_) => "driven",
        Motion::Slider(_) => "slides",
    };
    let boundary = match part.boundary {
        PartBoundary::Wall => "wall",
        PartBoundary::Velocity { .. } => "velocity",
        PartBoundary::Pressure { .. } => "pressure",
        PartBoundary::Reservoir(_) => "reservoir",
    };
    format!("{motion}, {boundary}{}", if part.cavity { ", fluid inside" } else { "" })
}

fn describe_set(set: &BodySet) -> String {
    let motion = match set.motion {
        Motion::Free => "",
        Motion::Fixed => ", fixed",
        Motion::Prescribed(_) | Motion::Timed(_) => ", driven",
        Motion::Slider(_) => ", sliding",
    };
    let (how_many, diameters) = match &set.placement {
        Placement::Listed(list) => {
            let plural = if list.len() == 1 { "" } else { "s" };
            (format!("{} sphere{plural}", list.len()), span(list.iter().map(|s| s.diameter)))
        }
        Placement::Packed(packing) => {
            let extremes = packing.diameters.extremes();
            (format!("{} % packing", number(100.0 * packing.fraction)), span(extremes.into_iter()))
        }
        Placement::Polyhedra(own) => {
            let (how_many, diameters) = match &own.placement {
                PolyhedronPlacement::Listed(list) => {
                    (list.len().to_string(), span(list.iter().map(|body| body.diameter)))
                }
                PolyhedronPlacement::Packed(packing) => (
                    format!("{} % packing of", number(100.0 * packing.fraction)),
                    span(packing.diameters.extremes().into_iter()),
                ),
            };
            (format!("{how_many} \"{}\", as large as spheres", own.shape), diameters)
        }
    };
    format!("{how_many} of {diameters}, {} kg/m³{motion}", number(set.density))
}

fn span(values: impl Iterator<Item = f64> + Clone) -> String {
    let low = values.clone().fold(f64::INFINITY, f64::min);
    let high = values.fold(0.0, f64::max);
    if low < high { format!("{} to {}", length(low), length(high)) } else { length(high) }
}

/// A length in the unit that gives the shortest number.
fn length(metres: f64) -> String {
    match metres.abs() {
        m if m >= 1.0 => format!("{} m", number(metres)),
        m if m >= 1e-3 => format!("{} mm", number(metres * 1e3)),
        _ => format!("{} µm", number(metres * 1e6)),
    }
}

/// Four digits, without the zeros at the end.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let digits = 3 - value.abs().log10().floor() as i32;
    if !(-1..=7).contains(&digits) {
        let text = format!("{value:.3e}");
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{}e{exponent}", trim(mantissa));
    }
    trim(&format!("{value:.*}", digits.max(0) as usize)).to_string()
}

fn trim(text: &str) -> &str {
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (1000.0, "1000"),
            (0.05, "0.05"),
            (1.2e-7, "1.2e-7"),
            (9.81, "9.81"),
            (123456.0, "1.235e5"),
            (0.1 + 0.2, "0.3"),
        ] {
            assert_eq!(number(value), text);
        }
        assert_eq!(length(0.0003), "300 µm");
    }

    #[test]
    fn a_plane_across_the_box_is_a_polygon() {
        let scene = crate::view::tests::empty_scene([0.0; 3], [1.0, 1.0, 2.0]);
        let plane = Plane {
            point: [0.5, 0.5, 1.0],
            normal: crate::view::unit(Vec3::new(0.0, 0.3, 1.0)).into(),
            material: "wall".into(),
        };
        assert_eq!(inner_plane(&scene.domain, &plane).unwrap().num_triangles(), 2);
        let outside =
            Plane { point: [0.0, 0.0, 9.0], normal: [0.0, 0.0, 1.0], material: "wall".into() };
        assert!(inner_plane(&scene.domain, &outside).is_none());
    }

    #[test]
    fn the_words_name_what_matters() {
        let text =
            about(&crate::view::tests::empty_scene([0.0, 0.0, -9.81], [0.04, 0.01, 0.02]), None);
        assert!(text.contains("40 mm x 10 mm x 20 mm"), "{text}");
        assert!(text.contains("9.81 m/s²"), "{text}");
    }
}
