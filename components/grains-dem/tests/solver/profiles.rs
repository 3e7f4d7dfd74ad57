//! Profiles against lattices whose stress and contacts are known, and against themselves.

use crate::common::{walls::part, *};
use tremie_grains_dem::{AddedSphere, GrainsDem, Parameters};
use tremie_messages::frame::{ProfileBin, ProfileHeader};
use tremie_messages::scene::{
    BinnedAxis, Damping, Geometry, GrainProfile, Motion, ProfileVelocity, Scene, Sphere,
};

const D: f64 = 2e-3;
const STIFF: f64 = 1e4;
const G: f64 = 9.81;
const STEP: f64 = 1e-6;

/// A profile over the whole domain, one table of all windows.
fn profile(name: &str, axes: &[(usize, usize)], scene: &Scene) -> GrainProfile {
    GrainProfile {
        name: name.into(),
        axes: axes.iter().map(|&(axis, bins)| BinnedAxis { axis, bins }).collect(),
        min: scene.domain.min,
        max: scene.domain.max,
        from: 0.0,
        every: None,
        average: None,
        velocity: ProfileVelocity::Instantaneous,
    }
}

fn measured(scene: &Scene, threads: usize, substeps: u32) -> GrainsDem {
    let mut dem = GrainsDem::new(scene, &Parameters::default(), STEP, threads).unwrap();
    dem.measure_profiles(scene, f64::from(substeps) * STEP);
    dem
}

fn table(scene: &Scene, dem: &GrainsDem, name: &str) -> (ProfileHeader, Vec<ProfileBin>) {
    let profile = scene.profiles.iter().find(|profile| profile.name == name).unwrap();
    let mut bins = vec![ProfileBin::default(); profile.bins()];
    let header = dem.profile(name, &mut bins);
    (header, bins)
}

/// Heights of the centres of a column of so many spheres at rest on a floor, from below, and the
/// overlap of each with what is below it.
fn at_rest(floor: f64, layers: usize) -> Vec<(f64, f64)> {
    let weight = mass(D) * G;
    let mut top = floor;
    let of_layer = |k: usize| {
        let overlap = (layers - k) as f64 * weight / STIFF;
        let centre = top - overlap + 0.5 * D;
        top = centre + 0.5 * D;
        (centre, overlap)
    };
    (0..layers).map(of_layer).collect()
}

/// A cubic lattice at rest between periodic sides that press it together.
fn lattice(squeeze: f64) -> (Scene, Vec<(f64, f64)>) {
    let (across, layers) = (4, 5);
    let pitch = D - squeeze;
    let side = across as f64 * pitch;
    let mut scene = scene([side, side, 6.0 * D], FLOOR, law(STIFF, 0.0, coefficients(0.0, 0.0)));
    scene.gravity = [0.0, 0.0, -G];
    let layers = at_rest(0.0, layers);
    let places = layers.iter().flat_map(|&(z, _)| {
        (0..across * across).map(move |k| {
            let at = |n: usize| (n as f64 + 0.5) * pitch;
            [at(k % across), at(k / across), z]
        })
    });
    let spheres: Vec<Sphere> = places.map(|x| sphere(x, D, [0.0; 3])).collect();
    scene.bodies = vec![set(Motion::Free, spheres)];
    (scene, layers)
}

