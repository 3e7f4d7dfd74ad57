//! Contacts of one linear law, eight at once in registers of AVX-512.
//!
//! The formula is that of [`LinearLaw::forces`], whose bits it gives; what is here reads the bodies
//! and histories of eight contacts, each in few pieces, and turns rows into lanes and back.

use crate::Vec3;
use crate::bodies::body_arrays::{BLOCK, BoundingSphere};
use crate::contact::linear_contact::{Batch, LinearLaw, Outcome};
use crate::contact::springs::Reduced;
use crate::forces::pair_forces::Block;
use crate::forces::register_scan::{AHEAD, ROOM, TOGETHER, scan};
use crate::math::simd::avx512_wide::{Wide, columns, rows, transposed};
use crate::math::simd::lanes::{LANES, Lane3};
use crate::math::simd::prefetch::{fetch, fetch_value};
use crate::math::tally::{DEEP, Other};
use crate::neighbours::neighbour_list::{ACTING, ContactState, TOUCHING};
use core::arch::x86_64::*;
use tremie_grains_kit::space::periodic::SELF_IMAGE;

/// Entries within reach of forces, one beside the other. The bodies exist: who writes them looks,
/// also of what stands behind the last.
struct HitsAvx512 {
    count: usize,
    k: [u32; ROOM],
    i: [u32; ROOM],
    j: [u32; ROOM],
    /// Vectors from centre to centre, radii, 1 where they touched before, `sqrt(m*)`.
    numbers: [[f64; ROOM]; 7],
}

impl Block<'_> {
    /// Evaluates the contacts of the block.
    pub fn in_registers(&mut self, law: LinearLaw) {
        // SAFETY: a variant is chosen only where it is available.
        unsafe { evaluate(self, law) }
    }
}

#[target_feature(enable = "avx512f,avx512vl,avx512bw")]
fn evaluate(block: &mut Block<'_>, law: LinearLaw) {
    let mut hits = HitsAvx512 {
        count: 0,
        k: [0; ROOM],
        i: [0; ROOM],
        j: [0; ROOM],
        numbers: [[0.0; ROOM]; 7],
    };
    scan!(block, law, hits, LANES, find, fetch_motions, batch);
}

/// Fetches the motions of the others of the hits from `waiting` on.
#[target_feature(enable = "avx512f,avx512vl,avx512bw")]
#[inline]
fn fetch_motions(block: &Block<'_>, hits: &HitsAvx512, waiting: usize) {
    for &j in &hits.j[waiting..hits.count] {
        fetch_value(&block.scenery.bodies.predicted, j as usize);
    }
}

impl HitsAvx512 {
    /// Adds those that touch: numbers of the entries and of their bodies, and what the formula
    /// takes of them.
    #[target_feature(enable = "avx512f,avx512vl,avx512bw")]
    #[inline]
    fn add(&mut self, touches: __mmask8, who: [__m256i; 3], all: &[__m512d; 7]) {
        let at = self.count;
        assert!(at + LANES <= ROOM);
        // SAFETY: there is room for a register from `at` on in each array.
        unsafe {
            for (to, from) in [&mut self.k, &mut self.i, &mut self.j].into_iter().zip(who) {
                let packed = _mm256_maskz_compress_epi32(touches, from);
                _mm256_storeu_si256(to.as_mut_ptr().add(at).cast(), packed);
            }
            for (to, &from) in self.numbers.iter_mut().zip(all) {
                _mm512_storeu_pd(to.as_mut_ptr().add(at), _mm512_maskz_compress_pd(touches, from));
            }
        }
        self.count += touches.count_ones() as usize;
    }

    /// Forgets the first `count`.
    #[inline(always)]
    fn forget(&mut self, count: usize) {
        assert!(self.count <= count + LANES && count + LANES <= ROOM);
        // Fewer than a register wait; a whole one is moved at once.
        to_front(&mut self.k, count);
        to_front(&mut self.i, count);
        to_front(&mut self.j, count);
        self.numbers.iter_mut().for_each(|n| to_front(n, count));
        self.count -= count;
    }
}

/// Copies the numbers from `at` on, as many as a register holds, to the front.
#[inline(always)]
fn to_front<T: Copy + Default>(numbers: &mut [T; ROOM], at: usize) {
    let mut some = [T::default(); LANES];
    some.copy_from_slice(&numbers[at..at + LANES]);
    numbers[..LANES].copy_from_slice(&some);
}

