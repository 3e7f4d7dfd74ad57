//! Waiting for a peer that answers within microseconds.

use crate::bell::Wait;
use std::time::{Duration, Instant};

/// Looks before the processor is given to others: a few microseconds. Where there are more
/// processes than processors, the peer may wait for this very one.
const LOOKS: u32 = 32;
/// A peer that takes longer than this is busy with something else: looks become rarer.
const PROMPT: Duration = Duration::from_millis(20);
/// Between two looks at a peer that is not prompt.
const NAP: Duration = Duration::from_micros(100);

/// Looks some times, as long as a peer takes that answers at once, without giving way to others.
///
/// # Errors
/// Whatever `check` fails with.
pub fn look<T, E>(mut check: impl FnMut() -> Result<Option<T>, E>) -> Result<Option<T>, E> {
    for _ in 0..LOOKS {
        if let Some(found) = check()? {
            return Ok(Some(found));
        }
        std::hint::spin_loop();
    }
    Ok(None)
}

/// Waits until `check` gives something, at most until `deadline`, without a bell: looks again and
/// again, giving way to others, and naps only where the answer takes long.
///
/// For exchanges inside a window, where ringing and being woken would cost more than the work;
/// after [`look`].
///
/// # Errors
/// Whatever `check` fails with.
pub fn spin<T, E>(
    deadline: Instant,
    mut check: impl FnMut() -> Result<Option<T>, E>,
) -> Result<Wait<T>, E> {
    let begin = Instant::now();
    loop {
        let now = Instant::now();
        if now >= deadline {
            return Ok(Wait::TimedOut);
        }
        if now - begin < PROMPT {
            rustix::thread::sched_yield();
        } else {
            std::thread::sleep(NAP);
        }
        if let Some(found) = check()? {
            return Ok(Wait::Ready(found));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_with_what_is_found_with_an_error_or_at_the_deadline() {
        let far = Instant::now() + Duration::from_secs(60);
        let mut looks = 0;
        let found = spin(far, || {
            looks += 1;
            Ok::<_, ()>((looks > 5).then_some(looks))
        });
        assert_eq!(found, Ok(Wait::Ready(6)));
        assert_eq!(look(|| Ok::<_, ()>(Some(3))), Ok(Some(3)));
        assert_eq!(look(|| Ok::<Option<()>, ()>(None)), Ok(None));
        assert_eq!(look(|| Err::<Option<()>, _>("broken")), Err("broken"));
        assert_eq!(spin(far, || Err::<Option<()>, _>("broken")), Err("broken"));
        let soon = Instant::now() + Duration::from_millis(25);
        assert_eq!(spin(soon, || Ok::<Option<()>, ()>(None)), Ok(Wait::TimedOut));
        assert!(Instant::now() >= soon);
    }
}
