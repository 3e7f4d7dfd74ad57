//! Space of grains: they start in the fluid, and get to where they leave.

use crate::cells::centres::Centres;
use crate::survey::leak::narrowest;
use crate::survey::static_geometry::StaticGeometry;
use crate::survey::voxels::unreached;
use serde::{Deserialize, Serialize};
use tremie_messages::Finding;
use tremie_messages::finding::short;
use tremie_messages::scene::{BodySet, Motion, Placement, Scene};

/// Part of a region without fluid from which on somebody should look: a rim of cells at a wall is
/// less.
const DRY: f64 = 0.01;

/// A region in which grains start or come, with space in it to which no fluid gets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DryRegion {
    /// Name of the set or inlet.
    pub name: String,
    /// The part of the region's free cells that no fluid reaches.
    pub share: f64,
}

/// The narrowest place on the widest way that grains have from where they start to where they
/// leave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Throat {
    /// Its width between what stands still, give or take [`Throat::SLACK`] cells [m].
    pub width: f64,
    /// Its place [m].
    pub place: [f64; 3],
    /// Diameter of the largest sphere [m].
    pub largest: f64,
    /// Edge of a cell [m].
    pub cell: f64,
}

/// Regions in which grains start or come: name and corners.
fn regions(scene: &Scene) -> Vec<(&str, [[f64; 3]; 2])> {
    let packed = scene.bodies.iter().filter_map(|set| match &set.placement {
        Placement::Packed(packing) => Some((set.name.as_str(), [packing.min, packing.max])),
        Placement::Listed(_) | Placement::Polyhedra(_) => None,
    });
    let inlets = scene.inlets.iter().map(|inlet| (inlet.name.as_str(), [inlet.min, inlet.max]));
    packed.chain(inlets).collect()
}

/// Cells whose centres lie in a box, by index.
fn cells_in(ground: &StaticGeometry, [min, max]: [[f64; 3]; 2]) -> impl Iterator<Item = usize> {
    let Centres { cell, min: origin } = ground.centres();
    let (grid, n) = (&ground.grid, ground.grid.n);
    let range = move |a: usize| {
        let first = ((min[a] - origin[a]) / cell - 0.5).ceil().clamp(0.0, f64::from(n[a]));
        let end = ((max[a] - origin[a]) / cell - 0.5).floor() + 1.0;
        first as i32..end.clamp(first, f64::from(n[a])) as i32
    };
    range(2)
        .flat_map(move |z| range(1).flat_map(move |y| range(0).map(move |x| grid.index([x, y, z]))))
}

/// Regions with more than a trace of space that no fluid reaches.
pub fn dry_regions(scene: &Scene, ground: &StaticGeometry) -> Vec<DryRegion> {
    let (solid, no_way) = (&ground.voxels.obstacles.solid, unreached(&ground.solids) + 1);
    let share = |corners| {
        let (mut wet, mut dry) = (0_usize, 0_usize);
        for cell in cells_in(ground, corners) {
            wet += usize::from(solid[cell] == 0);
            dry += usize::from(solid[cell] == no_way);
        }
        dry as f64 / (wet + dry).max(1) as f64
    };
    let all = regions(scene).into_iter();
    all.map(|(name, corners)| DryRegion { name: name.into(), share: share(corners) })
        .filter(|region| region.share > DRY)
        .collect()
}

/// The throat between regions in which grains start and the outlets, if grains leave at all.
pub fn throat(scene: &Scene, ground: &StaticGeometry) -> Option<Throat> {
    let largest = largest_diameter(scene).filter(|_| !scene.outlets.is_empty())?;
    let centres = ground.centres();
    let solid = &ground.voxels.obstacles.solid;
    let from: Vec<usize> =
        regions(scene).into_iter().flat_map(|(_, corners)| cells_in(ground, corners)).collect();
    let leaves = |k: &usize| {
        solid[*k] == 0 && scene.outlets.iter().any(|o| o.holds(centres.of(ground.grid.at(*k))))
    };
    let to: Vec<usize> = (0..ground.grid.len()).filter(leaves).collect();
    let found = narrowest(&ground.grid, ground.voxels.links, &ground.voxels.obstacles, &from, &to)?;
    let (width, place) = (found.width * centres.cell, centres.of(found.at));
    Some(Throat { width, place, largest, cell: centres.cell })
}

/// Of the spheres that are packed or come.
fn largest_diameter(scene: &Scene) -> Option<f64> {
    let of_set = |set: &BodySet| match &set.placement {
        Placement::Packed(packing) if set.motion == Motion::Free => {
            Some(packing.diameters.extremes()[1])
        }
        _ => None,
    };
    let packed = scene.bodies.iter().filter_map(of_set);
    packed.chain(scene.inlets.iter().map(|inlet| inlet.diameters.extremes()[1])).reduce(f64::max)
}

