//! Laws of the bellies below a vertex: what is deep raises the skin, too, and what is beyond the bone does not.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use sinew_core::{
    MotionSource, Musculature, Regional, RestMesh, Skeleton, Skin, SkinOptions, Tissue, TissueDescription,
    TissueKind,
};

use super::fixtures::rig::{columns, corrected};

const AROUND: usize = 48;
const ALONG: usize = 9;
const RADIUS_M: f64 = 0.06;

/// A bone along z in a tube of skin, and muscles beside it: (distance from the bone along x, half thickness), m.
fn tube(bellies: &[(f64, f64)], options: &SkinOptions) -> Skin {
    let heads = [0.0, 0.5].map(|z| columns(DAffine3::from_translation(DVec3::Z * z)));
    let skeleton = Skeleton::new(vec!["upper".into(), "lower".into()], &[-1, 0], &heads).unwrap();
    let muscle = |(index, &(x, half_m)): (usize, &(f64, f64))| {
        Tissue::new(TissueDescription {
            name: format!("muscle {index}"),
            kind: TissueKind::Muscle,
            origin_bone: 0,
            insertion_bone: 1,
            centre: [x, 0.0, 0.25],
            rotation: [1.0, 0.0, 0.0, 0.0],
            semi_axes: [half_m, 0.03, 0.2],
            origin_tendon_m: 0.02,
            insertion_tendon_m: 0.02,
            volume_keeping: 1.0,
            via_points: vec![],
            wraps: vec![],
        })
        .unwrap()
    };
    let tissues = bellies.iter().enumerate().map(muscle).collect();
    let points: Vec<[f32; 3]> = (0..AROUND * ALONG)
        .map(|vertex| {
            let angle = TAU * (vertex % AROUND) as f64 / AROUND as f64;
            let z = 0.05 * (vertex / AROUND) as f64 + 0.05;
            [
                (RADIUS_M * angle.cos()) as f32,
                (RADIUS_M * angle.sin()) as f32,
                z as f32,
            ]
        })
        .collect();
    let count = points.len() as i32;
    let mesh = RestMesh {
        points: &points,
        edges: &[],
        mesh_to_armature: &columns(DAffine3::IDENTITY),
        weight_offsets: &(0..=count).collect::<Vec<_>>(),
        weight_bones: &vec![0; points.len()],
        weights: &vec![1.0; points.len()],
    };
    Skin::new(
        Arc::new(Musculature::new(skeleton, tissues).unwrap()),
        &mesh,
        options,
    )
    .unwrap()
}

/// How far the skin at angle 0 in the middle of the tube rises with these tensions, m.
fn rise_m(bellies: &[(f64, f64)], tension: &[f32]) -> f64 {
    let skin = tube(bellies, &SkinOptions::default());
    let rest = [0.0, 0.5].map(|z| columns(DAffine3::from_translation(DVec3::Z * z)));
    let (offsets, _) = corrected(&skin, &rest, tension);
    f64::from(offsets[4 * AROUND][0])
}

/// A belly over another, the upper one 1 mm below the skin.
const STACK: [(f64, f64); 2] = [(0.047, 0.012), (0.022, 0.012)];
/// Gain in width at full tension (mathematics/muscles.md, Tension).
const GAIN: f64 = 0.195;

#[test]
fn a_deep_belly_raises_the_skin_through_the_one_above_it() {
    let [upper_m, deep_m, both_m] =
        [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|tension| rise_m(&STACK, &tension));
    assert!(deep_m > 1e-3, "{deep_m}");
    assert!(deep_m < upper_m, "{deep_m} {upper_m}");
    assert!((both_m - upper_m - deep_m).abs() < 1e-5, "{both_m}");
    // around a bone, what is gained at a radius is spread over that of the flesh
    let top_m = 0.059;
    let spread_m = |(x, half_m): (f64, f64)| GAIN * 2.0 * half_m * x / top_m;
    for (found_m, belly) in [(upper_m, STACK[0]), (deep_m, STACK[1])] {
        let expected_m = spread_m(belly);
        assert!(
            (found_m / expected_m - 1.0).abs() < 0.02,
            "{found_m} {expected_m}"
        );
    }
}

#[test]
fn a_belly_beyond_the_bone_does_not_raise_the_skin() {
    assert!(rise_m(&[STACK[0], (-0.03, 0.02)], &[0.0, 1.0]).abs() < 1e-9);
}

#[test]
fn bellies_that_overlap_count_once() {
    let alone_m = rise_m(&STACK[..1], &[1.0]);
    let twice_m = rise_m(&[STACK[0], STACK[0]], &[1.0, 1.0]);
    assert!((twice_m / alone_m - 1.0).abs() < 1e-4, "{alone_m} {twice_m}");
}

#[test]
fn a_slack_belly_does_not_thicken_without_bound() {
    let skin = tube(&STACK[..1], &SkinOptions::default());
    let rise_at = |height: f64| {
        let pose = [0.0, height].map(|z| columns(DAffine3::from_translation(DVec3::Z * z)));
        f64::from(corrected(&skin, &pose, &[0.0]).0[4 * AROUND][0])
    };
    // the belly of 0.4 m has 0.25, 0.125 and 0.06 of its length
    let [half_m, slack_m, slacker_m] = [0.2, 0.15, 0.125].map(rise_at);
    let alone_m = rise_m(&STACK[..1], &[1.0]) / GAIN;
    assert!(
        half_m < slack_m && slack_m < slacker_m,
        "{half_m} {slack_m} {slacker_m}"
    );
    assert!(slacker_m < 0.7 * alone_m, "{slacker_m} {alone_m}");
}

#[test]
fn other_options_anchor_to_the_surface_alone() {
    let scales_fat = SkinOptions {
        scales_fat: true,
        ..SkinOptions::default()
    };
    let influence = SkinOptions {
        muscle_influence: Regional::of_body(0.0),
        motion_source: MotionSource::Swelling,
        ..SkinOptions::default()
    };
    assert!(tube(&STACK, &scales_fat).anchored() > 0);
    assert_eq!(tube(&STACK, &influence).anchored(), 0);
}
