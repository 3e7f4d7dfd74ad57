//! Time steps that fit: one coupling window, and a whole number of substeps in it for everyone.

use crate::manifest::MOST_SUBSTEPS;
use tremie_messages::Problem;
use tremie_messages::finding::short;
use tremie_messages::start::Clock;

/// Ratios this close to a whole number are that number: steps come from divisions.
pub const TOLERANCE: f64 = 1e-9;
/// Windows of a run in which nothing asks for a step.
const WINDOWS: f64 = 1000.0;
/// Most ticks in a run: every count of them is exact in a 64-bit float too.
const MOST_TICKS: f64 = 9.0e15;

/// Step that a component of the physics asks for.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Wish {
    /// The component.
    pub name: String,
    /// Its key in the manifest.
    pub key: String,
    /// Largest step that it may take [s]; `None`: any.
    pub step: Option<f64>,
    /// Cause that keeps it from being longer; empty where that is not known.
    pub limit: String,
    /// Substeps that the manifest fixes.
    pub sync_iter: Option<u32>,
}

/// Steps that fit.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Steps {
    pub clock: Clock,
    /// Windows until the end of the run.
    pub windows: u64,
    /// Substeps of each component, in the order of the wishes.
    pub substeps: Vec<u32>,
    /// Notes on what was adapted, in sentences.
    pub notes: Vec<String>,
}

impl Steps {
    /// Step of a component that makes `substeps` in a window [s]: a whole number of ticks.
    pub fn step(&self, substeps: u32) -> f64 {
        self.clock.tick * (self.clock.ticks_per_window / u64::from(substeps)) as f64
    }
}

/// Assigns steps for a run of `until` [s].
///
/// The component with the largest step sets the window. The window is one step of it, or
/// `sync_iter` steps where the manifest fixes that number. Of several with the same step, the one
/// with the fewest steps sets it. Every other component makes `n = ceil(window/step)` substeps. Its
/// step is shortened to `window/n`, and never lengthened. A fixed `sync_iter` is taken as it is,
/// and refused where it would lengthen a step. A component that can take any step takes the window,
/// or `window/sync_iter`. Where all can, as grains that can touch nothing, a thousand windows make
/// the run.
///
/// # Errors
/// A fixed `sync_iter` that cannot be, more than 1000 substeps, no component at all, or more
/// windows than can be counted.
pub(super) fn assign(wishes: &[Wish], until: f64) -> Result<Steps, Vec<Problem>> {
    let pace = pacemaker(wishes)?;
    let mut notes = Vec::new();
    let step = pace.step.unwrap_or_else(|| {
        let sync = pace.sync_iter.unwrap_or(1);
        notes.push(format!("{} can take any step: {WINDOWS} windows make the run", pace.name));
        until / (WINDOWS * f64::from(sync))
    });
    let window = step * f64::from(pace.sync_iter.unwrap_or(1));
    let mut problems = Vec::new();
    let mut substeps = Vec::new();
    for wish in wishes {
        match fit(wish, pace, window, &mut notes) {
            Ok(n) => substeps.push(n),
            Err(problem) => problems.push(problem),
        }
    }
    if !problems.is_empty() {
        return Err(problems);
    }
    let ticks_per_window =
        substeps.iter().fold(1, |common, n| least_common_multiple(common, u64::from(*n)));
    // Less the tolerance: a quotient just above a whole number must not add a window.
    let windows = (until / window - TOLERANCE).ceil().max(1.0);
    if windows * ticks_per_window as f64 > MOST_TICKS {
        let message = format!(
            "{until} s are {windows:e} windows of {} s, more than can be counted",
            short(window)
        );
        let help = format!("end earlier, or make steps longer{}", reason(pace));
        return Err(vec![Problem::new("run.until", message).help(help)]);
    }
    let end = windows * window;
    if (end - until).abs() > 1e-6 * window {
        notes.push(format!("the run ends at a whole window: {} s", short(end)));
    }
    let clock = Clock { tick: window / ticks_per_window as f64, ticks_per_window };
    Ok(Steps { clock, windows: windows as u64, substeps, notes })
}

