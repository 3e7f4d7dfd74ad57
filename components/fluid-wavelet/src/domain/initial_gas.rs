//! The gas at the start of a run.

use crate::gas::gas_law::{Gas, GasState};
use tremie_messages::scene::{FluidMaterial, GasMaterial, Scene, Shock, Vortex};

/// The gas of a scene at the start, along the world's axes.
#[derive(Clone, Debug)]
pub struct InitialGas {
    /// Its law.
    pub law: Gas,
    /// The gas at rest, moving with the fluid's own velocity.
    pub rest: GasState,
    material: GasMaterial,
}

impl InitialGas {
    /// Of a scene whose fluid is a gas. `inviscid` leaves out friction and conduction.
    pub fn of(scene: &Scene, inviscid: bool) -> Option<Self> {
        let fluid = scene.fluid.as_ref()?;
        let material = fluid.gas.clone()?;
        let law = law_of(fluid, &material, inviscid);
        // Gas of the same temperature under the gauge pressure at the start.
        let pressure = material.pressure + fluid.pressure;
        let density = fluid.density * pressure / material.pressure;
        let rest = GasState { density, velocity: fluid.velocity, pressure };
        Some(Self { law, rest, material })
    }

    /// Speed of sound in the gas at rest [m/s].
    pub fn sound_speed(&self) -> f64 {
        self.law.sound_speed(self.rest.density, self.rest.pressure)
    }

    /// Its state at a point of the world [m].
    pub fn at(&self, point: [f64; 3]) -> GasState {
        let mut state = self.rest;
        if let Some(vortex) = &self.material.vortex {
            state = in_vortex(&self.law, state, vortex, point);
        }
        for region in self.material.regions.iter().filter(|region| region.holds(point)) {
            let (density, pressure) = (region.density, region.pressure);
            state = GasState { density, velocity: region.velocity, pressure };
        }
        match &self.material.shock {
            Some(shock) if shock.has_passed(point) => behind(&self.law, self.rest, shock),
            _ => state,
        }
    }

    /// Temperatures that surfaces hold [K].
    pub fn surface_temperatures(&self) -> impl Iterator<Item = f64> + '_ {
        self.material.surface_temperatures.values().copied()
    }

    /// All states that the start has besides the gas at rest.
    pub fn others(&self) -> impl Iterator<Item = GasState> + '_ {
        let regions = self.material.regions.iter().map(|region| GasState {
            density: region.density,
            velocity: region.velocity,
            pressure: region.pressure,
        });
        let shock = self.material.shock.iter().map(|shock| behind(&self.law, self.rest, shock));
        let fastest = self.material.vortex.iter().map(|vortex| {
            let mut velocity = self.rest.velocity;
            velocity[(vortex.axis + 1) % 3] += vortex.speed.abs();
            GasState { velocity, ..self.rest }
        });
        regions.chain(shock).chain(fastest)
    }
}

/// The law of a scene's gas.
fn law_of(fluid: &FluidMaterial, material: &GasMaterial, inviscid: bool) -> Gas {
    Gas {
        heat_ratio: material.heat_ratio,
        gas_constant: material.pressure / (fluid.density * material.temperature),
        viscosity: if inviscid { 0.0 } else { fluid.viscosity },
        reference: material.temperature,
        sutherland: material.sutherland,
        prandtl: material.prandtl,
    }
}

/// Gas behind a shock that runs into gas of a state (Rankine and Hugoniot).
fn behind(law: &Gas, ahead: GasState, shock: &Shock) -> GasState {
    let (ratio, square) = (law.heat_ratio, shock.mach * shock.mach);
    let denser = (ratio + 1.0) * square / ((ratio - 1.0) * square + 2.0);
    let sound = law.sound_speed(ahead.density, ahead.pressure);
    let mut velocity = ahead.velocity;
    velocity[shock.axis] += shock.direction * shock.mach * sound * (1.0 - 1.0 / denser);
    GasState {
        density: denser * ahead.density,
        velocity,
        pressure: ahead.pressure * (1.0 + 2.0 * ratio / (ratio + 1.0) * (square - 1.0)),
    }
}

/// Gas in a vortex: pressure and centrifugal force are in balance, and the entropy is that around it.
fn in_vortex(law: &Gas, around: GasState, vortex: &Vortex, point: [f64; 3]) -> GasState {
    let [b, c] = [(vortex.axis + 1) % 3, (vortex.axis + 2) % 3];
    let arm = [b, c].map(|a| (point[a] - vortex.centre[a]) / vortex.radius);
    let fall = (1.0 - arm[0] * arm[0] - arm[1] * arm[1]).exp();
    let mach = vortex.speed / law.sound_speed(around.density, around.pressure);
    let cooler = 1.0 - 0.5 * (law.heat_ratio - 1.0) * mach * mach * fall;
    let mut velocity = around.velocity;
    velocity[b] -= vortex.speed * arm[1] * fall.sqrt();
    velocity[c] += vortex.speed * arm[0] * fall.sqrt();
    GasState {
        density: around.density * cooler.powf(1.0 / (law.heat_ratio - 1.0)),
        velocity,
        pressure: around.pressure * cooler.powf(law.heat_ratio / (law.heat_ratio - 1.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AHEAD: GasState = GasState { density: 1.2, velocity: [0.0; 3], pressure: 1e5 };

    #[test]
    fn a_shock_keeps_mass_momentum_and_energy() {
        let law = Gas { gas_constant: 1e5 / (1.2 * 300.0), ..Gas::scaled(None) };
        let shock = Shock { axis: 1, position: 0.0, direction: -1.0, mach: 1.66 };
        let after = behind(&law, AHEAD, &shock);
        let speed = shock.mach * law.sound_speed(AHEAD.density, AHEAD.pressure);
        let fluxes = |state: GasState| {
            // Seen from the shock.
            let u = -state.velocity[1] - speed;
            let enthalpy = 3.5 * state.pressure / state.density;
            let mass = state.density * u;
            [mass, mass * u + state.pressure, mass * (enthalpy + 0.5 * u * u)]
        };
        for (one, other) in fluxes(AHEAD).into_iter().zip(fluxes(after)) {
            assert!((one / other - 1.0).abs() < 1e-12, "{one} {other}");
        }
        assert!(after.velocity[1] < 0.0);
    }

    #[test]
    fn pressure_holds_a_vortex_together() {
        let law = Gas { gas_constant: 1e5 / (1.2 * 300.0), ..Gas::scaled(None) };
        let vortex = Vortex { axis: 2, centre: [0.0; 3], radius: 0.1, speed: 150.0 };
        let state = |r: f64| in_vortex(&law, AHEAD, &vortex, [r, 0.0, 0.0]);
        assert_eq!(state(0.1).velocity, [0.0, 150.0, 0.0]);
        for r in [0.03, 0.1, 0.2] {
            let slope = (state(r + 1e-6).pressure - state(r - 1e-6).pressure) / 2e-6;
            let here = state(r);
            let wanted = here.density * here.velocity[1] * here.velocity[1] / r;
            assert!((slope / wanted - 1.0).abs() < 1e-6, "{slope} {wanted}");
        }
    }
}
