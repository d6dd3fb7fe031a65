//! The rig: bones in the rest pose, and the matrices of a pose (mathematics/muscles.md, Pose and
//! attachments).
//!
//! `B = pose · rest⁻¹` maps the space around a bone at rest to the space around the posed bone. All matrices
//! are in armature space, metres. Input matrices are column-major f32; stored ones are f64.

use glam::{DAffine3, DMat4, DVec3};

use crate::error::{Error, Result, require_distinct, require_length};

/// A 4x4 matrix as callers pass it: column-major, entry (row r, column c) at `c * 4 + r`.
pub type ColumnMajor = [f32; 16];

/// Smallest determinant, relative to the product of the lengths of its columns, of a matrix that counts as
/// invertible.
const SMALLEST_RELATIVE_DETERMINANT: f64 = 1e-9;
/// Largest difference of a matrix's last row from 0 0 0 1.
const PROJECTIVE_TOLERANCE: f64 = 1e-4;

/// The bones of a rig in the rest pose.
#[derive(Debug, Clone)]
pub struct Skeleton {
    names: Vec<String>,
    parents: Vec<Option<usize>>,
    rest: Vec<DAffine3>,
    inverse_rest: Vec<DAffine3>,
}

impl Skeleton {
    /// A skeleton of bones `names`. `parents` has the index of each bone's parent, -1 for a root; `rest` has
    /// the rest matrices in armature space, m. All three have one entry per bone.
    ///
    /// # Errors
    /// [`Error::Length`] for lists of different lengths, [`Error::Index`] for a parent that is not a bone,
    /// [`Error::Cycle`], [`Error::Singular`] or [`Error::Projective`] for a rest matrix, [`Error::Nameless`]
    /// or [`Error::Duplicate`] for a name.
    pub fn new(names: Vec<String>, parents: &[i32], rest: &[ColumnMajor]) -> Result<Self> {
        let count = names.len();
        require_length("parents", count, "one per bone name", parents.len())?;
        require_length("rest", count, "one per bone name", rest.len())?;
        require_distinct("bone", names.iter().map(String::as_str))?;
        let parents = parents
            .iter()
            .enumerate()
            .map(|(position, &parent)| parent_of(position, parent, count))
            .collect::<Result<Vec<_>>>()?;
        require_forest(&names, &parents)?;
        let rest = rest
            .iter()
            .zip(&names)
            .map(|(matrix, name)| affine(matrix, || format!("Rest matrix of bone \"{name}\"")))
            .collect::<Result<Vec<_>>>()?;
        let inverse_rest = rest
            .iter()
            .zip(&names)
            .map(|(matrix, name)| inverse(matrix, || format!("Rest matrix of bone \"{name}\"")))
            .collect::<Result<Vec<_>>>()?;
        Ok(Self {
            names,
            parents,
            rest,
            inverse_rest,
        })
    }

    /// Number of bones.
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// True if there are no bones.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// The names of the bones, in order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The parent of each bone, in order; `None` for a root.
    pub fn parents(&self) -> &[Option<usize>] {
        &self.parents
    }

    /// The rest matrix of each bone, in order, armature space, m.
    pub fn rest(&self) -> &[DAffine3] {
        &self.rest
    }

    /// The bones from `start` to `end` through the hierarchy, both included. If they are in different trees,
    /// only those two.
    pub fn path(&self, start: usize, end: usize) -> Vec<usize> {
        let (up, down) = (self.ancestry(start), self.ancestry(end));
        match up.iter().position(|bone| down.contains(bone)) {
            Some(meeting) => {
                let below = down.iter().take_while(|&&bone| bone != up[meeting]);
                up[..=meeting].iter().chain(below).copied().collect()
            }
            None => vec![start, end],
        }
    }

    /// Whether `bone` is `above` or one of its descendants.
    pub(crate) fn is_below(&self, bone: usize, above: usize) -> bool {
        std::iter::successors(Some(bone), |&bone| self.parents[bone]).any(|bone| bone == above)
    }

    /// `bone` and its ancestors, from `bone` to the root.
    fn ancestry(&self, bone: usize) -> Vec<usize> {
        std::iter::successors(Some(bone), |&bone| self.parents[bone]).collect()
    }
}

/// The maps of all bones in one pose: rest space to posed space, and scales.
#[derive(Debug, Clone)]
pub struct Palette {
    skinning_matrices: Vec<DAffine3>,
    scales: Vec<f64>,
}

