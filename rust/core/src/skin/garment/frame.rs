//! One frame of a garment (mathematics/garments.md, A frame of a garment).

use glam::{Mat3A, Vec3A};
use rayon::prelude::*;

use crate::error::{Result, require_length};
use crate::parallel::OUTPUT_CHUNK;
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

/// How often the pushes are spread over their neighbours and completed. Each round spreads them by one ring of
/// vertices.
const ROUNDS: usize = 4;

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
        Ok((self.over(skin, &body, &modifier), modifier, report))
    }

    /// The garment over a posed body.
    fn over(&self, skin: &Skin, body: &PosedBody, modifier: &PosedModifier) -> PosedGarment {
        let maps: Vec<Displacement> = (0..skin.points.len())
            .into_par_iter()
            .map(|vertex| skin.modifier_map(&modifier.maps, vertex))
            .collect();
        let modifier_offsets: Vec<Vec3A> = maps
            .iter()
            .zip(&skin.points)
            .map(|(map, point)| map.at(*point))
            .collect();
        let carried: Vec<Vec3A> = self
            .of_vertices
            .iter()
            .map(|(tie, fraction)| tie.mean(&body.corrections) * *fraction)
            .collect();
        let carried_to: Vec<Vec3A> = (0..carried.len())
            .map(|vertex| skin.points[vertex] + modifier_offsets[vertex] + carried[vertex])
            .collect();
        let pushes = self.pushes(body, &carried_to);
        let offsets = carried.iter().zip(&pushes).map(|(one, other)| *one + *other);
        PosedGarment {
            offsets: offsets.collect(),
            maps,
            modifier_offsets,
        }
    }

    /// What keeps the garment at its distance from the body, if its vertices are at `carried_to`. The pushes are
    /// spread over neighbouring vertices, so that cloth beside a pushed vertex is not folded.
    fn pushes(&self, body: &PosedBody, carried_to: &[Vec3A]) -> Vec<Vec3A> {
        let mut pushes = vec![Vec3A::ZERO; carried_to.len()];
        self.keep_above(body, carried_to, &mut pushes);
        if pushes.iter().all(|push| *push == Vec3A::ZERO) {
            return pushes;
        }
        for _ in 0..ROUNDS {
            pushes = self.spread(&pushes);
            self.keep_above(body, carried_to, &mut pushes);
        }
        pushes
    }

    /// Half of each push, and half of the mean of its neighbours'.
    fn spread(&self, pushes: &[Vec3A]) -> Vec<Vec3A> {
        let spread = |vertex: usize| {
            let beside = self.beside.row(vertex);
            if beside.is_empty() {
                return pushes[vertex];
            }
            let sum: Vec3A = beside.iter().map(|&other| pushes[other as usize]).sum();
            (pushes[vertex] + sum / beside.len() as f32) * (0.5 * self.of_vertices[vertex].1)
        };
        let vertices = (0..pushes.len()).into_par_iter().with_min_len(OUTPUT_CHUNK);
        vertices.map(spread).collect()
    }

    /// Increases `pushes` until the triangles of the garment are above the vertices of the body that they cover, and
    /// its vertices above the body under them.
    fn keep_above(&self, body: &PosedBody, carried_to: &[Vec3A], pushes: &mut [Vec3A]) {
        let mut largest = vec![Vec3A::ZERO; pushes.len()];
        for (vertex, tie) in &self.covers {
            let vertex = *vertex as usize;
            let corners = tie.corners.map(|corner| corner as usize);
            let [a, b, c] = corners.map(|corner| carried_to[corner] + pushes[corner]);
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
                if push.length_squared() > largest[corner].length_squared() {
                    largest[corner] = push;
                }
            }
        }
        let complete = |(vertex, (push, largest)): (usize, (&mut Vec3A, &Vec3A))| {
            *push += *largest;
            let (tie, fraction) = &self.of_vertices[vertex];
            if *fraction == 0.0 {
                return;
            }
            let normal = tie.mean(&body.normals).normalize_or_zero();
            let distance_m = (carried_to[vertex] + *push - tie.mean(&body.positions)).dot(normal);
            *push += normal * (self.lacking_m(tie.thickness_m, distance_m) * *fraction);
        };
        let vertices = pushes.par_iter_mut().zip(&largest).enumerate();
        vertices.with_min_len(OUTPUT_CHUNK).for_each(complete);
    }

    /// How far a garment at this distance from the body must be pushed, m; 0 where it lies inside at rest.
    fn lacking_m(&self, thickness_m: f32, distance_m: f32) -> f32 {
        if thickness_m <= 0.0 {
            return 0.0;
        }
        (KEPT * thickness_m - distance_m).clamp(0.0, self.largest_push_m)
    }
}
