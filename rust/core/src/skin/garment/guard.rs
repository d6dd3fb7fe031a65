//! The safeguard of a garment: where its skin has more faults than with the Armature modifier alone, it follows the
//! body only so far that it stays above (mathematics/garments.md, Safeguard).

use glam::{Mat3A, Vec3A};

use crate::error::Result;
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

/// What is wrong with a garment in one pose.
struct Faults {
    /// Whether its skin is worse than the modifier's.
    is_worse: bool,
    /// Number of faulty faces.
    faces: usize,
    /// Number of places at which the body passes it.
    passed: usize,
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
        let mut found: Vec<(Compared, Faults)> = vec![];
        // the largest rotation first: it has most faults
        for pose in poses.iter().rev() {
            let Ok(compared) = self.compared(skin, pose) else {
                return Sample::HARMLESS; // a bone too far away for f32
            };
            let faults = self.faults(skin, rest_skin, &compared, 0.0);
            if found.is_empty() && faults.faces == 0 && !faults.is_worse {
                return Sample::HARMLESS; // smaller rotations fold it less
            }
            found.push((compared, faults));
        }
        if !found.iter().any(|(_, faults)| faults.is_worse) {
            return Sample::HARMLESS;
        }
        let passed = |of: &[Faults]| of.iter().map(|faults| faults.passed).sum::<usize>();
        let faces = |of: &[Faults]| of.iter().map(|faults| faults.faces).sum::<usize>();
        let (found, whole): (Vec<Compared>, Vec<Faults>) = found.into_iter().unzip();
        let (mut returning, mut fewest) = (0.0, (faces(&whole), passed(&whole)));
        for candidate in [1.0 - BLENDED, 1.0] {
            let after: Vec<Faults> = found
                .iter()
                .map(|compared| self.faults(skin, rest_skin, compared, candidate))
                .collect();
            let (faces, passed) = (faces(&after), passed(&after));
            if passed > fewest.1 {
                continue; // a body that passes the garment is worse than a fold in it
            }
            let is_harmless = after.iter().all(|faults| !faults.is_worse);
            if is_harmless || faces < fewest.0 {
                (returning, fewest) = (candidate, (faces, passed));
            }
            if is_harmless {
                break;
            }
        }
        if returning == 0.0 {
            return Sample::HARMLESS;
        }
        let mut moved: Vec<u32> = whole.into_iter().flat_map(|faults| faults.moved).collect();
        moved.sort_unstable();
        moved.dedup();
        Sample {
            crease: 1.0,
            returning,
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

    /// The faults of a garment that returns to its modifier by a fraction.
    fn faults(&self, skin: &Skin, rest_skin: &RestSkin, compared: &Compared, returning: f32) -> Faults {
        let Compared {
            alone,
            maps,
            body,
            modifier,
        } = compared;
        let garment = self.over(skin, body, modifier, &vec![1.0 - returning; alone.len()]);
        let positions: Vec<Vec3A> = alone
            .iter()
            .zip(&garment.offsets)
            .map(|(alone, offset)| *alone + *offset)
            .collect();
        let part = rest_skin.difference(alone, &positions);
        let posed = |positions| Posed { positions, maps };
        let (is_worse, faces) = rest_skin.compare(&part, posed(&positions), posed(alone));
        Faults {
            is_worse,
            faces,
            passed: self.passed(body, &positions),
            moved: part.moved,
        }
    }

    /// The number of places at which the body passes the garment: vertices of the garment below the body, and vertices of
    /// the body above the garment that covers them.
    fn passed(&self, body: &PosedBody, positions: &[Vec3A]) -> usize {
        let is_below = |(vertex, (tie, fraction)): &(usize, &(Tie, f32))| {
            let above = (positions[*vertex] - tie.mean(&body.positions)).dot(tie.mean(&body.normals));
            tie.thickness_m > 0.0 && *fraction == 1.0 && above < 0.0
        };
        let is_passing = |(vertex, tie): &&(u32, Tie)| {
            let vertex = *vertex as usize;
            let above = (tie.mean(positions) - body.positions[vertex]).dot(body.normals[vertex]);
            tie.thickness_m > 0.0 && above < 0.0
        };
        let vertices = self.of_vertices.iter().enumerate().filter(is_below).count();
        vertices + self.covers.iter().filter(is_passing).count()
    }
}
