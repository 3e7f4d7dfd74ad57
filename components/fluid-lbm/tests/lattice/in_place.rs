//! The solver in place against a plain one with two arrays, written independently: random spheres
//! with moving surfaces, some overlapping, some cut by mirrors, walls, a sliding face, a body
//! force, every mix of faces.
//!
//! Tolerance: 1e-14 in populations of order 1e-2, which is rounding (the collisions are written in
//! different order); forces 1e-13.

use crate::common::*;
use tremie_fluid_lbm::d3q19::{C, C_F64, OPPOSITE, Q, W, cross, dot, equilibrium, mirrored};
use tremie_fluid_lbm::{Collision, GapPressure, LbmFluid};
use tremie_messages::BodyState;

struct Sphere {
    radius: f64,
    state: BodyState,
}

/// Two arrays over the cells; deviations from rest.
struct Plain {
    case: Case,
    spheres: Vec<Sphere>,
    lid: [f64; 3],
    h: Vec<[f64; Q]>,
    g: Vec<[f64; Q]>,
    force: Vec<[f64; 3]>,
    torque: Vec<[f64; 3]>,
}

impl Plain {
    fn index(&self, at: [i64; 3]) -> usize {
        let n = self.case.cells;
        at[0] as usize + n[0] * (at[1] as usize + n[1] * at[2] as usize)
    }

    /// The cell at `at + c` and the axes at which the way was mirrored, or the axis of the wall in
    /// between.
    fn step(&self, at: [i64; 3], c: [i32; 3], sign: i64) -> Result<([i64; 3], u8), usize> {
        let (mut to, mut mirrors, mut wall) = (at, 0, None);
        for a in 0..3 {
            let n = self.case.cells[a] as i64;
            to[a] += sign * i64::from(c[a]);
            if to[a] < 0 || to[a] >= n {
                if self.case.faces[a] == WALL {
                    wall = wall.or(Some(a));
                } else if self.case.faces[a] == SYMMETRY {
                    to[a] = if to[a] < 0 { -1 - to[a] } else { 2 * n - 1 - to[a] };
                    mirrors |= 1 << a;
                } else {
                    to[a] = to[a].rem_euclid(n);
                }
            }
        }
        wall.map_or(Ok((to, mirrors)), Err)
    }

    /// From the centre of a sphere to a cell, the shortest way.
    fn arm(&self, s: usize, at: [i64; 3]) -> [f64; 3] {
        std::array::from_fn(|a| {
            let (n, d) =
                (self.case.cells[a] as f64, at[a] as f64 + 0.5 - self.spheres[s].state.position[a]);
            if self.case.faces[a] == PERIODIC { d - n * (d / n).round() } else { d }
        })
    }

    fn holder(&self, s: usize, at: [i64; 3]) -> bool {
        let d = self.arm(s, at);
        dot(d, d) <= self.spheres[s].radius.powi(2)
    }

    fn fluid(&self, at: [i64; 3]) -> bool {
        (0..self.spheres.len()).all(|s| !self.holder(s, at))
    }

    fn collide(&mut self) {
        let (nu, a) = (self.case.viscosity(), self.case.acceleration);
        let tau = 0.5 + 3.0 * nu;
        for (g, h) in self.g.iter_mut().zip(&self.h) {
            let drho: f64 = h.iter().sum();
            let u: [f64; 3] = std::array::from_fn(|k| {
                (0..Q).map(|i| h[i] * C_F64[i][k]).sum::<f64>() / (1.0 + drho) + 0.5 * a[k]
            });
            for i in 0..Q {
                let source: f64 = (0..3)
                    .map(|k| {
                        let c = C_F64[i];
                        (3.0 * (c[k] - u[k]) + 9.0 * dot(c, u) * c[k]) * (1.0 + drho) * a[k]
                    })
                    .sum();
                g[i] = h[i] - (h[i] - equilibrium(i, drho, u)) / tau
                    + (1.0 - 0.5 / tau) * W[i] * source;
            }
        }
    }

