//! Contacts of one linear law, twice four at once in registers of AVX2.
//!
//! The formula is that of [`LinearLaw::forces`], whose bits it gives; what is here reads the bodies
//! and histories of four contacts, each in few pieces, and turns rows into lanes and back. The twin
//! of it for registers of twice the length is `avx512`, which has other instructions to pack and to
//! mask.

use crate::Vec3;
use crate::bodies::body_arrays::BLOCK;
use crate::bodies::body_arrays::BoundingSphere;
use crate::contact::linear_contact::{Batch, LinearLaw, Outcome};
use crate::forces::pair_forces::Block;
use crate::forces::register_scan::{AHEAD, ROOM, TOGETHER, scan};
use crate::math::simd::avx2_quad::{QUAD, Quad, transposed};
use crate::math::simd::lanes::{LANES, Lane3};
use crate::math::simd::prefetch::{fetch_ahead, fetch_value};
use crate::math::tally::{DEEP, Other};
use crate::neighbours::neighbour_list::{ACTING, ContactState, ListedPair, TOUCHING};
use core::arch::x86_64::*;
use tremie_grains_kit::space::periodic::SELF_IMAGE;

/// A bit in the lowest place of each byte of a word.
const BIT_OF_EACH: u32 = 0x0101_0101;

/// The four bits of a mask, each in a byte of its own.
const SPREAD: [u32; 1 << QUAD] = {
    let mut spread = [0; 1 << QUAD];
    let mut mask = 0;
    while mask < 1 << QUAD {
        let mut lane = 0;
        while lane < QUAD {
            spread[mask] |= ((mask as u32 >> lane) & 1) << (8 * lane);
            lane += 1;
        }
        mask += 1;
    }
    spread
};

/// Entries within reach of forces, one beside the other. The entries and their bodies exist: who
/// writes them looks, also of what stands behind the last.
struct HitsAvx2 {
    count: usize,
    k: [u32; ROOM],
    /// 1 where they touched before.
    touched: [u8; ROOM],
    /// Vectors from centre to centre, and the radius of the body of the entry.
    rows: [[f64; QUAD]; ROOM],
}

impl Block<'_> {
    /// Evaluates the contacts of the block.
    pub fn in_quads(&mut self, law: LinearLaw) {
        // SAFETY: a variant is chosen only where it is available.
        unsafe { evaluate(self, law) }
    }
}

#[target_feature(enable = "avx2,fma")]
fn evaluate(block: &mut Block<'_>, law: LinearLaw) {
    let mut hits =
        HitsAvx2 { count: 0, k: [0; ROOM], touched: [0; ROOM], rows: [[0.0; QUAD]; ROOM] };
    scan!(block, law, hits, QUAD, find, fetch_motions, batch);
}

/// Fetches the motions of the others of the hits from `waiting` on.
#[target_feature(enable = "avx2,fma")]
#[inline]
fn fetch_motions(block: &Block<'_>, hits: &HitsAvx2, waiting: usize) {
    for &k in &hits.k[waiting..hits.count] {
        let other = block.entries[k as usize].other as usize;
        fetch_value(&block.scenery.bodies.predicted, other);
    }
}

impl HitsAvx2 {
    /// Forgets the first `count`.
    #[inline(always)]
    fn forget(&mut self, count: usize) {
        self.k.copy_within(count..self.count, 0);
        self.touched.copy_within(count..self.count, 0);
        self.rows.copy_within(count..self.count, 0);
        self.count -= count;
    }
}

