//! Bodies and tissues for the laws of the fit: closed limbs with bumps, and tissues in and near them.

use std::f64::consts::TAU;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use proptest::prelude::*;
use sinew_core::TissueKind;
use sinew_core::fit::{PlacedTissue, Placement, PolygonMesh, Polygons, SkinSurface};

use super::fixtures::rig::columns;

/// A closed mesh of quads and triangles, with a polygon at each end.
#[derive(Debug, Clone)]
pub struct Limb {
    pub points: Vec<DVec3>,
    pub faces: Vec<Vec<u32>>,
}

impl Limb {
    pub fn transformed(&self, change: &DAffine3) -> Self {
        let mut limb = self.clone();
        limb.points
            .iter_mut()
            .for_each(|point| *point = change.transform_point3(*point));
        if change.matrix3.determinant() < 0.0 {
            limb.faces.iter_mut().for_each(|face| face.reverse());
        }
        limb
    }

    pub fn polygons(&self) -> Polygons {
        polygons(&self.points, &self.faces, None)
    }

    /// The corners of all triangles, each face as a fan around the mean of its corners.
    pub fn triangles(&self) -> Vec<[DVec3; 3]> {
        let mut triangles = vec![];
        for face in &self.faces {
            let corners: Vec<DVec3> = face
                .iter()
                .map(|&vertex| f32s(self.points[vertex as usize]))
                .collect();
            if let [a, b, c] = corners[..] {
                triangles.push([a, b, c]);
                continue;
            }
            let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
            for (index, &corner) in corners.iter().enumerate() {
                triangles.push([corner, corners[(index + 1) % corners.len()], middle]);
            }
        }
        triangles
    }
}

/// A point rounded to f32, as the core gets it.
pub fn f32s(point: DVec3) -> DVec3 {
    point.as_vec3().as_dvec3()
}

/// The polygons of a mesh, transformed to another space by `to_space`.
pub fn polygons(points: &[DVec3], faces: &[Vec<u32>], to_space: Option<DAffine3>) -> Polygons {
    let points: Vec<[f32; 3]> = points.iter().map(|point| point.as_vec3().to_array()).collect();
    let corners: Vec<i32> = faces.iter().flatten().map(|&vertex| vertex as i32).collect();
    let mut face_offsets = vec![0];
    face_offsets.extend(faces.iter().scan(0, |end, face| {
        *end += face.len() as i32;
        Some(*end)
    }));
    let matrix = to_space.map(columns);
    Polygons::new(&PolygonMesh {
        points: &points,
        corners: &corners,
        face_offsets: &face_offsets,
        to_space: matrix.as_ref(),
    })
    .unwrap()
}

pub fn surface(limbs: &[Limb]) -> SkinSurface {
    let all: Vec<Polygons> = limbs.iter().map(Limb::polygons).collect();
    SkinSurface::new(&all.iter().collect::<Vec<_>>()).unwrap()
}

/// The nearest point of a grid that f32 represents exactly, so that quarter turns and steps on it do not round.
fn snapped(point: DVec3) -> DVec3 {
    (point * 16_384.0).round() / 16_384.0
}

/// Quarter turns about all axes, and a step on the grid.
pub fn exact_motions() -> impl Strategy<Value = DAffine3> {
    let turns = proptest::collection::vec(0_usize..3, 0..4);
    (turns, vectors(0.5)).prop_map(|(axes, step)| {
        let quarter = |axis: usize| {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut turn = DMat3::ZERO;
            turn.col_mut(axis)[axis] = 1.0;
            turn.col_mut(next)[last] = 1.0;
            turn.col_mut(last)[next] = -1.0;
            turn
        };
        let turn = axes
            .into_iter()
            .fold(DMat3::IDENTITY, |turn, axis| quarter(axis) * turn);
        DAffine3::from_mat3_translation(turn, snapped(step))
    })
}

/// A limb along z, 1 m long and about 0.2 m thick, with bumps, bent by up to 0.1 m.
pub fn limb(around: usize, rings: usize, bumps: [f64; 4]) -> Limb {
    let [size, phase, twist, bend] = bumps;
    let mut points = vec![];
    for ring in 0..=rings {
        let along = 2.0 * ring as f64 / rings as f64 - 1.0;
        let width = 0.1 * (1.0 - 0.96 * along * along).sqrt();
        let middle = DVec3::new(bend * along * along, 0.0, 0.5 * along);
        for step in 0..around {
            let angle = TAU * step as f64 / around as f64;
            let radius = width * (1.0 + size * (2.0 * angle + phase + twist * along).sin());
            points.push(snapped(
                middle + DVec3::new(angle.cos(), 0.8 * angle.sin(), 0.0) * radius,
            ));
        }
    }
    let at = |ring: usize, step: usize| (ring * around + step % around) as u32;
    let mut faces = vec![(0..around).rev().map(|step| at(0, step)).collect::<Vec<_>>()];
    for ring in 0..rings {
        for step in 0..around {
            let quad = [
                at(ring, step),
                at(ring, step + 1),
                at(ring + 1, step + 1),
                at(ring + 1, step),
            ];
            if (ring + step) % 5 == 0 {
                faces.push(vec![quad[0], quad[1], quad[2]]);
                faces.push(vec![quad[0], quad[2], quad[3]]);
            } else {
                faces.push(quad.to_vec());
            }
        }
    }
    faces.push((0..around).map(|step| at(rings, step)).collect());
    Limb { points, faces }
}

