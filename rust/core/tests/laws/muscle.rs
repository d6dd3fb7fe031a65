//! A posed muscle keeps its volume and width ratio, and moves with its bones.

use std::f64::consts::PI;

use glam::{DAffine3, DMat4, DVec3};
use proptest::prelude::*;
use sinew_core::{Musculature, Palette, Skeleton, Tissue, TissueDescription, TissueKind};

use super::fixtures::rig::{PLAIN, TISSUES, columns, motions, tensions, turns};

/// One muscle of any shape between two separate bones.
fn muscle(semi_axes: [f64; 3], tendons: [f64; 2], volume_keeping: f64) -> Musculature {
    let rest = [DAffine3::IDENTITY, DAffine3::from_translation(DVec3::Z)].map(columns);
    let skeleton = Skeleton::new(vec!["a".into(), "b".into()], &[-1, 0], &rest).unwrap();
    let tissue = Tissue::new(TissueDescription {
        name: "belly".into(),
        kind: TissueKind::Muscle,
        origin_bone: 0,
        insertion_bone: 1,
        centre: [0.1, 0.2, 0.4],
        rotation: [0.9, 0.1, -0.2, 0.05],
        semi_axes,
        origin_tendon_m: tendons[0],
        insertion_tendon_m: tendons[1],
        volume_keeping,
        via_points: vec![],
        wraps: vec![],
    })
    .unwrap();
    Musculature::new(skeleton, vec![tissue]).unwrap()
}

/// The palette with bone b moved.
fn shifted(musculature: &Musculature, shift: [f64; 3]) -> Palette {
    let posed = DAffine3::from_translation(DVec3::Z + DVec3::from_array(shift));
    Palette::new(
        musculature.skeleton(),
        &[columns(DAffine3::IDENTITY), columns(posed)],
    )
    .unwrap()
}

fn widths(matrix: &DMat4) -> [f64; 3] {
    [
        matrix.x_axis.length(),
        matrix.y_axis.length(),
        matrix.z_axis.length(),
    ]
}