/// Adds the entries within reach of forces, of as many from `k` on as a register holds; the others
/// forget that they touched.
#[target_feature(enable = "avx512f,avx512vl,avx512bw")]
#[inline]
fn find(block: &mut Block<'_>, k: usize, hits: &mut HitsAvx512) {
    let balls = &block.scenery.bodies.balls[..];
    let some = &block.entries[k..block.entries.len().min(k + LANES)];
    let count = some.len();
    let valid = (0xff >> (LANES - count)) as u8;
    if let Some(ahead) = block.entries.get(k + AHEAD..k + AHEAD + LANES) {
        ahead.iter().for_each(|entry| fetch(balls, entry.other as usize));
    }
    block.fetch_stream::<LANES>(k);
    // SAFETY: an entry is two numbers of 32 bits; no more are read than `some` holds.
    let entries = unsafe { _mm512_maskz_loadu_epi64(valid, some.as_ptr().cast()) };
    let other = _mm512_cvtepi64_epi32(entries);
    let tags = _mm512_cvtepi64_epi32(_mm512_srli_epi64::<32>(entries));
    let place = _mm256_and_si256(tags, _mm256_set1_epi32(BLOCK as i32 - 1));
    let body = _mm256_add_epi32(_mm256_set1_epi32(block.first as i32), place);
    let bodies = _mm256_set1_epi32(balls.len() as i32);
    let exist = _mm256_cmplt_epu32_mask(_mm256_max_epu32(other, body), bodies);
    assert!(exist == 0xff, "entries of bodies that are there");
    let (mut of_i, mut of_j) = ([0_u32; LANES], [0_u32; LANES]);
    // SAFETY: both have room for a register of 32 bytes.
    unsafe {
        _mm256_storeu_si256(of_i.as_mut_ptr().cast(), body);
        _mm256_storeu_si256(of_j.as_mut_ptr().cast(), other);
    }
    let [x_i, y_i, z_i, r_i, x_j, y_j, z_j, r_j] = spheres(balls, &of_i, &of_j);
    let images = _mm256_and_si256(_mm256_srli_epi32::<9>(tags), _mm256_set1_epi32(31));
    let shift = displacements(block.scenery.shifts, valid, images);
    let d = Lane3 {
        x: Wide(_mm512_add_pd(_mm512_sub_pd(x_j, x_i), shift[0])),
        y: Wide(_mm512_add_pd(_mm512_sub_pd(y_j, y_i), shift[1])),
        z: Wide(_mm512_add_pd(_mm512_sub_pd(z_j, z_i), shift[2])),
    };
    let reach = _mm512_add_pd(_mm512_add_pd(r_i, r_j), _mm512_set1_pd(block.scenery.reach));
    let touches = valid & _mm512_cmp_pd_mask::<_CMP_LT_OQ>(d.dot(d).0, _mm512_mul_pd(reach, reach));
    let touched = follow_state(block, (k, count), touches, (&of_i, &of_j));
    let touched = _mm512_maskz_mov_pd(touched, _mm512_set1_pd(1.0));
    let root_mass = root_masses(&block.reduced[k..k + count]);
    let numbers =
        _mm256_add_epi32(_mm256_set1_epi32(k as i32), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
    let all = [d.x.0, d.y.0, d.z.0, r_i, r_j, touched, root_mass];
    hits.add(touches, [numbers, body, other], &all);
}

/// Centres and radii of both bodies of some entries, which exist.
#[target_feature(enable = "avx512f,avx512vl,avx512bw")]
#[inline]
fn spheres(balls: &[BoundingSphere], of_i: &[u32; LANES], of_j: &[u32; LANES]) -> [__m512d; LANES] {
    let mut rows = [_mm512_setzero_pd(); LANES];
    for l in 0..LANES {
        // SAFETY: the caller looked that the bodies exist, and a ball is four numbers.
        rows[l] = unsafe {
            let i = _mm256_loadu_pd(balls.as_ptr().add(of_i[l] as usize).cast());
            let j = _mm256_loadu_pd(balls.as_ptr().add(of_j[l] as usize).cast());
            _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(i), j)
        };
    }
    transposed(rows)
}

/// Keeps the states of `count` entries from `k` on, within reach of forces or not, and notes
/// changes. Returns the entries that touched before.
#[target_feature(enable = "avx512f,avx512vl,avx512bw")]
#[inline]
fn follow_state(
    block: &mut Block<'_>,
    (k, count): (usize, usize),
    touches: __mmask8,
    (of_i, of_j): (&[u32; LANES], &[u32; LANES]),
) -> __mmask8 {
    let state = &mut block.state[k..k + count];
    let mut before = [0; LANES];
    let after = _mm_maskz_set1_epi8(u16::from(touches), (ACTING | TOUCHING) as i8);
    let after = _mm_cvtsi128_si64(after).to_le_bytes();
    // Whole registers without a mask, which makes stores slow.
    if let Ok(state) = <&mut [u8; LANES]>::try_from(&mut *state) {
        before = std::mem::replace(state, after);
    } else {
        before[..count].copy_from_slice(state);
        state.copy_from_slice(&after[..count]);
    }
    let before = _mm_cvtsi64_si128(i64::from_le_bytes(before));
    let mut changes = touches ^ _mm_test_epi8_mask(before, _mm_set1_epi8(ACTING as i8)) as u8;
    while changes != 0 {
        let l = changes.trailing_zeros() as usize;
        block.changed.note(of_i[l] as usize, of_j[l] as usize);
        changes &= changes - 1;
    }
    _mm_test_epi8_mask(before, _mm_set1_epi8(TOUCHING as i8)) as u8
}

