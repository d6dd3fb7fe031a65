//! The segments of the body: bones that count as one part.

/// The segments and lengths of a rig's bones.
#[derive(Debug, Clone, Copy)]
pub struct Segments<'a> {
    /// Segment of each bone. Bones with the same number are one segment (split and twist bones).
    pub of_bone: &'a [i32],
    /// Length of each bone, m.
    pub lengths_m: &'a [f32],
}
