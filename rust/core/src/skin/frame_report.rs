//! What a frame reports.

/// What a frame reports besides its positions.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FrameReport {
    /// Indices of the muscles whose belly is close to its minimum length.
    pub clamped: Vec<usize>,
    /// Vertices whose correction is damped or bounded.
    pub damped: usize,
}
