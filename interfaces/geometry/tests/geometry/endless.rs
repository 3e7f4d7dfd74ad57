//! Parts that go through periodic faces: their ends beyond the domain are no walls, and what is
//! between the faces goes on.

use tremie_geometry::{EndlessFault, Frame, GeometryError, Surface, Vec3, motion_problem};
use tremie_messages::scene::{
    Course, Domain, Face, Geometry, Motion, Part, PartBoundary, Pose, TimedMotion,
};

/// A box from zero to `size` with the given axes periodic.
fn domain(size: Vec3, periodic: [bool; 3]) -> Domain {
    let face = |p: bool| if p { Face::Periodic } else { Face::WALL };
    Domain::new([0.0; 3], size.into(), periodic.map(|p| [face(p), face(p)]))
}

fn part(geometry: Geometry, position: Vec3, (axis, degrees): (Vec3, f64)) -> Part {
    let (sin, cos) = (0.5 * degrees.to_radians()).sin_cos();
    Part {
        name: "bar".into(),
        geometry,
        pose: Pose {
            position: position.into(),
            orientation: [axis[0] * sin, axis[1] * sin, axis[2] * sin, cos],
        },
        cavity: false,
        material: "steel".into(),
        motion: Motion::Fixed,
        boundary: PartBoundary::Wall,
    }
}

const UPRIGHT: (Vec3, f64) = (Vec3::new(1.0, 0.0, 0.0), 0.0);

fn fault(part: &Part, domain: &Domain) -> EndlessFault {
    match Surface::in_domain(part, domain) {
        Err(GeometryError::Endless(fault)) => fault,
        other => panic!("{other:?}"),
    }
}

/// Asks about points of the domain and a little around it, in the world: what is inside, and how
/// far away the wall is.
fn agrees(part: &Part, domain: &Domain, distance: impl Fn(Vec3) -> f64, exact: f64) {
    let surface = Surface::in_domain(part, domain).unwrap();
    let position = surface.endless().place(part.pose.position).into();
    let (frame, size) = (Frame::of(&Pose { position, ..part.pose }), domain.size());
    let (mut inside, mut outside) = (0, 0);
    for k in 0..4000 {
        let share = |s: f64| (f64::from(k) * s).fract() * 1.4 - 0.2;
        let shares = [share(0.754_877_67), share(0.569_840_29), share(0.430_159_71)];
        let at = Vec3::from_fn(|a, _| domain.min[a] + shares[a] * size[a]);
        let wanted = distance(at);
        let found = surface.signed_distance(frame.to_part(at));
        if wanted.abs() < 2.0 * exact {
            continue;
        }
        assert_eq!(found < 0.0, wanted < 0.0, "{at:?}: {found} {wanted}");
        assert!((found - wanted).abs() < exact, "{at:?}: {found} {wanted}");
        if wanted < 0.0 { inside += 1 } else { outside += 1 }
    }
    assert!(inside > 100 && outside > 100, "{inside} {outside}");
}

#[test]
fn a_rod_has_no_ends_wherever_they_are() {
    let domain = domain(Vec3::new(1.0, 1.0, 0.5), [false, false, true]);
    for (length, middle) in [(0.5, 0.25), (0.7, 0.25), (0.501, 0.2502), (9.0, -2.0), (4.0, 1.0)] {
        let rod =
            part(Geometry::Cylinder { radius: 0.2, length }, Vec3::new(0.5, 0.5, middle), UPRIGHT);
        agrees(&rod, &domain, |x| (x[0] - 0.5).hypot(x[1] - 0.5) - 0.2, 2e-5);
        let surface = Surface::in_domain(&rod, &domain).unwrap();
        let (volume, centre) = surface.volume_and_centroid();
        assert!((volume - std::f64::consts::PI * 0.02).abs() < 1e-12, "{volume}");
        assert!(centre[0].abs() < 1e-12 && centre[1].abs() < 1e-12, "{centre:?}");
        assert!((surface.area() - 0.2 * std::f64::consts::PI).abs() < 1e-4);
        assert!((surface.bounding_radius() - 0.2).abs() < 2e-5, "its length does not count");
        // Two triangles for each of its sides: what was cut to pieces is whole again.
        let walls = (0..surface.mesh().triangles.len()).filter(|&t| surface.is_wall(t as u32));
        assert_eq!(walls.count(), 512);
    }
    // One that ends a little before the face is not endless.
    let short =
        part(Geometry::Cylinder { radius: 0.2, length: 0.49 }, Vec3::new(0.5, 0.5, 0.25), UPRIGHT);
    assert!(!Surface::in_domain(&short, &domain).unwrap().endless().is_any());
}

