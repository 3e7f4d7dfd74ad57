//! What happens in a scene, told by a lattice in one piece or by one in shares.

use crate::common::*;
use crate::thread_ranks::ThreadRank;
use std::ops::Range;
use tremie_fluid_lbm::LbmFluid;
use tremie_messages::scene::{BodySet, DeformableSurface, Motion, Placement, Scene, Sphere};
use tremie_messages::{BodyEvent, BodyState, FacetLoad, SurfaceVertex};

/// What happens in a scene.
pub struct Story {
    pub case: Case,
    pub scene: Scene,
    pub events: Vec<BodyEvent>,
    pub bodies: Vec<BodyState>,
    /// Half-way through, events, and bodies that these add.
    pub swap: Vec<BodyEvent>,
    pub newcomers: Vec<BodyState>,
    pub steps: usize,
    /// Vertices of a surface that deforms, at the end of a step.
    pub vertices: Option<Box<dyn Fn(usize) -> Vec<SurfaceVertex> + Sync>>,
}

impl Story {
    pub fn new(case: Case) -> Self {
        Self::of(case.scene(), case)
    }

    pub fn of(scene: Scene, case: Case) -> Self {
        let (events, bodies, swap, newcomers) = Default::default();
        Self { scene, case, events, bodies, swap, newcomers, steps: 40, vertices: None }
    }

    /// A sphere that moves evenly.
    pub fn with(mut self, radius: f64, position: [f64; 3], velocity: [f64; 3]) -> Self {
        // The scene says what can be in it: ranks hold copies as deep as that takes.
        let diameter = 2.0 * radius;
        let sphere = Sphere { position, diameter, velocity, angular_velocity: [0.0; 3] };
        self.scene.bodies.push(BodySet {
            name: format!("set{}", self.bodies.len()),
            density: 2.0,
            material: "wall".into(),
            motion: Motion::Free,
            clump: None,
            placement: Placement::Listed(vec![sphere]),
        });
        let id = self.bodies.len() as u64;
        self.events.push(added(id, radius));
        self.bodies.push(BodyState { velocity, ..BodyState::at_rest(id, position) });
        self
    }

    /// Plays the story in a fluid, which may be a share; bits of all that it tells, and of the cells that it counts.
    fn play(&self, mut fluid: LbmFluid) -> (Vec<u64>, CountedBits) {
        self.begin(&mut fluid);
        let told = self.go(&mut fluid, 0..self.steps);
        (told, counted(&fluid))
    }

    /// Begins it.
    pub fn begin(&self, fluid: &mut LbmFluid) {
        let waves = |at: [f64; 3]| {
            let [x, y, z] = at.map(|x| 0.3 * x);
            ([0.02 * y.sin(), 0.01 * (x + z).cos(), 0.015 * (z - y).sin()], 1e-3 * (x * 0.7).cos())
        };
        fluid.set_state(waves);
        fluid.apply_events(&self.events).unwrap();
        self.deform(fluid, 0);
        fluid.start(&self.bodies, &mut loads_of(&self.bodies)).unwrap();
    }

    fn deform(&self, fluid: &mut LbmFluid, step: usize) {
        if let Some(vertices) = &self.vertices {
            fluid.set_surfaces(&vertices(step)).unwrap();
        }
    }

    /// Goes through some of its steps; bits of what the fluid tells.
    pub fn go(&self, fluid: &mut LbmFluid, steps: Range<usize>) -> Vec<u64> {
        let mut bits = Vec::new();
        let mut bodies = self.bodies.clone();
        for step in 0..steps.end {
            let is_there = steps.contains(&step);
            if step == self.steps / 2 && !self.swap.is_empty() {
                if is_there {
                    fluid.apply_events(&self.swap).unwrap();
                }
                bodies.retain(|body| !self.swap.contains(&removed(body.id)));
                bodies.extend(&self.newcomers);
            }
            advance(&mut bodies);
            if is_there {
                self.deform(fluid, step + 1);
                let mut loads = loads_of(&bodies);
                fluid.step(&bodies, &mut loads).unwrap();
                note(fluid, &loads, &mut bits);
                let facets = self.scene.surfaces.iter().map(DeformableSurface::facet_count).sum();
                let mut on_facets = vec![FacetLoad::default(); facets];
                fluid.surface_loads(&mut on_facets);
                let of_facets =
                    on_facets.iter().flat_map(|load| load.force.iter().chain(&load.point));
                bits.extend(of_facets.map(|x| x.to_bits()));
            }
        }
        bits
    }

    /// The share of a rank.
    pub fn share(&self, way: ThreadRank) -> LbmFluid {
        let with = (self.case.threads, self.case.variant);
        let (parameters, way) = (self.case.parameters(), Box::new(way));
        LbmFluid::with_ranks(&self.scene, &parameters, 1.0, with, way).unwrap()
    }

