//! The cubic step, by which all influences in a body start and end: its slope is 0 at both ends.

/// 0 below 0, 1 above 1, `3t² - 2t³` between.
pub(crate) fn smooth_step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// [`smooth_step`] in f32, for values per vertex and frame.
pub(crate) fn smooth_step_single(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
