//! Broad phase: the pairs of clusters that may touch in a pose (mathematics/contact.md, Skin contact).

use glam::{Affine3A, DMat4, Vec3A};

use crate::math::norm::frobenius_squared;
use crate::pose::Palette;
use crate::skin::contact::cluster::{BoneClusters, Pair};
use crate::skin::contact::contact::Contact;

/// Approach, over the sum of the radii, below which a pair counts as unchanged from rest. It is above the
/// rounding of f32.
const SMALLEST_APPROACH: f32 = 0.01;

impl Contact {
    /// Finds the pairs of clusters that may touch, in a fixed order: clusters of different segments that
    /// are nearer to each other than at rest, and those that face each other at rest if their skin is
    /// relaxed. `relaxed` is a buffer for whether any vertex of a cluster is relaxed.
    pub(crate) fn find_pairs(
        &self,
        palette: &Palette,
        is_relaxed: impl Fn(usize) -> bool,
        relaxed: &mut [bool],
        posed: &mut [PosedCluster],
        bones: &mut Vec<PosedBone>,
        pairs: &mut Vec<Pair>,
    ) {
        pairs.clear();
        for &cluster in &self.facing_clusters {
            let mut vertices = self.clusters[cluster as usize].vertices.clone();
            relaxed[cluster as usize] = vertices.any(&is_relaxed);
        }
        let any_relaxed = |pair: &Pair| relaxed[pair.one as usize] || relaxed[pair.other as usize];
        pairs.extend(self.facing_pairs.iter().copied().filter(any_relaxed));
        let matrix =
            |bone: usize| Affine3A::from_mat4(DMat4::from(palette.skinning_matrices()[bone]).as_mat4());
        for bone in &self.bones {
            let matrix = matrix(bone.bone);
            for index in bone.clusters.clone() {
                let cluster = &self.clusters[index];
                posed[index] = PosedCluster {
                    centre: matrix.transform_point3a(cluster.centre),
                    axis: matrix.transform_vector3a(cluster.axis).normalize_or_zero(),
                    scale: palette.scales()[bone.bone] as f32,
                };
            }
        }
        bones.clear();
        bones.extend(self.bones.iter().map(|bone| PosedBone::new(bone, palette)));
        for (index, (one, here)) in self.bones.iter().zip(&*bones).enumerate() {
            for (other, there) in self.bones.iter().zip(&*bones).skip(index + 1) {
                if one.segment != other.segment
                    && here.may_meet(there, self.reach_m)
                    && here.has_moved_against(there)
                {
                    self.find_pairs_of((one, here), (other, there), posed, pairs);
                }
            }
        }
    }

    fn find_pairs_of(
        &self,
        (one, one_posed): (&BoneClusters, &PosedBone),
        (other, other_posed): (&BoneClusters, &PosedBone),
        posed: &[PosedCluster],
        pairs: &mut Vec<Pair>,
    ) {
        let scale = one_posed.scale.max(other_posed.scale);
        let reach_m = self.reach_m * scale;
        let near = |centre: Vec3A, radius_m: f32, to: Vec3A, to_radius_m: f32| {
            let near_m = (radius_m + to_radius_m) * scale + reach_m;
            centre.distance_squared(to) <= near_m * near_m
        };
        for index in one.clusters.clone() {
            let (first, here) = (&self.clusters[index], &posed[index]);
            if !near(here.centre, first.radius_m, other_posed.centre, other.radius_m) {
                continue;
            }
            for other_index in other.clusters.clone() {
                let (second, there) = (&self.clusters[other_index], &posed[other_index]);
                if !near(here.centre, first.radius_m, there.centre, second.radius_m)
                    || here.axis.dot(there.axis) >= first.cone.and(second.cone).min_opposing_cos()
                {
                    continue;
                }
                let approach_m =
                    first.centre.distance(second.centre) * scale - here.centre.distance(there.centre);
                if approach_m > SMALLEST_APPROACH * (first.radius_m + second.radius_m) * scale {
                    pairs.push(Pair {
                        one: index as u32,
                        other: other_index as u32,
                    });
                }
            }
        }
    }

    /// Whether skin with this normal may face some of a posed cluster.
    pub(crate) fn may_face(&self, normal: Vec3A, cluster: u32, posed: &PosedCluster) -> bool {
        normal.dot(posed.axis) < self.clusters[cluster as usize].min_opposing_cos
    }
}

/// The clusters of a bone in a pose.
#[derive(Debug)]
pub(crate) struct PosedBone {
    matrix: Affine3A,
    rest_centre: Vec3A,
    centre: Vec3A,
    /// Radii of the sphere that contains the clusters and of the smallest cluster, m.
    radius_m: f32,
    smallest_m: f32,
    /// Uniform scale of the bone.
    scale: f32,
}

impl PosedBone {
    fn new(bone: &BoneClusters, palette: &Palette) -> Self {
        let matrix = Affine3A::from_mat4(DMat4::from(palette.skinning_matrices()[bone.bone]).as_mat4());
        let scale = palette.scales()[bone.bone] as f32;
        Self {
            matrix,
            rest_centre: bone.centre,
            centre: matrix.transform_point3a(bone.centre),
            radius_m: bone.radius_m * scale,
            smallest_m: bone.smallest_m * scale,
            scale,
        }
    }

    fn may_meet(&self, other: &Self, reach_m: f32) -> bool {
        let near_m = self.radius_m + other.radius_m + reach_m * self.scale.max(other.scale);
        self.centre.distance_squared(other.centre) < near_m * near_m
    }

    /// Whether any of its clusters may be nearer to one of the other bone's than at rest: not if both
    /// bones moved together.
    fn has_moved_against(&self, other: &Self) -> bool {
        let difference = self.matrix.matrix3 - other.matrix.matrix3;
        let shifted_m = self
            .centre
            .distance(other.matrix.transform_point3a(self.rest_centre));
        shifted_m + frobenius_squared(&difference).sqrt() * self.radius_m
            > SMALLEST_APPROACH * (self.smallest_m + other.smallest_m)
    }
}

/// A cluster in a pose.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PosedCluster {
    pub centre: Vec3A,
    pub axis: Vec3A,
    /// Uniform scale of its bone.
    pub scale: f32,
}
