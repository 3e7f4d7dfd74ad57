//! Asking for memory before it is needed.

/// Brings `values[index]` towards the processor, if it is there; changes nothing that can be seen.
#[inline(always)]
pub(crate) fn fetch<T>(values: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    if let Some(value) = values.get(index) {
        fetch_line(std::ptr::from_ref(value).cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (values, index);
}

/// As [`prefetch`], where nobody need look whether the value is there.
#[inline(always)]
pub(crate) fn fetch_ahead<T>(values: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    fetch_line(values.as_ptr().wrapping_add(index).cast());
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (values, index);
}

/// Brings the line of memory that a place lies in, which need not exist, towards the processor.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(crate) fn fetch_line(place: *const i8) {
    use core::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
    // SAFETY: a prefetch reads nothing.
    unsafe { _mm_prefetch::<_MM_HINT_T0>(place) };
}

/// Brings a value of less than a line, which need not be there and may lie in two, towards the
/// processor.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(crate) fn fetch_value<T>(values: &[T], index: usize) {
    let place = values.as_ptr().wrapping_add(index).cast::<i8>();
    fetch_line(place);
    fetch_line(place.wrapping_add(size_of::<T>() - 1));
}

/// Brings each line of `COUNT` values from `index` on, which need not be there, towards the
/// processor.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(crate) fn fetch_lines<T, const COUNT: usize>(values: &[T], index: usize) {
    let first = values.as_ptr().wrapping_add(index).cast::<i8>();
    for byte in (0..COUNT * size_of::<T>()).step_by(64) {
        fetch_line(first.wrapping_add(byte));
    }
}
