//! The one error of the core: each variant names the thing, the value found and the limit it broke.

use thiserror::Error;

/// Why an input was refused.
///
/// Two families: *lists* that do not fit each other (lengths, indices, order) and *anatomy* that cannot be
/// (singular rest matrices, negative semi-axes, tissues on unknown bones). [`Error::is_of_lists`] tells them apart.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Error {
    /// A list has another length than the thing that it describes.
    #[error("{list}: expected {expected} entries ({reason}), got {found}")]
    Length {
        /// The list, by its argument's name.
        list: &'static str,
        /// How many entries it must have.
        expected: usize,
        /// What sets that number.
        reason: &'static str,
        /// How many entries it has.
        found: usize,
    },
    /// An index points outside the list that it points into.
    #[error("{list}: entry {position} is {found}, outside 0..{limit} ({of})")]
    Index {
        /// The list of indices, by its argument's name.
        list: &'static str,
        /// Where in the list.
        position: usize,
        /// The index found.
        found: i64,
        /// One past the largest index allowed.
        limit: usize,
        /// What is indexed.
        of: &'static str,
    },
    /// Row offsets do not start at zero, fall, or do not end at the number of entries.
    #[error(
        "{list}: entry {position} is {found}, offsets must rise from 0 to the number of weights, {limit}"
    )]
    Offsets {
        /// The list of offsets, by its argument's name.
        list: &'static str,
        /// Where in the list.
        position: usize,
        /// The offset found.
        found: i64,
        /// The number of entries that the last offset must name.
        limit: usize,
    },
    /// A bone weight is below 0.
    #[error("weights: entry {position} is {found}, must be finite and 0 or more")]
    Weight {
        /// Where in the list.
        position: usize,
        /// The weight found.
        found: f32,
    },
    /// A number is not finite, or outside its limits.
    #[error("{thing}: {quantity} is {found}, must be {limit}")]
    Value {
        /// What has the number, by name.
        thing: String,
        /// Which number, with its unit.
        quantity: &'static str,
        /// The number found.
        found: f64,
        /// The limits, in words.
        limit: &'static str,
    },
    /// Two things of one kind share a name.
    #[error("{kind} \"{name}\" is there twice (entries {first} and {second}); give each a name of its own")]
    Duplicate {
        /// What shares the name: bone or tissue.
        kind: &'static str,
        /// The name.
        name: String,
        /// The entry that has it first.
        first: usize,
        /// The entry that has it again.
        second: usize,
    },
    /// A name is empty.
    #[error("{kind} {position} has an empty name")]
    Nameless {
        /// What has no name: bone or tissue.
        kind: &'static str,
        /// Its entry.
        position: usize,
    },
    /// A bone is its own ancestor.
    #[error("bone \"{bone}\" is its own ancestor; clear its parent")]
    Cycle {
        /// The bone.
        bone: String,
    },
    /// A matrix cannot be inverted.
    #[error("{thing} cannot be inverted (determinant {determinant:e}); apply or repair its scale")]
    Singular {
        /// Whose matrix.
        thing: String,
        /// Its determinant.
        determinant: f64,
    },
    /// A matrix has a last row other than 0 0 0 1, as a row-major matrix read column-major has.
    #[error("{thing} is not affine: its last row is {row:?}, must be [0, 0, 0, 1]; is it row-major?")]
    Projective {
        /// Whose matrix.
        thing: String,
        /// Its last row.
        row: [f64; 4],
    },
    /// A tissue is attached to a bone that the skeleton has not.
    #[error("tissue \"{tissue}\": its {end} bone is {found}, but the skeleton has bones 0..{limit}")]
    UnknownBone {
        /// The tissue.
        tissue: String,
        /// Which end: origin or insertion.
        end: &'static str,
        /// The index found.
        found: i64,
        /// The number of bones.
        limit: usize,
    },
    /// A rigid tissue is attached to two bones.
    #[error("tissue \"{tissue}\" is rigid but goes from bone {origin} to bone {insertion}; give it one bone")]
    RigidAcrossBones {
        /// The tissue.
        tissue: String,
        /// Its origin bone.
        origin: usize,
        /// Its insertion bone.
        insertion: usize,
    },
    /// A tissue that never bends has via points or wraps.
    #[error("tissue \"{tissue}\" is rigid but has via points or wraps; only a muscle goes round things")]
    RigidAndCurved {
        /// The tissue.
        tissue: String,
    },
    /// A muscle goes round something that the musculature has not.
    #[error(
        "tissue \"{tissue}\" goes round \"{wrap}\", which the musculature has not; add that sphere, or wrap another"
    )]
    UnknownWrap {
        /// The muscle.
        tissue: String,
        /// The name that was not found.
        wrap: String,
    },
    /// A muscle goes round a tissue that is no sphere.
    #[error(
        "tissue \"{tissue}\" goes round \"{wrap}\", which is no sphere; a muscle goes round spheres only"
    )]
    WrapOfOtherKind {
        /// The muscle.
        tissue: String,
        /// What it would go round.
        wrap: String,
    },
    /// A skin has no vertices.
    #[error("the mesh has no vertices; there is nothing to bind")]
    NoVertices,
    /// A musculature to bind to has no tissues.
    #[error("the musculature has no tissues; add a muscle before binding")]
    NoTissues,
    /// A linkage has no joints.
    #[error("there are no joints to reach with; choose a bone that has a rotation of its own")]
    NoJoints,
    /// A surface would take too much memory.
    #[error(
        "resolution {resolution} needs about {needed_mb} MB of memory, the limit is {limit_mb} MB; choose {fits} or less, \
         or raise the limit"
    )]
    Memory {
        /// Voxels along the longest side.
        resolution: usize,
        /// What it would take, MB.
        needed_mb: usize,
        /// What it may take, MB.
        limit_mb: usize,
        /// A resolution that fits.
        fits: usize,
    },
    /// The person asked for an end.
    #[error("cancelled; nothing has changed")]
    Cancelled,
}

impl Error {
    /// True when lists do not fit each other, false when the anatomy they describe is impossible.
    pub fn is_of_lists(&self) -> bool {
        match self {
            Self::Length { .. } | Self::Index { .. } | Self::Offsets { .. } | Self::Weight { .. } => true,
            Self::Value { .. }
            | Self::Duplicate { .. }
            | Self::Nameless { .. }
            | Self::Cycle { .. }
            | Self::Singular { .. }
            | Self::Projective { .. }
            | Self::UnknownBone { .. }
            | Self::RigidAcrossBones { .. }
            | Self::RigidAndCurved { .. }
            | Self::UnknownWrap { .. }
            | Self::WrapOfOtherKind { .. }
            | Self::NoVertices
            | Self::NoTissues
            | Self::NoJoints
            | Self::Memory { .. }
            | Self::Cancelled => false,
        }
    }
}

/// A result of the core.
pub type Result<T> = std::result::Result<T, Error>;

/// `found` if `allowed`, else an [`Error::Value`] that names it.
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

/// Fails where a name of `names` is empty or occurs twice.
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

/// Fails unless a list has the length that `reason` gives it.
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

/// `triangles` as places in a list of `vertices`.
pub(crate) fn require_triangles(triangles: &[[i32; 3]], vertices: usize) -> Result<Vec<[u32; 3]>> {
    let checked = triangles.iter().enumerate().map(|(position, &[a, b, c])| {
        let corner = |found| require_vertex("triangles", position, found, vertices);
        Ok([corner(a)?, corner(b)?, corner(c)?])
    });
    checked.collect()
}

/// The place in a list of `limit` vertices that `found` is.
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
