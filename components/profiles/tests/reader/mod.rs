//! A reader of NumPy's archives, by the description of their format (NEP 1) and not by the writer.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// An array of little-endian `f64` in C's order.
#[derive(Clone, Debug, PartialEq)]
pub struct NumpyArray {
    pub shape: Vec<usize>,
    pub values: Vec<f64>,
}

/// The arrays of an archive by name.
pub fn read_npz(path: &Path) -> BTreeMap<String, NumpyArray> {
    let mut archive = zip::ZipArchive::new(File::open(path).unwrap()).unwrap();
    let mut arrays = BTreeMap::new();
    for k in 0..archive.len() {
        let mut file = archive.by_index(k).unwrap();
        let name = file.name().strip_suffix(".npy").expect("an array").to_string();
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).unwrap();
        arrays.insert(name, parse(&bytes));
    }
    arrays
}

fn parse(bytes: &[u8]) -> NumpyArray {
    assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
    let end = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let head = std::str::from_utf8(&bytes[10..end]).unwrap();
    assert_eq!((end % 64, head.chars().last()), (0, Some('\n')));
    assert!(head.contains("'descr': '<f8'") && head.contains("'fortran_order': False"), "{head}");
    let (_, rest) = head.split_once("'shape': (").unwrap();
    let (lengths, _) = rest.split_once(')').unwrap();
    let lengths = lengths.split(',').map(str::trim).filter(|text| !text.is_empty());
    let shape: Vec<usize> = lengths.map(|text| text.parse().unwrap()).collect();
    let (words, rest) = bytes[end..].as_chunks::<8>();
    assert!(rest.is_empty());
    let values: Vec<f64> = words.iter().map(|word| f64::from_le_bytes(*word)).collect();
    assert_eq!(values.len(), shape.iter().product::<usize>());
    NumpyArray { shape, values }
}