    fn stream(&mut self) {
        let n = self.case.cells.map(|n| n as i64);
        self.force.fill([0.0; 3]);
        self.torque.fill([0.0; 3]);
        let place = |k: i64| [k % n[0], k / n[0] % n[1], k / (n[0] * n[1])];
        let wet = || (0..n[0] * n[1] * n[2]).filter(|&k| self.fluid(place(k)));
        let excess: f64 = wet().flat_map(|k| self.g[k as usize]).sum();
        let mean = 1.0 + excess / wet().count() as f64;
        for k in 0..n[0] * n[1] * n[2] {
            let at = [k % n[0], k / n[0] % n[1], k / (n[0] * n[1])];
            if self.fluid(at) {
                // Mass that the lid pushes in and takes out beyond that at the mean density.
                let mut beyond = 0.0;
                for i in 0..Q {
                    // The population that arrives against direction i comes from the neighbour
                    // along i, or is reflected there.
                    let f = match self.step(at, C[i], 1) {
                        Ok((to, mirrors)) if self.fluid(to) => {
                            self.g[self.index(to)][mirrored(OPPOSITE[i], mirrors)]
                        }
                        Ok((to, mirrors)) => self.reflect(at, to, i, mirrors),
                        Err(axis) => {
                            let rho = 1.0 + self.g[k as usize].iter().sum::<f64>();
                            let lid = axis == 2 && C[i][2] == 1;
                            let u = if lid { self.lid } else { [0.0; 3] };
                            let push = 6.0 * W[i] * rho * dot(C_F64[i], u);
                            beyond += push * (1.0 - mean / rho);
                            self.g[k as usize][i] - push
                        }
                    };
                    self.h[k as usize][OPPOSITE[i]] = f;
                }
                self.h[k as usize][0] += beyond;
            }
        }
    }

    /// The link `i` of a cell into a sphere at `to`; through a mirror it is reckoned as the
    /// mirrored link of the mirrored cell.
    fn reflect(&mut self, at: [i64; 3], to: [i64; 3], i: usize, mirrors: u8) -> f64 {
        let g = self.g[self.index(at)];
        let seen: [i64; 3] = std::array::from_fn(|a| match mirrors >> a & 1 {
            0 => at[a],
            _ if C[i][a] < 0 => -1 - at[a],
            _ => 2 * self.case.cells[a] as i64 - 1 - at[a],
        });
        let along = C_F64[mirrored(i, mirrors)];
        let distance = |s: usize| {
            let (d, c, r) = (self.arm(s, seen), along, self.spheres[s].radius);
            let (b, cc) = (dot(d, c), dot(c, c));
            (-b - (b * b - cc * (dot(d, d) - r * r)).sqrt()) / cc
        };
        let (q, s) = (0..self.spheres.len())
            .filter(|&s| self.holder(s, to))
            .map(|s| (distance(s), s))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap();
        let arm = self.arm(s, seen);
        let wall: [f64; 3] = std::array::from_fn(|a| arm[a] + q * along[a]);
        let state = &self.spheres[s].state;
        let turn = cross(state.angular_velocity, wall);
        let u: [f64; 3] = std::array::from_fn(|a| state.velocity[a] + turn[a]);
        let flux = (1.0 + g.iter().sum::<f64>()) * dot(along, u);
        let behind = self.step(at, C[i], -1).ok().filter(|&(b, _)| self.fluid(b));
        let f = match (q < 0.5, behind) {
            (false, _) => {
                g[i] / (2.0 * q) + (2.0 * q - 1.0) / (2.0 * q) * g[OPPOSITE[i]]
                    - 3.0 * W[i] / q * flux
            }
            (true, Some((behind, mirrors))) => {
                let other = self.g[self.index(behind)][mirrored(i, mirrors)];
                2.0 * q * g[i] + (1.0 - 2.0 * q) * other - 6.0 * W[i] * flux
            }
            (true, None) => g[i] - 6.0 * W[i] * flux,
        };
        let force: [f64; 3] =
            std::array::from_fn(|a| g[i] * (along[a] - u[a]) + f * (along[a] + u[a]));
        let torque = cross(wall, force);
        for a in 0..3 {
            self.force[s][a] += force[a];
            self.torque[s][a] += torque[a];
        }
        f
    }
}

/// Six spheres of different sizes that move and turn.
fn random_spheres(dice: &mut Dice, cells: [usize; 3]) -> Vec<Sphere> {
    let mut vector = |most: f64| std::array::from_fn(|_| dice.between(-most, most));
    (0..6)
        .map(|id| {
            let offset: [f64; 3] = vector(0.5);
            let position = std::array::from_fn(|a| (0.5 + offset[a]) * cells[a] as f64);
            let mut state = BodyState::at_rest(id, position);
            (state.velocity, state.angular_velocity) = (vector(0.02), vector(0.005));
            Sphere { radius: 0.4 + 0.6 * id as f64 + 0.1, state }
        })
        .collect()
}

impl Plain {
    /// Checks that all cells are solid or have the same populations.
    fn agrees(&self, fluid: &LbmFluid, step: usize) {
        for (k, cell) in cells(fluid).enumerate() {
            let solid = !self.fluid(cell.map(|k| k as i64));
            assert_eq!(fluid.node(cell).solid, solid);
            if !solid {
                let h = fluid.populations_at(cell);
                for i in 0..Q {
                    let error = (h[i] - self.h[k][i]).abs();
                    assert!(error < 1e-14, "step {step} {cell:?} {i}: {} {}", h[i], self.h[k][i]);
                }
            }
        }
    }

