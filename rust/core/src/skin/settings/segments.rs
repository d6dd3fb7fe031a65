//! The segments of the body: bones that are one part of it.

/// What of the rig the elastic skin needs beyond the rest pose.
#[derive(Debug, Clone, Copy)]
pub struct Segments<'a> {
    /// The segment of each bone: bones of one number are one segment of the body (split and twist bones).
    pub of_bone: &'a [i32],
    /// Length of each bone, m.
    pub lengths_m: &'a [f32],
}
