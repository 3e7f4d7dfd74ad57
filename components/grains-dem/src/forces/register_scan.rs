//! The scan for pairs that touch, as far as registers of all lengths have it in common.
//!
//! Entries are looked at in their order, a register of them at once. Those that act are set one
//! beside the other, and evaluated by whole batches while what they need is close.

use crate::forces::pair_forces::Block;
use crate::math::simd::lanes::LANES;
use crate::math::simd::prefetch::fetch_lines;

/// Number of entries scanned before the acting ones are evaluated: few enough to stay in the cache.
pub(crate) const TOGETHER: usize = 128;

/// Number of entries by which bodies are fetched ahead.
pub(crate) const AHEAD: usize = 32;

/// Number of entries by which arrays that are read in order are fetched ahead.
const STREAM: usize = 96;

/// Room for the acting entries, for entries that wait until a batch is full, and a whole register
/// at the end.
pub(crate) const ROOM: usize = TOGETHER + 2 * LANES;

/// Looks through the entries of a block: `find` adds those of a register that act to `hits`,
/// `fetch` asks for the motions of those since a place, and `batch` evaluates some. A macro, for
/// what a function calls is not compiled for its registers.
macro_rules! scan {
    ($block:ident, $law:ident, $hits:ident, $step:ident, $find:ident, $fetch:ident, $batch:ident) => {
        let entries = $block.entries.len();
        assert!(entries <= $block.records.len() && entries <= $block.xi.len());
        for begin in (0..entries).step_by(TOGETHER) {
            let end = entries.min(begin + TOGETHER);
            let waiting = $hits.count;
            for k in (begin..end).step_by($step) {
                $find($block, k, &mut $hits);
            }
            $fetch($block, &$hits, waiting);
            // Whole batches at once; the rest waits for company.
            let ready = if end == entries { $hits.count } else { $hits.count / LANES * LANES };
            for at in (0..ready).step_by(LANES) {
                $batch($block, &$law, &$hits, at, LANES.min(ready - at));
            }
            $hits.forget(ready);
        }
    };
}
pub(crate) use scan;

impl Block<'_> {
    /// Fetches what is read one after the other, of a register of entries well behind the entry k.
    #[inline(always)]
    pub fn fetch_stream<const COUNT: usize>(&self, k: usize) {
        fetch_lines::<_, COUNT>(self.entries, k + STREAM);
        fetch_lines::<_, COUNT>(self.reduced, k + STREAM);
        fetch_lines::<_, COUNT>(self.xi, k + STREAM);
        fetch_lines::<_, COUNT>(self.records, k + STREAM);
    }
}
