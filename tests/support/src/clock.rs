//! Time that a thread spends on a processor, and waiting.

use std::time::{Duration, Instant};

/// Seconds that this thread has spent on a processor, whatever other programs do. Where the system
/// does not tell, the seconds since the first call.
///
/// (`/proc/thread-self/schedstat` tells it too, but on some systems in steps of a scheduler's
/// tick.)
pub fn processor_seconds() -> f64 {
    of_thread().unwrap_or_else(|| {
        thread_local!(static START: Instant = Instant::now());
        START.with(|start| start.elapsed().as_secs_f64())
    })
}

#[cfg(target_os = "linux")]
fn of_thread() -> Option<f64> {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the time is written where it points to.
    let refused = unsafe { libc::clock_gettime(libc::CLOCK_THREAD_CPUTIME_ID, &mut time) };
    (refused == 0).then_some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64)
}

#[cfg(not(target_os = "linux"))]
fn of_thread() -> Option<f64> {
    None
}

/// Waits, long enough for any machine, until something holds.
#[track_caller]
pub fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !holds() {
        assert!(begin.elapsed() < Duration::from_secs(60), "in vain: {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}
