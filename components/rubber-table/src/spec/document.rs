//! The tables of a specification, and what can be wrong with their values.

use serde::Deserialize;
use std::path::PathBuf;
use tremie_messages::Problem;
use tremie_messages::units::{Length, Pressure};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SpecDocument {
    pub section: Section,
    pub rubber: Rubber,
    pub carrier: Option<Carrier>,
    #[serde(default)]
    pub seat: SeatTable,
    pub table: TableTable,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Section {
    Rectangle(Rectangle),
    ORing(ORing),
    DRing(DRing),
    Mesh(MeshFile),
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Rectangle {
    pub inner_radius: Length,
    pub outer_radius: Length,
    pub height: Length,
    pub elements: [usize; 2],
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ORing {
    pub diameter: Length,
    pub thickness: Length,
    pub elements: usize,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DRing {
    pub diameter: Length,
    pub width: Length,
    pub elements: usize,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshFile {
    pub file: PathBuf,
    pub unit: Length,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Rubber {
    pub shear_modulus: Pressure,
    pub bulk_modulus: Pressure,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Carrier {
    #[serde(default)]
    pub bonded: Vec<String>,
    #[serde(default)]
    pub sliding: Vec<String>,
    #[serde(default)]
    pub guided: Vec<String>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct SeatTable {
    pub meridian: Option<Vec<[Length; 2]>>,
    pub rounding: Option<Length>,
    /// Pressure at a depth of an edge's length, over Young's modulus.
    pub stiffness: f64,
}

impl Default for SeatTable {
    fn default() -> Self {
        Self { meridian: None, rounding: None, stiffness: 1000.0 }
    }
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TableTable {
    pub compression: Length,
    #[serde(default = "frames")]
    pub frames: usize,
    /// Compression at which what touches the seat is the foot, in the frame nearest to it; without it, the largest.
    pub foot_at: Option<Length>,
}

fn frames() -> usize {
    41
}

/// Fewest frames of a table: between frames, force and shape are straight lines.
pub const FEWEST_FRAMES: usize = 33;

/// Most elements along a side, and most frames: beyond, memory and time are lost for nothing.
const MOST_ELEMENTS: usize = 400;
const MOST_FRAMES: usize = 2000;

impl SpecDocument {
    /// Boundaries that hold the section: as written, or as suits its shape.
    pub fn carrier(&self) -> Carrier {
        let top = match self.section {
            Section::ORing(_) => "upper",
            _ => "top",
        };
        self.carrier.clone().unwrap_or(Carrier {
            bonded: vec![top.into()],
            sliding: Vec::new(),
            guided: Vec::new(),
        })
    }

    /// Everything that is wrong with single values.
    pub fn problems(&self) -> Vec<Problem> {
        let mut out = Vec::new();
        self.check_section(&mut out);
        for (key, modulus) in [
            ("shear_modulus", self.rubber.shear_modulus),
            ("bulk_modulus", self.rubber.bulk_modulus),
        ] {
            positive(&format!("rubber.{key}"), modulus.0, "Pa", &mut out);
        }
        if self.rubber.bulk_modulus.0 < self.rubber.shear_modulus.0 && out.is_empty() {
            let found = "found less than the shear modulus, which no rubber has".to_string();
            out.push(
                Problem::new("rubber.bulk_modulus", found)
                    .help("rubber has 0.5 to 3 GPa; are the two exchanged?"),
            );
        }
        positive("table.compression", self.table.compression.0, "m", &mut out);
        within("table.frames", self.table.frames, FEWEST_FRAMES, MOST_FRAMES, &mut out);
        self.check_foot(&mut out);
        self.check_seat(&mut out);
        out
    }

    fn check_section(&self, out: &mut Vec<Problem>) {
        let at = |key: &str, name: &str| format!("section.{key}.{name}");
        match &self.section {
            Section::Rectangle(r) => {
                if r.inner_radius.0 < 0.0 {
                    let found = format!("found {} m, expected 0 or more", r.inner_radius.0);
                    out.push(Problem::new(at("rectangle", "inner_radius"), found));
                } else if r.outer_radius <= r.inner_radius {
                    let found = format!(
                        "found {} m, expected more than inner_radius, {} m",
                        r.outer_radius.0, r.inner_radius.0
                    );
                    out.push(Problem::new(at("rectangle", "outer_radius"), found));
                }
                positive(&at("rectangle", "height"), r.height.0, "m", out);
                let least = *r.elements.iter().min().unwrap_or(&0);
                within(&at("rectangle", "elements"), least, 1, MOST_ELEMENTS, out);
                let most = *r.elements.iter().max().unwrap_or(&0);
                within(&at("rectangle", "elements"), most.max(1), 1, MOST_ELEMENTS, out);
            }
            Section::ORing(o) => {
                positive(&at("o_ring", "diameter"), o.diameter.0, "m", out);
                positive(&at("o_ring", "thickness"), o.thickness.0, "m", out);
                within(&at("o_ring", "elements"), o.elements, 2, MOST_ELEMENTS, out);
            }
            Section::DRing(d) => {
                positive(&at("d_ring", "diameter"), d.diameter.0, "m", out);
                positive(&at("d_ring", "width"), d.width.0, "m", out);
                within(&at("d_ring", "elements"), d.elements, 2, MOST_ELEMENTS, out);
            }
            Section::Mesh(m) => positive(&at("mesh", "unit"), m.unit.0, "m", out),
        }
    }

    fn check_foot(&self, out: &mut Vec<Problem>) {
        let Some(foot_at) = self.table.foot_at else { return };
        let largest = self.table.compression.0;
        // In the frame at rest nothing presses.
        let least = largest / (self.table.frames.max(2) - 1) as f64;
        if largest > 0.0 && !(least..=largest).contains(&foot_at.0) {
            let found = format!(
                "found {} m, expected from {least} m, the first frame's compression, to {largest} m, the last one's",
                foot_at.0
            );
            out.push(Problem::new("table.foot_at", found));
        }
    }

    fn check_seat(&self, out: &mut Vec<Problem>) {
        if let Some(rounding) = self.seat.rounding
            && rounding.0 < 0.0
        {
            out.push(Problem::new(
                "seat.rounding",
                format!("found {} m, expected 0 or more", rounding.0),
            ));
        }
        if !(1.0..=1e6).contains(&self.seat.stiffness) {
            let found = format!("found {}, expected 1 to 1e6", self.seat.stiffness);
            out.push(Problem::new("seat.stiffness", found).help("100 to 1000 suits most seals"));
        }
    }
}

fn positive(key: &str, value: f64, unit: &str, out: &mut Vec<Problem>) {
    if value <= 0.0 {
        out.push(Problem::new(key, format!("found {value} {unit}, expected more than 0")));
    }
}

fn within(key: &str, value: usize, least: usize, most: usize, out: &mut Vec<Problem>) {
    if !(least..=most).contains(&value) {
        out.push(Problem::new(key, format!("found {value}, expected {least} to {most}")));
    }
}
