//! The smallest fluid that can sit opposite Tremie's grains: Stokes drag and buoyancy.
//!
//! On each grain act the force `F = -3 pi mu d (V - u) - rho_f V_g g` and the torque `T = -pi mu
//! d^3 omega` (Stokes 1851). The fluid's velocity `u` is constant. There is no lattice, and no
//! grain acts on another through the fluid. This is right for a dilute suspension of very small
//! grains, and a place to start for a fluid of your own. It uses nothing of Tremie but the sdk.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::process::ExitCode;
use tremie_sdk::messages::scene::{FluidMaterial, Scene};
use tremie_sdk::messages::start::{Description, Signal};
use tremie_sdk::messages::{BodyEvent, BodyState, Load, Problem};
use tremie_sdk::state::{StateError, StateExchange};
use tremie_sdk::{AsFluid, Fluid, Setup, SolverError};

struct StokesFluid {
    material: FluidMaterial,
    gravity: [f64; 3],
    /// Diameter of each living grain by its id [m].
    diameters: BTreeMap<u64, f64>,
    largest_drag: f64,
}

/// The fluid's material, or a problem that points at the manifest's key.
fn material(scene: &Scene) -> Result<&FluidMaterial, Vec<Problem>> {
    scene.fluid.as_ref().ok_or_else(|| {
        vec![Problem::new("scene", "there is no fluid").help("add a [scene.fluid] table")]
    })
}

impl Fluid for StokesFluid {
    const PROGRAM: &'static str = concat!("minimal-fluid ", env!("CARGO_PKG_VERSION"));

    fn describe(setup: &Setup) -> Result<Description, Vec<Problem>> {
        let fluid = material(&setup.hello.scene)?;
        Ok(Description {
            // No step of its own: it takes whatever window the others need.
            step: None,
            signals: vec![Signal {
                name: "largest_drag".into(),
                unit: "N".into(),
                meaning: "largest drag on a sphere".into(),
                sampled: false,
            }],
            notes: vec![format!("Stokes drag, {} Pa s", fluid.viscosity)],
            // Another number whenever `exchange_state` names other things.
            state: Some(1),
            warnings: vec!["grains do not feel each other through this fluid".into()],
            ..Description::default()
        })
    }

    fn create(setup: &Setup) -> Result<Self, Vec<Problem>> {
        let scene = &setup.hello.scene;
        Ok(Self {
            material: material(scene)?.clone(),
            gravity: scene.gravity,
            diameters: BTreeMap::new(),
            largest_drag: 0.0,
        })
    }

    fn events(&mut self, events: &[BodyEvent]) -> Result<(), SolverError> {
        for event in events {
            match event.kind {
                BodyEvent::ADDED if event.shape == BodyEvent::SPHERE => {
                    self.diameters.insert(event.id, 2.0 * event.size[0]);
                }
                BodyEvent::REMOVED => {
                    self.diameters.remove(&event.id);
                }
                _ => return Err(SolverError(format!("body {} is no sphere", event.id))),
            }
        }
        Ok(())
    }

    fn start(&mut self, bodies: &[BodyState], loads: &mut [Load]) -> Result<(), SolverError> {
        self.advance(0, bodies, loads)
    }

    fn advance(
        &mut self,
        _substeps: u32,
        bodies: &[BodyState],
        loads: &mut [Load],
    ) -> Result<(), SolverError> {
        let FluidMaterial { density, viscosity, velocity, .. } = &self.material;
        self.largest_drag = 0.0;
        for (body, load) in bodies.iter().zip(loads) {
            let d = self.diameters[&body.id];
            let volume = PI / 6.0 * d * d * d;
            for axis in 0..3 {
                let drag = 3.0 * PI * viscosity * d * (velocity[axis] - body.velocity[axis]);
                // Buoyancy is part of the load: grains always apply their full weight.
                load.force[axis] = drag - density * volume * self.gravity[axis];
                load.torque[axis] = -PI * viscosity * d * d * d * body.angular_velocity[axis];
                self.largest_drag = self.largest_drag.max(drag.abs());
            }
        }
        Ok(())
    }

    fn exchange_state(&mut self, state: &mut StateExchange<'_>) -> Result<(), StateError> {
        state.value("diameters", &mut self.diameters)?;
        state.value("largest_drag", &mut self.largest_drag)
    }

    fn signals(&mut self, values: &mut Vec<f64>) {
        values.push(self.largest_drag);
    }
}

fn main() -> ExitCode {
    tremie_sdk::main::<AsFluid<StokesFluid>>()
}
