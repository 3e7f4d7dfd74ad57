//! Numbers of the lattice, judged before the run.

use crate::domain::parameters::{Parameters, Precision};
use crate::lattice::d3q19::CS2;
use crate::report::compression;
use crate::report::gap_findings as gaps;
use crate::report::reservoir_findings as reservoirs;
use crate::report::resolution::Resolution;
use tremie_fluid_kit::checks::cell_findings::CellFindings;
use tremie_fluid_kit::checks::grain_space_check::{DryRegion, Throat};
use tremie_fluid_kit::checks::mended_part::MendedPart;
use tremie_messages::finding::short;
use tremie_messages::scene::{Face, FluidMaterial, Motion, PartBoundary, Scene};
use tremie_messages::{Finding, Limit, WatchedQuantity};

/// Relaxation time below which rounding and waves are damped too little to be safe.
const LOW_TAU: f64 = 0.505;
/// Relaxation time above which the flow lags behind changes.
const HIGH_TAU: f64 = 2.0;
/// Mach number up to which the lattice's error, of its square, is about a per cent.
const LOW_MACH: f64 = 0.1;
/// Weight of the grains over the lattice's stiffness that is still small, and the one at which the
/// fluid was measured to give way under the bed.
const SOFT: [f64; 2] = [0.05, 0.1];

/// Findings on a lattice before it runs, each number with a verdict.
pub fn findings(parameters: &Parameters, scene: &Scene, resolution: &Resolution) -> Vec<Finding> {
    let Some(fluid) = &scene.fluid else { return Vec::new() };
    let lattice = Lattice { parameters, resolution, fluid, scene };
    let mut findings = vec![lattice.relaxation_time(), lattice.speed()];
    findings.extend(lattice.mach());
    let cells = CellFindings { cell: resolution.cell };
    findings.extend(resolution.cells_per_smallest_sphere.map(|across| cells.sphere(across)));
    findings.extend(resolution.cells_per_smallest_sphere.and_then(|d| cells.layer(d, fluid)));
    findings
        .extend(resolution.cells_per_thinnest_polyhedron.map(|across| cells.polyhedron(across)));
    findings.extend(resolution.thin_parts.iter().flat_map(|part| cells.part(part)));
    findings.extend(resolution.dry_regions.iter().map(DryRegion::finding));
    findings.extend(resolution.throat.as_ref().map(Throat::finding));
    findings.extend(resolution.narrowest_gap.as_ref().map(|gap| cells.gap(gap)));
    findings.extend(resolution.narrowest_gap_of_bodies.as_ref().map(|gap| cells.film(gap)));
    findings.extend(resolution.mended.iter().map(MendedPart::finding));
    findings.extend(lattice.pressure_noise());
    findings.extend(lattice.compression());
    findings.extend(compression::of_flow(scene, lattice.stiffness(), resolution.time_step));
    findings.extend(lattice.softness());
    findings.extend(reservoirs::findings(scene, resolution));
    findings.extend(gaps::findings(parameters, scene, resolution));
    findings
}

/// Part of the fluid's mass that links may lose or make before it shows in pressures and rates of
/// flow.
const LOST: f64 = 1e-3;
/// Part of it with which the fluid is another one.
const MUCH_LOST: f64 = 0.1;
/// Relative deviations of the density above which a liquid is compressed as a gas would be, and above
/// which the equilibrium of the lattice means nothing.
const COMPRESSED: [f64; 2] = [0.1, 0.5];

