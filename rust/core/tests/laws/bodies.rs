//! Bodies for the laws of elastic skin: tubes of skin on straight arms, with lengths and distances as a law
//! needs them.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DAffine3, DQuat, DVec3};
use sinew_core::{
    ColumnMajor, Elasticity, Musculature, RestMesh, Segments, Skeleton, Skin, SkinOptions, Tissue,
    TissueDescription, TissueKind,
};

use super::curved_rig::wxyz;
use super::rig::columns;

pub const RADIUS_M: f64 = 0.05;
/// Height of the elbows. The lower arms end at twice this height.
pub const ELBOW_M: f64 = 0.3;
pub const ROUNDS: usize = 10;

/// A closed tube of skin along z.
struct Tube {
    radius_m: f64,
    around: usize,
    rings: usize,
}

const ARM: Tube = Tube {
    radius_m: RADIUS_M,
    around: 20,
    rings: 40,
};
/// With triangles wider than a finger.
const WIDE_ARM: Tube = Tube {
    radius_m: RADIUS_M,
    around: 8,
    rings: 20,
};
const FINGER: Tube = Tube {
    radius_m: 0.01,
    around: 10,
    rings: 60,
};

/// A rig with tissues and skin.
#[derive(Clone)]
pub struct Body {
    /// The head of each bone.
    pub heads: Vec<DVec3>,
    pub parents: Vec<i32>,
    /// Each bone is its own segment.
    segments: Vec<i32>,
    lengths_m: Vec<f32>,
    pub tissues: Vec<TissueDescription>,
    pub points: Vec<DVec3>,
    pub edges: Vec<[i32; 2]>,
    pub triangles: Vec<[i32; 3]>,
    /// The bones of each vertex and their weights.
    pub weights: Vec<Vec<(i32, f32)>>,
    /// The scale of the whole body, with which the lengths of its options are multiplied.
    pub scale: f64,
}

/// One arm along z: bone 0 below the elbow, bone 1 above it, and a body bone in the first.
pub fn arm() -> Body {
    let mut body = Body::of(&[(-1, DVec3::ZERO), (0, DVec3::Z * ELBOW_M)]);
    body.add_arm(0.0, [0, 1]);
    body.tissues
        .push(ball("humerus", TissueKind::Bone, 0, DVec3::Z * 0.15, 0.02));
    body
}

/// Two arms side by side, `apart_m` between their axes: the left of bones 1 and 2, the right of bones 3 and
/// 4, a trunk of bone 0 far below, and a muscle across each elbow.
pub fn arms(apart_m: f64) -> Body {
    let (left, right) = (-0.5 * apart_m * DVec3::X, 0.5 * apart_m * DVec3::X);
    let elbow = DVec3::Z * ELBOW_M;
    let mut body = Body::of(&[
        (-1, DVec3::Z * -1.0),
        (0, left),
        (1, left + elbow),
        (0, right),
        (3, right + elbow),
    ]);
    body.add_arm(left.x, [1, 2]);
    body.add_arm(right.x, [3, 4]);
    body.add_tube(&ARM, DVec3::Z * -1.0, 0.3, |_| vec![(0, 1.0)]);
    for (name, x, bone) in [("left", left.x, 1), ("right", right.x, 3)] {
        let muscle = ball(name, TissueKind::Muscle, bone, DVec3::new(x, 0.025, 0.2), 0.015);
        body.tissues.push(TissueDescription {
            insertion_bone: bone + 1,
            semi_axes: [0.015, 0.015, 0.12],
            origin_tendon_m: 0.02,
            insertion_tendon_m: 0.03,
            ..muscle
        });
    }
    body
}

/// A finger of bone 2, `apart_m` from the skin of an arm of bone 1, both along z, and a trunk of bone 0 far
/// below.
pub fn finger_on_wide_arm(apart_m: f64) -> Body {
    let finger = DVec3::X * (WIDE_ARM.radius_m * (TAU / 16.0).cos() + FINGER.radius_m + apart_m);
    let start = DVec3::Z * 0.2;
    let mut body = Body::of(&[(-1, DVec3::Z * -1.0), (0, DVec3::ZERO), (0, finger + start)]);
    body.add_tube(&WIDE_ARM, DVec3::ZERO, 2.0 * ELBOW_M, |_| vec![(1, 1.0)]);
    body.add_tube(&FINGER, finger + start, 0.2, |_| vec![(2, 1.0)]);
    body.add_tube(&ARM, DVec3::Z * -1.0, 0.3, |_| vec![(0, 1.0)]);
    for vertex in 0..WIDE_ARM.around * WIDE_ARM.rings + 2 {
        // with a face, not an edge, towards the finger
        body.points[vertex] = DQuat::from_rotation_z(TAU / 16.0) * body.points[vertex];
    }
    body.tissues
        .push(ball("humerus", TissueKind::Bone, 1, DVec3::Z * 0.15, 0.02));
    body
}

