//! Spheres on surfaces that deform, and the seats of these: trials and histories of contacts.

mod facet_lists;
mod kept;

use crate::Vec3;
use crate::bodies::body_arrays::{BoundingSphere, Wrench};
use crate::bodies::deformable_surface::{DeformableSurface, FacetLoad, mean_edge};
use crate::bodies::mesh_contact::{self, LookedFrom, MOST, Seeker, WallPoint, WallPoints};
use crate::contact::contact_force::{self, Contact, Steps};
use crate::contact::contact_history::{Remembered, WallContactHistory};
use crate::contact::contact_law::Law;
use crate::contact::region_shares::shares;
use crate::contact::springs::Reduced;
use crate::forces::pair_forces::ContactContext;
use crate::math::tally::{Other, Tally};
use crate::walls::reached_walls::{Reached, of_surface, together};
use crate::walls::rigid_seat_contact::Seat;
use facet_lists::Box3;
pub(crate) use facet_lists::SurfaceSurroundings;
use serde::{Deserialize, Serialize};
use tremie_grains_kit::space::wall_triangle::Triangle;
use tremie_team::{Variant, instructions::Work};

/// A sphere near a surface.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct SphereAtSurface {
    /// Id of the body, and where it stands in memory.
    id: u64,
    pub body: u32,
    /// Place of its force in the sum.
    pub place: u32,
    law: u16,
    reduced: Reduced,
    /// The contacts at the last accepted shape.
    history: WallContactHistory,
}

/// A surface with the bodies near it.
#[derive(Clone, Debug)]
pub(crate) struct SurfaceContacts {
    triangles: Vec<[u32; 3]>,
    vertices: usize,
    /// Index of the part that carries it, and how many times the whole is what spheres meet.
    pub carrier: usize,
    whole: f64,
    material: u16,
    /// Largest displacement of vertices until bodies and seats near them are listed anew [m].
    skin: f64,
    /// Vertices when they were, and whether that was in vain.
    listed: Vec<[f64; 3]>,
    stale: bool,
    /// Vertices of the last shape that was looked at, and how far any of them can have come since
    /// facets were listed [m].
    shape: Vec<[f64; 3]>,
    travel: f64,
    /// By the id of the body; `start[e]..start[e + 1]` are the places of entry e's facets.
    pub entries: Vec<SphereAtSurface>,
    start: Vec<u32>,
    facets: Vec<u32>,
    /// For each entry where it looked at all its facets last, and for each of these how far it was
    /// then.
    looked: Vec<LookedFrom>,
    distances: Vec<f32>,
    spare: Vec<SphereAtSurface>,
    /// Contact points of each entry's body at the shape that was taken last.
    found: Vec<WallPoints>,
    /// A box around the surface when facets were listed.
    bounds: Box3,
    groups: Vec<Box3>,
    pub seat: Seat,
    /// Loads on facets, where nobody asks for them.
    loads: Vec<FacetLoad>,
    /// Force on the carrier at the last accepted shape [N].
    pub on_carrier: Vec3,
}

/// Takes over coordinates, all of them numbers, and finds the largest change of any.
struct Take<'a> {
    now: &'a [f64],
    before: &'a mut [f64],
    farthest: &'a mut f64,
}

impl Work for Take<'_> {
    #[inline(always)]
    fn run(self) {
        let mut farthest = [0.0; 16];
        for (now, before) in self.now.chunks(16).zip(self.before.chunks_mut(16)) {
            for (farthest, (now, before)) in farthest.iter_mut().zip(now.iter().zip(before)) {
                let change = (now - *before).abs();
                // Without a branch, which vectors have not.
                *farthest = if change > *farthest { change } else { *farthest };
                *before = *now;
            }
        }
        *self.farthest = farthest.into_iter().fold(0.0, f64::max);
    }
}

/// Contact points of one sphere with a surface and the share of each. Other contacts of the sphere
/// lower these shares.
struct ActingContacts<'a> {
    found: WallPoints,
    shares: [f64; MOST],
    /// History of the contacts with rigid walls beside the surface.
    of_rigid: Option<&'a WallContactHistory>,
}

/// Reach of bodies, by their places, into rigid walls and into all surfaces; `number` is the index
/// of this surface.
pub(crate) struct WallsBeside<'a> {
    pub number: usize,
    pub rigid: &'a [Reached],
    pub soft: &'a [Reached],
}

/// Stiffness of a contact against retreat [N/m]: the fall of its normal force as the surface
/// retreats through a substep. It is the spring's slope and the dashpot over the substep; 0 where
/// the contact does not push.
fn retreat(law: &Law, pair: Reduced, overlap: f64, normal: f64, steps: Steps) -> f64 {
    if normal == 0.0 {
        return 0.0;
    }
    let dashpot = law.at(overlap, overlap, pair).gamma_n;
    law.normal_slope(overlap, pair) + dashpot / steps.after
}