/// Weight above: the stress of a layer is that in its middle, exactly, for it bears half of its own
/// weight there; the sides press with the force of the springs between neighbours.
#[test]
fn a_cubic_lattice_bears_its_weight_and_touches_six() {
    let squeeze = 1e-3 * D;
    let (mut scene, layers) = lattice(squeeze);
    let height = 5.0 * D;
    let mut bins = profile("height", &[(2, 5)], &scene);
    bins.max[2] = height;
    scene.profiles = vec![bins];
    let substeps = 4;
    let mut dem = measured(&scene, 1, substeps);
    for _ in 0..3 {
        dem.advance(substeps, &[]).unwrap();
    }
    let (header, bins) = table(&scene, &dem, "height");
    assert_eq!(header.samples, 3);
    let pitch = D - squeeze;
    let cell = pitch * pitch * D;
    for (k, bin) in bins.iter().enumerate() {
        assert_eq!(bin.grains, 16.0);
        assert!(
            (bin.solid_fraction * cell / (std::f64::consts::PI / 6.0 * D.powi(3)) - 1.0).abs()
                < 1e-12
        );
        assert_eq!(bin.coordination, if k < 4 { 6.0 } else { 5.0 });
        // Forces below and above at the arms of both contacts.
        let weight = mass(D) * G;
        let below = (5 - k) as f64 * weight;
        let above = (4 - k) as f64 * weight;
        let overlap_above = layers.get(k + 1).map_or(0.0, |layer| layer.1);
        let exact = (below * (0.5 * D - 0.5 * layers[k].1)
            + above * (0.5 * D - 0.5 * overlap_above))
            / cell;
        let [xx, yy, zz, yz, zx, xy] = bin.contact_stress;
        assert!((zz / exact - 1.0).abs() < 1e-6, "layer {k}: {zz} {exact}");
        // Hydrostatic: mean density times depth of the middle, as far as overlaps are small.
        let hydrostatic = mass(D) / cell * G * (4.5 - k as f64) * D;
        assert!((zz / hydrostatic - 1.0).abs() < 5e-5, "layer {k}: {zz} {hydrostatic}");
        let sides = STIFF * squeeze * pitch / cell;
        assert!((xx / sides - 1.0).abs() < 1e-9 && (yy / sides - 1.0).abs() < 1e-9, "{xx} {sides}");
        assert!([yz, zx, xy].iter().all(|shear| shear.abs() < 1e-9 * sides), "{yz} {zx} {xy}");
        assert!(bin.kinetic_stress[2] < 1e-9 * exact && bin.temperature < 1e-12);
    }
}

/// A column on a part, on a face of the domain, and on spheres that are held: the same stress, the
/// same number of contacts.
#[test]
fn parts_walls_and_spheres_at_rest_bear_alike() {
    let on = |what: &str| {
        let mut scene = scene([5.0 * D; 3], WALLS, law(STIFF, 0.0, coefficients(0.0, 0.0)));
        scene.gravity = [0.0, 0.0, -G];
        let floor = if what == "wall" { 0.0 } else { D };
        if what == "part" {
            let slab = Geometry::Box { size: [4.0 * D, 4.0 * D, D] };
            scene.parts = vec![part(slab, [2.5 * D, 2.5 * D, 0.5 * D])];
        }
        let at = |z: f64| sphere([2.5 * D, 2.5 * D, z], D, [0.0; 3]);
        let column = at_rest(floor, 3).into_iter().map(|(z, _)| at(z)).collect();
        scene.bodies = vec![set(Motion::Free, column)];
        if what == "sphere" {
            scene.bodies.push(set(Motion::Fixed, vec![at(0.5 * D)]));
        }
        let mut bins = profile("column", &[(2, 3)], &scene);
        (bins.min[2], bins.max[2]) = (floor, floor + 3.0 * D);
        scene.profiles = vec![bins];
        let mut dem = measured(&scene, 1, 2);
        dem.advance(2, &[]).unwrap();
        assert!(dem.has_profile("column", true) && !dem.has_profile("column", false));
        table(&scene, &dem, "column").1
    };
    let (wall, part, sphere) = (on("wall"), on("part"), on("sphere"));
    let weight = mass(D) * G;
    let lowest = weight * 2.5 * D / (25.0 * D * D * D);
    assert!((wall[0].contact_stress[2] / lowest - 1.0).abs() < 5e-5);
    for k in 0..3 {
        for other in [&part, &sphere] {
            assert_eq!(other[k].coordination, wall[k].coordination);
            assert_eq!(other[k].grains, 1.0, "what is held does not count");
            let (a, b) = (other[k].contact_stress[2], wall[k].contact_stress[2]);
            assert!((a / b - 1.0).abs() < 1e-6, "{k}: {a} {b}");
        }
    }
    assert_eq!(wall.iter().map(|bin| bin.coordination).collect::<Vec<_>>(), [2.0, 2.0, 1.0]);
}

