//! The buffers of both skins of a pose: the Armature modifier's, and Sinew's.

use glam::{Mat3A, Vec3A};

use crate::skin::safeguard::rest_skin::Posed;
use crate::skin::workspace::Workspace;

/// The buffers of the poses.
#[derive(Debug)]
pub(crate) struct Sampler {
    pub workspace: Workspace,
    pub tension: Vec<f32>,
    /// Factor of the crease planes in the pose before, 0 to 1.
    pub crease: f32,
    pub alone: Vec<Vec3A>,
    pub whole: Vec<Vec3A>,
    pub blended: Vec<Vec3A>,
    pub maps: Vec<Mat3A>,
    pub is_dirty: Vec<bool>,
}

impl Sampler {
    /// The buffers of a skin with this many vertices, tissues and chunks of its output.
    pub fn new(workspace: Workspace, vertices: usize, tissues: usize, chunks: usize) -> Self {
        Self {
            workspace,
            tension: vec![0.0; tissues],
            crease: 1.0,
            alone: vec![Vec3A::ZERO; vertices],
            whole: vec![Vec3A::ZERO; vertices],
            blended: vec![],
            maps: vec![Mat3A::IDENTITY; vertices],
            is_dirty: vec![true; chunks],
        }
    }

    /// The skin of the Armature modifier alone in the last pose.
    pub fn alone(&self) -> Posed<'_> {
        Posed {
            positions: &self.alone,
            maps: &self.maps,
        }
    }

    /// Sinew's skin in the last pose.
    pub fn whole(&self) -> Posed<'_> {
        Posed {
            positions: &self.whole,
            maps: &self.maps,
        }
    }

    /// The last blend of both.
    pub fn blended(&self) -> Posed<'_> {
        Posed {
            positions: &self.blended,
            maps: &self.maps,
        }
    }

    /// Blends both skins of the last pose. `fraction` is that of Sinew's, 0 to 1.
    pub fn blend(&mut self, fraction: f32) {
        let pairs = self.alone.iter().zip(&self.whole);
        self.blended.clear();
        self.blended
            .extend(pairs.map(|(&alone, &whole)| alone + (whole - alone) * fraction));
    }
}
