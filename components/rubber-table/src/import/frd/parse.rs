//! The text of a `.frd` file: fixed columns, blocks that end with -3.

use super::FrdError;
use crate::mesh::Point;
use std::collections::BTreeMap;

#[derive(Default)]
pub(super) struct FrdFile {
    pub nodes: BTreeMap<usize, Point>,
    /// Corners and, of quadratic elements, middles of the sides, in order around.
    pub elements: Vec<Vec<usize>>,
    /// Values by time and name of the block, in the order of the file.
    pub results: Vec<Block>,
}

/// Two values at nodes.
pub(super) struct Block {
    pub time: f64,
    pub name: String,
    pub values: BTreeMap<usize, [f64; 2]>,
}

/// Columns of a line, counted in bytes; text beyond the end is empty.
fn columns(line: &str, from: usize, to: usize) -> &str {
    line.get(from..to.min(line.len())).unwrap_or("").trim()
}

impl FrdFile {
    pub fn read(text: &str) -> Result<Self, FrdError> {
        let mut file = Self::default();
        let mut lines = text.lines().enumerate().map(|(at, line)| (at + 1, line)).peekable();
        let mut time = 0.0;
        while let Some((line, text)) = lines.next() {
            let wrong = |expected| FrdError::Line { line, found: text.trim_end().into(), expected };
            if text.starts_with("    2C") {
                let block = Self::block(&mut lines);
                file.read_nodes(&block)?;
            } else if text.starts_with("    3C") {
                let block = Self::block(&mut lines);
                file.read_elements(&block)?;
            } else if text.starts_with("  100C") {
                time = columns(text, 12, 24)
                    .parse()
                    .map_err(|_| wrong("a time in columns 13 to 24"))?;
            } else if text.starts_with(" -4") {
                let name = columns(text, 3, 13).to_string();
                let block = Self::block(&mut lines);
                let values = if name == "DISP" || name == "FORC" {
                    read_values(&block)?
                } else {
                    BTreeMap::new()
                };
                file.results.push(Block { time, name, values });
            }
        }
        Ok(file)
    }

    /// Lines up to the end of a block.
    fn block<'a>(lines: &mut impl Iterator<Item = (usize, &'a str)>) -> Vec<(usize, &'a str)> {
        lines.take_while(|(_, line)| !line.starts_with(" -3")).collect()
    }

    fn read_nodes(&mut self, block: &[(usize, &str)]) -> Result<(), FrdError> {
        for (node, [x, y]) in read_values(block)? {
            self.nodes.insert(node, [x, y]);
        }
        Ok(())
    }

    fn read_elements(&mut self, block: &[(usize, &str)]) -> Result<(), FrdError> {
        let mut sides = 0;
        for &(line, text) in block {
            let wrong = |expected| FrdError::Line { line, found: text.trim_end().into(), expected };
            if text.starts_with(" -1") {
                let kind = columns(text, 13, 18)
                    .parse()
                    .map_err(|_| wrong("a type in columns 14 to 18"))?;
                sides = match kind {
                    7 | 8 => 3,
                    9 | 10 => 4,
                    kind => return Err(FrdError::Element { line, kind }),
                };
            } else if let Some(nodes) = text.strip_prefix(" -2") {
                let chunks = nodes.as_bytes().chunks(10);
                let nodes: Option<Vec<usize>> =
                    chunks.map(number).filter(|n| *n != Some(0)).collect();
                let nodes = nodes.filter(|nodes| nodes.len() == sides || nodes.len() == 2 * sides);
                self.elements
                    .push(around(&nodes.ok_or_else(|| wrong("nodes, 10 columns each"))?, sides));
            }
        }
        Ok(())
    }
}

fn number(bytes: &[u8]) -> Option<usize> {
    let text = std::str::from_utf8(bytes).ok()?.trim();
    if text.is_empty() { Some(0) } else { text.parse().ok() }
}

/// Corners first, then middles, to all in order around.
pub(super) fn around(nodes: &[usize], sides: usize) -> Vec<usize> {
    match nodes.len() == sides {
        true => nodes.to_vec(),
        false => (0..sides).flat_map(|side| [nodes[side], nodes[sides + side]]).collect(),
    }
}

/// First two values of each node: 10 columns for its number, 12 for each value.
fn read_values(block: &[(usize, &str)]) -> Result<BTreeMap<usize, [f64; 2]>, FrdError> {
    let mut values = BTreeMap::new();
    for &(line, text) in block.iter().filter(|(_, text)| text.starts_with(" -1")) {
        let wrong = || FrdError::Line {
            line,
            found: text.trim_end().into(),
            expected: "a node in columns 4 to 13 and values in 12 columns each",
        };
        let node = columns(text, 3, 13).parse().map_err(|_| wrong())?;
        let value = |at: usize| {
            columns(text, 13 + 12 * at, 25 + 12 * at).parse::<f64>().map_err(|_| wrong())
        };
        values.insert(node, [value(0)?, value(1)?]);
    }
    Ok(values)
}