    /// What each of so many ranks makes.
    pub fn on_ranks<T: Send>(
        &self,
        ranks: usize,
        make: impl Fn(usize, LbmFluid) -> T + Sync,
    ) -> Vec<T> {
        std::thread::scope(|scope| {
            let ranks = ThreadRank::all(ranks).into_iter().enumerate();
            let make = &make;
            let spawn = |(rank, way)| scope.spawn(move || make(rank, self.share(way)));
            let threads: Vec<_> = ranks.map(spawn).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        })
    }

    /// Checks that so many ranks, each of these, have the bits of one.
    pub fn holds_for(&self, all: &[usize]) {
        let (told, of_cells) = self.play(self.case.fluid_of(&self.scene));
        assert!(told.len() > 20 * self.steps && !of_cells.is_empty());
        all.iter().for_each(|&ranks| self.hold(ranks, &told, &of_cells));
    }

    fn hold(&self, ranks: usize, told: &[u64], of_cells: &CountedBits) {
        let shares = self.on_ranks(ranks, |_, fluid| self.play(fluid));
        let mut all = Vec::new();
        for (rank, (of_share, cells)) in shares.into_iter().enumerate() {
            self.compare(&format!("rank {rank} of {ranks}"), told, &of_share);
            all.extend(cells);
        }
        compare_cells(&format!("{ranks} ranks"), of_cells, all);
    }

    /// Checks that what is told of some steps has the bits that it shall have.
    pub fn compare(&self, who: &str, expected: &[u64], told: &[u64]) {
        assert_eq!(expected.len(), told.len(), "{who}");
        let per_step = (expected.len() / self.steps).max(1);
        let other = (0..told.len()).find(|&k| expected[k] != told[k]);
        let place = other.map(|k| (k / per_step, k % per_step));
        assert_eq!(place, None, "{who}: step, and number in it");
    }
}

/// Bits of the populations of cells, with the cells' numbers in the box.
pub type CountedBits = Vec<(usize, u64)>;

/// Those of the cells that a fluid counts.
pub fn counted(fluid: &LbmFluid) -> CountedBits {
    let own = cells(fluid).enumerate().filter(|(_, cell)| fluid.counts(*cell));
    let bits =
        |(number, cell)| fluid.populations_at(cell).into_iter().map(move |f| (number, f.to_bits()));
    own.flat_map(bits).collect()
}

/// Checks that cells of all ranks are those that they shall be.
pub fn compare_cells(who: &str, expected: &CountedBits, mut found: CountedBits) {
    found.sort_by_key(|(number, _)| *number);
    assert_eq!(found.len(), expected.len(), "{who}: each cell is counted once");
    let other = found.iter().zip(expected).find(|(a, b)| a != b);
    assert!(other.is_none(), "{who}: {other:?}");
}

/// Adds the bits of what a fluid tells at the end of a step.
fn note(fluid: &mut LbmFluid, loads: &[tremie_messages::Load], bits: &mut Vec<u64>) {
    let mut put = |x: f64| bits.push(x.to_bits());
    for load in loads {
        load.force.iter().chain(&load.torque).for_each(|&x| put(x));
    }
    let found = fluid.diagnostics();
    put(found.max_speed);
    put(found.min_density_deviation);
    put(found.max_density_deviation);
    put(found.max_tau);
    put(found.links as f64);
    put(found.frozen as f64);
    put(found.isolated as f64);
    put(found.fallback_links as f64);
    put(found.fluid_cells as f64);
    let ledger = fluid.ledger();
    put(ledger.mass);
    put(ledger.mass_owed);
    put(ledger.mass_lost);
    for term in [
        ledger.momentum,
        ledger.walls,
        ledger.parts,
        ledger.open,
        ledger.bodies,
        ledger.covered,
        ledger.uncovered,
        ledger.isolated,
        ledger.gaps,
    ] {
        term.iter().for_each(|&x| put(x));
    }
    let mut on_parts = Vec::new();
    fluid.loads_on_parts(&mut on_parts);
    on_parts.iter().for_each(|load| load.force.iter().chain(&load.torque).for_each(|&x| put(x)));
    fluid.wall_forces().iter().flatten().for_each(|force| force.iter().for_each(|&x| put(x)));
    let (mut probes, mut reservoirs) = (Vec::new(), Vec::new());
    fluid.probes(&mut probes);
    probes.iter().for_each(|&x| put(x));
    fluid.reservoirs(&mut reservoirs);
    reservoirs.iter().for_each(|state| state.values().iter().for_each(|&x| put(x)));
    fluid.ports().iter().for_each(|port| put(port.velocity));
}
