//! Bodies, vertices of surfaces and cuts as the points of a point cloud, and back.

use crate::proto::{
    Grid, NumericType, PackedElementField, PointCloud, Pose, Quaternion, Vector3, timestamp,
};
use tremie_messages::frame::{BodySample, SliceHeader, SliceNode, SurfaceSample};
use tremie_messages::{BodyState, SurfaceVertex};

/// Bytes of a body: its sample, and its speed.
const BODY: usize = 144 + 4;
/// Bytes of a vertex of a surface: its sample.
const VERTEX: usize = 56;
/// Bytes of a node: its position, the node itself, and its speed; and those of recordings that know
/// neither its density nor its level.
const NODE: usize = 12 + 32 + 4;
const NODE_WITHOUT_DENSITY: usize = 12 + 24 + 4;

const BODY_FIELDS: [(&str, u32, NumericType); 22] = {
    use NumericType::{Float32, Float64, Uint32};
    [
        ("x", 8, Float64),
        ("y", 16, Float64),
        ("z", 24, Float64),
        ("speed", 144, Float32),
        ("radius", 112, Float64),
        ("mass", 120, Float64),
        ("id_low", 0, Uint32),
        ("id_high", 4, Uint32),
        ("set", 128, Uint32),
        ("motion", 136, Uint32),
        ("qx", 32, Float64),
        ("qy", 40, Float64),
        ("qz", 48, Float64),
        ("qw", 56, Float64),
        ("vx", 64, Float64),
        ("vy", 72, Float64),
        ("vz", 80, Float64),
        ("wx", 88, Float64),
        ("wy", 96, Float64),
        ("wz", 104, Float64),
        ("shape", 132, Uint32),
        ("part", 140, Uint32),
    ]
};

const VERTEX_FIELDS: [(&str, u32, NumericType); 7] = {
    use NumericType::Float64;
    [
        ("x", 0, Float64),
        ("y", 8, Float64),
        ("z", 16, Float64),
        ("strain", 48, Float64),
        ("vx", 24, Float64),
        ("vy", 32, Float64),
        ("vz", 40, Float64),
    ]
};

const NODE_FIELDS: [(&str, u32, NumericType); 12] = {
    use NumericType::{Float32, Uint32};
    [
        ("x", 0, Float32),
        ("y", 4, Float32),
        ("z", 8, Float32),
        ("speed", 44, Float32),
        ("vx", 12, Float32),
        ("vy", 16, Float32),
        ("vz", 20, Float32),
        ("pressure", 24, Float32),
        ("fill", 28, Float32),
        ("solid", 32, Uint32),
        ("density", 36, Float32),
        ("level", 40, Uint32),
    ]
};

fn cloud(
    nanoseconds: u64,
    stride: usize,
    fields: &[(&str, u32, NumericType)],
    data: Vec<u8>,
) -> PointCloud {
    let field = |(name, offset, kind): &(&str, u32, NumericType)| PackedElementField {
        name: (*name).into(),
        offset: *offset,
        r#type: (*kind).into(),
    };
    PointCloud {
        timestamp: Some(timestamp(nanoseconds)),
        frame_id: "world".into(),
        pose: Some(Pose {
            position: Some(Vector3::default()),
            orientation: Some(Quaternion { w: 1.0, ..Default::default() }),
        }),
        point_stride: stride as u32,
        fields: fields.iter().map(field).collect(),
        data,
    }
}

/// Bodies as a point cloud.
pub fn encode_bodies(nanoseconds: u64, bodies: &[BodySample]) -> PointCloud {
    let mut data = Vec::with_capacity(bodies.len() * BODY);
    for body in bodies {
        let state = &body.state;
        data.extend(state.id.to_le_bytes());
        let numbers = [
            &state.position[..],
            &state.orientation,
            &state.velocity,
            &state.angular_velocity,
            &[body.radius, body.mass],
        ];
        numbers.concat().iter().for_each(|x| data.extend(x.to_le_bytes()));
        [body.set, body.shape, body.motion, body.part]
            .iter()
            .for_each(|x| data.extend(x.to_le_bytes()));
        data.extend((norm(state.velocity) as f32).to_le_bytes());
    }
    cloud(nanoseconds, BODY, &BODY_FIELDS, data)
}

/// Bodies of a point cloud; `None` if it is of another layout.
pub fn decode_bodies(cloud: &PointCloud) -> Option<Vec<BodySample>> {
    fits(cloud, BODY).then(|| cloud.data.chunks_exact(BODY).map(body).collect())
}

