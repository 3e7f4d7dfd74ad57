//! Spheres on surfaces that deform, and the seats of these: lists, trials and what contacts remember.

use crate::{
    Vec3,
    bodies::{Ball, Bodies, Mobility, Wrench},
    contact::{self, Contact, Memory, Steps},
    error::GrainsError,
    forces::Scenery,
    law::{Law, Reduced},
    laws::Laws,
    mesh_contact::{self, MOST, Nearest, Triangle},
    part_contacts::closest,
    seat::{Seat, Seats},
    surface::{DeformableSurface, FacetLoad, mean_edge},
    tally::{Other, Tally},
};

/// A sphere near a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    /// Id of the body, and where it stands in memory.
    id: u64,
    pub body: u32,
    /// Where its force is added up.
    pub place: u32,
    law: u16,
    /// Number of contacts at the last accepted shape; as many memories count.
    touching: u8,
    reduced: Reduced,
    memories: [Memory; MOST],
}

/// A surface with the bodies near it.
#[derive(Clone, Debug)]
pub(crate) struct Held {
    triangles: Vec<[u32; 3]>,
    vertices: usize,
    /// Index of the part that carries it, and how many times the whole is what spheres meet.
    pub carrier: usize,
    whole: f64,
    material: u16,
    /// How far vertices may go before bodies and seats near them are listed anew [m].
    skin: f64,
    /// Vertices when they were, and whether that was in vain.
    listed: Vec<[f64; 3]>,
    stale: bool,
    /// Facets near any sphere, and what these are now.
    near: Vec<u32>,
    now: Vec<Triangle>,
    /// By the id of the body; `start[e]..start[e + 1]` are the places in `near` of entry e's facets.
    pub entries: Vec<Entry>,
    start: Vec<u32>,
    facets: Vec<u32>,
    spare: Vec<Entry>,
    groups: Vec<Box3>,
    pub seat: Seat,
    /// Loads on facets, where nobody asks for them.
    loads: Vec<FacetLoad>,
    /// Force on the carrier at the last accepted shape [N].
    pub on_carrier: Vec3,
}

/// What is listed near a surface.
#[derive(Clone, Copy)]
pub(crate) struct Around<'a> {
    pub bodies: &'a Bodies,
    pub laws: &'a Laws,
    pub seats: Seats<'a>,
    /// How much two bodies may have closed in while their lists are used [m].
    pub skin: f64,
}

/// So many facets, which lie together in most meshes, are looked at by one box.
const GROUP: usize = 32;

/// How fast the normal force of a contact falls as the surface retreats through a substep [N/m]: the spring's
/// slope, and the dashpot over the substep; not at all where the contact pushes no more.
fn retreat(law: &Law, pair: Reduced, overlap: f64, normal: f64, steps: Steps) -> f64 {
    if normal == 0.0 {
        return 0.0;
    }
    let dashpot = law.at(overlap, overlap, pair).gamma_n;
    law.normal_slope(overlap, pair) + dashpot / steps.after
}

/// An upright box.
#[derive(Clone, Copy, Debug)]
struct Box3 {
    min: Vec3,
    max: Vec3,
}

impl Box3 {
    fn of(points: impl Iterator<Item = Vec3>) -> Self {
        let none = Self { min: Vec3::repeat(f64::INFINITY), max: Vec3::repeat(f64::NEG_INFINITY) };
        points.fold(none, |all, x| Self { min: all.min.inf(&x), max: all.max.sup(&x) })
    }

    fn is_near(&self, x: Vec3, reach: f64) -> bool {
        (0..3).all(|a| x[a] > self.min[a] - reach && x[a] < self.max[a] + reach)
    }
}

/// Vertices are listed anew when one has gone by this part of the mean edge.
const SKIN: f64 = 0.1;

impl Held {
    /// Of a surface that is right.
    pub fn new(surface: &DeformableSurface, material: u16, whole: f64) -> Self {
        Self {
            triangles: surface.triangles.clone(),
            vertices: surface.vertices.len(),
            carrier: surface.carrier,
            whole,
            material,
            skin: SKIN * mean_edge(surface),
            listed: surface.vertices.clone(),
            stale: true,
            near: Vec::new(),
            now: Vec::new(),
            entries: Vec::new(),
            start: vec![0],
            facets: Vec::new(),
            spare: Vec::new(),
            groups: Vec::new(),
            seat: Seat::new(surface),
            loads: Vec::new(),
            on_carrier: Vec3::zeros(),
        }
    }

    /// Bodies changed their places in memory, or went far.
    pub fn spoil(&mut self) {
        self.stale = true;
    }

    /// Forgets the bodies that are not among `ids`, which ascend.
    pub fn forget(&mut self, ids: &[u64]) {
        self.entries.retain(|entry| ids.binary_search(&entry.id).is_ok());
    }

