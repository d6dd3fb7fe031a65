//! Faults of a skin in a pose, and when they are worse than those of another
//! (mathematics/safeguard.md, Faults).

/// Faces more than the modifier's, as a number and as a fraction of its, from which a skin is worse: a single
/// face is not. They are below the limits of `scripts/harm.py`, because poses between those that are compared
/// are worse than both.
const FACES_MORE: f64 = 1.0;
const FRACTION_MORE: f64 = 0.01;
/// Stretch over the modifier's from which a skin is worse, and how much more is allowed in addition.
const STRETCH_RATIO: f64 = 1.05;
const STRETCH_MORE: f64 = 0.025;

/// Whether `ours` faces are worse than `theirs`.
pub(crate) fn are_more(ours: usize, theirs: usize) -> bool {
    let theirs = theirs as f64;
    ours as f64 > theirs + FACES_MORE.max(FRACTION_MORE * theirs)
}

/// Whether the stretch `ours` is worse than `theirs`.
pub(crate) fn is_longer(ours: f64, theirs: f64) -> bool {
    ours > STRETCH_RATIO * theirs + STRETCH_MORE
}
