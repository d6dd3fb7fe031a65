//! Laws of a skin that blends linear skinning and Preserve Volume at each vertex, as two Armature modifiers
//! with Multi Modifier do.

use glam::DAffine3;
use proptest::prelude::*;
use sinew_core::{Error, Regional, Skin, SkinOptions, Skinning};

use super::fixtures::rig::{PLAIN, corrected, deformed, gap, no_tension, options, tensions, turns};

/// The modifier alone on these rest points: a skin that no tissue moves.
fn modified(
    points: &[[f32; 3]],
    skinning: Skinning,
    fractions: Option<&[f32]>,
    pose: &[sinew_core::ColumnMajor],
) -> Vec<[f32; 3]> {
    let still = SkinOptions {
        skinning,
        preserved_fractions: fractions,
        muscle_influence: Regional::of_body(0.0),
        ..SkinOptions::default()
    };
    deformed(
        &PLAIN.skin_of(points, &DAffine3::IDENTITY, &still),
        pose,
        &no_tension(),
    )
}

fn fractions() -> impl Strategy<Value = Vec<f32>> {
    let fraction = prop_oneof![Just(0.0_f32), Just(1.0), 0.0..1.0_f32];
    prop::collection::vec(fraction, PLAIN.points().len())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn each_vertex_has_its_fraction_of_each_skinning(fractions in fractions(), turns in turns(2.0)) {
        let (points, pose) = (PLAIN.points(), PLAIN.pose(&turns, DAffine3::IDENTITY));
        let linear = modified(&points, Skinning::Linear, None, &pose);
        let preserving = modified(&points, Skinning::PreserveVolume, None, &pose);
        let blended = modified(&points, Skinning::Linear, Some(&fractions), &pose);
        for (vertex, &fraction) in fractions.iter().enumerate() {
            for axis in 0..3 {
                let expected = linear[vertex][axis] * (1.0 - fraction) + preserving[vertex][axis] * fraction;
                prop_assert!((blended[vertex][axis] - expected).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn the_modifiers_move_the_corrected_point_onto_the_skin(
        options in options(), fractions in fractions(), turns in turns(1.0), tension in tensions(),
    ) {
        prop_assume!(options.skinning != Skinning::None);
        let options = SkinOptions { preserved_fractions: Some(&fractions), ..options };
        let pose = PLAIN.pose(&turns, DAffine3::IDENTITY);
        let skin = PLAIN.skin(&options);
        let (offsets, damped) = corrected(&skin, &pose, &tension);
        prop_assume!(damped == 0);
        let add = |(point, offset): ([f32; 3], &[f32; 3])| std::array::from_fn(|axis| point[axis] + offset[axis]);
        let shifted: Vec<[f32; 3]> = PLAIN.points().into_iter().zip(&offsets).map(add).collect();
        let got = modified(&shifted, options.skinning, Some(&fractions), &pose);
        prop_assert!(gap(&got, &deformed(&skin, &pose, &tension)) < 1e-5);
    }
}

#[test]
fn fractions_are_one_per_vertex_from_0_to_1() {
    let refused = |fractions: &[f32]| {
        let options = SkinOptions {
            preserved_fractions: Some(fractions),
            ..SkinOptions::default()
        };
        PLAIN.try_skin(&options)
    };
    let count = PLAIN.points().len();
    let good = vec![0.5; count];
    assert!(refused(&good).is_ok());
    assert!(matches!(
        refused(&good[1..]),
        Err(Error::Length {
            list: "preserved_fractions",
            ..
        })
    ));
    for wrong in [-0.1, 1.1, f32::NAN] {
        let mut fractions = good.clone();
        fractions[2] = wrong;
        let error: sinew_core::Result<Skin> = refused(&fractions);
        assert!(error.is_err_and(|error| error.to_string().contains("vertex 2")));
    }
}
