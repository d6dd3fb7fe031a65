//! The three factors of a setting multiply, blend as weights do, and change nothing if they are 1.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use proptest::prelude::*;
use sinew_core::{ColumnMajor, Elasticity, Error, Regional, SkinOptions};

use super::fixtures::rig::{
    ALONG, AROUND, Limb, PLAIN, SEGMENTS, corrected, deformed, edges, gap, mapped, no_tension, tensions,
    triangles, turns, weights,
};

const VERTICES: usize = AROUND * ALONG;
const BONES: usize = 3;

fn influenced(muscle_influence: Regional) -> SkinOptions {
    SkinOptions {
        muscle_influence,
        ..SkinOptions::default()
    }
}

/// A regional setting with these factors and a body value of 1.
fn factors<'a>(bones: &'a [f32], vertices: &'a [f32]) -> Regional<'a> {
    Regional {
        bones: Some(bones),
        vertices: Some(vertices),
        ..Regional::default()
    }
}

/// How far the muscles lift each vertex, m.
fn lifts(limb: &Limb, influence: Regional, pose: &[ColumnMajor], tension: &[f32]) -> Vec<DVec3> {
    let wide = |points: Vec<[f32; 3]>| {
        points
            .into_iter()
            .map(|point| DVec3::from_array(point.map(f64::from)))
    };
    let with = wide(deformed(&limb.skin(&influenced(influence)), pose, tension));
    let without = wide(deformed(
        &limb.skin(&influenced(Regional::of_body(0.0))),
        pose,
        tension,
    ));
    with.zip(without).map(|(with, without)| with - without).collect()
}

/// The mean factor of a vertex's bones, computed from the weights of this rig.
fn means(bones: &[f32]) -> Vec<f64> {
    let (offsets, bones_of, weights) = weights();
    let mean = |ends: &[i32]| {
        let row = ends[0] as usize..ends[1] as usize;
        let sum: f32 = weights[row.clone()].iter().sum();
        let factors = row.map(|entry| f64::from(weights[entry] / sum * bones[bones_of[entry] as usize]));
        if ends[0] == ends[1] { 1.0 } else { factors.sum() }
    };
    offsets.windows(2).map(mean).collect()
}

fn bone_factors() -> impl Strategy<Value = Vec<f32>> {
    prop::collection::vec(0.0f32..3.0, BONES)
}

fn vertex_factors() -> impl Strategy<Value = Vec<f32>> {
    prop::collection::vec(prop_oneof![Just(0.0f32), 0.0f32..3.0], VERTICES)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn factors_of_one_change_no_bit(turns in turns(1.5), tension in tensions()) {
        let pose = PLAIN.pose(&turns, DAffine3::IDENTITY);
        let (edges, triangles) = (edges(), triangles());
        let ones = factors(&[1.0; BONES], &[1.0; VERTICES]);
        let plain = Elasticity {
            safeguards: false,
            ..Elasticity::new(&edges, &triangles, SEGMENTS, 4)
        };
        let settings = Elasticity {
            anchor_stiffness: ones,
            edge_stiffness: ones,
            slack_m: Regional { body: 0.0, ..ones },
            relaxation: ones,
            fat_sliding: Regional { body: 0.0, ..ones },
            volume: Some(&[1.0; BONES]),
            crease: Some(&[1.0; BONES]),
            contact: Some(&[1.0; BONES]),
            ..plain
        };
        let expected = PLAIN.skin_with(&SkinOptions::default(), &plain).unwrap();
        let skin = PLAIN.skin_with(&influenced(ones), &settings).unwrap();
        prop_assert_eq!(corrected(&skin, &pose, &tension), corrected(&expected, &pose, &tension));
    }

    #[test]
    fn body_bones_and_vertices_multiply(
        body in 0.0..2.0, bones in bone_factors(), vertices in vertex_factors(), turns in turns(1.5), tension in tensions(),
    ) {
        let pose = PLAIN.pose(&turns, DAffine3::IDENTITY);
        let whole = lifts(&PLAIN, Regional::default(), &pose, &tension);
        let found = lifts(&PLAIN, Regional { body, ..factors(&bones, &vertices) }, &pose, &tension);
        for (((found, whole), mean), factor) in found.iter().zip(whole).zip(means(&bones)).zip(&vertices) {
            let factor = body * mean * f64::from(*factor);
            prop_assert!(found.distance(factor * whole) < 1e-6 * (1.0 + factor));
        }
    }

    #[test]
    fn no_muscle_moves_a_vertex_of_factor_zero(vertices in vertex_factors(), tension in tensions()) {
        let skin = PLAIN.skin(&influenced(factors(&[1.0; BONES], &vertices)));
        let (offsets, _) = corrected(&skin, &PLAIN.pose(&[0.2, 1.1, 0.4].map(DQuat::from_rotation_x), DAffine3::IDENTITY), &tension);
        for (offset, factor) in offsets.iter().zip(vertices) {
            prop_assert!(factor > 0.0 || *offset == [0.0; 3]);
        }
        prop_assert!(offsets.iter().any(|offset| *offset != [0.0; 3]));
    }

    #[test]
    fn a_mirrored_limb_is_influenced_as_its_mirror_image(bones in bone_factors(), vertices in vertex_factors(), turns in turns(1.5)) {
        let mirror = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)));
        let mirrored = Limb { placed: mirror };
        let of = |limb: &Limb| {
            let skin = limb.skin(&influenced(factors(&bones, &vertices)));
            deformed(&skin, &limb.pose(&turns, DAffine3::IDENTITY), &[0.7; 6])
        };
        prop_assert!(gap(&mapped(&of(&PLAIN), mirror), &of(&mirrored)) < 2e-5);
    }
}

