//! Interrupts: Ctrl-C, and the signals that mean the same.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Counts the user's interrupts from now on.
///
/// # Errors
/// If the operating system refuses.
pub(super) fn count_interrupts() -> std::io::Result<Arc<AtomicUsize>> {
    let interrupts = Arc::new(AtomicUsize::new(0));
    let mut signals = signal_hook::iterator::Signals::new([
        signal_hook::consts::SIGINT,
        signal_hook::consts::SIGTERM,
        signal_hook::consts::SIGHUP,
    ])?;
    let count = interrupts.clone();
    let wait = move || {
        for _ in signals.forever() {
            count.fetch_add(1, Ordering::Relaxed);
        }
    };
    std::thread::Builder::new().spawn(wait)?;
    Ok(interrupts)
}