/// Limits by which signals are judged, and by which a run watches them.
pub fn limits(parameters: &Parameters, resolution: &Resolution) -> Vec<Limit> {
    let step = format!("(now {} s)", short(resolution.time_step));
    let [doubtful, wrong] = COMPRESSED;
    let mach = Limit {
        signal: "max_mach".into(),
        quantity: "largest Mach number of the lattice".into(),
        unit: "1".into(),
        doubtful: LOW_MACH,
        wrong: Some(parameters.mach_limit),
        why: format!(
            "above {LOW_MACH} the lattice's compressibility is more than a per cent of the flow, and somewhat higher its \
             flow is no longer that of a liquid"
        ),
        remedy: format!(
            "a shorter time step {step}, with which the number falls in proportion; or a larger expected_speed of the \
             scene's fluid, where that sets the step"
        ),
        watch: Some(WatchedQuantity::Mach),
    };
    let density = Limit {
        signal: "max_density_deviation".into(),
        quantity: "largest relative deviation of the density".into(),
        unit: "1".into(),
        doubtful,
        wrong: Some(wrong),
        why: format!(
            "above {doubtful} the fluid is compressed as a gas would be: its pressures are large beside rho c_s^2"
        ),
        remedy: format!(
            "a shorter time step {step}, with which the number falls by its square; or a larger relaxation time, where \
             waves and noise made it"
        ),
        watch: Some(WatchedQuantity::Density),
    };
    vec![mach, density, mass()]
}

fn mass() -> Limit {
    Limit {
        signal: "mass_lost_share".into(),
        quantity: "mass that walls and bodies took or made over the fluid's".into(),
        unit: "1".into(),
        doubtful: LOST,
        wrong: Some(MUCH_LOST),
        why: "walls and bodies pay back what they take over some 500 steps, but with refill = \"eqneq\" moving bodies never do; \
              meanwhile pressures in a closed box are off by that"
            .into(),
        remedy: "refill = \"mass\", which is the default; or a finer cell, in which bodies cross fewer cells in a step".into(),
        watch: Some(WatchedQuantity::Mass),
    }
}

struct Lattice<'a> {
    parameters: &'a Parameters,
    resolution: &'a Resolution,
    fluid: &'a FluidMaterial,
    scene: &'a Scene,
}