    /// Whether a shape needs other lists than those at hand.
    ///
    /// # Errors
    /// Arrays of another length than the surface has vertices, or numbers that are no points.
    pub fn needs_list(
        &self,
        surface: usize,
        vertices: &[[f64; 3]],
        velocities: &[[f64; 3]],
    ) -> Result<bool, GrainsError> {
        let expected = self.vertices;
        for found in [vertices.len(), velocities.len()] {
            if found != expected {
                return Err(GrainsError::SurfaceVertices { surface, found, expected });
            }
        }
        // Each coordinate by itself, without a branch, and so that what is no number counts as far.
        let limit = self.skin / 3f64.sqrt();
        let (now, then) = (vertices.as_flattened(), self.listed.as_flattened());
        let within = |all: bool, (a, b): (&f64, &f64)| all & ((a - b).abs() <= limit);
        if now.iter().zip(then).fold(true, within) {
            return Ok(self.stale);
        }
        match vertices.iter().position(|x| x.iter().any(|c| !c.is_finite())) {
            Some(vertex) => Err(GrainsError::SurfaceNotFinite { surface, vertex }),
            None => Ok(true),
        }
    }

    /// Lists what is near; contacts keep their history.
    pub fn list(&mut self, vertices: &[[f64; 3]], around: &Around<'_>) {
        self.listed.copy_from_slice(vertices);
        self.stale = false;
        self.seat.list(vertices, self.skin, around.seats);
        std::mem::swap(&mut self.entries, &mut self.spare);
        self.entries.clear();
        self.facets.clear();
        self.start.truncate(1);
        self.near.clear();
        let corner = |triangle: &[u32; 3]| triangle.map(|v| Vec3::from(vertices[v as usize]));
        self.groups.clear();
        let groups = self.triangles.chunks(GROUP);
        self.groups.extend(groups.map(|group| Box3::of(group.iter().flat_map(corner))));
        let all = Box3::of(vertices.iter().map(|&x| x.into()));
        // Both bodies' lists may be half spent when this one begins.
        let gap = around.skin + self.skin;
        for (&id, &slot) in around.bodies.ids.iter().zip(&around.bodies.slot) {
            let (slot, bodies) = (slot as usize, around.bodies);
            let Ball { x, radius } = bodies.balls[slot];
            if bodies.mobility[slot].is_free() && all.is_near(x, radius + gap) {
                self.list_facets(x, radius + gap, corner);
                if self.facets.len() > self.start[self.start.len() - 1] as usize {
                    self.start.push(self.facets.len() as u32);
                    self.enter(id, slot, around);
                }
            }
        }
        self.number_facets();
    }

    /// Adds the facets near a place.
    fn list_facets(&mut self, x: Vec3, reach: f64, corner: impl Fn(&[u32; 3]) -> [Vec3; 3]) {
        for (g, _) in self.groups.iter().enumerate().filter(|(_, group)| group.is_near(x, reach)) {
            let first = g * GROUP;
            let end = self.triangles.len().min(first + GROUP);
            for (facet, triangle) in (first..).zip(&self.triangles[first..end]) {
                if mesh_contact::distance(x, corner(triangle)) < reach {
                    self.facets.push(facet as u32);
                }
            }
        }
    }

    fn enter(&mut self, id: u64, slot: usize, around: &Around<'_>) {
        let bodies = around.bodies;
        let known = self.spare.binary_search_by_key(&id, |entry| entry.id).ok();
        let (touching, memories) = known.map_or((0, [Memory::default(); MOST]), |e| {
            (self.spare[e].touching, self.spare[e].memories)
        });
        self.entries.push(Entry {
            id,
            body: slot as u32,
            place: 0,
            law: around.laws.between(self.material, bodies.material[slot]),
            touching,
            reduced: Reduced {
                root_mass: bodies.mobility[slot].root_reduced_mass(Mobility::NONE),
                radius: bodies.balls[slot].radius,
            },
            memories,
        });
    }

    /// Facets of entries get their places among those that are near any.
    fn number_facets(&mut self) {
        self.near.extend(&self.facets);
        self.near.sort_unstable();
        self.near.dedup();
        for facet in &mut self.facets {
            // Every facet of an entry is among them.
            *facet = self.near.partition_point(|near| near < facet) as u32;
        }
    }

    /// Contacts of a shape as if it were accepted; adds what they do to facets.
    pub fn try_shape(
        &mut self,
        state: (&[[f64; 3]], &[[f64; 3]]),
        scenery: &Scenery<'_>,
        out: &mut Vec<FacetLoad>,
    ) {
        self.place_facets(state.0);
        for e in 0..self.entries.len() {
            let mut copy = self.entries[e];
            self.meet(e, &mut copy, state, scenery, &mut Tally::default(), out);
        }
        self.seat.push(state.0, out);
    }

