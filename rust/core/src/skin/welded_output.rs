//! The output of welded vertices (see [`WeldedVertices`](crate::skin::mesh::welded::WeldedVertices)).

use glam::{Mat3A, Vec3A};

use crate::skin::correction::inverse::invert;
use crate::skin::skin::Skin;
use crate::skin::workspace::{Workspace, Written};

impl Skin {
    /// Writes the welded vertices that have bone weights of their own. Each gets the position of the vertex
    /// that it is welded to.
    pub(crate) fn write_welded(&self, frame: &Workspace, out: &mut [[f32; 3]]) {
        for (welded, weights) in self.welded.iter() {
            let vertex = welded.sorted_index as usize;
            let modifier_offset = self.modifier_offset(frame, vertex);
            let offset = self.offset_after_modifier(frame, vertex, modifier_offset);
            let moved = modifier_offset + offset.unwrap_or(Vec3A::ZERO);
            let written = if frame.written == Written::Deformed {
                welded.mesh_point + self.armature_to_mesh * moved
            } else {
                let map = frame.bones.blend(weights, self.preserved_fraction(vertex));
                let posed_offset = moved - map.at(welded.point);
                if offset.is_none() && posed_offset.length_squared() <= self.welded.together_m.powi(2) {
                    Vec3A::ZERO // the modifier's position, to the bit
                } else {
                    self.armature_to_mesh * invert(map.linear + Mat3A::IDENTITY, posed_offset).offset
                }
            };
            out[welded.vertex as usize] = written.to_array();
        }
    }
}
