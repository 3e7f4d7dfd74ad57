//! Storage of the populations: 19 planes over the stored cells, in one array.
//!
//! Populations are stored as deviations `h_i = f_i - w_i` from the fluid at rest at the reference
//! density 1, so that rounding is relative to the flow and not to the background pressure.
//!
//! Numbers are kept in atomics: passes over links and refilled cells run on several threads in
//! plain safe code, with relaxed loads and stores that cost what ordinary ones do. Only the
//! collision kernel, whose threads own disjoint places, goes through [`Field::base`].

use crate::lattice::d3q19::Q;
use std::alloc::{Layout, alloc, dealloc, handle_alloc_error};
use std::ptr::NonNull;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};
use tremie_state::StateNumber;
use tremie_team::simd::SimdVector;

/// A number of storage and collision: `f64` or `f32`.
pub trait Real: StateNumber + Copy + Send + Sync + PartialOrd + std::fmt::Debug + 'static {
    /// Atomic of the same layout.
    type Atomic: Send + Sync;
    /// The populations of a cell, as a state keeps them.
    type Row: StateNumber + AsMut<[Self]>;
    /// Count of numbers that fill 64 bytes.
    const LINE: usize;
    /// As f64, exact.
    fn to_f64(self) -> f64;
    /// Nearest value.
    fn from_f64(value: f64) -> Self;
    /// Reads without ordering.
    fn load(place: &Self::Atomic) -> Self;
    /// Writes without ordering.
    fn store(self, place: &Self::Atomic);
    /// Writes its bytes to as many.
    fn put(self, bytes: &mut [u8]);
    /// The number of as many bytes.
    fn get(bytes: &[u8]) -> Self;
}

/// A vector of numbers that the lattice stores.
pub trait LatticeVector: SimdVector<Scalar: Real> {}

impl<V: SimdVector<Scalar: Real>> LatticeVector for V {}

macro_rules! real {
    ($real:ty, $atomic:ty, $line:literal) => {
        impl Real for $real {
            type Atomic = $atomic;
            type Row = [$real; Q];
            const LINE: usize = $line;
            #[inline(always)]
            fn to_f64(self) -> f64 {
                self.into()
            }
            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                value as $real
            }
            #[inline(always)]
            fn load(place: &$atomic) -> Self {
                <$real>::from_bits(place.load(Relaxed))
            }
            #[inline(always)]
            fn store(self, place: &$atomic) {
                place.store(self.to_bits(), Relaxed);
            }
            #[inline(always)]
            fn put(self, bytes: &mut [u8]) {
                bytes.copy_from_slice(&self.to_ne_bytes());
            }
            #[inline(always)]
            fn get(bytes: &[u8]) -> Self {
                Self::from_ne_bytes(std::array::from_fn(|k| bytes[k]))
            }
        }
    };
}
real!(f64, AtomicU64, 8);
real!(f32, AtomicU32, 16);

