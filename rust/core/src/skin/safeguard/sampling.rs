//! Samples a joint: compares Sinew's skin with the modifier's in rotations of the joint, all others at rest.

use glam::{DAffine3, DMat4, DQuat};
use rayon::prelude::*;

use crate::math::rows::Rows;
use crate::pose::ColumnMajor;
use crate::skin::mesh::along_skin::distances_along_skin;
use crate::skin::safeguard::faults::{are_more, is_longer};
use crate::skin::safeguard::guard::{Guard, Sample};
use crate::skin::safeguard::rest_skin::{Difference, Posed, RestSkin};
use crate::skin::safeguard::sampled_rotations::compared;
use crate::skin::safeguard::sampler::Sampler;
use crate::skin::skin::Skin;

/// Fraction of Sinew's skin that a joint keeps if the whole is worse than the modifier's, but not the blend of
/// both. Otherwise it keeps nothing. Measured: finer steps leave more poses between samples that are worse.
const BLENDED: f32 = 0.5;
/// Distance along the skin, over the size of the mesh, over which the return fades beyond the skin that the
/// joint moves. Other joints move that skin.
const FADES_OVER_SIZE: f32 = 0.02;

impl Skin {
    /// Samples what is `missing`: guarded bones, by index, and samples.
    pub(crate) fn sample(&self, guard: &Guard, missing: &[(usize, u32)]) {
        let rest_skin = guard.rest_skin(|| self.rest_skin(guard));
        let tasks = missing.len().div_ceil(rayon::current_num_threads());
        missing.par_chunks(tasks.max(1)).for_each(|missing| {
            let sample_all = |sampler: &mut Sampler| {
                for &(index, sample) in missing {
                    let found = self.sampled(guard, rest_skin, sampler, index, sample);
                    guard.store(index, sample, found);
                }
            };
            self.with_sampler(sample_all);
        });
    }

    fn sampled(
        &self,
        guard: &Guard,
        rest_skin: &RestSkin,
        sampler: &mut Sampler,
        index: usize,
        sample: u32,
    ) -> Sample {
        let mut poses = compared(sample as usize).map(|rotation| self.sampled_pose(guard, index, rotation));
        poses.reverse(); // the largest rotation has most faults
        let Some(whole) = self.comparisons(rest_skin, sampler, &poses, 1.0) else {
            return Sample::HARMLESS;
        };
        let is_harmless =
            |comparisons: &[Comparison]| !comparisons.iter().any(|comparison| comparison.is_worse);
        if is_harmless(&whole) {
            return Sample::HARMLESS;
        }
        let has_crease = self.has_crease(guard.bones[index].bone);
        let flat = has_crease
            .then(|| self.comparisons(rest_skin, sampler, &poses, 0.0))
            .flatten();
        if flat.as_deref().is_some_and(is_harmless) {
            return Sample {
                crease: 0.0,
                ..Sample::HARMLESS
            };
        }
        let faces = |of: &[Comparison]| of.iter().map(|comparison| comparison.faces).sum::<usize>();
        let (crease, comparisons) = match flat {
            Some(flat) if faces(&flat) < faces(&whole) => (0.0, flat),
            _ => (1.0, whole),
        };
        let is_blend_worse = poses.iter().zip(&comparisons).any(|(pose, comparison)| {
            self.pose_both(sampler, pose, crease);
            sampler.blend(BLENDED);
            rest_skin
                .compare(&comparison.part, sampler.blended(), sampler.alone())
                .0
        });
        let moved = comparisons.iter().flat_map(|comparison| &comparison.part.moved);
        let mut moved: Vec<u32> = moved.copied().collect();
        moved.sort_unstable();
        moved.dedup();
        Sample {
            crease,
            returning: if is_blend_worse { 1.0 } else { 1.0 - BLENDED },
            field: self.field(guard, rest_skin.size_m, &moved),
        }
    }

    /// Compares both skins in each pose, or only in the first if Sinew's has no fault there. `None` if a pose
    /// cannot be computed.
    fn comparisons(
        &self,
        rest_skin: &RestSkin,
        sampler: &mut Sampler,
        poses: &[Vec<ColumnMajor>],
        crease: f32,
    ) -> Option<Vec<Comparison>> {
        let mut comparisons: Vec<Comparison> = vec![];
        for pose in poses {
            if !self.pose_both(sampler, pose, crease) {
                return None;
            }
            let (whole, alone) = (sampler.whole(), sampler.alone());
            let part = rest_skin.difference(alone.positions, whole.positions);
            let (is_worse, faces) = rest_skin.compare(&part, whole, alone);
            let is_clean = comparisons.is_empty() && !part.moved.is_empty() && faces == 0;
            comparisons.push(Comparison {
                part,
                is_worse,
                faces,
            });
            if is_clean && !is_worse {
                break; // smaller rotations fold it less
            }
        }
        Some(comparisons)
    }