/// One arm of four bones with a muscle at each joint, so short that the regions of its joints overlap.
pub fn chain() -> Body {
    const LENGTH_M: f64 = 0.5 * ELBOW_M;
    let head = |bone: usize| DVec3::Z * (bone as f64 * LENGTH_M);
    let mut body = Body::of(&[(-1, head(0)), (0, head(1)), (1, head(2)), (2, head(3))]);
    body.add_tube(&ARM, DVec3::ZERO, 4.0 * LENGTH_M, |height_m| {
        let joint = (height_m / LENGTH_M).round().clamp(1.0, 3.0);
        let above = ((height_m - joint * LENGTH_M) / 0.08 + 0.5).clamp(0.0, 1.0) as f32;
        vec![(joint as i32 - 1, 1.0 - above), (joint as i32, above)]
    });
    for joint in 1..4 {
        let centre = head(joint) + DVec3::Y * 0.02;
        let muscle = ball(
            &format!("muscle {joint}"),
            TissueKind::Muscle,
            joint as i64 - 1,
            centre,
            0.012,
        );
        body.tissues.push(TissueDescription {
            insertion_bone: joint as i64,
            semi_axes: [0.012, 0.012, 0.05],
            ..muscle
        });
    }
    body.with_lengths(LENGTH_M as f32)
}

/// A spherical tissue.
pub fn ball(name: &str, kind: TissueKind, bone: i64, centre: DVec3, radius_m: f64) -> TissueDescription {
    TissueDescription {
        name: name.to_owned(),
        kind,
        origin_bone: bone,
        insertion_bone: bone,
        centre: centre.to_array(),
        rotation: wxyz(DQuat::IDENTITY),
        semi_axes: [radius_m; 3],
        origin_tendon_m: 0.0,
        insertion_tendon_m: 0.0,
        volume_keeping: 1.0,
        via_points: vec![],
        wraps: vec![],
    }
}

impl Body {
    fn of(bones: &[(i32, DVec3)]) -> Self {
        Self {
            heads: bones.iter().map(|(_, head)| *head).collect(),
            parents: bones.iter().map(|(parent, _)| *parent).collect(),
            segments: (0..bones.len() as i32).collect(),
            lengths_m: vec![ELBOW_M as f32; bones.len()],
            tissues: vec![],
            points: vec![],
            edges: vec![],
            triangles: vec![],
            weights: vec![],
            scale: 1.0,
        }
    }

    fn add_arm(&mut self, x: f64, bones: [i32; 2]) {
        self.add_tube(&ARM, DVec3::X * x, 2.0 * ELBOW_M, |height_m| {
            let lower = ((height_m - ELBOW_M) / 0.1 + 0.5).clamp(0.0, 1.0) as f32;
            vec![(bones[0], 1.0 - lower), (bones[1], lower)]
        });
    }

