//! Frames as data sets.

use crate::document::Document;
use crate::parameters::Compression;
use tremie_messages::BodyEvent;
use tremie_messages::frame::{BodySample, SliceNode, VolumeHeader};
use tremie_sdk::Moment;

/// Nodes of a lattice.
pub fn lattice(
    at: Moment,
    header: &VolumeHeader,
    nodes: &[SliceNode],
    compression: Compression,
) -> Document {
    let last = header.count.map(|n| n.saturating_sub(1));
    let extent = format!("0 {} 0 {} 0 {}", last[0], last[1], last[2]);
    let words = |v: [f64; 3]| format!("{:e} {:e} {:e}", v[0], v[1], v[2]);
    let attributes = format!(
        "WholeExtent=\"{extent}\" Origin=\"{}\" Spacing=\"{}\"",
        words(header.origin),
        words(header.step)
    );
    let mut document =
        Document::new("ImageData", &attributes, compression).moment(at.time, at.stamp.window);
    document.begin("Piece", &format!("Extent=\"{extent}\""));
    document.begin("PointData", "Vectors=\"velocity\" Scalars=\"pressure\"");
    document.array("velocity", 3, "m/s", nodes.iter().flat_map(|node| node.velocity));
    document.array("pressure", 1, "Pa", nodes.iter().map(|node| node.pressure));
    document.array("fill", 1, "", nodes.iter().map(|node| node.fill));
    document.array("solid", 1, "", nodes.iter().map(|node| u8::from(node.solid != 0)));
    document.array("density", 1, "kg/m3", nodes.iter().map(|node| node.density));
    document.array("level", 1, "", nodes.iter().map(|node| node.level));
    document
}

fn is_round(body: &BodySample) -> bool {
    matches!(body.shape, BodyEvent::SPHERE | BodyEvent::CYLINDER)
}

/// Spheres as points, and the cylinders of a plane scene.
pub fn bodies(at: Moment, bodies: &[BodySample], compression: Compression) -> Document {
    let spheres: Vec<_> = bodies.iter().filter(|body| is_round(body)).collect();
    let all = || spheres.iter();
    let count = spheres.len() as i64;
    let mut document = Document::new("PolyData", "", compression).moment(at.time, at.stamp.window);
    document.begin(
        "Piece",
        &format!(
            "NumberOfPoints=\"{count}\" NumberOfVerts=\"{count}\" NumberOfLines=\"0\" \
             NumberOfStrips=\"0\" NumberOfPolys=\"0\""
        ),
    );
    document.begin("PointData", "Vectors=\"velocity\" Scalars=\"radius\"");
    document.array("id", 1, "", all().map(|body| body.state.id));
    document.array("set", 1, "", all().map(|body| body.set));
    document.array("motion", 1, "", all().map(|body| body.motion));
    document.array("radius", 1, "m", all().map(|body| body.radius));
    document.array("mass", 1, "kg", all().map(|body| body.mass));
    document.array("velocity", 3, "m/s", all().flat_map(|body| body.state.velocity));
    let spin = all().flat_map(|body| body.state.angular_velocity);
    document.array("angular_velocity", 3, "rad/s", spin);
    document.array("orientation", 4, "", all().flat_map(|body| body.state.orientation));
    document.end();
    document.begin("Points", "");
    document.array("points", 3, "m", all().flat_map(|body| body.state.position));
    document.end();
    document.begin("Verts", "");
    document.array("connectivity", 1, "", 0..count);
    document.array("offsets", 1, "", 1..=count);
    document
}
