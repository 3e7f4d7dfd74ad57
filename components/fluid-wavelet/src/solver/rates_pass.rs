//! Rates of all blocks in one pass, with the loads on bodies.

use crate::bodies::body_mask::{BlockPlaces, BodyMask};
use crate::bodies::gas_body::{BodyLoad, GasBody};
use crate::bodies::momentum_loads::MomentumIntoBodies;
use crate::bodies::surface_loads::add_surface_loads;
use crate::gas::block_rates::{FaceWatch, GasRoom, NoGas, RatesOfBlock};
use crate::grid::block_shape::BlockShape;
use crate::grid::block_tree::{BlockAddress, BlockTree, NONE};
use crate::grid::block_values::BlockValues;
use crate::solver::wavelet_solver::WaveletSettings;
use tremie_team::Variant;

/// What the rates of all blocks are found of.
pub struct RatesPass<'a> {
    /// The blocks.
    pub tree: &'a BlockTree,
    /// Their fields.
    pub values: &'a BlockValues,
    /// How the gas is solved.
    pub settings: &'a WaveletSettings,
    /// The points inside bodies.
    pub mask: &'a BodyMask,
    /// Largest values of each field.
    pub scales: &'a [f64],
    /// Instructions to use.
    pub variant: Variant,
    /// Where blocks stand.
    pub places: BlockPlaces,
}

/// What is found of a block besides its rates.
#[derive(Default)]
pub struct OfBlock {
    /// A point without gas.
    pub failed: Option<NoGas>,
    /// Loads on the bodies near it by stress, if they were asked for.
    pub by_stress: Vec<BodyLoad>,
    /// The same by momentum.
    pub by_momentum: Vec<BodyLoad>,
}

impl RatesPass<'_> {
    /// Finds the rates of a block's points, and its share of the loads.
    pub fn find(
        &self,
        slot: usize,
        bodies: &[impl GasBody],
        with_loads: bool,
        room: &mut GasRoom,
        rates: &mut [f64],
        found: &mut OfBlock,
    ) {
        let Self { tree, values, settings, mask, places, .. } = self;
        let OfBlock { failed, by_stress, by_momentum } = found;
        let is_leaf = tree.children[slot][0] == NONE;
        let near = if with_loads && is_leaf { mask.near(slot) } else { &[] };
        *failed = None;
        for loads in [&mut *by_stress, &mut *by_momentum] {
            loads.clear();
            loads.resize(near.len(), BodyLoad::default());
        }
        if !is_leaf {
            return;
        }
        let (shape, gas, count) = (&tree.domain.shape, &settings.gas, values.fields);
        let block = tree.blocks[slot];
        let pressure = (gas.heat_ratio - 1.0) * self.scales[1 + settings.dims];
        let marks = mask.of(shape, slot);
        let spacing = settings.spacing(block.level);
        let arm = |body: usize, at| bodies[body].arm(at);
        let mut into_bodies = marks.filter(|_| with_loads).map(|marks| MomentumIntoBodies {
            shape,
            spacing,
            marks,
            low: places.padded_point(block, [0; 3]),
            arm: &arm,
            near,
            loads: by_momentum,
        });
        let of = RatesOfBlock {
            shape,
            gas,
            spacing,
            bounds: [self.scales[0], pressure].map(|scale| settings.roughness * scale),
            padded: &values.padded[slot * count * shape.stored..][..count * shape.stored],
            room: &mut *room,
            rates: &mut *rates,
            watch: into_bodies.as_mut().map(|into| into as &mut dyn FaceWatch),
        };
        if let Err(no_gas) = of.find(self.variant) {
            *failed = Some(no_gas);
            return;
        }
        self.add_sources(slot, block, rates);
        if let Some(marks) = marks {
            hold_inside(shape, marks, rates);
            // Surfaces lie in blocks of the finest level; a coarser one would count anew.
            if block.level == settings.deepest {
                let rest = settings.rest_pressure;
                add_surface_loads(
                    (places, gas),
                    block,
                    rest,
                    (bodies, near),
                    marks,
                    room,
                    by_stress,
                );
            }
        }
    }

    /// Adds what drives the gas, and what the sponge takes.
    fn add_sources(&self, slot: usize, block: BlockAddress, rates: &mut [f64]) {
        let Self { tree, values, settings, places, .. } = self;
        let (shape, count) = (&tree.domain.shape, values.fields);
        let length = count * shape.points;
        let own = &values.own[slot * length..][..length];
        if let Some(sponge) = &settings.sponge {
            sponge.add(&tree.domain, places, block, own, rates);
        }
        for a in (0..shape.dims).filter(|&a| settings.acceleration[a] != 0.0) {
            let push = settings.acceleration[a];
            let (momentum, energy) = ((1 + a) * shape.points, (1 + shape.dims) * shape.points);
            for point in 0..shape.points {
                rates[momentum + point] += push * own[point];
                rates[energy + point] += push * own[momentum + point];
            }
        }
    }
}

/// Points inside bodies do not change by the gas's own motion.
fn hold_inside(shape: &BlockShape, marks: &[u16], rates: &mut [f64]) {
    for own in (0..shape.points).filter(|&own| marks[shape.padded_place(own)] != 0) {
        rates.iter_mut().skip(own).step_by(shape.points).for_each(|rate| *rate = 0.0);
    }
}