#[test]
fn a_rod_may_lie_along_any_axis_and_be_a_hollow() {
    let domain = domain(Vec3::new(0.5, 1.0, 1.0), [true, false, false]);
    let geometry = Geometry::Cylinder { radius: 0.3, length: 2.0 };
    let mut rod = part(geometry, Vec3::new(0.1, 0.5, 0.5), (Vec3::new(0.0, 1.0, 0.0), 90.0));
    let round = |x: Vec3| (x[1] - 0.5).hypot(x[2] - 0.5) - 0.3;
    agrees(&rod, &domain, round, 3e-5);
    rod.cavity = true;
    let hollow = Surface::in_domain(&rod, &domain).unwrap().inside_out();
    assert!(hollow.is_cavity() && hollow.endless().axes == [true, false, false]);
    let frame = Frame::of(&rod.pose);
    assert!(!hollow.contains(frame.to_part([0.5, 0.5, 0.5])));
    assert!(hollow.contains(frame.to_part([0.5, 0.5, 0.9])));
}

#[test]
fn a_plate_is_endless_along_two_axes() {
    let domain = domain(Vec3::new(0.0625, 10.0, 0.0625), [true, false, true]);
    let plate = part(Geometry::Box { size: [4.0, 1.0, 4.0] }, Vec3::new(0.03, 3.0, 0.03), UPRIGHT);
    agrees(&plate, &domain, |x| (x[1] - 3.0).abs() - 0.5, 1e-12);
    let surface = Surface::in_domain(&plate, &domain).unwrap();
    assert_eq!(surface.endless().axes, [true, false, true]);
    assert_eq!(surface.endless().straight, [true, false, true]);
    let (volume, centre) = surface.volume_and_centroid();
    assert!((volume - 0.0625 * 0.0625).abs() < 1e-15, "{volume}");
    assert!(centre[1].abs() < 1e-12, "{centre:?}");
    // Wherever it slides to, its surface stays.
    assert_eq!(surface.endless().place([17.3, 3.5, -8.0]), Vec3::new(0.03, 3.5, 0.03));
}

/// Two plates, as one file may have them: four walls meet in each line between what closes them.
#[test]
fn two_plates_in_one_file_are_endless_too() {
    let domain = domain(Vec3::new(1.0, 4.0, 1.0), [true, false, true]);
    let mut mesh = Surface::of(&Geometry::Box { size: [3.0, 0.5, 3.0] }).unwrap().mesh().clone();
    let other = mesh.clone();
    let first = mesh.vertices.len() as u32;
    mesh.vertices.extend(other.vertices.iter().map(|v| v + Vec3::y() * 1.5));
    mesh.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plates.stl");
    write(&path, &mesh);
    let geometry = Geometry::File { path: path.to_string_lossy().into_owned(), unit: 1.0 };
    let plates = part(geometry, Vec3::new(0.5, 1.0, 0.5), UPRIGHT);
    let distance = |x: Vec3| ((x[1] - 1.0).abs() - 0.25).min((x[1] - 2.5).abs() - 0.25);
    agrees(&plates, &domain, distance, 1e-6);
}