impl Palette {
    /// The palette of the rest pose: all maps are the identity.
    pub fn at_rest(skeleton: &Skeleton) -> Self {
        Self {
            skinning_matrices: vec![DAffine3::IDENTITY; skeleton.len()],
            scales: vec![1.0; skeleton.len()],
        }
    }

    /// The palette of `pose`: one matrix per bone, armature space, m.
    ///
    /// # Errors
    /// The same as [`Palette::set`].
    pub fn new(skeleton: &Skeleton, pose: &[ColumnMajor]) -> Result<Self> {
        let mut palette = Self::at_rest(skeleton);
        palette.set(skeleton, pose)?;
        Ok(palette)
    }

    /// Computes the palette of `pose` (one matrix per bone, armature space, m) without allocating.
    ///
    /// # Errors
    /// [`Error::Length`] for a number of matrices other than the number of bones, [`Error::Projective`] for a
    /// matrix that is not affine. After an error the palette is of no pose; set it again before use.
    pub fn set(&mut self, skeleton: &Skeleton, pose: &[ColumnMajor]) -> Result<()> {
        require_length("pose", skeleton.len(), "one per bone", pose.len())?;
        for (bone, matrix) in pose.iter().enumerate() {
            let posed = affine(matrix, || {
                format!("Pose matrix of bone \"{}\"", skeleton.names[bone])
            })?;
            let skinning = posed * skeleton.inverse_rest[bone];
            self.skinning_matrices[bone] = skinning;
            self.scales[bone] = skinning.matrix3.determinant().abs().cbrt();
        }
        Ok(())
    }

    /// The skinning matrix `B` of each bone: rest space to posed space.
    pub fn skinning_matrices(&self) -> &[DAffine3] {
        &self.skinning_matrices
    }

    /// The uniform scale of each bone: the cube root of `|det B|`.
    pub fn scales(&self) -> &[f64] {
        &self.scales
    }
}

/// The affine map of a column-major matrix.
///
/// # Errors
/// [`Error::Projective`], naming `thing`.
pub(crate) fn affine(matrix: &ColumnMajor, thing: impl FnOnce() -> String) -> Result<DAffine3> {
    let wide = DMat4::from_cols_array(&matrix.map(f64::from));
    let row = wide.row(3).to_array();
    let flat = row
        .iter()
        .zip([0.0, 0.0, 0.0, 1.0])
        .all(|(found, expected)| (found - expected).abs() <= PROJECTIVE_TOLERANCE);
    if flat {
        Ok(DAffine3::from_mat4(wide))
    } else {
        Err(Error::Projective { thing: thing(), row })
    }
}

/// The inverse of `map`.
///
/// # Errors
/// [`Error::Singular`], naming `thing`.
pub(crate) fn inverse(map: &DAffine3, thing: impl FnOnce() -> String) -> Result<DAffine3> {
    let linear = map.matrix3;
    let determinant = linear.determinant();
    let size = linear.x_axis.length() * linear.y_axis.length() * linear.z_axis.length();
    if size > 0.0 && determinant.abs() > SMALLEST_RELATIVE_DETERMINANT * size {
        Ok(map.inverse())
    } else {
        Err(Error::Singular {
            thing: thing(),
            determinant,
        })
    }
}

/// A unit vector perpendicular to `direction` (unit). The same direction always gives the same vector.
pub(crate) fn any_perpendicular(direction: DVec3) -> DVec3 {
    direction.any_orthonormal_vector()
}

fn parent_of(position: usize, parent: i32, count: usize) -> Result<Option<usize>> {
    match usize::try_from(parent) {
        Ok(parent) if parent < count => Ok(Some(parent)),
        Err(_) if parent == -1 => Ok(None),
        _ => Err(Error::Index {
            list: "parents",
            position,
            found: parent.into(),
            limit: count,
            of: "bones, or -1 for a root",
        }),
    }
}

fn require_forest(names: &[String], parents: &[Option<usize>]) -> Result<()> {
    for bone in 0..parents.len() {
        let steps = std::iter::successors(parents[bone], |&above| parents[above]).take(parents.len() + 1);
        if steps.count() > parents.len() {
            return Err(Error::Cycle {
                bone: names[bone].clone(),
            });
        }
    }
    Ok(())
}