/// Adds the entries within reach of forces, of as many from `k` on as a register holds; the others
/// forget that they touched.
#[target_feature(enable = "avx2,fma")]
#[inline]
fn find(block: &mut Block<'_>, k: usize, hits: &mut HitsAvx2) {
    let scenery = block.scenery;
    let balls = &scenery.bodies.balls[..];
    let some = &block.entries[k..block.entries.len().min(k + QUAD)];
    let count = some.len();
    if let Some(ahead) = block.entries.get(k + AHEAD..k + AHEAD + QUAD) {
        for entry in ahead {
            fetch_ahead(balls, entry.other as usize);
        }
    }
    block.fetch_stream::<QUAD>(k);
    // Lanes that hold no entry hold the first body and itself.
    let mut short = [ListedPair::new(block.first, block.first as u32, SELF_IMAGE, 0); QUAD];
    let entries = some.try_into().unwrap_or_else(|_| {
        short[..count].copy_from_slice(some);
        &short
    });
    assert!(exist(entries, block.first, balls.len()), "entries of bodies that are there");
    let shift = displacements(scenery.shifts, entries);
    let (mut tested, mut kept) = ([_mm256_setzero_pd(); QUAD], [_mm256_setzero_pd(); QUAD]);
    for l in 0..QUAD {
        const { assert!(size_of::<BoundingSphere>() == 32) };
        let (i, j) = (entries[l].body(block.first), entries[l].other as usize);
        // SAFETY: the bodies exist, and a ball is four numbers.
        let (i, j) = unsafe {
            let at = |body| _mm256_loadu_pd(balls.as_ptr().add(body).cast());
            (at(i), at(j))
        };
        let d = _mm256_add_pd(_mm256_sub_pd(j, i), shift[l]);
        tested[l] = _mm256_blend_pd::<0b1000>(d, _mm256_add_pd(i, j));
        kept[l] = _mm256_blend_pd::<0b1000>(d, i);
    }
    let [x, y, z, radii] = transposed(tested).map(Quad);
    let d = Lane3 { x, y, z };
    let reach = _mm256_add_pd(radii.0, _mm256_set1_pd(scenery.reach));
    let square = _mm256_mul_pd(reach, reach);
    let touches = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LT_OQ>(d.dot(d).0, square));
    let touches = touches as usize & (0xf >> (QUAD - count));

    let touched = follow_state(block, k, entries, (touches, count));
    let mut at = hits.count;
    assert!(at + QUAD <= ROOM);
    for l in 0..QUAD {
        // Without a branch: which pairs of a list touch cannot be foretold. Entries that are not
        // there are not written, so that those behind the last hit exist too.
        hits.k[at] = (k + l.min(count - 1)) as u32;
        hits.touched[at] = touched[l];
        // SAFETY: a row is four numbers.
        unsafe { _mm256_storeu_pd(hits.rows[at].as_mut_ptr(), kept[l]) };
        at += touches >> l & 1;
    }
    hits.count = at;
}

/// Keeps the states of `count` entries from `k` on, within reach of forces or not, and notes
/// changes. Returns 1 for each that touched before.
#[target_feature(enable = "avx2,fma")]
#[inline]
fn follow_state(
    block: &mut Block<'_>,
    k: usize,
    entries: &[ListedPair; QUAD],
    (touches, count): (usize, usize),
) -> [u8; QUAD] {
    let state = &mut block.state[k..k + count];
    let mut before = [0; QUAD];
    let after = SPREAD[touches] * u32::from(ACTING | TOUCHING);
    if let Ok(state) = <&mut [u8; QUAD]>::try_from(&mut *state) {
        before = std::mem::replace(state, after.to_le_bytes());
    } else {
        before[..count].copy_from_slice(state);
        state.copy_from_slice(&after.to_le_bytes()[..count]);
    }
    let before = u32::from_le_bytes(before);
    const { assert!(ACTING == 1 && TOUCHING == 2) };
    let mut changes = (before ^ after) & BIT_OF_EACH;
    while changes != 0 {
        let l = changes.trailing_zeros() as usize / 8;
        block.changed.note(entries[l].body(block.first), entries[l].other as usize);
        changes &= changes - 1;
    }
    (before >> 1 & BIT_OF_EACH).to_le_bytes()
}

/// True if all bodies of these entries, of a block that begins at body `first`, are among the
/// `count` bodies.
#[target_feature(enable = "avx2,fma")]
#[inline]
fn exist(entries: &[ListedPair; QUAD], first: usize, count: usize) -> bool {
    const { assert!(size_of::<ListedPair>() == 8) };
    // SAFETY: an entry is two numbers of 32 bits, the other and the tags.
    let entries = unsafe { _mm256_loadu_si256(entries.as_ptr().cast()) };
    let others_alone = _mm256_set1_epi64x(u32::MAX.into());
    let other = _mm256_and_si256(entries, others_alone);
    let place =
        _mm256_and_si256(_mm256_srli_epi64::<32>(entries), _mm256_set1_epi64x(BLOCK as i64 - 1));
    let body = _mm256_add_epi64(_mm256_set1_epi64x(first as i64), place);
    let beyond = _mm256_set1_epi64x(count as i64);
    let both =
        _mm256_and_si256(_mm256_cmpgt_epi64(beyond, other), _mm256_cmpgt_epi64(beyond, body));
    _mm256_movemask_epi8(both) == -1
}

