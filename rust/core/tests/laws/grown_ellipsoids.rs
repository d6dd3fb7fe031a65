//! Ellipsoids to grow a skin over, and properties of every grown skin.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::{DAffine3, DQuat, DVec3};
use proptest::prelude::*;
use sinew_core::surface::LEAST_QUALITY;
use sinew_core::{
    GrowOptions, GrownSkin, Musculature, Progress, Skeleton, SkinBones, Tissue, TissueDescription,
    TissueKind, grow,
};

use super::rig::columns;

/// An ellipsoid: centre, rotation, semi-axes.
#[derive(Debug, Clone, Copy)]
pub struct Shape(pub DVec3, pub DQuat, pub DVec3);

pub fn upright(centre: [f64; 3], semi_axes: [f64; 3]) -> Shape {
    Shape(centre.into(), DQuat::IDENTITY, semi_axes.into())
}

pub fn ball(x: f64, radius: f64) -> Shape {
    upright([x, 0.0, 0.0], [radius; 3])
}

/// The ellipsoids as stuffing, each on its own bone at its centre.
pub fn musculature(shapes: &[Shape]) -> Musculature {
    let names: Vec<String> = (0..shapes.len()).map(|index| index.to_string()).collect();
    let rest: Vec<_> = shapes
        .iter()
        .map(|shape| columns(DAffine3::from_translation(shape.0)))
        .collect();
    let skeleton = Skeleton::new(names.clone(), &vec![-1; shapes.len()], &rest).unwrap();
    let tissue = |(index, (name, shape)): (usize, (&String, &Shape))| {
        Tissue::new(TissueDescription {
            name: name.clone(),
            kind: TissueKind::Stuffing,
            origin_bone: index as i64,
            insertion_bone: index as i64,
            centre: shape.0.to_array(),
            rotation: [shape.1.w, shape.1.x, shape.1.y, shape.1.z],
            semi_axes: shape.2.to_array(),
            origin_tendon_m: 0.0,
            insertion_tendon_m: 0.0,
            volume_keeping: 1.0,
            via_points: vec![],
            wraps: vec![],
        })
        .unwrap()
    };
    let tissues = names.iter().zip(shapes).enumerate().map(tissue).collect();
    Musculature::new(skeleton, tissues).unwrap()
}

pub fn try_grow(shapes: &[Shape], options: &GrowOptions) -> sinew_core::Result<GrownSkin> {
    let musculature = musculature(shapes);
    let weight_bones: Vec<usize> = (0..shapes.len()).collect();
    let bones = SkinBones {
        lengths_m: &vec![0.05; shapes.len()],
        weight_bones: &weight_bones,
    };
    grow(
        &musculature,
        &vec![0.0; shapes.len()],
        bones,
        options,
        &Progress::default(),
    )
}

pub fn grown(shapes: &[Shape], options: &GrowOptions) -> GrownSkin {
    try_grow(shapes, options).unwrap()
}

pub fn at(resolution: u32) -> GrowOptions {
    GrowOptions {
        resolution,
        ..GrowOptions::default()
    }
}

pub fn points(skin: &GrownSkin) -> Vec<DVec3> {
    skin.points
        .iter()
        .map(|point| DVec3::from_array(point.map(f64::from)))
        .collect()
}

/// Area and volume, with each quad split into two triangles.
pub fn area_and_volume(skin: &GrownSkin) -> (f64, f64) {
    let points = points(skin);
    let triangles = skin.quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    triangles.fold((0.0, 0.0), |(area, volume), triangle| {
        let [a, b, c] = triangle.map(|corner| points[corner as usize]);
        let normal = (b - a).cross(c - a);
        (area + 0.5 * normal.length(), volume + a.dot(normal) / 6.0)
    })
}

/// Checks that each edge has a face on either side and that the faces around each vertex form one fan;
/// returns V - E + F.
pub fn require_closed_manifold(skin: &GrownSkin) -> i64 {
    let mut sides = HashMap::new();
    // for each vertex and each face around it: from the corner before the vertex to the corner after it
    let mut fans: Vec<HashMap<i32, i32>> = vec![HashMap::new(); skin.points.len()];
    for quad in &skin.quads {
        for corner in 0..4 {
            let [before, own, after] = [3, 4, 5].map(|step| quad[(corner + step) % 4]);
            assert!(
                sides.insert((own, after), ()).is_none(),
                "two faces on one side of an edge"
            );
            assert!(fans[own as usize].insert(after, before).is_none());
        }
    }
    for &(from, to) in sides.keys() {
        assert!(sides.contains_key(&(to, from)), "the edge {from} {to} is open");
    }
    for fan in fans {
        assert!(fan.len() >= 3, "a vertex with {} faces", fan.len());
        let start = *fan.keys().next().unwrap();
        let around = std::iter::successors(Some(fan[&start]), |next| (*next != start).then(|| fan[next]));
        assert_eq!(around.count(), fan.len(), "a vertex where surfaces meet");
    }
    skin.points.len() as i64 - sides.len() as i64 / 2 + skin.quads.len() as i64
}

pub fn require_sound(skin: &GrownSkin) {
    let euler = require_closed_manifold(skin);
    let pieces = skin.report.pieces as i64;
    assert!(
        euler % 2 == 0 && euler <= 2 * pieces,
        "Euler characteristic {euler} of {pieces} pieces"
    );
    assert!(
        area_and_volume(skin).1 > 0.0,
        "the faces look inward: {:?}",
        skin.report
    );
    assert!(
        skin.report.worst_quality >= LEAST_QUALITY,
        "worst face {}",
        skin.report.worst_quality
    );
    assert_eq!(skin.weights.offsets.len(), skin.points.len() + 1);
    for row in skin.weights.offsets.windows(2) {
        let weights = &skin.weights.weights[row[0] as usize..row[1] as usize];
        assert!(
            (weights.iter().sum::<f32>() - 1.0).abs() < 1e-5 && weights.iter().all(|&weight| weight > 0.0)
        );
    }
}

pub fn shapes() -> impl Strategy<Value = Vec<Shape>> {
    let centre = prop::array::uniform3(-0.5..0.5);
    let turn = prop::array::uniform3(-PI..PI);
    let semi_axes = prop::array::uniform3((0.003_f64.ln()..0.35_f64.ln()).prop_map(f64::exp));
    let shape = (centre, turn, semi_axes).prop_map(|(centre, turn, semi_axes)| {
        Shape(
            centre.into(),
            DQuat::from_scaled_axis(turn.into()),
            semi_axes.into(),
        )
    });
    prop::collection::vec(shape, 1..12)
}

pub fn options() -> impl Strategy<Value = GrowOptions> {
    let faces = prop_oneof![Just(None), (60_usize..2000).prop_map(Some)];
    (
        8_u32..48,
        0_u32..7,
        1_u32..3,
        0.0..2.0,
        0.0..0.05,
        faces,
        any::<bool>(),
    )
        .prop_map(
            |(resolution, smoothing, radius, decay, thickness_m, faces, symmetric)| GrowOptions {
                resolution,
                smoothing,
                radius,
                decay,
                thickness_m,
                faces,
                symmetric,
                ..GrowOptions::default()
            },
        )
}