fn body(bytes: &[u8]) -> BodySample {
    let u = |word: usize| u64::from_le_bytes(take(bytes, 8 * word));
    let f = |word: usize| f64::from_bits(u(word));
    let half = |at: usize| u32::from_le_bytes(take(bytes, at));
    BodySample {
        state: BodyState {
            id: u(0),
            position: std::array::from_fn(|k| f(1 + k)),
            orientation: std::array::from_fn(|k| f(4 + k)),
            velocity: std::array::from_fn(|k| f(8 + k)),
            angular_velocity: std::array::from_fn(|k| f(11 + k)),
        },
        radius: f(14),
        mass: f(15),
        set: half(128),
        shape: half(132),
        motion: half(136),
        part: half(140),
    }
}

/// Vertices of deformable surfaces as a point cloud.
pub fn encode_vertices(nanoseconds: u64, samples: &[SurfaceSample]) -> PointCloud {
    let mut data = Vec::with_capacity(samples.len() * VERTEX);
    for SurfaceSample { vertex, strain } in samples {
        let numbers = vertex.position.iter().chain(&vertex.velocity).chain([strain]);
        numbers.for_each(|x| data.extend(x.to_le_bytes()));
    }
    cloud(nanoseconds, VERTEX, &VERTEX_FIELDS, data)
}

/// Vertices of a point cloud; `None` if it is of another layout.
pub fn decode_vertices(cloud: &PointCloud) -> Option<Vec<SurfaceSample>> {
    fits(cloud, VERTEX).then(|| cloud.data.chunks_exact(VERTEX).map(vertex).collect())
}

fn vertex(bytes: &[u8]) -> SurfaceSample {
    let f = |word: usize| f64::from_le_bytes(take(bytes, 8 * word));
    let vertex = SurfaceVertex {
        position: std::array::from_fn(f),
        velocity: std::array::from_fn(|k| f(3 + k)),
    };
    SurfaceSample { vertex, strain: f(6) }
}

/// Nodes of a cut as a point cloud.
pub fn encode_nodes(nanoseconds: u64, header: &SliceHeader, nodes: &[SliceNode]) -> PointCloud {
    let mut data = Vec::with_capacity(nodes.len() * NODE);
    let width = header.count[0].max(1) as usize;
    for (k, node) in nodes.iter().enumerate() {
        let (i, j) = ((k % width) as f64, (k / width) as f64);
        let at =
            |a: usize| (header.origin[a] + i * header.step[0][a] + j * header.step[1][a]) as f32;
        let [u, v, w] = node.velocity;
        for x in [at(0), at(1), at(2), u, v, w, node.pressure] {
            data.extend(x.to_le_bytes());
        }
        data.extend(node.fill.to_le_bytes());
        data.extend(node.solid.to_le_bytes());
        data.extend(node.density.to_le_bytes());
        data.extend(node.level.to_le_bytes());
        data.extend((norm(node.velocity.map(f64::from)) as f32).to_le_bytes());
    }
    cloud(nanoseconds, NODE, &NODE_FIELDS, data)
}

/// Nodes of a point cloud; `None` if it is of another layout.
pub fn decode_nodes(cloud: &PointCloud) -> Option<Vec<SliceNode>> {
    let stride = [NODE, NODE_WITHOUT_DENSITY].into_iter().find(|stride| fits(cloud, *stride))?;
    Some(cloud.data.chunks_exact(stride).map(node).collect())
}

fn node(bytes: &[u8]) -> SliceNode {
    let f = |word: usize| f32::from_le_bytes(take(bytes, 4 * word));
    let u = |word: usize| u32::from_le_bytes(take(bytes, 4 * word));
    let (density, level) = if bytes.len() == NODE { (f(9), u(10)) } else { (0.0, 0) };
    SliceNode {
        velocity: [f(3), f(4), f(5)],
        pressure: f(6),
        fill: f(7),
        solid: u(8),
        density,
        level,
    }
}

/// The exact grid of a cut.
pub fn encode_grid(header: &SliceHeader) -> Grid {
    Grid {
        origin: header.origin.into(),
        step_0: header.step[0].into(),
        step_1: header.step[1].into(),
        count: header.count.into(),
    }
}

/// A cut's header but for its stamp; `None` if the grid is of another form.
pub fn decode_grid(grid: Grid) -> Option<SliceHeader> {
    Some(SliceHeader {
        origin: grid.origin.try_into().ok()?,
        step: [grid.step_0.try_into().ok()?, grid.step_1.try_into().ok()?],
        count: grid.count.try_into().ok()?,
        ..SliceHeader::default()
    })
}

fn fits(cloud: &PointCloud, stride: usize) -> bool {
    cloud.point_stride as usize == stride && cloud.data.len().is_multiple_of(stride)
}

fn take<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    std::array::from_fn(|k| bytes[at + k])
}

fn norm(v: [f64; 3]) -> f64 {
    (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt()
}
