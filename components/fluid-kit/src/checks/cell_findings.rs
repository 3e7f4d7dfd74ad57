//! Verdicts on what is how many cells across.

use crate::checks::gap_width_check::Narrow;
use crate::checks::part_extent::PartExtent;
use tremie_messages::Finding;
use tremie_messages::finding::short;
use tremie_messages::scene::FluidMaterial;

/// Cells across a sphere from which its drag is trusted to a few per cent.
const RESOLVED: f64 = 8.0;
/// Cells across a sphere below which it may cover no cell at all.
const UNSEEN: f64 = 2.0;
/// Cells in the boundary layer of a sphere, D/√Re thick, below which the layer is not resolved.
const LAYER: f64 = 1.0;
/// Cells across a gap from which the flow through it is trusted.
const WIDE: f64 = 4.0;
/// Cells across a gap below which it may hold no cell.
const SHUT: f64 = 1.0;

/// Judges what is resolved by cells of an edge.
#[derive(Clone, Copy, Debug)]
pub struct CellFindings {
    /// Edge of a cell [m].
    pub cell: f64,
}

impl CellFindings {
    /// Judges the cells across what the fluid goes around. `meaning` says what the number is,
    /// `what` begins the reasons.
    fn across(&self, quantity: &str, cells: f64, [meaning, what]: [&str; 2]) -> Finding {
        let width = cells * self.cell;
        let remedy = format!("a cell of {} m makes it {RESOLVED}", short(width / RESOLVED));
        Finding::new(quantity, cells, "1")
            .because(meaning)
            .wrong_if(
                cells < UNSEEN,
                format!("{what}below {UNSEEN} it may cover no cell at all and feel no fluid"),
                &remedy,
            )
            .doubtful_if(
                cells < RESOLVED,
                format!("{what}its drag is trusted to a few per cent from {RESOLVED} on"),
                remedy,
            )
    }

    /// Cells across the smallest sphere.
    pub fn sphere(&self, cells: f64) -> Finding {
        self.across("cells across the smallest sphere", cells, ["", ""])
    }

    /// A flake has the volume of a sphere that is many cells across, and none itself.
    pub fn polyhedron(&self, cells: f64) -> Finding {
        let said = ["its least width between two planes", "its least width; "];
        self.across("cells across the thinnest polyhedron", cells, said)
    }

    /// A part that is slim two ways is judged as a sphere of that diameter; a plate has to be seen
    /// at all.
    pub fn part(&self, part: &PartExtent) -> Vec<Finding> {
        let cell = self.cell;
        let across = part.across.map(|cells| {
            let said = ["where the fluid goes around it", ""];
            self.across(&format!("cells across {}", part.part), cells, said)
        });
        // A part that the lattice does not see is told already.
        let is_seen = part.across.is_none_or(|cells| cells >= UNSEEN);
        let through = (is_seen && part.through < SHUT).then(|| {
            let remedy = format!("a cell of {} m makes it {SHUT}", short(part.through * cell / SHUT));
            Finding::new(format!("cells through {}", part.part), part.through, "1").doubtful_if(
                true,
                format!("its thickness; below {SHUT} no cell of it is sure to be covered, and one that moves may let fluid through"),
                remedy,
            )
        });
        across.into_iter().chain(through).collect()
    }

    /// A low relaxation time is a large Reynolds number of a cell: with few cells across, the layer
    /// in which a sphere's drag is made is thinner than one.
    pub fn layer(&self, cells: f64, fluid: &FluidMaterial) -> Option<Finding> {
        let speed = fluid.expected_speed.filter(|speed| *speed > 0.0)?;
        let nu = fluid.viscosity / fluid.density;
        let diameter = cells * self.cell;
        let re = speed * diameter / nu;
        let layer = cells / re.sqrt();
        let finding =
            Finding::new("cells in the boundary layer of the smallest sphere", layer, "1");
        let at = format!(
            "D over the root of its Reynolds number, {} if it met the expected speed",
            short(re)
        );
        Some(finding.because(&at).doubtful_if(
            layer < LAYER,
            format!("{at}; below {LAYER} the layer that makes its drag is thinner than a cell"),
            format!("a cell of {} m makes it {LAYER}; where spheres go along with the fluid this matters less", short(diameter / re.sqrt() / LAYER)),
        ))
    }

    /// The narrowest gap between parts and walls.
    pub fn gap(&self, gap: &Narrow) -> Finding {
        let remedy = format!(
            "a cell of {} m makes it {WIDE}; or close it in the geometry, if nothing should flow there",
            short(gap.cells * self.cell / WIDE)
        );
        Finding::new("cells across the narrowest gap", gap.cells, "1")
            .because(place_of(gap))
            .doubtful_if(
                gap.cells < SHUT,
                format!(
                    "{}; below {SHUT} it may hold no cell: nothing flows there, and gap_pressure says what presses",
                    place_of(gap)
                ),
                &remedy,
            )
            .doubtful_if(
                gap.cells < WIDE,
                format!("{}; the flow through it is trusted from {WIDE} on", place_of(gap)),
                remedy,
            )
    }

    /// The narrowest gap of a body at the start.
    pub fn film(&self, gap: &Narrow) -> Finding {
        Finding::new("cells across the narrowest gap of a body", gap.cells, "1")
            .because(format!("at the start, {}", place_of(gap)))
            .doubtful_if(
                gap.cells < SHUT,
                format!(
                    "at the start, {}; below {SHUT} no cell resolves the film between",
                    place_of(gap)
                ),
                format!(
                    "a cell of {} m makes it {SHUT}; or give the contact lubrication",
                    short(gap.cells * self.cell / SHUT)
                ),
            )
    }
}

/// Place of a gap, in words.
fn place_of(gap: &Narrow) -> String {
    let [x, y, z] = gap.place.map(short);
    let [one, other] = &gap.between;
    format!("between {one} and {other} at ({x}, {y}, {z}) m")
}
