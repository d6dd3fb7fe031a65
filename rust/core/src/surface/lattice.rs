//! The regular lattice on which a surface is sampled.
//!
//! Its origin is that of armature space, with the plane x = 0 half-way between two layers. So symmetric
//! tissues are sampled symmetrically, and vertices of the middle are on the plane.

use glam::{DVec3, IVec3};

/// A lattice of cubes (*voxels*), each sampled at its centre.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lattice {
    /// Edge length of a voxel, m.
    pub voxel_m: f64,
}

impl Lattice {
    /// The centre of `voxel`, armature space, m.
    pub fn centre(self, voxel: IVec3) -> DVec3 {
        self.point(voxel.as_dvec3())
    }

    /// The point at a position in voxels, armature space, m. Integers are the centres of voxels.
    pub fn point(self, position: DVec3) -> DVec3 {
        (position + 0.5) * self.voxel_m
    }

    /// The position in voxels of a point in armature space, m.
    pub fn in_voxels(self, point_m: DVec3) -> DVec3 {
        point_m / self.voxel_m - 0.5
    }
}

/// The mirror image of a voxel at the plane x = 0.
pub(super) fn mirrored(voxel: IVec3) -> IVec3 {
    IVec3::new(-1 - voxel.x, voxel.y, voxel.z)
}