/// Displacements of the images through which the others are seen, with 0 as the fourth number.
#[target_feature(enable = "avx2,fma")]
#[inline]
fn displacements(shifts: &[Vec3; 27], entries: &[ListedPair; QUAD]) -> [__m256d; QUAD] {
    // No array of images: one that is written number by number and read as a whole stalls.
    let differ = entries.iter().fold(0, |differ, entry| differ | (entry.image() ^ SELF_IMAGE));
    let mut displacements = [_mm256_setzero_pd(); QUAD];
    if differ != 0 {
        for l in 0..QUAD {
            let shift = shifts[entries[l].image() as usize];
            displacements[l] = _mm256_setr_pd(shift.x, shift.y, shift.z, 0.0);
        }
    }
    displacements
}

/// Evaluates `count` contacts from `at` on.
#[target_feature(enable = "avx2,fma")]
#[inline]
fn batch(block: &mut Block<'_>, law: &LinearLaw, hits: &HitsAvx2, at: usize, count: usize) {
    const { assert!(LANES == 2 * QUAD) };
    // Lanes beyond the last hit hold what was there before, or nought; nobody takes them.
    let [first, second] = [at, at + QUAD].map(|at| std::array::from_fn(|l| hits.k[at + l]));
    let input = read(block, hits, at, &first).beside(read(block, hits, at + QUAD, &second));
    let [out, later] = law.forces(&input, block.scenery.steps).halves();
    write(block, &out, &first, QUAD.min(count));
    if count > QUAD {
        write(block, &later, &second, count - QUAD);
    }
}

/// Input of the formula for the entries `of_k`, the hits from `at` on.
#[target_feature(enable = "avx2,fma")]
#[inline]
fn read(block: &Block<'_>, hits: &HitsAvx2, at: usize, of_k: &[u32; QUAD]) -> Batch<Quad> {
    let bodies = block.scenery.bodies;
    let (balls, predicted) = (&bodies.balls[..], &bodies.predicted[..]);
    let mut root_mass = [0.0; QUAD];
    let none = [_mm256_setzero_pd(); QUAD];
    let (mut d, mut v, mut w_i, mut w_j, mut xi, mut old) = (none, none, none, none, none, none);
    let three = _mm256_setr_epi64x(-1, -1, -1, 0);
    for l in 0..QUAD {
        let k = of_k[l] as usize;
        let (i, j) = block.bodies(k);
        debug_assert!(i < predicted.len() && j < predicted.len() && k < block.records.len());
        root_mass[l] = block.reduced[k].root_mass;
        // SAFETY: `find` looked that the bodies of an entry exist; a ball is four numbers and a
        // twist six. `evaluate` looked that each entry has a record and a displacement; no more is
        // read than these have.
        unsafe {
            let motion_i = predicted.as_ptr().add(i).cast::<f64>();
            let motion_j = predicted.as_ptr().add(j).cast::<f64>();
            let ball_j = _mm256_loadu_pd(balls.as_ptr().add(j).cast());
            d[l] = _mm256_loadu_pd(hits.rows[at + l].as_ptr());
            let relative = _mm256_sub_pd(_mm256_loadu_pd(motion_i), _mm256_loadu_pd(motion_j));
            v[l] = _mm256_blend_pd::<0b1000>(relative, ball_j);
            w_i[l] = _mm256_loadu_pd(motion_i.add(2));
            w_j[l] = _mm256_loadu_pd(motion_j.add(2));
            let (record, displacement) = (block.records.as_ptr().add(k), block.xi.as_ptr().add(k));
            xi[l] = _mm256_maskload_pd(displacement.cast(), three);
            old[l] = _mm256_loadu_pd(record.cast());
        }
    }
    let [d_x, d_y, d_z, radius_i] = transposed(d).map(Quad);
    let [v_x, v_y, v_z, radius_j] = transposed(v).map(Quad);
    let [_, wi_x, wi_y, wi_z] = transposed(w_i).map(Quad);
    let [_, wj_x, wj_y, wj_z] = transposed(w_j).map(Quad);
    let [xi_x, xi_y, xi_z, _] = transposed(xi).map(Quad);
    let [n_x, n_y, n_z, _] = transposed(old).map(Quad);
    let touched: [u8; QUAD] = std::array::from_fn(|l| hits.touched[at + l]);
    let touched = _mm_cvtepu8_epi32(_mm_cvtsi32_si128(i32::from_le_bytes(touched)));
    Batch {
        d: Lane3 { x: d_x, y: d_y, z: d_z },
        radius_i,
        radius_j,
        v: Lane3 { x: v_x, y: v_y, z: v_z },
        w_i: Lane3 { x: wi_x, y: wi_y, z: wi_z },
        w_j: Lane3 { x: wj_x, y: wj_y, z: wj_z },
        xi: Lane3 { x: xi_x, y: xi_y, z: xi_z },
        old: Lane3 { x: n_x, y: n_y, z: n_z },
        touching: Quad(_mm256_cvtepi32_pd(touched)),
        root_mass: Quad(_mm256_setr_pd(root_mass[0], root_mass[1], root_mass[2], root_mass[3])),
    }
}