/// `sqrt(m*)` of pairs, of no more than there are lanes.
#[target_feature(enable = "avx512f,avx512vl,avx512bw")]
#[inline]
fn root_masses(pairs: &[Reduced]) -> __m512d {
    const { assert!(size_of::<Reduced>() == 24 && core::mem::offset_of!(Reduced, root_mass) == 0) };
    let (numbers, valid) = (pairs.as_ptr().cast::<f64>(), (1u32 << (3 * pairs.len())) - 1);
    // SAFETY: a pair is three numbers; no more are read than the slice holds.
    unsafe {
        let low = _mm512_maskz_loadu_pd(valid as u8, numbers);
        let middle = _mm512_maskz_loadu_pd((valid >> 8) as u8, numbers.wrapping_add(LANES));
        let high = _mm512_maskz_loadu_pd((valid >> 16) as u8, numbers.wrapping_add(2 * LANES));
        let most = _mm512_permutex2var_pd(low, _mm512_setr_epi64(0, 3, 6, 9, 12, 15, 0, 0), middle);
        _mm512_permutex2var_pd(most, _mm512_setr_epi64(0, 1, 2, 3, 4, 5, 10, 13), high)
    }
}

/// Displacements of the images through which the others are seen; none in lanes that hold no entry.
#[target_feature(enable = "avx512f,avx512vl,avx512bw")]
#[inline]
fn displacements(shifts: &[Vec3; 27], valid: __mmask8, images: __m256i) -> [__m512d; 3] {
    let own = _mm256_set1_epi32(SELF_IMAGE as i32);
    let images = _mm256_mask_mov_epi32(own, valid, images);
    if _mm256_cmpeq_epi32_mask(images, own) == 0xff {
        return [_mm512_setzero_pd(); 3];
    }
    let mut numbers = [0_u32; LANES];
    // SAFETY: there is room for a register of 32 bytes.
    unsafe { _mm256_storeu_si256(numbers.as_mut_ptr().cast(), images) };
    let shifts = numbers.map(|image| shifts[image as usize]);
    let lane = |a: usize| shifts.map(|shift| shift[a]);
    // SAFETY: an array of eight numbers is read.
    [0, 1, 2].map(|a| unsafe { _mm512_loadu_pd(lane(a).as_ptr()) })
}

/// Evaluates `count` contacts from `at` on.
#[target_feature(enable = "avx512f,avx512vl,avx512bw")]
#[inline]
fn batch(block: &mut Block<'_>, law: &LinearLaw, hits: &HitsAvx512, at: usize, count: usize) {
    let input = read(block, hits, at);
    let out = law.forces(&input, block.scenery.steps);
    write(block, &out, &input.xi, (hits, at, count));
}

/// Input of the formula for the hits from `at` on.
#[target_feature(enable = "avx512f,avx512vl,avx512bw")]
#[inline]
fn read(block: &Block<'_>, hits: &HitsAvx512, at: usize) -> Batch<Wide> {
    let predicted = &block.scenery.bodies.predicted[..];
    let some = at..at + LANES;
    let (of_k, of_i, of_j) = (&hits.k[some.clone()], &hits.i[some.clone()], &hits.j[some]);
    // Lanes beyond the last hit hold what was there before, or nought; nobody takes them.
    let mut motion = [_mm512_setzero_pd(); LANES];
    let mut rest = motion;
    let mut normals = [_mm256_setzero_pd(); LANES];
    for l in 0..LANES {
        let (k, i, j) = (of_k[l] as usize, of_i[l] as usize, of_j[l] as usize);
        debug_assert!(i < predicted.len() && j < predicted.len() && k < block.records.len());
        // SAFETY: the bodies exist, and a twist is six numbers; the entry does, and `evaluate`
        // looked that each has a record and a displacement; no more is read than these have.
        unsafe {
            let (record, xi) = (block.records.get_unchecked(k), block.xi.get_unchecked(k));
            let i = _mm512_maskz_loadu_pd(0x3f, predicted.as_ptr().add(i).cast());
            let j = predicted.as_ptr().add(j).cast::<f64>();
            let relative = _mm512_mask_sub_pd(i, 7, i, _mm512_maskz_loadu_pd(7, j));
            motion[l] = relative;
            let w_j = _mm256_maskz_loadu_pd(7, j.add(3));
            let xi = _mm256_maskz_loadu_pd(7, xi.as_ptr());
            rest[l] = _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(w_j), xi);
            normals[l] = _mm256_loadu_pd(std::ptr::from_ref(record).cast());
        }
    }
    let [v_x, v_y, v_z, w_x, w_y, w_z, _, _] = transposed(motion).map(Wide);
    let [u_x, u_y, u_z, _, xi_x, xi_y, xi_z, _] = transposed(rest).map(Wide);
    let [n_x, n_y, n_z] = columns(normals).map(Wide);
    let number = |which: usize| {
        // SAFETY: there is room for a register from each place that `at` can be.
        Wide(unsafe { _mm512_loadu_pd(hits.numbers[which][at..at + LANES].as_ptr()) })
    };
    Batch {
        d: Lane3 { x: number(0), y: number(1), z: number(2) },
        radius_i: number(3),
        radius_j: number(4),
        v: Lane3 { x: v_x, y: v_y, z: v_z },
        w_i: Lane3 { x: w_x, y: w_y, z: w_z },
        w_j: Lane3 { x: u_x, y: u_y, z: u_z },
        xi: Lane3 { x: xi_x, y: xi_y, z: xi_z },
        old: Lane3 { x: n_x, y: n_y, z: n_z },
        touching: number(5),
        root_mass: number(6),
    }
}