    /// Contacts of the accepted shape: histories go on, forces on bodies are added to `wrench`.
    pub fn accept(
        &mut self,
        state: (&[[f64; 3]], &[[f64; 3]]),
        scenery: &Scenery<'_>,
        wrench: &mut [Wrench],
        tally: &mut Tally,
    ) {
        self.place_facets(state.0);
        let mut out = std::mem::take(&mut self.loads);
        out.clear();
        for e in 0..self.entries.len() {
            let mut entry = self.entries[e];
            let on_body = self.meet(e, &mut entry, state, scenery, tally, &mut out);
            let sum = &mut wrench[entry.place as usize];
            sum.force += on_body.force;
            sum.torque += on_body.torque;
            self.entries[e] = entry;
        }
        self.seat.energy = self.seat.push(state.0, &mut out);
        let sum = |all: Vec3, load: &FacetLoad| all + Vec3::from(load.force);
        self.on_carrier = out.iter().fold(Vec3::zeros(), sum);
        self.loads = out;
    }

    fn place_facets(&mut self, vertices: &[[f64; 3]]) {
        self.now.clear();
        let triangles = &self.triangles;
        self.now.extend(self.near.iter().map(|&facet| {
            let corners = triangles[facet as usize].map(|v| Vec3::from(vertices[v as usize]));
            let [a, b, c] = corners;
            let normal = (b - a).cross(&(c - a));
            Triangle { corners, normal: normal * (1.0 / normal.norm_squared().sqrt()) }
        }));
    }

    /// The contacts of one sphere: the force on it, and what its entry remembers then.
    fn meet(
        &self,
        e: usize,
        entry: &mut Entry,
        (_, velocities): (&[[f64; 3]], &[[f64; 3]]),
        scenery: &Scenery<'_>,
        tally: &mut Tally,
        out: &mut Vec<FacetLoad>,
    ) -> Wrench {
        let body = entry.body as usize;
        let (ball, twist) = (&scenery.bodies.balls[body], &scenery.bodies.predicted[body]);
        let facets = &self.facets[self.start[e] as usize..self.start[e + 1] as usize];
        let triangles = facets.iter().map(|&place| self.now[place as usize]);
        let found = mesh_contact::find(ball.x, ball.radius, ball.radius, triangles);
        let (known, old) = (entry.touching as usize, &self.entries[e].memories);
        entry.touching = 0;
        let (mut used, mut on_body) = ([false; MOST], Wrench::zero());
        for near in found.contacts() {
            let place = facets[near.triangle as usize] as usize;
            let facet = self.near[place];
            let n = -near.normal;
            let overlap = ball.radius - near.distance;
            let arm = ball.radius - 0.5 * overlap;
            let surface = self.velocity(place, near, velocities);
            let contact = Contact {
                normal: n,
                overlap,
                velocity: (twist.v - surface) + twist.w.cross(&n) * arm,
                twist: 0.5 * twist.w.dot(&n),
                rolling: twist.w,
            };
            let heir =
                closest(&old[..known], n).filter(|&k| !std::mem::replace(&mut used[k], true));
            let mut memory = heir.map_or(Memory::default(), |k| old[k]);
            let (law, steps) = (&scenery.laws[entry.law as usize], scenery.steps);
            let f =
                contact::force(law, entry.reduced, &contact, &mut memory, heir.is_some(), steps);
            entry.memories[entry.touching as usize] = memory;
            entry.touching += 1;
            let force = f.tangential - n * f.normal;
            on_body.force += force;
            on_body.torque += n.cross(&f.tangential) * arm + f.rolling;
            let point = (ball.x + n * arm).into();
            let stiffness = self.whole * retreat(law, entry.reduced, overlap, f.normal, steps);
            out.push(FacetLoad { facet, force: (force * -self.whole).into(), point, stiffness });
            tally.add(overlap / ball.radius, entry.body, Other::Surface(self.carrier as u32));
        }
        on_body
    }

    /// Velocity of the surface at a point of a facet: that of its corners in the point's shares.
    fn velocity(&self, place: usize, near: &Nearest, velocities: &[[f64; 3]]) -> Vec3 {
        let [u, v, w] = self.triangles[self.near[place] as usize]
            .map(|vertex| Vec3::from(velocities[vertex as usize]));
        let [a, b, c] = self.now[place].corners;
        let (ab, ac, ap) = (b - a, c - a, near.point - a);
        let (bb, bc, cc) = (ab.dot(&ab), ab.dot(&ac), ac.dot(&ac));
        let (pb, pc) = (ap.dot(&ab), ap.dot(&ac));
        let scale = 1.0 / (bb * cc - bc * bc);
        let (s, t) = ((cc * pb - bc * pc) * scale, (bb * pc - bc * pb) * scale);
        u + (v - u) * s + (w - u) * t
    }

    /// Energy in the springs of spheres' contacts and of the seat, of which the domain has a share [J].
    pub fn elastic_energy(&self, laws: &[Law]) -> f64 {
        let of = |entry: &Entry| {
            let law = &laws[entry.law as usize];
            let memories = &entry.memories[..entry.touching as usize];
            memories.iter().map(|memory| law.remembered_energy(memory, entry.reduced)).sum::<f64>()
        };
        self.entries.iter().map(of).sum::<f64>() + self.seat.energy / self.whole
    }
}