impl DryRegion {
    /// With a verdict.
    pub fn finding(&self) -> Finding {
        let why = "no fluid reaches that part of the region: grains there are dry, and feel neither drag nor buoyancy";
        Finding::new(format!("dry share of the region of {}", self.name), self.share, "1")
            .doubtful_if(true, why, "move the region into the fluid; or name a point of that space in scene.fluid.inside, if it should be fluid")
    }
}

impl Throat {
    /// Cells by which a width that is counted in cells may be too small: their middle may be
    /// between two, and a wall takes the cells whose centres it touches.
    pub const SLACK: f64 = 2.0;

    /// With a verdict.
    pub fn finding(&self) -> Finding {
        let Self { width, place: [x, y, z], largest, cell } = *self;
        let [x, y, z] = [x, y, z].map(short);
        let place = format!(
            "{} m wide, give or take {} cells, at ({x}, {y}, {z}) m, on the widest way to an outlet past all that stands still",
            short(width),
            Self::SLACK
        );
        Finding::new("narrowest passage over the largest grain", width / largest, "1")
            .because(&place)
            .doubtful_if(
                width + Self::SLACK * cell < largest,
                format!("{place}: no grain of {} m gets through", short(largest)),
                format!("grains of less than {} m, or a wider passage", short(width)),
            )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tremie_messages::Verdict;
    use tremie_messages::scene::{
        Diameters, Domain, Face, FluidMaterial, Geometry, Outlet, Packing, Part, PartBoundary, Pose,
    };

    /// A box of 40 x 20 x 20 with a wall across x = 20 and a slot of `slot` in its middle, or none.
    fn scene(slot: f64, inside: Vec<[f64; 3]>) -> Scene {
        let wall = |name: &str, size: [f64; 3], position: [f64; 3]| Part {
            name: name.into(),
            geometry: Geometry::Box { size },
            pose: Pose { position, ..Pose::IDENTITY },
            cavity: false,
            material: "steel".into(),
            motion: Motion::Fixed,
            boundary: PartBoundary::Wall,
        };
        let half = 0.5 * (20.0 - slot);
        let lower = wall("lower", [4.0, 40.0, 2.0 * half], [20.0, 10.0, 0.0]);
        let upper = wall("upper", [4.0, 40.0, 2.0 * half], [20.0, 10.0, 20.0]);
        let packing = Packing {
            min: [2.0, 0.0, 0.0],
            max: [38.0, 20.0, 20.0],
            fraction: 0.1,
            diameters: Diameters::Uniform { min: 2.0, max: 7.0 },
            seed: 1,
        };
        Scene {
            fluid: Some(FluidMaterial { inside, ..FluidMaterial::at_rest(1000.0, 1e-3) }),
            parts: vec![lower, upper],
            bodies: vec![BodySet {
                name: "sand".into(),
                density: 2000.0,
                material: "sand".into(),
                motion: Motion::Free,
                clump: None,
                placement: Placement::Packed(packing),
            }],
            ..Scene::empty(Domain::new([0.0; 3], [40.0, 20.0, 20.0], Face::WALLS))
        }
    }

    fn ground(scene: &Scene) -> StaticGeometry {
        StaticGeometry::in_unit_cells(scene)
    }

    #[test]
    fn space_that_no_fluid_reaches_is_told() {
        let whole = scene(0.0, Vec::new());
        assert_eq!(dry_regions(&whole, &ground(&whole)), []);
        let half = scene(0.0, vec![[5.0, 5.0, 5.0]]);
        let found = dry_regions(&half, &ground(&half));
        assert_eq!((found.len(), found[0].name.as_str()), (1, "sand"));
        assert!((found[0].share - 0.5).abs() < 1e-9, "{found:?}");
        assert_eq!(found[0].finding().verdict, Verdict::Doubtful);
    }

    #[test]
    fn a_slot_that_grains_do_not_pass_is_told() {
        for (slot, verdict) in [(4.0, Verdict::Doubtful), (10.0, Verdict::Ok)] {
            let mut scene = scene(slot, Vec::new());
            assert!(throat(&scene, &ground(&scene)).is_none(), "nobody leaves");
            scene.outlets = vec![Outlet { name: "drain".into(), axis: 0, at: 39.0, side: 1 }];
            let Placement::Packed(packing) = &mut scene.bodies[0].placement else { unreachable!() };
            packing.max[0] = 10.0;
            let found = throat(&scene, &ground(&scene)).unwrap();
            assert!((found.width - slot).abs() <= 1.0, "{found:?}");
            assert!((found.place[0] - 20.0).abs() < 3.0 && found.largest == 7.0, "{found:?}");
            assert_eq!(found.finding().verdict, verdict, "{found:?}");
        }
    }
}