    /// A tube along z from `start`, with weights by height.
    fn add_tube(
        &mut self,
        tube: &Tube,
        start: DVec3,
        length_m: f64,
        weights: impl Fn(f64) -> Vec<(i32, f32)>,
    ) {
        let &Tube {
            radius_m,
            around: sides,
            rings,
        } = tube;
        let first = self.points.len();
        let at = |ring: usize, around: usize| (first + ring * sides + around % sides) as i32;
        for vertex in 0..rings * sides {
            let (ring, around) = (vertex / sides, vertex % sides);
            let height_m = length_m * ring as f64 / (rings - 1) as f64;
            let angle = TAU * around as f64 / sides as f64;
            let across = DVec3::new(angle.cos(), angle.sin(), 0.0) * radius_m;
            self.points.push(start + across + DVec3::Z * height_m);
            self.weights.push(weights(height_m));
            self.edges.push([at(ring, around), at(ring, around + 1)]);
            if ring + 1 < rings {
                let [a, b] = [at(ring, around), at(ring, around + 1)];
                let [d, c] = [at(ring + 1, around), at(ring + 1, around + 1)];
                self.edges.extend([[a, d], [a, c], [b, d]]);
                self.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
        for (ring, height_m) in [(0, 0.0), (rings - 1, length_m)] {
            let hub = self.points.len() as i32;
            self.points.push(start + DVec3::Z * height_m);
            self.weights.push(weights(height_m));
            for around in 0..sides {
                let [a, b] = [at(ring, around), at(ring, around + 1)];
                self.edges.push([a, hub]);
                self.triangles
                    .push(if ring == 0 { [b, a, hub] } else { [a, b, hub] });
            }
        }
    }

    /// The same body, `scale` times as large.
    pub fn scaled(mut self, scale: f64) -> Self {
        for place in self.heads.iter_mut().chain(&mut self.points) {
            *place *= scale;
        }
        for tissue in &mut self.tissues {
            for length_m in tissue.centre.iter_mut().chain(&mut tissue.semi_axes) {
                *length_m *= scale;
            }
            tissue.origin_tendon_m *= scale;
            tissue.insertion_tendon_m *= scale;
        }
        self.lengths_m
            .iter_mut()
            .for_each(|length_m| *length_m *= scale as f32);
        self.scale *= scale;
        self
    }

    /// The same body with bones of this length, m.
    pub fn with_lengths(mut self, length_m: f32) -> Self {
        self.lengths_m.fill(length_m);
        self
    }

    /// The vertices of a limb: those weighted to one of `bones`.
    pub fn limb(&self, bones: [i32; 2]) -> Vec<usize> {
        let hangs = |vertex: &usize| self.weights[*vertex].iter().any(|(bone, _)| bones.contains(bone));
        (0..self.points.len()).filter(hangs).collect()
    }

    fn rest(&self) -> Vec<DAffine3> {
        let along = DQuat::from_rotation_arc(DVec3::Y, DVec3::Z);
        let heads = self.heads.iter();
        heads
            .map(|&head| DAffine3::from_rotation_translation(along, head))
            .collect()
    }

    /// The rest pose with each bone rotated about its head in the axes of space, together with its children;
    /// then `after`.
    pub fn pose(&self, turns: &[DQuat], after: DAffine3) -> Vec<ColumnMajor> {
        let mut carried: Vec<DAffine3> = vec![];
        for ((&head, &parent), &turn) in self.heads.iter().zip(&self.parents).zip(turns) {
            let above = usize::try_from(parent).map_or(after, |parent| carried[parent]);
            carried.push(above * super::rig::rotation_about(head, turn));
        }
        let rest = self.rest();
        carried
            .into_iter()
            .zip(rest)
            .map(|(map, rest)| columns(map * rest))
            .collect()
    }

    /// The pose with some bones rotated about y, radians.
    pub fn bent(&self, bends: &[(usize, f64)]) -> Vec<ColumnMajor> {
        let mut turns = vec![DQuat::IDENTITY; self.heads.len()];
        for &(bone, angle) in bends {
            turns[bone] = DQuat::from_rotation_y(angle);
        }
        self.pose(&turns, DAffine3::IDENTITY)
    }

    pub fn relaxed(&self) -> Vec<f32> {
        vec![0.0; self.tissues.len()]
    }

    pub fn options(&self) -> SkinOptions<'static> {
        let plain = SkinOptions::default();
        SkinOptions {
            falloff_m: plain.falloff_m * self.scale,
            softness_m: plain.softness_m * self.scale,
            ..plain
        }
    }

    pub fn stiff(&self, options: &SkinOptions) -> Skin {
        self.with_mesh(|mesh| Skin::new(self.musculature(), mesh, options).unwrap())
    }

    /// The elastic skin with default settings as modified by `change`.
    pub fn elastic<'a>(&'a self, change: impl FnOnce(&mut Elasticity<'a>)) -> Skin {
        let segments = Segments {
            of_bone: &self.segments,
            lengths_m: &self.lengths_m,
        };
        let mut elasticity = Elasticity::new(&self.edges, &self.triangles, segments, ROUNDS);
        change(&mut elasticity);
        self.with_mesh(|mesh| {
            let skin = Skin::new(self.musculature(), mesh, &self.options()).unwrap();
            skin.with_elasticity(mesh, &elasticity).unwrap()
        })
    }

    fn musculature(&self) -> Arc<Musculature> {
        let names = (0..self.heads.len()).map(|bone| format!("bone {bone}")).collect();
        let rest: Vec<ColumnMajor> = self.rest().into_iter().map(columns).collect();
        let skeleton = Skeleton::new(names, &self.parents, &rest).unwrap();
        let tissues = self.tissues.iter().cloned();
        let tissues = tissues.map(|description| Tissue::new(description).unwrap());
        Arc::new(Musculature::new(skeleton, tissues.collect()).unwrap())
    }

    fn with_mesh(&self, bind: impl FnOnce(&RestMesh) -> Skin) -> Skin {
        let points: Vec<[f32; 3]> = self
            .points
            .iter()
            .map(|point| point.as_vec3().to_array())
            .collect();
        let (mut offsets, mut bones, mut weights) = (vec![0], vec![], vec![]);
        for own in &self.weights {
            bones.extend(own.iter().map(|(bone, _)| *bone));
            weights.extend(own.iter().map(|(_, weight)| *weight));
            offsets.push(bones.len() as i32);
        }
        bind(&RestMesh {
            points: &points,
            edges: &self.edges,
            mesh_to_armature: &columns(DAffine3::IDENTITY),
            weight_offsets: &offsets,
            weight_bones: &bones,
            weights: &weights,
        })
    }

    /// The volume enclosed by the triangles.
    pub fn volume(&self, points: &[[f32; 3]]) -> f64 {
        let place = |vertex: i32| wide(points[vertex as usize]);
        let volumes = self.triangles.iter().map(|&[a, b, c]| {
            let [a, b, c] = [a, b, c].map(place);
            a.dot(b.cross(c)) / 6.0
        });
        volumes.sum()
    }

    /// The unit normal of each vertex.
    pub fn normals(&self, points: &[[f32; 3]]) -> Vec<DVec3> {
        let mut normals = vec![DVec3::ZERO; points.len()];
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|vertex| wide(points[vertex as usize]));
            for vertex in triangle {
                normals[*vertex as usize] += (b - a).cross(c - a);
            }
        }
        normals.into_iter().map(DVec3::normalize_or_zero).collect()
    }
}

pub fn wide(point: [f32; 3]) -> DVec3 {
    DVec3::from_array(point.map(f64::from))
}
