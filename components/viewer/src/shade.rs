//! A cut coloured by a quantity other than speed, in a view of its own with its legend.

use crate::cut::Shape;
use crate::legend::Legend;
use crate::quantity::CutQuantity;
use crate::scale::{AIR, GREY, Map, Scale};
use crate::view::part;
use rerun::{Color, Mesh3D, RecordingStream, RecordingStreamResult};
use tremie_messages::frame::{SliceHeader, SliceNode};
use tremie_messages::scene::Domain;

/// Frames after which a legend's numbers are sent again.
const REPEAT: u32 = 64;

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
        let colour = |(value, node): (&f32, &SliceNode)| {
            Color::from_u32(match node {
                node if node.solid != 0 => GREY,
                node if node.is_air() => AIR,
                _ => self.scale.colour(*value),
            })
        };
        let mesh = Mesh3D::update_fields().with_vertex_colors(pairs().map(colour));
        stream.log(self.path.as_str(), &mesh)
    }
}