fn write(path: &std::path::Path, mesh: &tremie_geometry::Mesh) {
    let mut text = String::from("solid bar\n");
    for t in 0..mesh.triangles.len() {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in mesh.corners(t).map(<[f64; 3]>::from) {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    std::fs::write(path, text + "endsolid bar\n").unwrap();
}

/// A wavy bar whose period is the domain's: not straight, but the same at both faces.
#[test]
fn a_wavy_rod_goes_on_as_its_waves_do() {
    let domain = domain(Vec3::new(1.0, 1.0, 1.0), [false, false, true]);
    let radius = |z: f64| 0.25 + 0.1 * (std::f64::consts::TAU * z).cos();
    let mut profile = vec![[0.0, -1.3]];
    profile.extend((0..=260).map(|k| -1.3 + 0.01 * f64::from(k)).map(|z| [radius(z), z]));
    profile.push([0.0, 1.3]);
    let rod = part(Geometry::Revolved { profile }, Vec3::new(0.5, 0.5, 0.37), UPRIGHT);
    let surface = Surface::in_domain(&rod, &domain).unwrap();
    assert_eq!(surface.endless().straight, [false; 3]);
    let whole = Surface::of(&rod.geometry).unwrap();
    let frame = Frame::of(&rod.pose);
    let mut inside = 0;
    for k in 0..3000 {
        let share = |s: f64| (f64::from(k) * s).fract();
        let at = [share(0.754_877_67), share(0.569_840_29), share(0.430_159_71)];
        let (old, new) = (whole.closest(frame.to_part(at)), surface.closest(frame.to_part(at)));
        assert!((old.distance - new.distance).abs() < 1e-9, "{at:?} {old:?} {new:?}");
        inside += u32::from(new.distance < 0.0);
        // A period further it is the same.
        for shift in [-0.6, 0.6] {
            let moved = [at[0], at[1], at[2] + shift];
            let back = [at[0], at[1], moved[2] - moved[2].floor()];
            let [there, here] = [moved, back].map(|x| surface.signed_distance(frame.to_part(x)));
            assert!((there - here).abs() < 1e-9, "{moved:?}: {there} {here}");
        }
    }
    assert!(inside > 400, "{inside}");
    let volume = std::f64::consts::PI * (0.25 * 0.25 + 0.005);
    assert!((surface.volume_and_centroid().0 / volume - 1.0).abs() < 1e-3);
    // It keeps to within half a period of where it was.
    let place = surface.endless().place([0.5, 0.5, 3.27]);
    assert!((place[2] - 0.27).abs() < 1e-12, "{place:?}");
}

/// A lattice of bars along all three axes: nothing leads out of it, and yet inside stays inside.
#[test]
fn a_porous_block_is_endless_along_all_axes() {
    let domain = domain(Vec3::from_element(1.0), [true; 3]);
    let geometry = Geometry::Box { size: [3.0, 0.4, 3.0] };
    let slab = part(geometry, Vec3::new(0.5, 0.5, 0.5), UPRIGHT);
    agrees(&slab, &domain, |x| [-1.0, 0.0, 1.0].map(|k| (x[1] - 0.5 + k).abs() - 0.2)[1], 1e-12);
    let whole = part(Geometry::Sphere { radius: 0.6 }, Vec3::from_element(0.5), UPRIGHT);
    let surface = Surface::in_domain(&whole, &domain).unwrap();
    assert_eq!(surface.endless().axes, [true; 3]);
    for k in 0..2000 {
        let share = |s: f64| (f64::from(k) * s).fract();
        let at = [share(0.754_877_67), share(0.569_840_29), share(0.430_159_71)];
        let from = |c: f64| c - 0.5;
        let distance = at.map(from).iter().map(|d| d * d).sum::<f64>().sqrt() - 0.6;
        if distance.abs() > 2e-4 {
            let seen = Frame::of(&whole.pose).to_part(at);
            assert_eq!(surface.contains(seen), distance < 0.0, "{at:?}");
        }
    }
}

#[test]
fn what_does_not_go_on_is_refused_and_why_is_said() {
    let along_z = domain(Vec3::from_element(1.0), [false, false, true]);
    let cone =
        Geometry::Revolved { profile: vec![[0.0, -1.0], [0.4, -1.0], [0.1, 1.0], [0.0, 1.0]] };
    let cone = part(cone, Vec3::new(0.5, 0.5, 0.5), UPRIGHT);
    let EndlessFault::Section { axis: 2, off, .. } = fault(&cone, &along_z) else { panic!() };
    assert!((off - 0.15).abs() < 1e-3, "the radius changes by 0.15 m in a period: {off}");
    let text = fault(&cone, &along_z).to_string();
    assert!(
        text.contains("periodic z face") && text.contains("0.15") || text.contains("1.5"),
        "{text}"
    );

    // A plate that is turned by a hundredth of a degree does not meet itself.
    let flat = Geometry::Box { size: [9.0, 0.2, 0.5] };
    let along_x = domain(Vec3::from_element(1.0), [true, false, false]);
    let tilted = part(flat.clone(), Vec3::from_element(0.5), (Vec3::new(0.0, 0.0, 1.0), 0.01));
    let EndlessFault::Section { axis: 0, off, .. } = fault(&tilted, &along_x) else { panic!() };
    assert!((off - 1e-2f64.to_radians()).abs() < 1e-6, "{off}");
    assert!(fault(&tilted, &along_x).help().contains("x a wall"));
    // About its own axis it may be turned.
    let rolled = part(flat, Vec3::from_element(0.5), (Vec3::new(1.0, 0.0, 0.0), 30.0));
    assert!(Surface::in_domain(&rolled, &along_x).unwrap().endless().axes[0]);

    let longer = part(Geometry::Box { size: [1.5, 0.2, 0.2] }, Vec3::new(1.2, 0.5, 0.5), UPRIGHT);
    let EndlessFault::Longer { axis: 0, below: false, .. } = fault(&longer, &along_x) else {
        panic!()
    };
    let around = part(Geometry::Box { size: [5.0; 3] }, Vec3::from_element(0.5), UPRIGHT);
    assert!(matches!(
        fault(&around, &domain(Vec3::from_element(1.0), [true; 3])),
        EndlessFault::NoWall { .. }
    ));
}

#[test]
fn an_endless_part_turns_about_its_axis_only() {
    let turning = |geometry: Geometry, axes: [bool; 3], w: Vec3| {
        let domain = domain(Vec3::from_element(1.0), axes);
        let timed = TimedMotion {
            velocity: [3.0; 3],
            angular_velocity: w.into(),
            course: Course::Points(Vec::new()),
        };
        let mut bar = part(geometry, Vec3::from_element(0.5), UPRIGHT);
        bar.motion = Motion::Timed(Box::new(timed));
        let surface = Surface::in_domain(&bar, &domain).unwrap();
        motion_problem("scene.parts[0]", &bar, &surface, &domain).map(|p| p.to_string())
    };
    let bar = Geometry::Box { size: [0.2, 0.3, 4.0] };
    let z = [false, false, true];
    assert_eq!(turning(bar.clone(), z, Vec3::zeros()), None);
    assert_eq!(turning(bar.clone(), z, Vec3::new(0.0, 0.0, 2.0)), None);
    let text = turning(bar, z, Vec3::new(0.0, 0.1, 2.0)).unwrap();
    assert!(text.contains("scene.parts[0].motion") && text.contains("let it turn about z alone"));
    // One that is shorter than the domain may not become longer by turning.
    let paddle = Geometry::Box { size: [0.95, 0.95, 0.1] };
    assert_eq!(turning(paddle.clone(), z, Vec3::new(0.0, 0.0, 1.0)), None);
    assert!(turning(paddle, z, Vec3::new(1.0, 0.0, 0.0)).unwrap().contains("run into itself"));
}