/// A shower over a turning floor: same tables on any number of threads, and whoever else measures.
#[test]
fn tables_have_the_same_bits_on_any_number_of_threads() {
    let mut scene = scene([14e-3, 14e-3, 30e-3], FLOOR, law(1e3, 0.5, Damping::Restitution(0.6)));
    scene.gravity = [10.0, 3.0, -100.0];
    scene.bodies = vec![packed([0.0; 3], [14e-3, 14e-3, 6e-3], 0.4, (0.7e-3, 0.9e-3), 2)];
    let slab = Geometry::Box { size: [4e-3, 3e-3, 1e-3] };
    scene.parts = vec![part(slab, [7e-3, 7e-3, 1e-3])];
    let plane = profile("plane", &[(0, 5), (2, 7)], &scene);
    let seen = GrainProfile {
        every: Some(3.0 * 150.0 * STEP),
        velocity: ProfileVelocity::Displacement,
        ..profile("seen", &[(2, 9)], &scene)
    };
    let run = |profiles: &[&GrainProfile], threads| {
        let mut scene = scene.clone();
        scene.profiles = profiles.iter().map(|&profile| profile.clone()).collect();
        let mut dem = measured(&scene, threads, 150);
        for _ in 0..60 {
            dem.advance(150, &[]).unwrap();
        }
        assert!(dem.body_count() > 1024 && dem.diagnostics().list_rebuilds > 1);
        profiles.iter().map(|profile| table(&scene, &dem, &profile.name)).collect::<Vec<_>>()
    };
    let bits = |tables: &[(ProfileHeader, Vec<ProfileBin>)]| -> Vec<u64> {
        let values = tables.iter().flat_map(|(_, bins)| bins).flat_map(ProfileBin::values);
        values.map(f64::to_bits).collect()
    };
    let one = run(&[&plane, &seen], 1);
    assert_eq!(bits(&one), bits(&run(&[&plane, &seen], 4)));
    assert_eq!(bits(&one[1..]), bits(&run(&[&seen], 2)));
    let (header, bins) = &one[0];
    assert_eq!(header.samples, 60);
    let grains: f64 = bins.iter().map(|bin| bin.grains).sum();
    assert!(grains > 1024.0 - 1e-6, "all lie in the box: {grains}");
    assert!(bins.iter().any(|bin| bin.coordination > 1.0 && bin.contact_stress[2] > 0.0));
    assert_eq!(one[1].0.samples, 20);
}

/// A camera that looks at falling grains sees the mean velocity between two pictures.
#[test]
fn displacements_give_the_mean_velocity_between_samples() {
    let (windows, substeps) = (12u32, 50);
    let mut scene = scene([10e-3; 3], PERIODIC, law(STIFF, 0.0, Damping::Restitution(1.0)));
    scene.gravity = [0.0, 0.0, -G];
    let fast = sphere([2e-3, 5e-3, 1e-3], D, [40.0, 0.0, -2.0]);
    scene.bodies = vec![set(Motion::Free, vec![fast])];
    let window = f64::from(substeps) * STEP;
    scene.profiles = vec![GrainProfile {
        every: Some(2.0 * window),
        average: Some(2.0 * window),
        velocity: ProfileVelocity::Displacement,
        ..profile("camera", &[(1, 1)], &scene)
    }];
    let mut dem = measured(&scene, 1, substeps);
    for k in 1..=windows {
        dem.advance(substeps, &[]).unwrap();
        assert_eq!(dem.has_profile("camera", false), k % 2 == 0);
        if k % 2 == 0 {
            let (header, bins) = table(&scene, &dem, "camera");
            // Around the box many times: 4 mm between samples, less than half of it.
            let middle = 0.5 * (header.begin + header.end);
            assert!((bins[0].velocity[0] - 40.0).abs() < 1e-9, "{:?}", bins[0].velocity);
            assert!((bins[0].velocity[2] + 2.0 + G * middle).abs() < 1e-9);
        }
    }
}

/// Spheres that come count from the window after on; tables go on when bodies are listed anew.
#[test]
fn grains_that_come_and_go_are_counted_while_they_are_there() {
    let mut scene = scene([20e-3; 3], PERIODIC, law(STIFF, 0.0, Damping::Restitution(1.0)));
    let at = |x: f64| sphere([x, 5e-3, 5e-3], D, [0.0; 3]);
    scene.bodies = vec![set(Motion::Free, vec![at(2e-3), at(8e-3)])];
    scene.profiles = vec![profile("all", &[(0, 1)], &scene)];
    let mut dem = measured(&scene, 1, 1);
    dem.advance(1, &[]).unwrap();
    let added = |x: f64| AddedSphere {
        set: 0,
        position: [x, 5e-3, 5e-3],
        diameter: D,
        velocity: [3.0, 0.0, 0.0],
    };
    dem.exchange(&[0], &[added(12e-3), added(16e-3)]).unwrap();
    dem.advance(1, &[]).unwrap();
    let (header, bins) = table(&scene, &dem, "all");
    assert_eq!((header.samples, bins[0].grains), (2, 2.5));
    assert!((bins[0].velocity[0] - 6.0 / 5.0).abs() < 1e-12);
}
