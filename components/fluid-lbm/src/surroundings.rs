//! What stands around the fluid: faces of the domain and static solids, and what they prescribe.

use crate::cells::{Fixture, Obstacles};
use crate::course::Law;
use crate::fixed::{self, FixedLinks};
use crate::grid::{Grid, Side};
use crate::layout::Layout;
use crate::open::{self, OpenCells};
use crate::parameters::Parameters;
use crate::places::Reflection;
use crate::resolution::Resolution;
use crate::units::Units;
use tremie_messages::Problem;
use tremie_messages::scene::{Face, Scene};

/// Faces of the domain and static solids.
pub struct Surroundings {
    grid: Grid,
    obstacles: Obstacles,
    /// For each fixture what it prescribes; `None` for a face that prescribes nothing.
    pub laws: Vec<Option<Law>>,
    /// For each fixture the point about which its torque counts [cells].
    pub references: Vec<[f64; 3]>,
}

/// What follows from the surroundings for cells in lines of a given length.
pub struct Built {
    /// Cells and places.
    pub layout: Layout,
    /// Links that need no work.
    pub reflections: Vec<Reflection>,
    /// Links that do.
    pub fixed: FixedLinks,
    /// Their items of work.
    pub fixed_items: Vec<fixed::Item>,
    /// Cells at open faces.
    pub open: OpenCells,
    /// Their items of work.
    pub open_items: Vec<open::Item>,
}

/// What faces are to the box of cells.
pub fn sides(scene: &Scene) -> [[Side; 2]; 3] {
    scene.domain.faces.each_ref().map(|faces| {
        faces.each_ref().map(|face| match face {
            Face::Periodic => Side::Periodic,
            Face::Wall { .. } => Side::Wall,
            Face::Symmetry => Side::Symmetry,
            Face::Velocity(_) | Face::Pressure { .. } => Side::Open,
        })
    })
}

impl Surroundings {
    /// Of a scene.
    ///
    /// # Errors
    /// Every problem of the geometry.
    pub fn new(
        scene: &Scene,
        _parameters: &Parameters,
        resolution: &Resolution,
        units: &Units,
    ) -> Result<Self, Vec<Problem>> {
        let grid = Grid::new(resolution.cells, sides(scene));
        let laws: Vec<_> =
            scene.domain.faces.iter().flatten().map(|face| Law::of_face(face, units)).collect();
        let references = vec![[0.0; 3]; laws.len()];
        Ok(Self { grid, obstacles: Obstacles::default(), laws, references })
    }

    /// Whether a fixture's links need work besides reflection half-way.
    fn is_special(&self, fixture: Fixture) -> bool {
        match fixture.as_solid() {
            Some(_) => true,
            None => !matches!(
                self.laws[usize::from(fixture.0)],
                None | Some(Law::Wall([0.0, 0.0, 0.0]))
            ),
        }
    }

    /// Lays out the cells in lines of `line`.
    pub fn build(&self, line: usize) -> Built {
        let special = |fixture| self.is_special(fixture);
        let (layout, survey) = Layout::new(self.grid.clone(), &self.obstacles, line, special);
        let is_open = |fixture: Fixture| {
            fixture.as_solid().is_none()
                && !matches!(self.laws[usize::from(fixture.0)], Some(Law::Wall(_)))
        };
        let (open, fixed): (Vec<_>, Vec<_>) =
            survey.blocked.into_iter().partition(|blocked| is_open(blocked.fixture));
        let (open, open_items) = OpenCells::new(&layout, &self.laws, &open);
        let (fixed, fixed_items) = FixedLinks::new(fixed.into_iter().map(|blocked| (blocked, 0.5)));
        Built { layout, reflections: survey.reflections, fixed, fixed_items, open, open_items }
    }
}
