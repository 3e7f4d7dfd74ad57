//! Memory that stays with the process when it is given back.
//!
//! Poses and loads of many bodies are megabytes, several times a window. The C library would give each of them back to the system,
//! and ask for pages anew, which takes longer than all copies do.

/// Largest piece that is kept [bytes]; the C library allows no more.
#[cfg(target_env = "gnu")]
const PIECE: libc::c_int = 32 << 20;

/// Most that is kept [bytes].
#[cfg(target_env = "gnu")]
const KEPT: libc::c_int = 256 << 20;

/// Keeps memory from now on.
pub fn keep_memory() {
    #[cfg(target_env = "gnu")]
    // SAFETY: sets two numbers of the C library, before there is a second thread.
    unsafe {
        libc::mallopt(libc::M_MMAP_THRESHOLD, PIECE);
        libc::mallopt(libc::M_TRIM_THRESHOLD, KEPT);
    }
}
