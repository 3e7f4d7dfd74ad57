//! Findings on a reservoir's numbers on the lattice, before it runs.

use crate::boundary::virtual_piston::cylinder::LEAST;
use crate::boundary::virtual_piston::face::{FASTEST, reservoirs_of};
use crate::report::resolution::Resolution;
use tremie_fluid_kit::cells::grid::face_name;
use tremie_messages::Finding;
use tremie_messages::finding::short;
use tremie_messages::scene::{Face, Reservoir, Scene};

/// Relative difference between the area of cells at a face and the piston's that goes unsaid.
const AREA: f64 = 0.01;

/// Of each reservoir: the area that its face has, how fast its piston is, and how long it lasts.
pub fn findings(scene: &Scene, resolution: &Resolution) -> Vec<Finding> {
    let cells = &resolution.reservoir_cells;
    let of = |((axis, side, reservoir), cells): ((usize, usize, &Reservoir), &(_, _, usize))| {
        let name = face_name(axis, side);
        let face = cells.2 as f64 * resolution.cell * resolution.cell;
        let area = area(scene, axis, &name, reservoir, face);
        [Some(area), Some(speed(&name, reservoir, resolution)), life(&name, reservoir)]
    };
    reservoirs_of(scene).zip(cells).flat_map(of).flatten().collect()
}

/// The face's area over the piston's. One that a symmetry plane cuts counts as the whole, if that
/// is nearer.
fn area(scene: &Scene, axis: usize, name: &str, reservoir: &Reservoir, face: f64) -> Finding {
    let cut = |a: &usize| *a != axis && scene.domain.faces[*a].contains(&Face::Symmetry);
    let mirrors = (0..3).filter(cut).count();
    let ratio = (0..=mirrors)
        .map(|k| f64::from(1_u32 << k) * face / reservoir.area)
        .min_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs()))
        .unwrap_or(f64::NAN);
    let why = format!(
        "the cells at the face have {} m2 of the piston's {} m2; the volume is scaled with them, to {} m3, so that the \
         cylinder stays {} m long",
        short(ratio * reservoir.area),
        short(reservoir.area),
        short(ratio * reservoir.volume),
        short(reservoir.length())
    );
    Finding::new(format!("area of the face {name} over its reservoir's piston"), ratio, "1")
        .doubtful_if(
            (ratio - 1.0).abs() > AREA,
            why,
            "give the area of the bore at the face, or a cell that meets it better",
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