#[test]
fn factors_however_large_stay_finite() {
    let skin = PLAIN.skin(&influenced(Regional {
        body: 1e300,
        ..factors(&[f32::MAX; BONES], &[f32::MAX; VERTICES])
    }));
    let (offsets, _) = corrected(&skin, &PLAIN.rest_pose(), &no_tension());
    assert!(offsets.as_flattened().iter().all(|number| number.is_finite()));
}

#[test]
fn a_setting_that_does_not_fit_is_refused_by_name() {
    type Spoil = for<'a> fn(&mut Elasticity<'a>);
    let spoils: [(Spoil, &str); 12] = [
        (
            |settings| settings.anchor_stiffness.body = -1.0,
            "anchor_stiffness is -1",
        ),
        (
            |settings| settings.edge_stiffness.bones = Some(&[1.0]),
            "edge_stiffness: expected 3 entries (one per bone), got 1",
        ),
        (
            |settings| settings.slack_m.vertices = Some(&[1.0]),
            "slack: expected 960 entries (one per vertex), got 1",
        ),
        (|settings| settings.slack_m.body = f64::INFINITY, "slack is inf"),
        (
            |settings| settings.relaxation.bones = Some(&[1.0, -0.5, 1.0]),
            "bone 1: relaxation is -0.5",
        ),
        (
            |settings| settings.relaxation.bones = Some(&[1.0, 1.0, f32::INFINITY]),
            "bone 2: relaxation is inf",
        ),
        (
            |settings| settings.fat_sliding.bones = Some(&[f32::NAN, 1.0, 1.0]),
            "bone 0: fat_sliding is NaN",
        ),
        (
            |settings| settings.fat_sliding.body = f64::NAN,
            "fat_sliding is NaN",
        ),
        (
            |settings| settings.volume = Some(&[1.0, 1.0, 1.5]),
            "bone 2: volume is 1.5",
        ),
        (
            |settings| settings.crease = Some(&[1.0; 4]),
            "crease: expected 3 entries (one per bone), got 4",
        ),
        (
            |settings| settings.contact = Some(&[-0.5, 1.0, 1.0]),
            "bone 0: contact is -0.5",
        ),
        (
            |settings| settings.contact = Some(&[f32::NAN, 1.0, 1.0]),
            "bone 0: contact is NaN",
        ),
    ];
    let (edges, triangles) = (edges(), triangles());
    let plain = Elasticity {
        safeguards: false,
        ..Elasticity::new(&edges, &triangles, SEGMENTS, 4)
    };
    assert!(PLAIN.skin_with(&SkinOptions::default(), &plain).is_ok());
    for (spoil, words) in spoils {
        let mut spoilt = plain;
        spoil(&mut spoilt);
        let error = PLAIN.skin_with(&SkinOptions::default(), &spoilt).unwrap_err();
        assert!(matches!(error, Error::Value { .. } | Error::Length { .. }));
        assert!(error.to_string().contains(words), "{error}");
    }
}