/// Keeps the results of the formula for the first `count` of the hits from `at` on, which had the
/// displacements `xi`.
#[target_feature(enable = "avx512f,avx512vl,avx512bw")]
#[inline]
fn write(
    block: &mut Block<'_>,
    out: &Outcome<Wide>,
    xi: &Lane3<Wide>,
    (hits, at, count): (&HitsAvx512, usize, usize),
) {
    let of_k = &hits.k[at..at + LANES];
    // Rounding: where the distance was a hair less than the reach they do not touch after all.
    let valid = (0xff >> (LANES - count)) as u8;
    let overlap = out.overlap.0;
    let touches = valid & _mm512_cmp_pd_mask::<_CMP_GT_OQ>(overlap, _mm512_setzero_pd());
    let keep = |value: Wide| _mm512_maskz_mov_pd(touches, value.0);
    let (n, t) = (out.normal, out.tangential);
    let tangential = [keep(t.x), keep(t.y), keep(t.z)];
    let [t_x, t_y, t_z] = tangential;
    let records = transposed([n.x.0, n.y.0, n.z.0, t_x, t_y, t_z, keep(out.force), overlap]);
    let changed = |new: Wide, old: Wide| _mm512_mask_mov_pd(old.0, touches, new.0);
    let xi = rows([changed(out.xi.x, xi.x), changed(out.xi.y, xi.y), changed(out.xi.z, xi.z)]);
    for l in 0..LANES {
        if l < count {
            let k = of_k[l] as usize;
            // SAFETY: as in `read`; a record is a register of eight numbers, a displacement three.
            unsafe {
                let record = block.records.get_unchecked_mut(k);
                let to = block.xi.get_unchecked_mut(k);
                _mm512_store_pd(std::ptr::from_mut::<ContactState>(record).cast(), records[l]);
                let to = to.as_mut_ptr();
                _mm_storeu_pd(to, _mm256_castpd256_pd128(xi[l]));
                _mm_store_sd(to.add(2), _mm256_extractf128_pd::<1>(xi[l]));
            }
        }
    }
    if touches != valid {
        for l in (0..count).filter(|l| touches >> l & 1 == 0) {
            block.state[of_k[l] as usize] = ACTING;
        }
    }
    tally(block, out.ratio, touches, (hits, at, count));
}

/// Counts the contacts of a batch that touch.
#[target_feature(enable = "avx512f,avx512vl,avx512bw")]
#[inline]
fn tally(
    block: &mut Block<'_>,
    ratio: Wide,
    touches: __mmask8,
    (hits, at, count): (&HitsAvx512, usize, usize),
) {
    let above =
        |bound: f64| touches & _mm512_cmp_pd_mask::<_CMP_GT_OQ>(ratio.0, _mm512_set1_pd(bound));
    block.tally.count(touches.count_ones(), above(DEEP).count_ones());
    let deepest = above(block.tally.deepest.ratio);
    if deepest != 0 {
        let mut ratios = [0.0; LANES];
        // SAFETY: there is room for a register.
        unsafe { _mm512_storeu_pd(ratios.as_mut_ptr(), ratio.0) };
        for l in (0..count).filter(|l| deepest >> l & 1 == 1) {
            block.tally.deepen(ratios[l], hits.i[at + l], Other::Body(hits.j[at + l]));
        }
    }
}