proptest! {
    #[test]
    fn a_belly_keeps_its_volume_and_width_ratio_at_any_length_and_tension(
        semi_axes in prop::array::uniform3(0.005..0.2f64),
        tendons in prop::array::uniform2(0.0..0.1f64),
        shift in prop::array::uniform3(-2.0..2.0f64),
        tension in 0.0f32..=1.0,
    ) {
        let musculature = muscle(semi_axes, tendons, 1.0);
        let posed = musculature.pose(&shifted(&musculature, shift), &[tension]).unwrap();
        let [x, y, z] = widths(&posed.matrices[0]);
        let volume = 4.0 / 3.0 * PI * semi_axes.iter().product::<f64>();
        prop_assert!((posed.volume[0] / volume - 1.0).abs() < 1e-6);
        prop_assert!((4.0 / 3.0 * PI * x * y * z / volume - 1.0).abs() < 1e-6);
        prop_assert!((x / y / (semi_axes[0] / semi_axes[1]) - 1.0).abs() < 1e-6);
        prop_assert!((z / semi_axes[2] / posed.stretch[0] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn volume_keeping_zero_keeps_the_widths(shift in prop::array::uniform3(-0.1..0.5f64)) {
        let musculature = muscle([0.02, 0.03, 0.1], [0.0, 0.0], 0.0);
        let posed = musculature.pose(&shifted(&musculature, shift), &[0.0]).unwrap();
        let [x, y, _] = widths(&posed.matrices[0]);
        prop_assert!((x - 0.02).abs() < 1e-9 && (y - 0.03).abs() < 1e-9);
    }

    #[test]
    fn tendons_keep_their_lengths(shift in prop::array::uniform3(-0.05..0.5f64)) {
        let musculature = muscle([0.02, 0.03, 0.1], [0.03, 0.05], 1.0);
        let palette = shifted(&musculature, shift);
        let own = musculature.tissues()[0].muscle().unwrap();
        let origin = palette.skinning_matrices()[0].transform_point3(own.origin.point);
        let insertion = palette.skinning_matrices()[1].transform_point3(own.insertion.point);
        let posed = musculature.pose(&palette, &[0.0]).unwrap();
        prop_assume!(posed.clamped.is_empty());
        let length = 2.0 * widths(&posed.matrices[0])[2];
        prop_assert!((insertion.distance(origin) - length - 0.08).abs() < 1e-9);
    }

    #[test]
    fn a_posed_tissue_moves_with_the_rig(turns in turns(2.0), tension in tensions(), motion in motions()) {
        let musculature = PLAIN.musculature();
        let at = |after| Palette::new(musculature.skeleton(), &PLAIN.pose(&turns, after)).unwrap();
        let here = musculature.pose(&at(DAffine3::IDENTITY), &tension).unwrap();
        let there = musculature.pose(&at(motion), &tension).unwrap();
        for tissue in 0..TISSUES {
            let due = DMat4::from(motion) * here.matrices[tissue];
            prop_assert!(due.abs_diff_eq(there.matrices[tissue], 5e-6), "{tissue}");
            prop_assert!((here.volume[tissue] / there.volume[tissue] - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn a_scaled_rig_scales_its_muscles(turns in turns(1.5), scale in 0.2..5.0f64) {
        let musculature = PLAIN.musculature();
        let scaling = DAffine3::from_scale(DVec3::splat(scale));
        let at = |after| Palette::new(musculature.skeleton(), &PLAIN.pose(&turns, after)).unwrap();
        let here = musculature.pose(&at(DAffine3::IDENTITY), &[0.0; TISSUES]).unwrap();
        let there = musculature.pose(&at(scaling), &[0.0; TISSUES]).unwrap();
        for tissue in 0..TISSUES {
            prop_assert!((here.stretch[tissue] - there.stretch[tissue]).abs() < 1e-5);
            prop_assert!((there.volume[tissue] / here.volume[tissue] / scale.powi(3) - 1.0).abs() < 1e-4);
        }
    }
}

#[test]
fn the_rest_pose_gives_the_tissues_own_matrices() {
    let musculature = PLAIN.musculature();
    let palette = Palette::new(musculature.skeleton(), &PLAIN.rest_pose()).unwrap();
    let posed = musculature.pose(&palette, &[0.0; TISSUES]).unwrap();
    for (matrix, tissue) in posed.matrices.iter().zip(musculature.tissues()) {
        let rest = tissue.envelope();
        let due = rest.axes * glam::DMat3::from_diagonal(rest.semi_axes);
        assert!(glam::DMat3::from_mat4(*matrix).abs_diff_eq(due, 1e-12));
        assert!(matrix.w_axis.truncate().abs_diff_eq(rest.centre, 1e-12));
    }
    assert!(posed.stretch.iter().all(|stretch| (stretch - 1.0).abs() < 1e-12));
    assert!(posed.clamped.is_empty());
}

#[test]
fn a_muscle_of_no_length_is_clamped_and_finite() {
    let musculature = muscle([0.02, 0.03, 0.1], [0.0, 0.0], 1.0);
    let own = musculature.tissues()[0].muscle().unwrap();
    let shift = own.origin.point - own.insertion.point;
    for nudge in [0.0, 1e-12, 1e-7] {
        let palette = shifted(&musculature, (shift + DVec3::X * nudge).to_array());
        let posed = musculature.pose(&palette, &[1.0]).unwrap();
        assert_eq!(posed.clamped, [0]);
        assert!(posed.matrices[0].is_finite());
        assert!(posed.stretch[0] >= 0.07 && posed.stretch[0] < 0.11);
    }
}

#[test]
fn a_muscle_whose_bones_twist_apart_keeps_square_axes() {
    let musculature = PLAIN.musculature();
    for degrees in 0..=360 {
        let twist = glam::DQuat::from_rotation_z(f64::from(degrees).to_radians());
        let pose = PLAIN.pose(&[glam::DQuat::IDENTITY, twist, twist], DAffine3::IDENTITY);
        let palette = Palette::new(musculature.skeleton(), &pose).unwrap();
        let posed = musculature.pose(&palette, &[0.0; TISSUES]).unwrap();
        for matrix in &posed.matrices {
            let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| axis.truncate().normalize());
            assert!(axes[0].dot(axes[1]).abs() < 1e-6 && axes[1].dot(axes[2]).abs() < 1e-6);
            assert!(axes[0].dot(axes[2]).abs() < 1e-6);
        }
    }
}