/// Keeps the results of the formula for the first `count` of the entries `of_k`.
#[target_feature(enable = "avx2,fma")]
#[inline]
fn write(block: &mut Block<'_>, out: &Outcome<Quad>, of_k: &[u32; QUAD], count: usize) {
    // Rounding: where the distance was a hair less than the reach they do not touch after all.
    let valid = 0xf >> (QUAD - count);
    let overlap = out.overlap.0;
    let touching = _mm256_cmp_pd::<_CMP_GT_OQ>(overlap, _mm256_setzero_pd());
    let touches = _mm256_movemask_pd(touching) & valid;
    let keep = |value: Quad| _mm256_and_pd(value.0, touching);
    let (n, t) = (out.normal, out.tangential);
    let first = transposed([n.x.0, n.y.0, n.z.0, keep(t.x)]);
    let second = transposed([keep(t.y), keep(t.z), keep(out.force), overlap]);
    let rows = transposed([out.xi.x.0, out.xi.y.0, out.xi.z.0, overlap]);
    for l in 0..count {
        let k = of_k[l] as usize;
        const { assert!(size_of::<ContactState>() == 64 && size_of::<Vec3>() == 24) };
        // SAFETY: `evaluate` looked that each entry has a record and a displacement; a record is
        // two registers of four numbers, a displacement three.
        unsafe {
            let record = block.records.as_mut_ptr().add(k).cast::<f64>();
            _mm256_store_pd(record, first[l]);
            _mm256_store_pd(record.add(QUAD), second[l]);
            if touches >> l & 1 == 1 {
                let to = block.xi.as_mut_ptr().add(k).cast::<f64>();
                _mm_storeu_pd(to, _mm256_castpd256_pd128(rows[l]));
                _mm_store_sd(to.add(2), _mm256_extractf128_pd::<1>(rows[l]));
            } else {
                block.state[k] = ACTING;
            }
        }
    }
    let above = |bound: f64| {
        let above = _mm256_cmp_pd::<_CMP_GT_OQ>(out.ratio.0, _mm256_set1_pd(bound));
        _mm256_movemask_pd(above) & touches
    };
    block.tally.count(touches.count_ones(), above(DEEP).count_ones());
    let deepest = above(block.tally.deepest.ratio);
    if deepest != 0 {
        let mut ratio = [0.0; QUAD];
        // SAFETY: there is room for a register.
        unsafe { _mm256_storeu_pd(ratio.as_mut_ptr(), out.ratio.0) };
        for l in (0..count).filter(|l| deepest >> l & 1 == 1) {
            let (i, j) = block.bodies(of_k[l] as usize);
            block.tally.deepen(ratio[l], i as u32, Other::Body(j as u32));
        }
    }
}
