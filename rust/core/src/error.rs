//! The error type of the core. Each variant names the thing, the value found and the limit.

use thiserror::Error;

/// Why an input was refused.
///
/// The first four variants say that lists do not fit one another (length, index, order). The others say that
/// their content is impossible, such as a singular rest matrix or a tissue on an unknown bone.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Error {
    /// A list does not have the length that follows from another input.
    #[error("{list}: expected {expected} entries ({reason}), got {found}")]
    Length {
        /// The name of the argument.
        list: &'static str,
        /// The number of entries that it must have.
        expected: usize,
        /// Where that number comes from.
        reason: &'static str,
        /// The number of entries that it has.
        found: usize,
    },
    /// An index is outside the list that it refers to.
    #[error("{list}: entry {position} is {found}, outside 0..{limit} ({of})")]
    Index {
        /// The name of the argument that holds indices.
        list: &'static str,
        /// The entry, counted from 0.
        position: usize,
        /// The index found.
        found: i64,
        /// One more than the largest index allowed.
        limit: usize,
        /// What the index refers to.
        of: &'static str,
    },
    /// Row offsets do not start at 0, decrease, or do not end at the number of entries.
    #[error(
        "{list}: entry {position} is {found}, offsets must increase from 0 to the number of weights, {limit}"
    )]
    Offsets {
        /// The name of the argument that holds offsets.
        list: &'static str,
        /// The entry, counted from 0.
        position: usize,
        /// The offset found.
        found: i64,
        /// The number of entries, which the last offset must equal.
        limit: usize,
    },
    /// Face offsets do not start at 0, rise by less than 3, or do not end at the number of corners.
    #[error(
        "face_offsets: entry {position} is {found}, offsets must rise by 3 or more from 0 to the number of corners, {limit}"
    )]
    FaceOffsets {
        /// The entry, counted from 0.
        position: usize,
        /// The offset found; -1 for an empty list.
        found: i64,
        /// The number of corners, which the last offset must equal.
        limit: usize,
    },
    /// A bone weight is negative or not finite.
    #[error("weights: entry {position} is {found}, must be finite and 0 or more")]
    Weight {
        /// The entry, counted from 0.
        position: usize,
        /// The weight found.
        found: f32,
    },
    /// A number is not finite or outside its limits.
    #[error("{thing}: {quantity} is {found}, must be {limit}")]
    Value {
        /// The name of the thing that has the number.
        thing: String,
        /// The quantity, with its unit.
        quantity: &'static str,
        /// The number found.
        found: f64,
        /// The limits, in words.
        limit: &'static str,
    },
    /// Two things of one kind have the same name.
    #[error("\"{name}\" is the name of two {kind}s (entries {first} and {second}); rename one")]
    Duplicate {
        /// The kind: bone, joint or tissue.
        kind: &'static str,
        /// The name.
        name: String,
        /// The first entry with this name.
        first: usize,
        /// The second entry with this name.
        second: usize,
    },
    /// A name is empty.
    #[error("The name of {kind} {position} is empty")]
    Nameless {
        /// The kind: bone, joint or tissue.
        kind: &'static str,
        /// The entry, counted from 0.
        position: usize,
    },
    /// A bone is its own ancestor.
    #[error("Bone \"{bone}\" is its own ancestor; clear its parent")]
    Cycle {
        /// The bone.
        bone: String,
    },
    /// A matrix is not invertible.
    #[error("{thing} cannot be inverted (determinant {determinant:e}); apply or repair its scale")]
    Singular {
        /// The name of the matrix.
        thing: String,
        /// Its determinant.
        determinant: f64,
    },
    /// The last row of a matrix is not 0 0 0 1. A row-major matrix has this fault if it is read as
    /// column-major.
    #[error("{thing} is not affine: its last row is {row:?}, must be [0, 0, 0, 1]; is it row-major?")]
    Projective {
        /// The name of the matrix.
        thing: String,
        /// Its last row.
        row: [f64; 4],
    },
    /// A tissue is attached to a bone that is not in the skeleton.
    #[error("Tissue \"{tissue}\": its {end} bone is {found}, but the skeleton has bones 0..{limit}")]
    UnknownBone {
        /// The tissue.
        tissue: String,
        /// Which attachment: origin, insertion or via point.
        end: &'static str,
        /// The index found.
        found: i64,
        /// The number of bones.
        limit: usize,
    },
    /// A rigid tissue is attached to two bones.
    #[error("Tissue \"{tissue}\" is rigid but goes from bone {origin} to bone {insertion}; give it one bone")]
    RigidAcrossBones {
        /// The tissue.
        tissue: String,
        /// Its origin bone.
        origin: usize,
        /// Its insertion bone.
        insertion: usize,
    },
    /// A rigid tissue has via points or wraps.
    #[error("Tissue \"{tissue}\" is rigid but has via points or wraps; only a muscle can have them")]
    RigidAndCurved {
        /// The tissue.
        tissue: String,
    },
    /// A muscle wraps around a tissue that is not in the musculature.
    #[error(
        "Tissue \"{tissue}\" wraps around \"{wrap}\", which is not in the musculature; add that sphere, or wrap around another"
    )]
    UnknownWrap {
        /// The muscle.
        tissue: String,
        /// The name that was not found.
        wrap: String,
    },
    /// A muscle wraps around a tissue that is not a sphere.
    #[error("Tissue \"{tissue}\" wraps around \"{wrap}\", which is not a sphere; choose a sphere")]
    WrapOfOtherKind {
        /// The muscle.
        tissue: String,
        /// The name of the tissue that is not a sphere.
        wrap: String,
    },
    /// A mesh has no vertices.
    #[error("The mesh has no vertices; there is nothing to bind")]
    NoVertices,
    /// A surface has no faces.
    #[error("Mesh {mesh} has no faces, so there is no surface; give it faces, or leave it out")]
    NoFaces {
        /// The mesh, counted from 0.
        mesh: usize,
    },
    /// A musculature has no tissues.
    #[error("The musculature has no tissues; add a muscle before binding")]
    NoTissues,
    /// An IK chain has no joints.
    #[error("There are no joints to reach with; choose a bone that can rotate")]
    NoJoints,
    /// Growing a skin would take more memory than allowed.
    #[error(
        "Resolution {resolution} needs about {needed_mb} MB of memory, the limit is {limit_mb} MB; choose {fits} or less, \
         or raise the limit"
    )]
    Memory {
        /// The resolution that was requested: voxels along the longest side.
        resolution: usize,
        /// The memory that it needs, MB.
        needed_mb: usize,
        /// The memory that it may take, MB.
        limit_mb: usize,
        /// The largest resolution that fits.
        fits: usize,
    },
    /// The user cancelled.
    #[error("Cancelled; nothing has changed")]
    Cancelled,
}