/// The component whose step sets the window.
fn pacemaker(wishes: &[Wish]) -> Result<&Wish, Vec<Problem>> {
    let wrong = |wish: &&Wish| wish.step.is_some_and(|step| !(step.is_finite() && step > 0.0));
    let problems: Vec<_> = (wishes.iter().filter(wrong))
        .map(|wish| {
            let step = wish.step.unwrap_or_default();
            Problem::new(
                &wish.key,
                format!("{} asks for a step of {step} s, which is none", wish.name),
            )
        })
        .collect();
    if !problems.is_empty() {
        return Err(problems);
    }
    let slower = |a: &&Wish, b: &&Wish| {
        // Of equal steps the component with the fewest sets the window; the others make more steps
        // in it.
        let fewer = || b.sync_iter.unwrap_or(1).cmp(&a.sync_iter.unwrap_or(1));
        a.step.unwrap_or(0.0).total_cmp(&b.step.unwrap_or(0.0)).then_with(fewer)
    };
    let pace = wishes.iter().filter(|wish| wish.step.is_some()).max_by(slower);
    pace.or(wishes.first()).ok_or_else(|| {
        let message = "no component takes steps: expected a fluid, or grains";
        vec![Problem::new("components", message)]
    })
}

/// Substeps of one component.
fn fit(wish: &Wish, pace: &Wish, window: f64, notes: &mut Vec<String>) -> Result<u32, Problem> {
    let Some(step) = wish.step else {
        return Ok(wish.sync_iter.unwrap_or(1));
    };
    let ratio = window / step;
    // Rounded up: a step is shortened, never lengthened beyond what is stable.
    let needed = (ratio - TOLERANCE).ceil().max(1.0);
    if let Some(fixed) = wish.sync_iter {
        return fixed_fits(wish, pace, fixed, window, needed);
    }
    if needed > f64::from(MOST_SUBSTEPS) {
        return Err(too_many(wish, pace, ratio, window));
    }
    let n = needed as u32;
    if (ratio - needed).abs() > TOLERANCE * needed {
        let (from, to) = (short(step), short(window / needed));
        let plural = if n == 1 { "" } else { "s" };
        notes.push(format!(
            "ratio {} becomes {n} substep{plural}: {} step {from} s shortened to {to} s",
            short(ratio),
            wish.name
        ));
    }
    Ok(n)
}

fn fixed_fits(
    wish: &Wish,
    pace: &Wish,
    fixed: u32,
    window: f64,
    needed: f64,
) -> Result<u32, Problem> {
    if f64::from(fixed) >= needed {
        return Ok(fixed);
    }
    let (name, step) = (&wish.name, wish.step.unwrap_or(window));
    let message = format!(
        "{fixed} substeps in a window of {} s are steps of {} s, but {name} takes at most {} s",
        short(window),
        short(window / f64::from(fixed)),
        short(step)
    );
    let pace_step = f64::from(fixed) * step / f64::from(pace.sync_iter.unwrap_or(1));
    let key = format!("{}.sync_iter", wish.key);
    Err(Problem::new(key, message).help(format!(
        "sync_iter = {needed} would do ({name} then steps {} s), or a step of at most {} s for {}",
        short(window / needed),
        short(pace_step),
        pace.name
    )))
}

fn too_many(wish: &Wish, pace: &Wish, ratio: f64, window: f64) -> Problem {
    let (name, slow) = (&wish.name, &pace.name);
    let message = format!(
        "{name} would make {} substeps of {} s in a window of {} s ({slow}), at most {MOST_SUBSTEPS} are allowed",
        (ratio - TOLERANCE).ceil(),
        short(wish.step.unwrap_or(window)),
        short(window)
    );
    let help = format!(
        "give {slow} a step of at most {} s (a finer grid), or let {name} take at least {} s (softer contacts, larger bodies){}",
        short(wish.step.unwrap_or(window) * f64::from(MOST_SUBSTEPS)),
        short(window / f64::from(MOST_SUBSTEPS)),
        reason(wish)
    );
    Problem::new(&wish.key, message).help(help)
}

/// Cause that keeps a component's step short, as the end of a sentence.
fn reason(wish: &Wish) -> String {
    match wish.limit.as_str() {
        "" => String::new(),
        limit => format!("; the step of {} follows from {limit}", wish.name),
    }
}

fn least_common_multiple(a: u64, b: u64) -> u64 {
    // Divided before it is multiplied: the product would overflow sooner.
    a / greatest_common_divisor(a, b) * b
}

fn greatest_common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}