/// Vertices are listed anew when one has gone by this part of the mean edge.
const SKIN: f64 = 0.1;

impl SurfaceContacts {
    /// Contacts of a valid surface.
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
            shape: surface.vertices.clone(),
            travel: 0.0,
            entries: Vec::new(),
            start: vec![0],
            facets: Vec::new(),
            looked: Vec::new(),
            distances: Vec::new(),
            spare: Vec::new(),
            found: Vec::new(),
            bounds: Box3::of(surface.vertices.iter().map(|&x| x.into())),
            groups: Vec::new(),
            seat: Seat::new(surface),
            loads: Vec::new(),
            on_carrier: Vec3::zeros(),
        }
    }

    /// Takes the facets to a shape, and finds where bodies touch it.
    pub fn look(&mut self, vertices: &[[f64; 3]], scenery: &ContactContext<'_>) {
        self.take_shape(vertices);
        for e in 0..self.entries.len() {
            self.found[e] = self.find(e, scenery);
        }
    }

    /// Adds what bodies reach of the shape that was looked at, and remember, to `reached` at their
    /// places; it is the surface of a `number`. Nothing, where bodies changed their places in
    /// memory since.
    pub fn give_reached(
        &self,
        number: usize,
        scenery: &ContactContext<'_>,
        reached: &mut [Reached],
    ) {
        if self.stale {
            return;
        }
        for (entry, found) in self.entries.iter().zip(&self.found) {
            let reached = &mut reached[entry.place as usize];
            let centre = scenery.bodies.balls[entry.body as usize].x;
            for near in found.contacts() {
                let near = WallPoint { point: near.point - centre, ..*near };
                reached.add(of_surface(near, number), (entry.law, entry.reduced));
            }
            if reached.history.held().is_empty() {
                reached.history = entry.history;
            }
        }
    }

    /// Contacts of the shape that was looked at as if it were accepted; adds what they do to
    /// facets.
    pub fn try_shape(
        &mut self,
        state: (&[[f64; 3]], &[[f64; 3]]),
        beside: &WallsBeside<'_>,
        scenery: &ContactContext<'_>,
        out: &mut Vec<FacetLoad>,
    ) {
        for e in 0..self.entries.len() {
            let contacts = self.contacts(e, beside, scenery);
            self.meet(&contacts, (e, None), state.1, scenery, &mut Tally::default(), out);
        }
        self.seat.push(state.0, out);
    }

    /// Contacts of the shape that was looked at, which is accepted: histories go on, forces on
    /// bodies are added to `wrench`.
    pub fn accept(
        &mut self,
        state: (&[[f64; 3]], &[[f64; 3]]),
        beside: &WallsBeside<'_>,
        scenery: &ContactContext<'_>,
        wrench: &mut [Wrench],
        tally: &mut Tally,
    ) {
        let mut out = std::mem::take(&mut self.loads);
        out.clear();
        for e in 0..self.entries.len() {
            let contacts = self.contacts(e, beside, scenery);
            if contacts.found.contacts().is_empty() {
                self.entries[e].history.clear();
                continue;
            }
            let mut entry =
                SphereAtSurface { history: WallContactHistory::NONE, ..self.entries[e] };
            let kept = Some(&mut entry);
            let on_body = self.meet(&contacts, (e, kept), state.1, scenery, tally, &mut out);
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

    /// Takes the facets to a shape.
    fn take_shape(&mut self, vertices: &[[f64; 3]]) {
        if self.entries.is_empty() {
            return;
        }
        let mut farthest = 0.0;
        let (now, before) = (vertices.as_flattened(), self.shape.as_flattened_mut());
        Variant::widest().run(Take { now, before, farthest: &mut farthest });
        self.travel += 3f64.sqrt() * farthest * (1.0 + 1e-9);
    }

    /// A facet as it is in the shape that was taken.
    fn triangle(&self, facet: u32) -> Triangle {
        Triangle::of(self.triangles[facet as usize].map(|v| self.shape[v as usize].into()))
    }

    /// The places where one sphere touches.
    fn find(&mut self, e: usize, scenery: &ContactContext<'_>) -> WallPoints {
        let BoundingSphere { x: centre, radius } =
            scenery.bodies.balls[self.entries[e].body as usize];
        let own = self.start[e] as usize..self.start[e + 1] as usize;
        let sphere = Seeker { centre, radius, reach: radius };
        let mut looked = self.looked[e];
        // Apart from the rest, which the triangles are made from.
        let mut distances = std::mem::take(&mut self.distances);
        let triangle = |k: usize| self.triangle(self.facets[own.start + k]);
        let found = mesh_contact::find(
            sphere,
            self.travel,
            &mut looked,
            &mut distances[own.clone()],
            triangle,
        );
        (self.distances, self.looked[e]) = (distances, looked);
        found
    }

    /// The contacts of one sphere where it was found to touch, and the share of each.
    fn contacts<'a>(
        &self,
        e: usize,
        beside: &WallsBeside<'a>,
        scenery: &ContactContext<'_>,
    ) -> ActingContacts<'a> {
        let entry = &self.entries[e];
        let ball = &scenery.bodies.balls[entry.body as usize];
        let rigid = &beside.rigid[entry.place as usize];
        if !rigid.is_empty() && !self.found[e].contacts().is_empty() {
            let soft = &beside.soft[entry.place as usize];
            let (found, mut shares) = together(rigid, soft, ball.radius, scenery.laws);
            let own = of_surface(WallPoint::NONE, beside.number).owner;
            for (near, share) in found.contacts().iter().zip(&mut shares) {
                *share = if near.owner == own { *share } else { 0.0 };
            }
            let of_rigid = Some(&rigid.history);
            return ActingContacts { found: found.moved_by(ball.x), shares, of_rigid };
        }
        let law = &scenery.laws[entry.law as usize];
        let found = self.found[e];
        let root = |near: &WallPoint| law.normal_root(ball.radius - near.distance, entry.reduced);
        let shares = shares(found.contacts(), root);
        ActingContacts { found, shares, of_rigid: None }
    }

    /// The contacts of one sphere where it was found to touch: the force on it, and in `kept`,
    /// which remembers none, what its entry remembers then.
    fn meet(
        &self,
        contacts: &ActingContacts<'_>,
        (e, mut kept): (usize, Option<&mut SphereAtSurface>),
        velocities: &[[f64; 3]],
        scenery: &ContactContext<'_>,
        tally: &mut Tally,
        out: &mut Vec<FacetLoad>,
    ) -> Wrench {
        let entry = &self.entries[e];
        let body = entry.body as usize;
        let (ball, twist) = (&scenery.bodies.balls[body], &scenery.bodies.predicted[body]);
        let facets = &self.facets[self.start[e] as usize..self.start[e + 1] as usize];
        let (reduced, steps) = (entry.reduced, scenery.steps);
        let mut on_body = Wrench::zero();
        let law = &scenery.laws[entry.law as usize];
        let ActingContacts { found, shares, of_rigid } = contacts;
        let acting = found.contacts().iter().zip(*shares).filter(|(_, share)| *share > 0.0);
        for (near, share) in acting {
            let facet = facets[near.triangle as usize];
            let n = -near.normal;
            let overlap = ball.radius - near.distance;
            let arm = ball.radius - 0.5 * overlap;
            let surface = self.velocity(facet, near, velocities);
            let contact = Contact {
                normal: n,
                overlap,
                velocity: (twist.v - surface) + twist.w.cross(&n) * arm,
                twist: 0.5 * twist.w.dot(&n),
                rolling: twist.w,
            };
            // A sphere may come from a rigid wall beside: its friction goes on.
            let heir = entry.history.heir(n).or_else(|| of_rigid.as_ref()?.heir(n));
            let mut memory = heir.unwrap_or_default();
            let f =
                contact_force::force(law, reduced, &contact, &mut memory, heir.is_some(), steps);
            if let Some(kept) = &mut kept {
                kept.history.add(Remembered { memory, share, law: entry.law, reduced });
            }
            let force = (f.tangential - n * f.normal) * share;
            on_body.force += force;
            on_body.torque += (n.cross(&f.tangential) * arm + f.rolling) * share;
            let point = (ball.x + n * arm).into();
            let stiffness = self.whole * share * retreat(law, reduced, overlap, f.normal, steps);
            out.push(FacetLoad { facet, force: (force * -self.whole).into(), point, stiffness });
            tally.add(overlap / ball.radius, entry.body, Other::Surface(self.carrier as u32));
        }
        on_body
    }

    /// Velocity of the surface at a point of a facet: that of its corners in the point's shares.
    fn velocity(&self, facet: u32, near: &WallPoint, velocities: &[[f64; 3]]) -> Vec3 {
        let vertices = self.triangles[facet as usize];
        let [u, v, w] = vertices.map(|vertex| Vec3::from(velocities[vertex as usize]));
        let [a, b, c] = vertices.map(|vertex| Vec3::from(self.shape[vertex as usize]));
        let (ab, ac, ap) = (b - a, c - a, near.point - a);
        let (bb, bc, cc) = (ab.dot(&ab), ab.dot(&ac), ac.dot(&ac));
        let (pb, pc) = (ap.dot(&ab), ap.dot(&ac));
        let scale = 1.0 / (bb * cc - bc * bc);
        let (s, t) = ((cc * pb - bc * pc) * scale, (bb * pc - bc * pb) * scale);
        u + (v - u) * s + (w - u) * t
    }

    /// Energy in the springs of spheres' contacts and of the seat, of which the domain has a share
    /// [J].
    pub fn elastic_energy(&self, laws: &[Law]) -> f64 {
        let of = |entry: &SphereAtSurface| entry.history.elastic_energy(laws);
        self.entries.iter().map(of).sum::<f64>() + self.seat.energy / self.whole
    }
}