/// A result of the core.
pub type Result<T> = std::result::Result<T, Error>;

/// `found` if `allowed` is true, else an [`Error::Value`] for it.
pub(crate) fn require(
    allowed: bool,
    thing: impl FnOnce() -> String,
    quantity: &'static str,
    found: f64,
    limit: &'static str,
) -> Result<f64> {
    if allowed {
        Ok(found)
    } else {
        Err(Error::Value {
            thing: thing(),
            quantity,
            found,
            limit,
        })
    }
}

/// Fails if a name in `names` is empty or occurs twice.
pub(crate) fn require_distinct<'a>(kind: &'static str, names: impl Iterator<Item = &'a str>) -> Result<()> {
    let mut seen = std::collections::HashMap::new();
    for (position, name) in names.enumerate() {
        if name.is_empty() {
            return Err(Error::Nameless { kind, position });
        }
        if let Some(first) = seen.insert(name, position) {
            return Err(Error::Duplicate {
                kind,
                name: name.to_owned(),
                first,
                second: position,
            });
        }
    }
    Ok(())
}

/// Fails if a list does not have the `expected` length, which `reason` explains.
pub(crate) fn require_length(
    list: &'static str,
    expected: usize,
    reason: &'static str,
    found: usize,
) -> Result<()> {
    if expected == found {
        Ok(())
    } else {
        Err(Error::Length {
            list,
            expected,
            reason,
            found,
        })
    }
}

/// Checks that `triangles` are indices of `vertices` vertices, and returns them as such.
///
/// # Errors
/// [`Error::Index`].
pub(crate) fn require_triangles(triangles: &[[i32; 3]], vertices: usize) -> Result<Vec<[u32; 3]>> {
    let checked = triangles.iter().enumerate().map(|(position, &[a, b, c])| {
        let corner = |found| require_vertex("triangles", position, found, vertices);
        Ok([corner(a)?, corner(b)?, corner(c)?])
    });
    checked.collect()
}

/// Checks that entry `position` of `list`, `found`, is the index of one of `limit` vertices.
///
/// # Errors
/// [`Error::Index`].
pub(crate) fn require_vertex(list: &'static str, position: usize, found: i32, limit: usize) -> Result<u32> {
    match u32::try_from(found) {
        Ok(index) if (index as usize) < limit => Ok(index),
        _ => Err(Error::Index {
            list,
            position,
            found: found.into(),
            limit,
            of: "vertices",
        }),
    }
}
