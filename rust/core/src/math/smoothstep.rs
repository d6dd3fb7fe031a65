//! The step that everything which comes and goes in a body takes: with no corner at either end.

/// 0 below 0, 1 above 1, `3t² - 2t³` between.
pub(crate) fn smooth_step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// [`smooth_step`] in single precision, for what a frame does for every vertex.
pub(crate) fn smooth_step_single(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