    fn rest_skin(&self, guard: &Guard) -> RestSkin {
        let sorted_indices = (0..self.len() as u32).map(|vertex| self.order.sorted_index(vertex));
        RestSkin::new(&guard.points, guard.triangles.clone(), sorted_indices.collect())
    }

    /// The pose in which a guarded bone has a rotation in its own axes, and all other bones are at rest.
    fn sampled_pose(&self, guard: &Guard, index: usize, rotation: DQuat) -> Vec<ColumnMajor> {
        let skeleton = self.musculature.skeleton();
        let guarded = &guard.bones[index];
        let rest = skeleton.rest();
        let head = DAffine3::from_translation(rest[guarded.bone].translation);
        let turned = head * DAffine3::from_quat(guarded.in_armature(rotation)) * head.inverse();
        let posed = |bone: usize| {
            let map = if skeleton.is_below(bone, guarded.bone) {
                turned * rest[bone]
            } else {
                rest[bone]
            };
            DMat4::from(map).to_cols_array().map(|entry| entry as f32)
        };
        (0..skeleton.len()).map(posed).collect()
    }

    fn has_crease(&self, bone: usize) -> bool {
        let joints = self.elastic.as_ref().map_or(&[][..], |elastic| &elastic.joints);
        joints
            .iter()
            .any(|joint| joint.joint.child == bone && joint.crease.is_some() && joint.crease_strength > 0.0)
    }

    /// The vertices that differ, which return fully, and those near them along the skin, which return less.
    fn field(&self, guard: &Guard, size_m: f32, moved: &[u32]) -> Vec<(u32, f32)> {
        let fades_m = f64::from(FADES_OVER_SIZE * size_m);
        let beside = guard.beside(|| {
            let welded = guard
                .triangles
                .iter()
                .map(|corners| corners.map(|corner| self.order.sorted_index(corner)));
            let ends = |[a, b, c]: [u32; 3]| [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)];
            Rows::from_set(self.points.len(), welded.flat_map(ends).collect())
        });
        let along_m = distances_along_skin(
            self.points.len(),
            moved.iter().copied(),
            fades_m,
            |vertex| beside.row(vertex),
            |from, to| f64::from(self.points[from].distance(self.points[to])),
            |_| true,
        );
        let reached = along_m
            .iter()
            .enumerate()
            .filter(|(_, along_m)| along_m.is_finite());
        reached
            .map(|(vertex, along_m)| (vertex as u32, (1.0 - along_m / fades_m) as f32))
            .collect()
    }
}

/// Sinew's skin and the modifier's in one pose.
struct Comparison {
    /// Where they differ.
    part: Difference,
    is_worse: bool,
    /// Number of faulty faces of Sinew's skin.
    faces: usize,
}

impl RestSkin {
    /// Whether the state `ours` is worse than `theirs` in a part of the skin, and the number of faulty faces of
    /// `ours`.
    fn compare(&self, part: &Difference, ours: Posed, theirs: Posed) -> (bool, usize) {
        if part.moved.is_empty() {
            return (false, 0);
        }
        let (our_stretches, their_stretches) = (self.stretches(ours), self.stretches(theirs));
        let stretch = our_stretches.percentile();
        // of `theirs` only that is found that can decide
        let is_stretched = is_longer(stretch, 1.0) && is_longer(stretch, their_stretches.percentile());
        let (inverted, crossing) = rayon::join(
            || self.inverted(part, ours, &our_stretches),
            || self.crossing(part, ours),
        );
        // pairs of which rounding decides may all intersect in ours, and none in theirs
        let crossing = crossing + self.doubtful(part);
        let is_inverted =
            are_more(inverted, 0) && are_more(inverted, self.inverted(part, theirs, &their_stretches));
        let is_crossing = are_more(crossing, 0) && are_more(crossing, self.crossing(part, theirs));
        (is_stretched || is_inverted || is_crossing, inverted + crossing)
    }
}
