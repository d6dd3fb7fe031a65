//! What the Armature modifier makes of an offset of a resting vertex, in one pose: how far an error before it shows after it.

use fixedbitset::FixedBitSet;
use glam::{Mat3A, Vec3A};

use super::Skin;
use super::skinning::BoneMaps;
use crate::error::Result;
use crate::pose::{ColumnMajor, Palette};

/// The maps of the Armature modifier in one pose.
#[derive(Debug, Clone)]
pub struct PosedModifier {
    maps: BoneMaps,
    /// What no offset is lengthened by more than.
    longest: f32,
}

impl PosedModifier {
    /// A factor that no offset is lengthened by more than.
    pub fn longest(&self) -> f32 {
        self.longest
    }
}

impl Skin {
    /// What the mesh's Armature modifier does in `pose`.
    ///
    /// # Errors
    /// Another number of matrices than bones, or one that is not affine.
    pub fn posed_modifier(&self, pose: &[ColumnMajor]) -> Result<PosedModifier> {
        let skeleton = self.musculature.skeleton();
        let palette = Palette::new(skeleton, pose)?;
        let mut all = FixedBitSet::with_capacity(skeleton.len());
        all.insert_range(..);
        let mut maps = BoneMaps::at_rest(self.skinning, skeleton.len());
        maps.set(skeleton, &palette, &all);
        // a mesh whose own axes are uneven in armature space lengthens by those, too
        let own = self.armature_to_mesh;
        let uneven = frobenius(own) * frobenius(own.inverse()) / 3.0;
        let longest = maps.longest() * if uneven < 1.001 { 1.001 } else { 3.0 * uneven };
        Ok(PosedModifier { maps, longest })
    }

    /// Where the modifier takes an offset of a vertex of the mesh, both in mesh space.
    pub fn posed_offset(&self, modifier: &PosedModifier, vertex: usize, offset: Vec3A) -> Vec3A {
        let number = self.order.number(vertex as u32) as usize;
        let map = modifier.maps.blend(self.bone_weights.of(number));
        let own = self.armature_to_mesh.inverse() * offset;
        self.armature_to_mesh * (own + map.linear * own)
    }
}

fn frobenius(matrix: Mat3A) -> f32 {
    let columns = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    columns
        .iter()
        .map(|column| column.length_squared())
        .sum::<f32>()
        .sqrt()
}
