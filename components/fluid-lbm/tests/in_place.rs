//! The solver in place against a plain one with two arrays, written independently: random spheres
//! with moving surfaces, some overlapping, walls, a sliding face, a body force, every mix of faces.
//!
//! Tolerance: 1e-14 in populations of order 1e-2, which is rounding (the collisions are written in
//! different order); forces 1e-13.

mod common;

use common::*;
use tremie_fluid_lbm::lattice::{C, C_F64, OPPOSITE, Q, W, cross, dot, equilibrium};
use tremie_fluid_lbm::{Collision, FluidLbm};
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

    /// The cell at `at + c`, or the axis of the wall in between.
    fn step(&self, at: [i64; 3], c: [i32; 3], sign: i64) -> Result<[i64; 3], usize> {
        let mut to = at;
        for a in 0..3 {
            let n = self.case.cells[a] as i64;
            to[a] += sign * i64::from(c[a]);
            if to[a] < 0 || to[a] >= n {
                if self.case.faces[a] == WALL {
                    return Err(a);
                }
                to[a] = to[a].rem_euclid(n);
            }
        }
        Ok(to)
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
        for k in 0..n[0] * n[1] * n[2] {
            let at = [k % n[0], k / n[0] % n[1], k / (n[0] * n[1])];
            if self.fluid(at) {
                for i in 0..Q {
                    // What arrives against direction i comes from the neighbour along i, or is
                    // reflected there.
                    let f = match self.step(at, C[i], 1) {
                        Ok(to) if self.fluid(to) => self.g[self.index(to)][OPPOSITE[i]],
                        Ok(to) => self.reflect(at, to, i),
                        Err(axis) => {
                            let rho = 1.0 + self.g[k as usize].iter().sum::<f64>();
                            let lid = axis == 2 && C[i][2] == 1;
                            let u = if lid { self.lid } else { [0.0; 3] };
                            self.g[k as usize][i] - 6.0 * W[i] * rho * dot(C_F64[i], u)
                        }
                    };
                    self.h[k as usize][OPPOSITE[i]] = f;
                }
            }
        }
    }

    fn reflect(&mut self, at: [i64; 3], to: [i64; 3], i: usize) -> f64 {
        let g = self.g[self.index(at)];
        let distance = |s: usize| {
            let (d, c, r) = (self.arm(s, at), C_F64[i], self.spheres[s].radius);
            let (b, cc) = (dot(d, c), dot(c, c));
            (-b - (b * b - cc * (dot(d, d) - r * r)).sqrt()) / cc
        };
        let (q, s) = (0..self.spheres.len())
            .filter(|&s| self.holder(s, to))
            .map(|s| (distance(s), s))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap();
        let arm = self.arm(s, at);
        let wall: [f64; 3] = std::array::from_fn(|a| arm[a] + q * C_F64[i][a]);
        let state = &self.spheres[s].state;
        let turn = cross(state.angular_velocity, wall);
        let u: [f64; 3] = std::array::from_fn(|a| state.velocity[a] + turn[a]);
        let flux = (1.0 + g.iter().sum::<f64>()) * dot(C_F64[i], u);
        let behind = self.step(at, C[i], -1).ok().filter(|&b| self.fluid(b));
        let f = match (q < 0.5, behind) {
            (false, _) => {
                g[i] / (2.0 * q) + (2.0 * q - 1.0) / (2.0 * q) * g[OPPOSITE[i]]
                    - 3.0 * W[i] / q * flux
            }
            (true, Some(behind)) => {
                2.0 * q * g[i] + (1.0 - 2.0 * q) * self.g[self.index(behind)][i] - 6.0 * W[i] * flux
            }
            (true, None) => g[i] - 6.0 * W[i] * flux,
        };
        let force: [f64; 3] =
            std::array::from_fn(|a| g[i] * (C_F64[i][a] - u[a]) + f * (C_F64[i][a] + u[a]));
        let torque = cross(wall, force);
        for a in 0..3 {
            self.force[s][a] += force[a];
            self.torque[s][a] += torque[a];
        }
        f
    }
}

fn compare(faces: [tremie_messages::scene::Face; 3], cells: [usize; 3], seed: u64) {
    let mut dice = Dice(seed);
    let mut case = Case::new(cells, faces.clone(), 0.7);
    case.collision = Collision::Bgk;
    case.acceleration = [1e-4, -2e-4, 5e-5];
    case.velocity = [0.02, 0.01, -0.01];
    let mut vector = |most: f64| std::array::from_fn(|_| dice.between(-most, most));
    let lid = [0.03, -0.02, 0.0];
    case.lid = (2, lid);
    let mut spheres: Vec<Sphere> = (0..6)
        .map(|id| {
            let offset: [f64; 3] = vector(0.5);
            let position = std::array::from_fn(|a| (0.5 + offset[a]) * cells[a] as f64);
            let mut state = BodyState::at_rest(id, position);
            (state.velocity, state.angular_velocity) = (vector(0.02), vector(0.005));
            Sphere { radius: 0.4 + 0.6 * id as f64 + 0.1, state }
        })
        .collect();
    // Two that overlap, so that they share cells.
    spheres[5].state.position = spheres[4].state.position.map(|x| x + 0.9);

    let mut fluid: FluidLbm = case.fluid();
    let events: Vec<_> = spheres.iter().map(|s| added(s.state.id, s.radius)).collect();
    let states: Vec<_> = spheres.iter().map(|s| s.state).collect();
    let mut loads = loads_of(&states);
    fluid.apply_events(&events).unwrap();
    fluid.start(&states, &mut loads).unwrap();

    let h: Vec<_> = common::cells(&fluid).map(|c| fluid.populations_at(c)).collect();
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
        for (k, cell) in common::cells(&fluid).enumerate() {
            let solid = !plain.fluid(cell.map(|k| k as i64));
            assert_eq!(fluid.node(cell).solid, solid);
            if !solid {
                let h = fluid.populations_at(cell);
                for i in 0..Q {
                    let error = (h[i] - plain.h[k][i]).abs();
                    assert!(error < 1e-14, "step {step} {cell:?} {i}: {} {}", h[i], plain.h[k][i]);
                }
            }
        }
        for (s, load) in loads.iter().enumerate() {
            // What the mean pressure gradient adds.
            let volume = 4.0 / 3.0 * std::f64::consts::PI * plain.spheres[s].radius.powi(3);
            for a in 0..3 {
                let force = load.force[a] - volume * plain.case.acceleration[a];
                assert!((force - plain.force[s][a]).abs() < 1e-13);
                assert!((load.torque[a] - plain.torque[s][a]).abs() < 1e-13);
                forces += force.abs();
            }
        }
    }
    assert!(forces > 0.1);
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
