//! The safeguard of a garment: where its skin has more faults than with the Armature modifier alone, it follows the
//! body only so far that it stays above (mathematics/garments.md, Safeguard).

use glam::{DVec3, Mat3A, Vec3A};
use rayon::prelude::*;

use crate::error::Result;
use crate::fit::{FaceTree, Polygons};
use crate::pose::{ColumnMajor, Palette};
use crate::skin::garment::body::PosedBody;
use crate::skin::garment::ties::{Tie, Ties};
use crate::skin::safeguard::guard::{Guard, Sample};
use crate::skin::safeguard::rest_skin::{Posed, RestSkin};
use crate::skin::safeguard::sampled_rotations::{Counted, compared, counted};
use crate::skin::safeguard::sampling::BLENDED;
use crate::skin::skin::Skin;
use crate::skin::skinning::posed_modifier::PosedModifier;

/// A garment in one pose without its correction, and over the body.
struct Compared {
    alone: Vec<Vec3A>,
    maps: Vec<Mat3A>,
    body: PosedBody,
    modifier: PosedModifier,
}

/// A garment that follows its body by some fraction in one pose.
struct Followed {
    positions: Vec<Vec3A>,
    /// Whether its skin is worse than the modifier's.
    is_worse: bool,
    /// Number of faulty faces.
    faces: usize,
    /// The vertices that differ from the modifier's.
    moved: Vec<u32>,
}

impl Ties {
    /// How fully each vertex of the garment follows the body, 0 to 1, in sorted order. Samples what is not known.
    pub fn kept(&self, skin: &Skin, guard: &Guard, pose: &[ColumnMajor]) -> Result<Vec<f32>> {
        let palette = Palette::new(skin.musculature().skeleton(), pose)?;
        let mut all: Vec<(usize, Counted)> = vec![];
        for (index, bone) in guard.bones.iter().enumerate() {
            counted(bone.rotation(&palette), |entry| all.push((index, entry)));
        }
        let mut kept = vec![1.0; skin.points.len()];
        for (index, entry) in all {
            // one after another: each poses the whole body, in parallel
            if guard.sample(index, entry.sample).is_none() {
                guard.store(
                    index,
                    entry.sample,
                    self.sampled(skin, guard, index, entry.sample),
                );
            }
            let Some(sample) = guard.sample(index, entry.sample) else {
                continue;
            };
            for &(vertex, fraction) in &sample.field {
                kept[vertex as usize] *= 1.0 - entry.weight * sample.returning * fraction;
            }
        }
        Ok(kept)
    }

    /// Compares the garment with its modifier in the rotations of one sample.
    fn sampled(&self, skin: &Skin, guard: &Guard, index: usize, sample: u32) -> Sample {
        let rest_skin = guard.rest_skin(|| skin.rest_skin(guard));
        let poses = compared(sample as usize).map(|rotation| skin.sampled_pose(guard, index, rotation));
        let mut found: Vec<(Compared, Followed)> = vec![];
        // the largest rotation first: it has most faults
        for pose in poses.iter().rev() {
            let Ok(compared) = self.compared(skin, pose) else {
                return Sample::HARMLESS; // a bone too far away for f32
            };
            let whole = self.followed(skin, rest_skin, &compared, 1.0);
            if found.is_empty() && whole.faces == 0 && !whole.is_worse {
                return Sample::HARMLESS; // smaller rotations fold it less
            }
            found.push((compared, whole));
        }
        if !found.iter().any(|(_, whole)| whole.is_worse) {
            return Sample::HARMLESS;
        }
        let is_better = |kept: f32| {
            found.iter().all(|(compared, whole)| {
                let less = self.followed(skin, rest_skin, compared, kept);
                !less.is_worse && {
                    let passed = |positions| self.passed(&compared.body, positions);
                    passed(&less.positions) <= passed(&whole.positions)
                }
            })
        };
        let Some(kept) = [BLENDED, 0.0].into_iter().find(|&kept| is_better(kept)) else {
            return Sample::HARMLESS;
        };
        let mut moved: Vec<u32> = found.into_iter().flat_map(|(_, whole)| whole.moved).collect();
        moved.sort_unstable();
        moved.dedup();
        Sample {
            crease: 1.0,
            returning: 1.0 - kept,
            field: skin.field(guard, rest_skin.size_m, &moved),
        }
    }

    fn compared(&self, skin: &Skin, pose: &[ColumnMajor]) -> Result<Compared> {
        let (body, _) = self.body.pose(pose, &vec![0.0; skin.musculature().len()])?;
        let modifier = skin.posed_modifier(pose)?;
        let vertices = 0..skin.points.len();
        let maps = vertices.map(|vertex| skin.modifier_map(&modifier.maps, vertex));
        let (alone, maps) = maps
            .zip(&skin.points)
            .map(|(map, point)| (*point + map.at(*point), map.linear + Mat3A::IDENTITY))
            .unzip();
        Ok(Compared {
            alone,
            maps,
            body,
            modifier,
        })
    }

    /// The garment that follows its body by a fraction.
    fn followed(&self, skin: &Skin, rest_skin: &RestSkin, compared: &Compared, kept: f32) -> Followed {
        let Compared {
            alone,
            maps,
            body,
            modifier,
        } = compared;
        let garment = self.over(skin, body, modifier, &vec![kept; alone.len()]);
        let positions: Vec<Vec3A> = alone
            .iter()
            .zip(&garment.offsets)
            .map(|(alone, offset)| *alone + *offset)
            .collect();
        let part = rest_skin.difference(alone, &positions);
        let posed = |positions| Posed { positions, maps };
        let (is_worse, faces) = rest_skin.compare(&part, posed(&positions), posed(alone));
        Followed {
            positions,
            is_worse,
            faces,
            moved: part.moved,
        }
    }

    /// The number of places at which the body passes the garment: vertices of the garment inside of the body, and
    /// vertices of the body above the garment that covers them.
    fn passed(&self, body: &PosedBody, positions: &[Vec3A]) -> usize {
        let triangles = self.body.triangles();
        let points: Vec<DVec3> = body.positions.iter().map(|point| point.as_dvec3()).collect();
        let tree = FaceTree::new(&Polygons::of_triangles(points, triangles));
        let is_inside = |(vertex, (tie, fraction)): &(usize, &(Tie, f32))| {
            if tie.thickness_m <= 0.0 || *fraction < 1.0 {
                return false;
            }
            let position = positions[*vertex].as_dvec3();
            tree.nearest(position).is_some_and(|nearest| {
                let corners = triangles[nearest.face].map(|corner| body.normals[corner as usize]);
                let normal = corners[0] + corners[1] + corners[2];
                (position - nearest.point).dot(normal.as_dvec3()) < 0.0
            })
        };
        let is_passing = |(vertex, tie): &&(u32, Tie)| {
            let vertex = *vertex as usize;
            let above = (tie.mean(positions) - body.positions[vertex]).dot(body.normals[vertex]);
            tie.thickness_m > 0.0 && above < 0.0
        };
        let vertices = self.of_vertices.par_iter().enumerate();
        vertices.filter(is_inside).count() + self.covers.iter().filter(is_passing).count()
    }
}