impl Lattice<'_> {
    /// Cell over time step [m/s].
    fn unit_speed(&self) -> f64 {
        self.resolution.cell / self.resolution.time_step
    }

    /// Gauge pressure of a relative change of density of one, `rho c_s^2` [Pa].
    fn stiffness(&self) -> f64 {
        self.fluid.density * CS2 * self.unit_speed() * self.unit_speed()
    }

    fn relaxation_time(&self) -> Finding {
        let Resolution { tau, time_step, cell, .. } = *self.resolution;
        let nu = self.fluid.viscosity / self.fluid.density;
        // At the same lattice speed tau - 1/2 grows as 1/cell.
        let finer = cell * (tau - 0.5) / (LOW_TAU - 0.5);
        let mut remedy = format!(
            "a cell of {} m (now {} m) at this lattice speed makes it {LOW_TAU}",
            short(finer),
            short(cell)
        );
        let step = self.parameters.time_step_of(LOW_TAU, nu);
        let mach = self.fluid.expected_speed.map_or(0.0, |u| self.parameters.mach_of(u, step));
        if mach <= LOW_MACH {
            remedy +=
                &format!(", so does a time step of {} s (now {} s)", short(step), short(time_step));
        }
        let why = if self.parameters.smagorinsky > 0.0 {
            "only the turbulence model damps waves and rounding, where the flow is sheared: the viscosity itself does next \
             to nothing, and still water rings"
        } else {
            remedy += "; or take a turbulence model, as smagorinsky = 0.1";
            "the collision is all but reversible: waves and rounding are damped too little, and the run may blow up or ring"
        };
        Finding::new("relaxation time", tau, "1")
            .doubtful_if(tau < LOW_TAU, format!("below {LOW_TAU} {why}"), remedy)
            .doubtful_if(
                tau > HIGH_TAU,
                format!("above {HIGH_TAU} the flow lags behind changes"),
                format!(
                    "a time step of {} s gives 1",
                    short(self.parameters.time_step_of(1.0, nu))
                ),
            )
    }

    fn speed(&self) -> Finding {
        let speed = self.unit_speed();
        let sound = speed * CS2.sqrt();
        Finding::new("lattice speed", speed, "m/s")
            .because(format!("a cell in a time step; sound travels at {} m/s", short(sound)))
    }

    fn mach(&self) -> Option<Finding> {
        let mach = self.resolution.expected_mach?;
        let finding = Finding::new("Mach number", mach, "1");
        let step = self.resolution.time_step * LOW_MACH / mach;
        Some(finding.because("at the expected speed").doubtful_if(
            mach > LOW_MACH * (1.0 + 1e-9),
            format!(
                "above {LOW_MACH} the lattice's compressibility is more than a per cent of the flow"
            ),
            format!("a time step of {} s gives {LOW_MACH}", short(step)),
        ))
    }

    /// Rounding of the pressure: populations hold deviations from rest, of the order of speed and
    /// pressure, so their rounding is a part of that.
    fn pressure_noise(&self) -> Option<Finding> {
        let speed = self.fluid.expected_speed.unwrap_or(0.0);
        let pressure = self.expected_pressure().max(self.fluid.density * speed * speed);
        if pressure == 0.0 {
            return None;
        }
        let rounding = match self.parameters.precision {
            Precision::F64 => f64::EPSILON,
            Precision::F32 => f64::from(f32::EPSILON),
        };
        let deviation = (speed / (CS2 * self.unit_speed())).max(pressure / self.stiffness());
        let noise = rounding * deviation * self.stiffness();
        let finding = Finding::new("pressure resolution", noise, "Pa");
        Some(finding.because(format!("of {} Pa that are expected", short(pressure))).doubtful_if(
            noise > 1e-3 * pressure,
            format!(
                "rounding is more than a thousandth of the {} Pa that are expected",
                short(pressure)
            ),
            "precision = \"f64\", or a longer time step",
        ))
    }

    fn compression(&self) -> Option<Finding> {
        let step = self.resolution.time_step;
        compression::finding(self.expected_pressure(), self.stiffness(), step, self.fluid.density)
    }

    /// The largest pressure that the scene gives [Pa].
    fn expected_pressure(&self) -> f64 {
        let faces = self.scene.domain.faces.iter().flatten().filter_map(|face| match face {
            Face::Pressure { pressure, .. } => Some(*pressure),
            _ => None,
        });
        let parts = self.scene.parts.iter().filter_map(|part| match part.boundary {
            PartBoundary::Pressure { pressure, .. } => Some(pressure),
            _ => None,
        });
        faces.chain(parts).chain([self.fluid.pressure]).fold(0.0, |most, p| most.max(p.abs()))
    }

    /// Excess weight of the free grains on the floor over the lattice's stiffness. The fluid
    /// carries the grains; where its pressure is not small beside `rho c_s^2` it is compressed as a
    /// spring.
    fn softness(&self) -> Option<Finding> {
        let gravity = self.scene.gravity;
        let down = (0..3).max_by(|a, b| gravity[*a].abs().total_cmp(&gravity[*b].abs()))?;
        let size = self.scene.domain.size();
        let floor: f64 = (0..3).filter(|a| *a != down).map(|a| size[a]).product();
        let free = self.scene.bodies.iter().filter(|set| set.motion == Motion::Free);
        let weight: f64 = free
            .map(|set| {
                (set.density - self.fluid.density).abs()
                    * set.placement.sizes().volume()
                    * gravity[down].abs()
            })
            .sum();
        if weight == 0.0 || self.scene.domain.is_periodic(down) {
            return None;
        }
        let pressure = weight / floor;
        let softness = pressure / self.stiffness();
        let [doubtful, wrong] = SOFT;
        // The softness goes with the square of the step: this one brings it to 0.4 of the limit.
        let step = self.resolution.time_step * (0.4 * doubtful / softness).sqrt();
        let why = format!(
            "the grains' excess weight is {} Pa on the floor, the lattice's stiffness {} Pa; above {doubtful} \
             the grains bounce on the fluid, near {wrong} a bed was measured to fail",
            short(pressure),
            short(self.stiffness())
        );
        let remedy = format!(
            "a time step of {} s makes it {:.2}; so does an expected speed {:.1} times as large, where that sets the step",
            short(step),
            0.4 * doubtful,
            self.resolution.time_step / step
        );
        let finding = Finding::new("weight of the grains over lattice stiffness", softness, "1");
        Some(finding.wrong_if(softness > wrong, &why, &remedy).doubtful_if(
            softness > doubtful,
            why,
            remedy,
        ))
    }
}

#[cfg(test)]
mod tests;