pub fn limbs() -> impl Strategy<Value = Limb> {
    let bumps = (0.05..0.3, 0.0..TAU, -2.0..2.0, -0.1..0.1);
    (7_usize..16, 6_usize..14, bumps).prop_map(|(around, rings, (size, phase, twist, bend))| {
        limb(around, rings, [size, phase, twist, bend])
    })
}

/// Limbs, rotated and moved.
pub fn placed_limbs() -> impl Strategy<Value = Limb> {
    (limbs(), motions(0.15)).prop_map(|(limb, motion)| limb.transformed(&motion))
}

pub fn rotations() -> impl Strategy<Value = DQuat> {
    [-1.0..1.0_f64, -1.0..1.0, -1.0..1.0, 0.1..1.0]
        .prop_map(|[x, y, z, w]| DQuat::from_xyzw(x, y, z, w).normalize())
}

pub fn vectors(size: f64) -> impl Strategy<Value = DVec3> {
    [-size..size, -size..size, -size..size].prop_map(DVec3::from_array)
}

pub fn motions(size: f64) -> impl Strategy<Value = DAffine3> {
    (rotations(), vectors(size)).prop_map(|(turn, step)| DAffine3::from_rotation_translation(turn, step))
}

/// A tissue in or near a limb along z, often too thick or protruding.
pub fn tissues() -> impl Strategy<Value = PlacedTissue> {
    let kinds = prop_oneof![
        3 => Just(TissueKind::Muscle),
        1 => Just(TissueKind::Stuffing),
        1 => Just(TissueKind::Bone),
        1 => Just(TissueKind::Sphere),
    ];
    let centres = [-0.09..0.09, -0.07..0.07, -0.4..0.4_f64].prop_map(DVec3::from_array);
    let leans =
        (rotations(), 0.0..0.3_f64).prop_map(|(turn, fraction)| DQuat::IDENTITY.slerp(turn, fraction));
    let sizes = [0.01..0.07, 0.01..0.07, 0.05..0.3_f64].prop_map(DVec3::from_array);
    let via_points = proptest::collection::vec(vectors(0.05), 0..3);
    (kinds, centres, leans, sizes, via_points).prop_map(|(kind, centre, rotation, semi_axes, aside)| {
        let count = aside.len() as f64 + 1.0;
        let on_line = |index: usize| {
            let station = 2.0 * (index as f64 + 1.0) / count - 1.0;
            centre + rotation * (DVec3::Z * (semi_axes.z * station))
        };
        let via_points = aside
            .iter()
            .enumerate()
            .map(|(index, aside)| on_line(index) + *aside);
        placed(Placement {
            kind,
            centre,
            rotation,
            semi_axes,
            origin_tendon_m: 0.02,
            insertion_tendon_m: 0.03,
            via_points: if kind == TissueKind::Muscle {
                via_points.collect()
            } else {
                vec![]
            },
        })
    })
}

/// A tissue with both ends within the length of a limb, as in a preset.
pub fn tissues_within() -> impl Strategy<Value = PlacedTissue> {
    (tissues(), -0.2..0.2_f64).prop_map(|(tissue, along)| {
        let at = tissue.placement();
        let step = DVec3::Z * (along - at.centre.z);
        placed(Placement {
            centre: at.centre + step,
            semi_axes: at.semi_axes.with_z(at.semi_axes.z.min(0.2)),
            via_points: at.via_points.iter().map(|&point| point + step).collect(),
            ..*at
        })
    })
}

pub fn placed(at: Placement) -> PlacedTissue {
    PlacedTissue::new(at, || "tissue".to_owned()).unwrap()
}

/// A tissue moved or mirrored by `motion`, and scaled by `scale`.
pub fn changed(tissue: &PlacedTissue, motion: &DAffine3, scale: f64) -> PlacedTissue {
    let at = tissue.placement();
    let axes = DMat3::from_quat(at.rotation);
    let rigid = DMat3::from_cols_array(&motion.matrix3.to_cols_array().map(|number| number / scale));
    let (x, z) = (rigid * axes.x_axis, rigid * axes.z_axis);
    placed(Placement {
        centre: motion.transform_point3(at.centre),
        rotation: DQuat::from_mat3(&DMat3::from_cols(x, z.cross(x), z)),
        semi_axes: at.semi_axes * scale,
        origin_tendon_m: at.origin_tendon_m * scale,
        insertion_tendon_m: at.insertion_tendon_m * scale,
        via_points: at
            .via_points
            .iter()
            .map(|&point| motion.transform_point3(point))
            .collect(),
        ..*at
    })
}

/// The largest difference between two tissues, m.
pub fn difference_m(a: &PlacedTissue, b: &PlacedTissue) -> f64 {
    let (a, b) = (a.placement(), b.placement());
    if a.via_points.len() != b.via_points.len() {
        return f64::INFINITY;
    }
    let turn = DMat3::from_quat(a.rotation) - DMat3::from_quat(b.rotation);
    let turned_m = turn
        .to_cols_array()
        .into_iter()
        .fold(0.0, |most: f64, part| most.max(part.abs()));
    let vias = a
        .via_points
        .iter()
        .zip(&b.via_points)
        .map(|(a, b)| a.distance(*b));
    vias.chain([
        a.centre.distance(b.centre),
        a.semi_axes.distance(b.semi_axes),
        turned_m * a.semi_axes.z,
        (a.origin_tendon_m - b.origin_tendon_m).abs(),
        (a.insertion_tendon_m - b.insertion_tendon_m).abs(),
    ])
    .fold(0.0, f64::max)
}
