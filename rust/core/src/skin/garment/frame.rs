//! One frame of a garment (mathematics/garments.md, A frame of a garment).

use glam::{Mat3A, Vec3A};
use rayon::prelude::*;

use crate::error::{Result, require_length};
use crate::pose::ColumnMajor;
use crate::skin::correction::inverse::{PosedOffset, invert, invert_each};
use crate::skin::frame_report::FrameReport;
use crate::skin::garment::body::PosedBody;
use crate::skin::garment::ties::Ties;
use crate::skin::skin::{Garment, Skin};
use crate::skin::skinning::displacement::Displacement;
use crate::skin::skinning::posed_modifier::PosedModifier;

/// Fraction of its distance from the body at rest that a garment keeps. Less than 1, so that rounding at rest
/// pushes nothing.
const KEPT: f32 = 0.98;

/// A garment's vertices in a frame, in sorted order.
struct PosedGarment {
    maps: Vec<Displacement>,
    /// The displacement by the Armature modifier, m.
    modifier_offsets: Vec<Vec3A>,
    /// The offset after the modifier, m.
    offsets: Vec<Vec3A>,
}

impl Garment for Ties {
    fn correct(
        &self,
        skin: &Skin,
        pose: &[ColumnMajor],
        tension: &[f32],
        out: &mut [[f32; 3]],
    ) -> Result<FrameReport> {
        require_length("out", skin.len(), "one per vertex", out.len())?;
        let (garment, modifier, mut report) = self.pose(skin, pose, tension)?;
        let mut sorted = vec![[0.0; 3]; garment.offsets.len()];
        let moved = garment
            .offsets
            .iter()
            .enumerate()
            .filter(|(_, offset)| **offset != Vec3A::ZERO);
        let posed = moved.map(|(vertex, &offset)| PosedOffset {
            key: vertex,
            linear: garment.maps[vertex].linear + Mat3A::IDENTITY,
            offset,
        });
        invert_each(posed, |vertex, rest| {
            sorted[vertex] = (skin.armature_to_mesh * rest.offset).to_array();
            report.damped += usize::from(rest.is_damped);
        });
        skin.order.to_mesh_order(&sorted, out);
        for (welded, weights) in skin.welded.iter() {
            let vertex = welded.sorted_index as usize;
            let map = modifier.maps.blend(weights, skin.preserved_fraction(vertex));
            let moved = garment.modifier_offsets[vertex] + garment.offsets[vertex];
            let rest = invert(map.linear + Mat3A::IDENTITY, moved - map.at(welded.point));
            out[welded.vertex as usize] = (skin.armature_to_mesh * rest.offset).to_array();
        }
        Ok(report)
    }

    fn deform(
        &self,
        skin: &Skin,
        pose: &[ColumnMajor],
        tension: &[f32],
        out: &mut [[f32; 3]],
    ) -> Result<FrameReport> {
        require_length("out", skin.len(), "one per vertex", out.len())?;
        let (garment, _, report) = self.pose(skin, pose, tension)?;
        let moved = garment
            .modifier_offsets
            .iter()
            .zip(&garment.offsets)
            .map(|(one, other)| *one + *other);
        let moved: Vec<Vec3A> = moved.map(|moved| skin.armature_to_mesh * moved).collect();
        let sorted: Vec<[f32; 3]> = skin
            .mesh_points
            .iter()
            .zip(&moved)
            .map(|(point, moved)| (*point + *moved).to_array())
            .collect();
        skin.order.to_mesh_order(&sorted, out);
        for (welded, _) in skin.welded.iter() {
            out[welded.vertex as usize] =
                (welded.mesh_point + moved[welded.sorted_index as usize]).to_array();
        }
        Ok(report)
    }

    fn following(&self) -> Vec<bool> {
        self.of_vertices
            .iter()
            .map(|(_, fraction)| *fraction > 0.0)
            .collect()
    }
}

impl Ties {
    fn pose(
        &self,
        skin: &Skin,
        pose: &[ColumnMajor],
        tension: &[f32],
    ) -> Result<(PosedGarment, PosedModifier, FrameReport)> {
        let (body, mut report) = self.body.pose(pose, tension)?;
        report.damped = 0;
        let modifier = skin.posed_modifier(pose)?;
        let vertices = 0..skin.points.len();
        let maps: Vec<Displacement> = vertices
            .into_par_iter()
            .map(|vertex| skin.modifier_map(&modifier.maps, vertex))
            .collect();
        let modifier_offsets: Vec<Vec3A> = maps
            .iter()
            .zip(&skin.points)
            .map(|(map, point)| map.at(*point))
            .collect();
        let posed = |vertex: usize| skin.points[vertex] + modifier_offsets[vertex];
        let mut offsets: Vec<Vec3A> = (0..maps.len())
            .into_par_iter()
            .map(|vertex| self.offset(vertex, posed(vertex), &body))
            .collect();
        self.keep_above(&body, posed, &mut offsets);
        let garment = PosedGarment {
            maps,
            modifier_offsets,
            offsets,
        };
        Ok((garment, modifier, report))
    }

    /// The offset of a garment's vertex that its modifier brings to `posed`: the correction of the body under
    /// it, and what keeps its distance from the body.
    fn offset(&self, vertex: usize, posed: Vec3A, body: &PosedBody) -> Vec3A {
        let (tie, fraction) = &self.of_vertices[vertex];
        if *fraction == 0.0 {
            return Vec3A::ZERO;
        }
        let carried = tie.mean(&body.corrections) * *fraction;
        let normal = tie.mean(&body.normals).normalize_or_zero();
        let distance_m = (posed + carried - tie.mean(&body.positions)).dot(normal);
        carried + normal * (self.lacking_m(tie.thickness_m, distance_m) * *fraction)
    }

    /// Pushes the garment's triangles out of the vertices of the body that they cover.
    fn keep_above(&self, body: &PosedBody, posed: impl Fn(usize) -> Vec3A, offsets: &mut [Vec3A]) {
        let mut pushes = vec![Vec3A::ZERO; offsets.len()];
        for (vertex, tie) in &self.covers {
            let vertex = *vertex as usize;
            let corners = tie.corners.map(|corner| corner as usize);
            let [a, b, c] = corners.map(|corner| posed(corner) + offsets[corner]);
            let [u, v, w] = tie.weights;
            let normal = body.normals[vertex];
            let distance_m = (a * u + b * v + c * w - body.positions[vertex]).dot(normal);
            let lacking_m = self.lacking_m(tie.thickness_m, distance_m);
            if lacking_m <= 0.0 {
                continue;
            }
            for corner in corners {
                let push = normal * (lacking_m * self.of_vertices[corner].1);
                // the largest push alone, so that the result does not grow with the number of vertices
                if push.length_squared() > pushes[corner].length_squared() {
                    pushes[corner] = push;
                }
            }
        }
        for (offset, push) in offsets.iter_mut().zip(pushes) {
            *offset += push;
        }
    }

    /// How far a garment at this distance from the body must be pushed, m; 0 where it lies inside at rest.
    fn lacking_m(&self, thickness_m: f32, distance_m: f32) -> f32 {
        if thickness_m <= 0.0 {
            return 0.0;
        }
        (KEPT * thickness_m - distance_m).clamp(0.0, self.largest_push_m)
    }
}
