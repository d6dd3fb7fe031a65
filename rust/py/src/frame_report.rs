//! `FrameReport`.

use pyo3::prelude::*;

/// Conditions met in one frame.
#[pyclass(frozen, module = "_sinew")]
pub struct FrameReport {
    /// Names of the muscles close to their minimum length.
    #[pyo3(get)]
    clamped: Vec<String>,
    /// Number of vertices whose correction is damped and bounded.
    #[pyo3(get)]
    damped: usize,
}

impl FrameReport {
    /// The report of a frame of `musculature`.
    pub fn new(musculature: &sinew_core::Musculature, report: sinew_core::FrameReport) -> Self {
        Self {
            clamped: names_of(musculature, &report.clamped),
            damped: report.damped,
        }
    }
}

/// The names of the tissues with these indices.
pub fn names_of(musculature: &sinew_core::Musculature, indices: &[usize]) -> Vec<String> {
    indices
        .iter()
        .map(|&index| musculature.tissues()[index].name().to_owned())
        .collect()
}
