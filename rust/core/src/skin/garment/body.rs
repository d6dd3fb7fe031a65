//! The body under a garment: its rest surface, and its surface in a frame (mathematics/garments.md).

use std::sync::{Arc, Mutex, PoisonError};

use glam::{DVec3, Mat3A, Vec3A};
use rayon::prelude::*;

use crate::error::{Error, Result, require_triangles};
use crate::pose::ColumnMajor;
use crate::skin::frame_report::FrameReport;
use crate::skin::mesh::normals::normals;
use crate::skin::skin::Skin;

/// The body under a garment. Vertices are in the body's sorted order.
#[derive(Debug)]
pub(crate) struct Body {
    skin: Arc<Skin>,
    triangles: Vec<[u32; 3]>,
    /// Unit normals that point outward.
    normals: Vec<Vec3A>,
    /// 1, or -1 if the triangles' own normals point inward.
    outward: f32,
    /// Buffers that no frame uses.
    buffers: Mutex<Vec<Vec<[f32; 3]>>>,
}

/// The body in a frame, armature space.
pub(crate) struct PosedBody {
    /// The displacement of each vertex by the correction, m.
    pub corrections: Vec<Vec3A>,
    /// Each vertex, m.
    pub positions: Vec<Vec3A>,
    /// Unit normals that point outward.
    pub normals: Vec<Vec3A>,
}

impl Body {
    pub fn new(skin: Arc<Skin>, triangles: &[[i32; 3]]) -> Result<Self> {
        let triangles = skin
            .order
            .triangles(require_triangles(triangles, skin.len())?)
            .into_entries();
        if triangles.is_empty() {
            return Err(Error::NoFaces { mesh: 0 });
        }
        let points: Vec<DVec3> = skin.points.iter().map(|point| point.as_dvec3()).collect();
        let outward = if signed_volume_times_6(&points, &triangles) < 0.0 {
            -1.0
        } else {
            1.0
        };
        let normals = normals(&points, &triangles)
            .into_iter()
            .map(|normal| normal * outward)
            .collect();
        Ok(Self {
            skin,
            triangles,
            normals,
            outward,
            buffers: Mutex::default(),
        })
    }

    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    pub fn rest_points(&self) -> Vec<DVec3> {
        self.skin.points.iter().map(|point| point.as_dvec3()).collect()
    }

    pub fn rest_normals(&self) -> &[Vec3A] {
        &self.normals
    }

    /// The longest side of the box around the body, m.
    pub fn size_m(&self) -> f64 {
        let (low, high) = self
            .skin
            .points
            .iter()
            .fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(low, high), point| {
                (low.min(*point), high.max(*point))
            });
        f64::from((high - low).max_element())
    }

    /// The body as its modifiers show it.
    pub fn pose(&self, pose: &[ColumnMajor], tension: &[f32]) -> Result<(PosedBody, FrameReport)> {
        let skin = &*self.skin;
        let mut offsets = self.borrow_buffer();
        let report = skin.correct(pose, tension, &mut offsets)?;
        let modifier = skin.posed_modifier(pose)?;
        let to_armature = skin.armature_to_mesh.inverse();
        let mesh_indices: Vec<usize> = skin.order.vertices().collect();
        let posed = |(vertex, mesh_index): (usize, usize)| {
            let map = skin.modifier_map(&modifier.maps, vertex);
            let offset = to_armature * Vec3A::from_array(offsets[mesh_index]);
            let correction = (map.linear + Mat3A::IDENTITY) * offset;
            (
                correction,
                skin.points[vertex] + map.at(skin.points[vertex]) + correction,
            )
        };
        let (corrections, positions): (Vec<Vec3A>, Vec<Vec3A>) =
            mesh_indices.into_par_iter().enumerate().map(posed).unzip();
        let normals = self.posed_normals(&positions);
        self.buffers
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push(offsets);
        let body = PosedBody {
            corrections,
            positions,
            normals,
        };
        Ok((body, report))
    }

    fn posed_normals(&self, positions: &[Vec3A]) -> Vec<Vec3A> {
        let mut normals = vec![Vec3A::ZERO; positions.len()];
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|corner| positions[corner as usize]);
            let normal = (b - a).cross(c - a) * self.outward;
            triangle
                .iter()
                .for_each(|&corner| normals[corner as usize] += normal);
        }
        normals.into_iter().map(Vec3A::normalize_or_zero).collect()
    }

    fn borrow_buffer(&self) -> Vec<[f32; 3]> {
        let idle = self.buffers.lock().unwrap_or_else(PoisonError::into_inner).pop();
        idle.unwrap_or_else(|| vec![[0.0; 3]; self.skin.len()])
    }
}

/// Six times the volume of the cones from the triangles to the mean of the points, m³.
fn signed_volume_times_6(points: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let mean = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let cone = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|corner| points[corner as usize] - mean);
        a.dot(b.cross(c))
    };
    triangles.iter().map(cone).sum()
}
