//! The mesh's own bone weights: which bones carry a vertex, and how strongly.

use std::ops::Range;

use crate::error::{Error, Result};
use crate::skin::mesh::rest_mesh::RestMesh;

/// Sum of weights up to which a vertex does not move with bones (Blender's own limit).
const SMALLEST_SUM: f32 = 1e-4;

/// One bone's share of a vertex.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoneWeight {
    pub bone: u32,
    /// Share, of a sum of 1.
    pub weight: f32,
}

/// Bone weights of every vertex, normalised, each in the mesh's own order (which dual quaternions depend on).
#[derive(Debug, Clone)]
pub(crate) struct BoneWeights {
    offsets: Vec<u32>,
    entries: Vec<BoneWeight>,
}

impl BoneWeights {
    /// The weights of `mesh`, whose lists have fitting lengths, on a skeleton of `bones` bones.
    ///
    /// # Errors
    /// Offsets that do not rise from 0 to the number of weights, a bone that is not there, a weight below 0.
    pub fn new(mesh: &RestMesh, bones: usize) -> Result<Self> {
        let (mut offsets, mut entries) = (Vec::with_capacity(mesh.weight_offsets.len()), vec![]);
        require_bones(mesh.weight_bones, bones)?;
        require_weights(mesh.weights)?;
        for row in rows(mesh.weight_offsets, mesh.weights.len())? {
            offsets.push(entries.len() as u32);
            let sum: f32 = mesh.weights[row.clone()].iter().sum();
            if sum <= SMALLEST_SUM {
                continue;
            }
            let own = mesh.weight_bones[row.clone()].iter().zip(&mesh.weights[row]);
            let weighing = own.filter(|&(_, &weight)| weight > 0.0);
            entries.extend(weighing.map(|(&bone, &weight)| BoneWeight {
                bone: bone as u32,
                weight: weight / sum,
            }));
        }
        offsets.push(entries.len() as u32);
        Ok(Self { offsets, entries })
    }

    /// The weights of some of its vertices, in turn.
    pub fn of_vertices(&self, vertices: impl Iterator<Item = usize>) -> Self {
        let (mut offsets, mut entries) = (vec![0], Vec::with_capacity(self.entries.len()));
        for vertex in vertices {
            entries.extend_from_slice(self.of(vertex));
            offsets.push(entries.len() as u32);
        }
        Self { offsets, entries }
    }

    /// The bones that carry `vertex`; none for a vertex that does not move with bones.
    pub fn of(&self, vertex: usize) -> &[BoneWeight] {
        let ends = &self.offsets[vertex..vertex + 2];
        &self.entries[ends[0] as usize..ends[1] as usize]
    }
}

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