    /// Force and torque on a whole sphere, of which a mirror may show half.
    fn whole_load(&self, s: usize) -> [[f64; 3]; 2] {
        let (mut force, mut torque) = (self.force[s], self.torque[s]);
        for axis in (0..3).filter(|&axis| self.case.faces[axis] == SYMMETRY) {
            let (x, n) = (self.spheres[s].state.position[axis], self.case.cells[axis] as f64);
            if x.min(n - x).abs() < self.spheres[s].radius {
                // The half behind the mirror.
                for a in 0..3 {
                    force[a] *= if a == axis { 0.0 } else { 2.0 };
                    torque[a] *= if a == axis { 2.0 } else { 0.0 };
                }
            }
        }
        [force, torque]
    }
}

fn compare(faces: [tremie_messages::scene::Face; 3], cells: [usize; 3], seed: u64) {
    let mut dice = Dice(seed);
    let mut case = Case::new(cells, faces.clone(), 0.7);
    // The reference knows nothing between spheres that nearly touch.
    case.gap_pressure = GapPressure::Zero;
    case.collision = Collision::Bgk;
    case.acceleration = [1e-4, -2e-4, 5e-5];
    case.velocity = [0.02, 0.01, -0.01];
    let lid = [0.03, -0.02, 0.0];
    case.lid = (2, lid);
    let mut spheres = random_spheres(&mut dice, cells);
    // One that a mirror cuts in the middle.
    for a in 0..3 {
        if faces[a] == SYMMETRY {
            spheres[3].state.position[a] = [0.0, cells[a] as f64][a % 2];
        }
    }
    // Two that overlap, so that they share cells.
    spheres[5].state.position = spheres[4].state.position.map(|x| x + 0.9);

    let mut fluid: LbmFluid = case.fluid();
    let events: Vec<_> = spheres.iter().map(|s| added(s.state.id, s.radius)).collect();
    let states: Vec<_> = spheres.iter().map(|s| s.state).collect();
    let mut loads = loads_of(&states);
    fluid.apply_events(&events).unwrap();
    fluid.start(&states, &mut loads).unwrap();

    let h: Vec<_> = crate::common::cells(&fluid).map(|c| fluid.populations_at(c)).collect();
    let count = spheres.len();
    let mut plain = Plain {
        g: h.clone(),
        h,
        case,
        spheres,
        lid,
        force: vec![[0.0; 3]; count],
        torque: vec![[0.0; 3]; count],
    };
    let mut forces = 0.0_f64;
    for step in 0..15 {
        fluid.step(&states, &mut loads).unwrap();
        plain.collide();
        plain.stream();
        plain.agrees(&fluid, step);
        for (s, load) in loads.iter().enumerate() {
            // Load that the mean pressure gradient adds.
            let volume = 4.0 / 3.0 * std::f64::consts::PI * plain.spheres[s].radius.powi(3);
            let [expected, torque] = plain.whole_load(s);
            for a in 0..3 {
                let force = load.force[a] - volume * plain.case.acceleration[a];
                assert!((force - expected[a]).abs() < 2e-13, "{s} {a}: {force} {}", expected[a]);
                assert!((load.torque[a] - torque[a]).abs() < 2e-13);
                forces += force.abs();
            }
            let gap = fluid.ledger();
            let terms = gap.momentum_terms();
            for a in 0..3 {
                assert!((gap.momentum_change[a] - terms[a]).abs() < 1e-12 || step == 0);
            }
        }
    }
    assert!(forces > 0.1);
}

#[test]
fn between_mirrors() {
    compare([SYMMETRY; 3], [14, 13, 15], 6);
}

#[test]
fn with_mirrors_beside_walls_and_periodic_faces() {
    compare([SYMMETRY, WALL, PERIODIC], [15, 13, 14], 7);
    compare([WALL, PERIODIC, SYMMETRY], [13, 14, 17], 8);
    compare([PERIODIC, SYMMETRY, WALL], [19, 13, 13], 9);
}

#[test]
fn in_a_periodic_box() {
    compare([PERIODIC; 3], [17, 14, 13], 1);
}

#[test]
fn between_walls() {
    compare([WALL; 3], [14, 17, 13], 2);
}

#[test]
fn with_mixed_faces() {
    compare([PERIODIC, WALL, PERIODIC], [13, 15, 14], 3);
    compare([WALL, PERIODIC, WALL], [16, 13, 14], 4);
    compare([PERIODIC, PERIODIC, WALL], [21, 13, 13], 5);
}
