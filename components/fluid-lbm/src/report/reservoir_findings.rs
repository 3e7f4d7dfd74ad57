//! Findings on a reservoir's numbers on the lattice, before it runs.

use crate::boundary::virtual_piston::cylinder::{FASTEST, LEAST};
use crate::boundary::virtual_piston::part_surface::parts_of_area;
use crate::boundary::virtual_piston::reservoir_state::reservoirs_of;
use crate::lattice::reservoir_place::ReservoirPlace;
use crate::report::resolution::Resolution;
use tremie_messages::Finding;
use tremie_messages::finding::short;
use tremie_messages::scene::{Face, Reservoir, Scene};

/// Relative difference between the area of cells at a face and the piston's that goes unsaid.
const AREA: f64 = 0.01;

/// Such a difference of the side of a part: links at its edges end at the walls beside it.
const AREA_OF_PART: f64 = 0.1;

/// Of each reservoir: the area that its face has, how fast its piston is, and how long it lasts.
pub fn findings(scene: &Scene, resolution: &Resolution) -> Vec<Finding> {
    let of = |((place, reservoir), cells): ((ReservoirPlace, &Reservoir), &f64)| {
        let name = place.name(scene);
        let face = cells * resolution.cell * resolution.cell;
        let area = area(scene, place, &name, reservoir, face);
        [Some(area), Some(speed(&name, reservoir, resolution)), life(&name, reservoir)]
    };
    reservoirs_of(scene).zip(&resolution.reservoir_areas).flat_map(of).flatten().collect()
}

/// The area of a face or surface over the piston's. One that a symmetry plane cuts counts as the whole,
/// if that is nearer.
fn area(
    scene: &Scene,
    place: ReservoirPlace,
    name: &str,
    reservoir: &Reservoir,
    found: f64,
) -> Finding {
    let is_across = |a: usize| matches!(place, ReservoirPlace::Face { axis, .. } if axis == a);
    let cut = |a: &usize| !is_across(*a) && scene.domain.faces[*a].contains(&Face::Symmetry);
    let mirrors = (0..3).filter(cut).count();
    let ratio = parts_of_area(reservoir.area, found, mirrors) * found / reservoir.area;
    let (area, whole) = (short(ratio * reservoir.area), short(reservoir.area));
    let (volume, length) = (short(ratio * reservoir.volume), short(reservoir.length()));
    let (what, most, why) = match place {
        ReservoirPlace::Face { .. } => (
            "face",
            AREA,
            format!(
                "the cells at the face have {area} m2 of the piston's {whole} m2; the volume is scaled with them, to \
                 {volume} m3, so that the cylinder stays {length} m long"
            ),
        ),
        ReservoirPlace::Part(_) => (
            "surface",
            AREA_OF_PART,
            format!(
                "the links that end at the part have {area} m2 of the piston's {whole} m2; what flows is the piston's \
                 area times its velocity, so the fluid is as much faster at the surface"
            ),
        ),
    };
    Finding::new(format!("area of the {what} {name} over its reservoir's piston"), ratio, "1")
        .doubtful_if(
            (ratio - 1.0).abs() > most,
            why,
            "give the area of the bore there, or a cell that meets it better",
        )
}

/// The piston's speed on the lattice, which a steady flow has at the face.
fn speed(name: &str, reservoir: &Reservoir, resolution: &Resolution) -> Finding {
    let piston = reservoir.piston.abs();
    let cells = piston * resolution.time_step / resolution.cell;
    let step = 0.5 * FASTEST * resolution.cell / piston;
    Finding::new(format!("cells that the piston of {name} moves in a step"), cells, "1").wrong_if(
        cells > FASTEST,
        format!("above {FASTEST} a run ends: the flow at the face is too fast for the lattice"),
        format!("a time step of {} s makes it {}", short(step), 0.5 * FASTEST),
    )
}

/// The time in which a piston that never slows down would empty the reservoir.
fn life(name: &str, reservoir: &Reservoir) -> Option<Finding> {
    let time = (1.0 - LEAST) * reservoir.length() / reservoir.piston;
    let why =
        "at the piston's full velocity, to the last twentieth of its volume, where a run ends";
    let quantity = format!("life of the reservoir {name}");
    (reservoir.piston > 0.0).then(|| Finding::new(quantity, time, "s").because(why))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::parameters::Parameters;
    use tremie_messages::Verdict;
    use tremie_messages::scene::{Domain, FluidMaterial};

    fn scene(area: f64, side: Face) -> Scene {
        let mut domain = Domain::new([0.0; 3], [4.0, 5.0, 6.0], Face::WALLS);
        domain.faces[2][0] = Face::Reservoir(Reservoir::new(area, 10.0 * area, 2.0));
        domain.faces[0][0] = side;
        Scene { fluid: Some(FluidMaterial::at_rest(1.0, 0.1)), ..Scene::empty(domain) }
    }

    fn of(scene: &Scene) -> Vec<Finding> {
        let parameters = Parameters::with_cell(1.0);
        findings(scene, &parameters.resolve(scene).unwrap())
    }

    #[test]
    fn areas_that_differ_are_doubtful() {
        let [area, speed, life] = &of(&scene(20.1, Face::WALL))[..] else { panic!() };
        assert_eq!(speed.verdict, Verdict::Wrong, "{speed:?}");
        assert!(area.verdict == Verdict::Ok && (area.value - 20.0 / 20.1).abs() < 1e-12);
        assert!((life.value - 4.75).abs() < 1e-12, "{life:?}");
        let [area, ..] = &of(&scene(22.0, Face::WALL))[..] else { panic!() };
        assert_eq!(area.verdict, Verdict::Doubtful);
        assert!(area.why.contains("20 m2 of the piston's 22 m2"), "{area:?}");
    }

    /// Half a model may give the area of the whole bore or its own.
    #[test]
    fn half_a_model_counts_as_the_whole() {
        for whole in [20.0, 40.0] {
            assert_eq!(of(&scene(whole, Face::Symmetry))[0].verdict, Verdict::Ok);
        }
        assert_eq!(of(&scene(30.0, Face::Symmetry))[0].verdict, Verdict::Doubtful);
    }
}
