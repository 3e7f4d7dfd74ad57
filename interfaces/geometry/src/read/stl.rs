//! STL files, binary and text.
//!
//! The reader takes a file for text if it begins with "solid ", reads one solid, and knows keywords in
//! small letters only. Files in the wild are less orderly: binary headers that begin with "solid",
//! several solids in one text, capitals, a solid without a name. They are set right before.

use crate::Mesh;
use std::io::Cursor;

/// Bytes before the first triangle of a binary file: a header and the number of triangles.
const HEADER: usize = 84;
/// Bytes of a triangle in a binary file.
const TRIANGLE: usize = 50;

/// The triangles of a file, or why it is none.
pub fn parse(bytes: &[u8]) -> Result<Mesh, String> {
    let mut mesh = Mesh::default();
    match binary_triangles(bytes) {
        Some(Ok(())) => {
            // The header's text means nothing; blank, it cannot be taken for that of a text file.
            let mut blank = bytes.to_vec();
            blank[..80].fill(0);
            append(&mut mesh, &blank)?;
        }
        Some(Err(why)) => return Err(why),
        None => {
            for solid in solids(bytes)? {
                append(&mut mesh, solid.as_bytes())?;
            }
        }
    }
    Ok(mesh)
}

/// Whether a file is binary, and if so, whether it is complete. `None` for a text.
fn binary_triangles(bytes: &[u8]) -> Option<Result<(), String>> {
    let is_text = || {
        let start = bytes.trim_ascii_start();
        start.len() >= 5 && start[..5].eq_ignore_ascii_case(b"solid")
    };
    let Some(header) = bytes.get(..HEADER) else {
        let short = format!("it has {} bytes; a binary file has at least {HEADER}", bytes.len());
        return if is_text() { None } else { Some(Err(short)) };
    };
    let count = u32::from_le_bytes([header[80], header[81], header[82], header[83]]) as usize;
    let present = (bytes.len() - HEADER) / TRIANGLE;
    if present == count && (bytes.len() - HEADER).is_multiple_of(TRIANGLE) {
        return Some(Ok(()));
    }
    if is_text() {
        return None;
    }
    if present < count {
        return Some(Err(format!("its header says {count} triangles, but only {present} follow")));
    }
    // More bytes than triangles: some programs add their own data at the end.
    Some(Ok(()))
}

/// Every solid of a text, in the form that the reader knows.
fn solids(bytes: &[u8]) -> Result<Vec<String>, String> {
    let text = str::from_utf8(bytes).map_err(|e| {
        format!(
            "it is neither a complete binary file nor text (byte {} is no character)",
            e.valid_up_to()
        )
    })?;
    let mut solids: Vec<String> = Vec::new();
    for line in text.lines().map(|line| line.trim().to_ascii_lowercase()) {
        if line.split_whitespace().next() == Some("solid") {
            solids.push("solid part\n".to_string());
        } else if !line.is_empty() {
            let Some(solid) = solids.last_mut() else {
                return Err(format!("expected \"solid\", found \"{line}\""));
            };
            solid.push_str(&line);
            solid.push('\n');
        }
    }
    Ok(solids)
}

fn append(mesh: &mut Mesh, solid: &[u8]) -> Result<(), String> {
    let mut cursor = Cursor::new(solid);
    let triangles = stl_io::create_stl_reader(&mut cursor).map_err(|e| e.to_string())?;
    for triangle in triangles {
        let triangle =
            triangle.map_err(|e| format!("after {} triangles: {e}", mesh.triangles.len()))?;
        let first = u32::try_from(mesh.vertices.len() + 2)
            .map_err(|_| "it has more triangles than 32-bit numbers can tell apart".to_string())?
            - 2;
        mesh.vertices.extend(triangle.vertices.map(|v| v.0.map(f64::from)));
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    Ok(())
}
