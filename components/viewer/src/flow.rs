//! Drawings from a frame of a volume: cuts along planes, streamlines, surfaces.

use crate::field::Field;
use crate::isosurface::{Isosurface, Level};
use crate::parameters::{Parameters, PlaneSetting};
use crate::patch::Patch;
use crate::scale::Scale;
use crate::streamlines::Streamlines;
use rerun::{RecordingStream, RecordingStreamResult};
use tremie_messages::frame::{SliceHeader, SliceNode};
use tremie_messages::scene::{Domain, Scene};

/// The pictures of one volume.
pub struct Flow {
    /// Planes that are cut, by name.
    patches: Vec<(String, Patch)>,
    streamlines: Option<Streamlines>,
    surfaces: Vec<Isosurface>,
}

fn patch(domain: &Domain, plane: &PlaneSetting) -> Option<Patch> {
    Patch::new(domain, plane.point.map(|x| x.0).into(), plane.normal.into())
}

impl Flow {
    /// Drawings of the volume `name` of `from` that the parameters ask for.
    pub fn new(from: &str, name: &str, scene: &Scene, parameters: &Parameters) -> Self {
        let domain = &scene.domain;
        let planes = parameters.slices.iter().filter(|_| parameters.cuts);
        let named = planes.enumerate().map(|(k, plane)| (format!("plane {}", k + 1), plane));
        let seeds = parameters.seeds.as_ref().and_then(|plane| patch(domain, plane));
        let count = parameters.streamlines_in(scene);
        let speed = parameters.iso_speed.map(|speed| Level::Speed(speed.0));
        let pressure = parameters.iso_pressure.map(|pressure| Level::Pressure(pressure.0));
        let free = parameters.draws_free_surface(scene).then_some(Level::FreeSurface);
        Self {
            patches: named.filter_map(|(k, plane)| Some((k, patch(domain, plane)?))).collect(),
            streamlines: (count > 0)
                .then(|| Streamlines::new(from, name, domain, seeds.as_ref(), count)),
            surfaces: (speed.into_iter().chain(pressure).chain(free))
                .map(|level| Isosurface::new(from, name, level))
                .collect(),
        }
    }

    /// Cuts along the planes, by name.
    pub fn cuts(&self, field: &Field<'_>) -> Vec<(String, SliceHeader, Vec<SliceNode>)> {
        let cut = |(name, patch): &(String, Patch)| {
            let (header, nodes) = patch.sample(field);
            (name.clone(), header, nodes)
        };
        self.patches.iter().map(cut).collect()
    }

    /// Draws streamlines and surfaces of one moment.
    pub fn log(
        &mut self,
        stream: &RecordingStream,
        field: &Field<'_>,
        scale: &Scale,
    ) -> RecordingStreamResult<()> {
        if let Some(streamlines) = &self.streamlines {
            streamlines.log(stream, field, scale)?;
        }
        self.surfaces.iter_mut().try_for_each(|surface| surface.log(stream, field, scale))
    }
}
