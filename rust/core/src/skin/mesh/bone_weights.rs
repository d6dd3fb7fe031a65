//! The bone weights of a mesh.

use std::ops::Range;

use crate::error::{Error, Result};
use crate::math::rows::Rows;
use crate::skin::mesh::rest_mesh::RestMesh;

/// Sum of weights up to which a vertex does not move with bones, as in Blender.
const SMALLEST_SUM: f32 = 1e-4;

/// The weight of one bone at a vertex.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoneWeight {
    pub bone: u32,
    /// Fraction of the sum of the vertex's weights.
    pub weight: f32,
}

/// The bone weights of every vertex, normalised. The bones of a vertex keep the mesh's order, which dual
/// quaternions depend on.
#[derive(Debug, Clone)]
pub(crate) struct BoneWeights(Rows<BoneWeight>);

impl BoneWeights {
    /// The weights of `mesh`, whose lists have matching lengths, for a skeleton of `bones` bones.
    ///
    /// # Errors
    /// Offsets that do not rise from 0 to the number of weights, a bone that does not exist, a weight
    /// below 0 or not finite.
    pub fn new(mesh: &RestMesh, bones: usize) -> Result<Self> {
        require_bones(mesh.weight_bones, bones)?;
        require_weights(mesh.weights)?;
        let mut all = Rows::default();
        for row in rows(mesh.weight_offsets, mesh.weights.len())? {
            let sum: f32 = mesh.weights[row.clone()].iter().sum();
            let weights = mesh.weight_bones[row.clone()].iter().zip(&mesh.weights[row]);
            let positive = weights.filter(|&(_, &weight)| sum > SMALLEST_SUM && weight > 0.0);
            all.push(positive.map(|(&bone, &weight)| BoneWeight {
                bone: bone as u32,
                weight: weight / sum,
            }));
        }
        Ok(Self(all))
    }

    /// The weights of some of its vertices, in the order of `vertices`.
    pub fn of_vertices(&self, vertices: impl Iterator<Item = usize>) -> Self {
        Self(Rows::from_rows(
            vertices.map(|vertex| self.of(vertex).iter().copied()),
        ))
    }

    /// The weights of `vertex`; empty if it does not move with bones.
    pub fn of(&self, vertex: usize) -> &[BoneWeight] {
        self.0.row(vertex)
    }
}

/// The range of each row.
fn rows(offsets: &[i32], weights: usize) -> Result<impl Iterator<Item = Range<usize>>> {
    let mut floor = 0;
    for (position, &found) in offsets.iter().enumerate() {
        let is_first = position == 0;
        let is_last = position + 1 == offsets.len();
        let index = usize::try_from(found).unwrap_or(usize::MAX);
        let is_wrong =
            index < floor || index > weights || is_first && index != 0 || is_last && index != weights;
        if is_wrong {
            let found = found.into();
            return Err(Error::Offsets {
                list: "weight_offsets",
                position,
                found,
                limit: weights,
            });
        }
        floor = index;
    }
    Ok(offsets.windows(2).map(|pair| pair[0] as usize..pair[1] as usize))
}

fn require_bones(bones: &[i32], limit: usize) -> Result<()> {
    match bones
        .iter()
        .position(|&bone| usize::try_from(bone).map_or(true, |bone| bone >= limit))
    {
        None => Ok(()),
        Some(position) => {
            let found = bones[position].into();
            Err(Error::Index {
                list: "weight_bones",
                position,
                found,
                limit,
                of: "bones",
            })
        }
    }
}

fn require_weights(weights: &[f32]) -> Result<()> {
    match weights
        .iter()
        .position(|&weight| !(weight.is_finite() && weight >= 0.0))
    {
        None => Ok(()),
        Some(position) => Err(Error::Weight {
            position,
            found: weights[position],
        }),
    }
}
