//! A cut coloured by a quantity other than speed, in a view of its own with its legend.

use crate::cut::{Shape, node_colour};
use crate::legend::Legend;
use crate::quantity::CutQuantity;
use crate::scale::{Map, Scale};
use crate::session::REPEAT;
use crate::view::part;
use rerun::{Mesh3D, RecordingStream, RecordingStreamResult};
use tremie_messages::frame::{SliceHeader, SliceNode};
use tremie_messages::scene::Domain;

/// A cut as one quantity shows it.
pub struct Shade {
    /// The quantity.
    pub quantity: CutQuantity,
    /// Entity of the mesh.
    pub path: String,
    /// Its legend.
    pub legend: Legend,
    scale: Scale,
    age: u32,
}

impl Shade {
    /// Draws shape and legend.
    pub fn open(
        stream: &RecordingStream,
        (from, name): (&str, &str),
        quantity: CutQuantity,
        header: &SliceHeader,
        domain: &Domain,
    ) -> RecordingStreamResult<Self> {
        let place = format!("{}/{}/{}", part(from), part(name), quantity.name());
        let shade = Self {
            quantity,
            path: format!("shades/{place}"),
            legend: Legend::new(format!("legend/shades/{place}"), quantity.unit()),
            scale: Scale::new(Map::Viridis, None, None).signed(quantity.is_signed()),
            age: 0,
        };
        shade.legend.log_bar(stream, Map::Viridis)?;
        Shape::new(header).log(stream, &shade.path, domain)?;
        Ok(shade)
    }

    /// Draws one moment.
    pub fn log(
        &mut self,
        stream: &RecordingStream,
        header: &SliceHeader,
        nodes: &[SliceNode],
    ) -> RecordingStreamResult<()> {
        let values = self.quantity.values(header, nodes);
        let pairs = || values.iter().zip(nodes);
        let seen = pairs().filter(|(_, node)| node.is_fluid());
        let mut sizes: Vec<f32> = seen.map(|(value, _)| value.abs()).collect();
        if self.scale.follow(&mut sizes) || self.age == 0 {
            self.legend.log_numbers(stream, &self.scale)?;
        }
        self.age = (self.age + 1) % REPEAT;
        let colour = |(value, node): (&f32, &SliceNode)| node_colour(node, &self.scale, *value);
        let mesh = Mesh3D::update_fields().with_vertex_colors(pairs().map(colour));
        stream.log(self.path.as_str(), &mesh)
    }
}