/// Fetches a cache line that will be used soon. Any address will do.
#[inline(always)]
pub fn prefetch<T>(place: *const T) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a prefetch of any address is allowed, and every x86-64 processor has it.
    unsafe {
        core::arch::x86_64::_mm_prefetch::<{ core::arch::x86_64::_MM_HINT_T0 }>(place.cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = place;
}

/// Fetches a cache line that will be used later, no nearer than the second-level cache: the first
/// has no room for all that is under way. Any address will do.
#[inline(always)]
pub fn prefetch_early<T>(place: *const T) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: a prefetch of any address is allowed, and every x86-64 processor has it.
    unsafe {
        core::arch::x86_64::_mm_prefetch::<{ core::arch::x86_64::_MM_HINT_T1 }>(place.cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = place;
}

/// Large pages of the system; a step walks through 19 distant planes, which small pages would make
/// the processor look up over and over.
const LARGE_PAGE: usize = 2 << 20;

/// The populations of a list of cells. For their places see `aa_pattern`.
pub struct Field<T: Real> {
    first: NonNull<T::Atomic>,
    layout: Layout,
}

// SAFETY: the field owns its array of atomics, which may be used from any thread.
unsafe impl<T: Real> Send for Field<T> {}
// SAFETY: as above.
unsafe impl<T: Real> Sync for Field<T> {}

impl<T: Real> Field<T> {
    /// A fluid at rest in planes of `stride` numbers.
    pub fn new(stride: usize) -> Self {
        Self::zeros(stride * Q)
    }

    /// Room for `count` numbers, all zero.
    pub fn zeros(count: usize) -> Self {
        let bytes = (count * (64 / T::LINE)).max(1).next_multiple_of(LARGE_PAGE);
        let layout = Layout::from_size_align(bytes, LARGE_PAGE)
            .expect("a lattice that was resolved fits in memory");
        // SAFETY: the layout is not empty.
        let memory = unsafe { alloc(layout) };
        let Some(memory) = NonNull::new(memory) else { handle_alloc_error(layout) };
        #[cfg(target_os = "linux")]
        // SAFETY: the range is this allocation, whole pages of it; the advice changes no content.
        // It may be refused, which costs nothing but time.
        let _ = unsafe { libc::madvise(memory.as_ptr().cast(), bytes, libc::MADV_HUGEPAGE) };
        // SAFETY: the range is this allocation. Zero bits are the number 0.
        unsafe { memory.write_bytes(0, bytes) };
        Self { first: memory.cast(), layout }
    }

    /// Memory that planes of `stride` numbers take [bytes].
    pub fn bytes(stride: u64) -> u64 {
        (stride * Q as u64 * (64 / T::LINE as u64)).next_multiple_of(LARGE_PAGE as u64)
    }

    /// All places as atomics.
    #[inline(always)]
    fn places(&self) -> &[T::Atomic] {
        // SAFETY: the array holds that many numbers, was zeroed, is aligned beyond what an atomic
        // needs, and lives as long as `self`.
        unsafe {
            std::slice::from_raw_parts(
                self.first.as_ptr(),
                self.layout.size() / size_of::<T::Atomic>(),
            )
        }
    }

    /// Copies the numbers from a place on to a column of rows, or the column to there.
    pub fn exchange_column(&self, place: usize, i: usize, rows: &mut [T::Row], restores: bool) {
        for (place, row) in self.places()[place..].iter().zip(rows) {
            match restores {
                true => row.as_mut()[i].store(place),
                false => row.as_mut()[i] = T::load(place),
            }
        }
    }

    /// The number in a place.
    #[inline(always)]
    pub fn get(&self, place: usize) -> f64 {
        T::load(&self.places()[place]).to_f64()
    }

    /// The numbers in as many places as a line has, from one on.
    #[inline(always)]
    pub fn line(&self, first: usize) -> impl Iterator<Item = f64> {
        self.places()[first..first + T::LINE].iter().map(|place| T::load(place).to_f64())
    }

    /// Writes the nearest number to a place and returns it.
    #[inline(always)]
    pub fn set(&self, place: usize, value: f64) -> f64 {
        let value = T::from_f64(value);
        value.store(&self.places()[place]);
        value.to_f64()
    }

    /// Copies the numbers from a place on to as many bytes.
    #[inline]
    pub fn read_run(&self, place: usize, bytes: &mut [u8]) {
        let places = self.places()[place..].iter();
        for (place, bytes) in places.zip(bytes.chunks_exact_mut(size_of::<T>())) {
            T::load(place).put(bytes);
        }
    }

    /// Copies as many numbers from bytes to places from one on.
    #[inline]
    pub fn write_run(&self, place: usize, bytes: &[u8]) {
        let places = self.places()[place..].iter();
        for (place, bytes) in places.zip(bytes.chunks_exact(size_of::<T>())) {
            T::get(bytes).store(place);
        }
    }

    /// Fetches a place that will be used soon.
    #[inline(always)]
    pub fn prefetch(&self, place: usize) {
        prefetch(self.base().wrapping_add(place));
    }

    /// Start of the array, aligned to 64 bytes, for the collision kernel. Writing through it is
    /// sound while no other thread uses the same places: the storage has interior mutability.
    pub fn base(&self) -> *mut T {
        self.first.as_ptr().cast()
    }
}

impl<T: Real> Drop for Field<T> {
    fn drop(&mut self) {
        // SAFETY: allocated in `new` with this layout; atomics need no drop.
        unsafe { dealloc(self.first.as_ptr().cast(), self.layout) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_distinct_and_begin_at_rest() {
        fn check<T: Real>() {
            let field = Field::<T>::new(128);
            for place in 0..Q * 128 {
                assert_eq!(field.get(place), 0.0);
                field.set(place, place as f64);
            }
            for place in 0..Q * 128 {
                assert_eq!(field.get(place), place as f64);
            }
        }
        check::<f64>();
        check::<f32>();
    }
}
