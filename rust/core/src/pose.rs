//! The rig: bones in the rest pose, and what a pose does to each (ALGORITHM 1).
//!
//! `B = pose · rest⁻¹` carries the space around a resting bone to the posed bone. All matrices are in armature space,
//! metres; those that come from outside are column-major f32, those kept here are f64.

use glam::{DAffine3, DMat4, DVec3};

use crate::error::{Error, Result, require_distinct, require_length};

/// A 4x4 matrix as it comes from outside: column-major, `columns[c * 4 + r]`.
pub type ColumnMajor = [f32; 16];

/// Smallest determinant, relative to its columns' lengths, of a matrix that counts as invertible.
const SMALLEST_RELATIVE_DETERMINANT: f64 = 1e-9;
/// Largest deviation of a matrix's last row from 0 0 0 1.
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
    /// A skeleton of bones named `names` under `parents` (-1 for a root) with `rest` matrices in armature space.
    ///
    /// # Errors
    /// Lists of different lengths, a parent that is no bone, a cycle of parents, a rest matrix that is singular or not
    /// affine, a name that is empty or there twice.
    pub fn new(names: Vec<String>, parents: &[i32], rest: &[ColumnMajor]) -> Result<Self> {
        let count = names.len();
        require_length("parents", count, "one a bone name", parents.len())?;
        require_length("rest", count, "one a bone name", rest.len())?;
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
            .map(|(matrix, name)| affine(matrix, || format!("rest matrix of bone \"{name}\"")))
            .collect::<Result<Vec<_>>>()?;
        let inverse_rest = rest
            .iter()
            .zip(&names)
            .map(|(matrix, name)| inverse(matrix, || format!("rest matrix of bone \"{name}\"")))
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

    /// True for a skeleton without bones.
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// The bones' names, in order.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The parent of each bone, in order.
    pub fn parents(&self) -> &[Option<usize>] {
        &self.parents
    }

    /// The rest matrix of each bone, armature space.
    pub fn rest(&self) -> &[DAffine3] {
        &self.rest
    }

    /// The bones on the path from `start` to `end` through the hierarchy, both included; only those two where they
    /// stand in different trees.
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

    /// `bone` and its ancestors, upward.
    fn ancestry(&self, bone: usize) -> Vec<usize> {
        std::iter::successors(Some(bone), |&bone| self.parents[bone]).collect()
    }
}

/// What one pose does to each bone.
#[derive(Debug, Clone)]
pub struct Palette {
    skinning_matrices: Vec<DAffine3>,
    scales: Vec<f64>,
}

impl Palette {
    /// The palette of the rest pose: every bone stays where it is.
    pub fn at_rest(skeleton: &Skeleton) -> Self {
        Self {
            skinning_matrices: vec![DAffine3::IDENTITY; skeleton.len()],
            scales: vec![1.0; skeleton.len()],
        }
    }

    /// The palette of `pose`: one matrix a bone, armature space.
    ///
    /// # Errors
    /// As [`Palette::set`].
    pub fn new(skeleton: &Skeleton, pose: &[ColumnMajor]) -> Result<Self> {
        let mut palette = Self::at_rest(skeleton);
        palette.set(skeleton, pose)?;
        Ok(palette)
    }

    /// Takes on `pose`, allocating nothing.
    ///
    /// # Errors
    /// Another number of matrices than bones, or one that is not affine; the palette is then of no pose, and must be
    /// set again before use.
    pub fn set(&mut self, skeleton: &Skeleton, pose: &[ColumnMajor]) -> Result<()> {
        require_length("pose", skeleton.len(), "one a bone", pose.len())?;
        for (bone, matrix) in pose.iter().enumerate() {
            let posed = affine(matrix, || {
                format!("pose matrix of bone \"{}\"", skeleton.names[bone])
            })?;
            let carry = posed * skeleton.inverse_rest[bone];
            self.skinning_matrices[bone] = carry;
            self.scales[bone] = carry.matrix3.determinant().abs().cbrt();
        }
        Ok(())
    }

    /// `B` of each bone: rest space to posed space.
    pub fn skinning_matrices(&self) -> &[DAffine3] {
        &self.skinning_matrices
    }

    /// Uniform scale of each bone: the cube root of `|det B|`.
    pub fn scales(&self) -> &[f64] {
        &self.scales
    }
}

/// The affine map of a column-major matrix.
pub(crate) fn affine(matrix: &ColumnMajor, thing: impl FnOnce() -> String) -> Result<DAffine3> {
    let wide = DMat4::from_cols_array(&matrix.map(f64::from));
    let row = wide.row(3).to_array();
    let flat = row
        .iter()
        .zip([0.0, 0.0, 0.0, 1.0])
        .all(|(found, due)| (found - due).abs() <= PROJECTIVE_TOLERANCE);
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

/// Any unit vector at a right angle to `direction` (unit), the same for the same direction.
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
