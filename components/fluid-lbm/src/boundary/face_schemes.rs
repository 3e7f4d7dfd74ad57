//! The list of schemes of open faces: a new one is registered here.

use crate::boundary::convective_outflow::ConvectiveOutflow;
use crate::boundary::face_scheme::{FaceCell, FaceScheme};
use crate::boundary::open_area::OpenAreas;
use crate::boundary::open_boundary::OpenFace;
use crate::domain::boundary_condition::BoundaryCondition;
use crate::domain::parameters::OpenFaces;
use crate::lattice::layout::Layout;
use crate::lattice::populations::Real;
use tremie_messages::scene::{Face, Outflow};

/// An open face before the first step.
pub struct FaceSite<'a> {
    /// Cells and places.
    pub layout: &'a Layout,
    /// The face, `2 axis + side`.
    pub number: usize,
    /// Its cells.
    pub cells: Vec<FaceCell>,
    /// Condition that it prescribes.
    pub condition: Option<&'a BoundaryCondition>,
    /// Open areas of its cells.
    pub areas: &'a OpenAreas,
    /// The scheme of faces that prescribe velocity or pressure.
    pub scheme: OpenFaces,
}

impl FaceSite<'_> {
    /// Cells of the domain along the face's axis.
    pub fn length(&self) -> i32 {
        self.layout.grid.n[self.number / 2]
    }
}

/// The scheme of an open face without a reservoir.
pub fn scheme_of<T: Real>(face: &Face, site: FaceSite) -> Box<dyn FaceScheme<T>> {
    let FaceSite { layout, number, ref cells, condition, areas, scheme } = site;
    let open = OpenFace::new(layout, number, scheme, condition, cells, areas);
    match face {
        Face::Pressure { outflow: Outflow::Absorbing, .. } => {
            Box::new(open.absorbing(site.length()))
        }
        Face::Pressure { outflow: Outflow::Convective, .. } => {
            let length = site.length();
            Box::new(ConvectiveOutflow::new(layout, number, site.cells.clone(), length))
        }
        _ => Box::new(open),
    }
}
