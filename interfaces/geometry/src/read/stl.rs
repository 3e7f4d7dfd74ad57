//! STL files, binary and text.
//!
//! The first word does not tell the two apart: headers of binary files begin with "solid" too.

use super::stl_text;
use super::text::{decode, looks_like};
use crate::Mesh;
use crate::Vec3;
use std::io::Cursor;

/// Bytes before the first triangle of a binary file: a header and the number of triangles.
const HEADER: usize = 84;
/// Bytes of a triangle in a binary file.
const TRIANGLE: usize = 50;

/// The triangles of a file, or why it is none.
pub fn parse(bytes: &[u8]) -> Result<Mesh, String> {
    if bytes.is_empty() {
        return Err("it is empty".into());
    }
    if is_whole_binary(bytes) {
        return binary(bytes);
    }
    if is_text(bytes) {
        return stl_text::parse(&decode(bytes));
    }
    if let Some(what) = looks_like(bytes).filter(|what| !what.contains("STL")) {
        return Err(format!("it looks like {what}"));
    }
    let Some(present) = bytes.len().checked_sub(HEADER).map(|rest| rest / TRIANGLE) else {
        return Err(format!("it has {} bytes; a binary file has at least {HEADER}", bytes.len()));
    };
    let count = count(bytes);
    if present < count {
        return Err(format!("its header says {count} triangles, but only {present} follow"));
    }
    if count == 0 {
        return Err(format!("its header says 0 triangles, but there is room for {present}"));
    }
    // More bytes than triangles: some programs add their own data at the end.
    binary(bytes)
}

/// The number of triangles that a binary file's header says.
fn count(bytes: &[u8]) -> usize {
    bytes
        .get(80..HEADER)
        .map_or(0, |count| u32::from_le_bytes([count[0], count[1], count[2], count[3]]) as usize)
}

/// True if a file has just the length that its header says.
fn is_whole_binary(bytes: &[u8]) -> bool {
    let length = |bytes: &[u8]| HEADER.checked_add(count(bytes).checked_mul(TRIANGLE)?);
    bytes.len() >= HEADER && length(bytes) == Some(bytes.len())
}

/// True if a file is a text that begins as an STL file does. Text has no zeros, and the number in a
/// binary header has: of its four bytes the last.
fn is_text(bytes: &[u8]) -> bool {
    let begin = &bytes[..bytes.len().min(4096)];
    let is_wide = matches!(begin, [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..]);
    if !is_wide && begin.contains(&0) {
        return false;
    }
    let text = decode(begin);
    let start = text.trim_start().as_bytes();
    start.len() >= 5 && start[..5].eq_ignore_ascii_case(b"solid")
}

fn binary(bytes: &[u8]) -> Result<Mesh, String> {
    // The header's text means nothing; blank, it cannot be taken for that of a text file.
    let mut blank = bytes.to_vec();
    blank[..80].fill(0);
    let mut mesh = Mesh::default();
    let mut cursor = Cursor::new(blank);
    let triangles = stl_io::create_stl_reader(&mut cursor).map_err(|e| e.to_string())?;
    for triangle in triangles {
        let triangle =
            triangle.map_err(|e| format!("after {} triangles: {e}", mesh.triangles.len()))?;
        let first = u32::try_from(mesh.vertices.len() + 2)
            .map_err(|_| "it has more triangles than 32-bit numbers can tell apart".to_string())?
            - 2;
        mesh.vertices.extend(triangle.vertices.map(|v| Vec3::from(v.0.map(f64::from))));
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    Ok(mesh)
}
