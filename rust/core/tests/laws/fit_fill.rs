//! Laws of filling a body with its tissues.

use glam::{DAffine3, DQuat, DVec3};
use proptest::prelude::*;
use sinew_core::TissueKind;
use sinew_core::fit::{
    Goal, PlacedTissue, Placement, SkinSurface, fill, fit_all, protrusion_m, volume_m3 as body_m3,
};

use super::fit_bodies::{Limb, changed, limb, placed, surface};

/// Depth of fat in these laws, m.
const FAT_M: f64 = 0.004;

/// A bone along the limb, four muscles around it and a stuffing at one end.
fn tissues() -> Vec<PlacedTissue> {
    let at = |kind, centre, semi_axes| {
        placed(Placement {
            kind,
            centre,
            rotation: DQuat::IDENTITY,
            semi_axes,
            origin_tendon_m: if kind == TissueKind::Muscle { 0.05 } else { 0.0 },
            insertion_tendon_m: if kind == TissueKind::Muscle { 0.08 } else { 0.0 },
            via_points: vec![],
        })
    };
    let mut tissues = vec![at(TissueKind::Bone, DVec3::ZERO, DVec3::new(0.015, 0.015, 0.4))];
    for (x, y) in [(1.0, 0.1), (-1.0, 0.0), (0.0, 1.0), (0.1, -1.0)] {
        let centre = DVec3::new(0.04 * x, 0.035 * y, 0.0);
        tissues.push(at(TissueKind::Muscle, centre, DVec3::new(0.015, 0.02, 0.2)));
    }
    tissues.push(at(TissueKind::Stuffing, DVec3::Z * 0.38, DVec3::splat(0.02)));
    tissues
}

fn goals(volume_m3: f64, count: usize) -> Vec<Goal> {
    vec![
        Goal {
            volume_m3,
            fat_m: FAT_M
        };
        count
    ]
}

fn limbs() -> impl Strategy<Value = Limb> {
    (0.05..0.2, 0.0..6.2, -2.0..2.0).prop_map(|(size, phase, twist)| limb(14, 12, [size, phase, twist, 0.0]))
}

fn filled(tissues: &[PlacedTissue], goals: &[Goal], skin: &SkinSurface) -> Vec<PlacedTissue> {
    fill(tissues, goals, &vec![None; tissues.len()], skin).unwrap()
}

fn volume_m3(tissue: &PlacedTissue) -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * tissue.placement().semi_axes.element_product()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4))]

    #[test]
    fn a_filled_belly_is_under_the_skin_and_bones_stay(limb in limbs()) {
        let skin = surface(&[limb]);
        let tissues = tissues();
        let filled = filled(&tissues, &goals(0.0, tissues.len()), &skin);
        prop_assert_eq!(&filled[0], &tissues[0]);
        for tissue in &filled {
            prop_assert!(protrusion_m(tissue, &skin) < 3e-4);
        }
    }

    #[test]
    fn a_belly_with_room_gets_its_measured_volume(limb in limbs(), cm3 in 150.0..400.0_f64) {
        let skin = surface(&[limb]);
        let tissues = tissues();
        let filled = filled(&tissues, &goals(cm3 * 1e-6, tissues.len()), &skin);
        for muscle in &filled[1..5] {
            let ratio = volume_m3(muscle) / (cm3 * 1e-6);
            prop_assert!((0.8..1.25).contains(&ratio), "{}", ratio);
        }
    }

    #[test]
    fn origin_and_insertion_keep_their_distance(limb in limbs()) {
        let skin = surface(&[limb]);
        let tissues = tissues();
        let filled = filled(&tissues, &goals(0.0, tissues.len()), &skin);
        let length_m = |tissue: &PlacedTissue| {
            let at = tissue.placement();
            at.origin_tendon_m + 2.0 * at.semi_axes.z + at.insertion_tendon_m
        };
        for (before, after) in tissues.iter().zip(&filled).take(5) {
            prop_assert!((length_m(before) - length_m(after)).abs() < 1e-9);
        }
    }

    #[test]
    fn the_right_stays_the_exact_mirror_image(limb in limbs()) {
        let aside = DAffine3::from_translation(DVec3::X * 0.3);
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let left_limb = limb.transformed(&aside);
        let skin = surface(&[left_limb.clone(), left_limb.transformed(&mirror)]);
        let left: Vec<_> = tissues().iter().map(|tissue| changed(tissue, &aside, 1.0)).collect();
        let right: Vec<_> = left.iter().map(|tissue| changed(tissue, &mirror, 1.0)).collect();
        let both = [left, right].concat();
        let half = both.len() / 2;
        let twins: Vec<_> = (0..both.len()).map(|index| index.checked_sub(half)).collect();
        let fitted = fit_all(&both, &twins, &skin).unwrap();
        let filled = fill(&fitted, &goals(0.0, both.len()), &twins, &skin).unwrap();
        for (left, right) in filled[..half].iter().zip(&filled[half..]) {
            let (left, right) = (left.placement(), right.placement());
            prop_assert_eq!(DVec3::new(-left.centre.x, left.centre.y, left.centre.z), right.centre);
            prop_assert_eq!(left.semi_axes, right.semi_axes);
        }
    }
}

#[test]
fn tissues_fill_most_of_a_limb_and_more_than_before() {
    let skin = surface(&[limb(24, 24, [0.1, 0.3, 0.0, 0.0])]);
    let tissues = tissues();
    let filled = filled(&tissues, &goals(0.0, tissues.len()), &skin);
    let share = |tissues: &[PlacedTissue]| tissues.iter().map(volume_m3).sum::<f64>() / body_m3(&skin);
    assert!(share(&tissues) < 0.3, "{}", share(&tissues));
    assert!(share(&filled) > 0.5, "{}", share(&filled));
}

#[test]
fn the_volume_of_a_body_is_counted_on_a_grid() {
    let skin = surface(&[limb(64, 64, [0.0; 4])]);
    let rings_m3: f64 = (0..1000)
        .map(|ring| {
            let along = 2.0 * (f64::from(ring) + 0.5) / 1000.0 - 1.0;
            0.8 * std::f64::consts::PI * 0.01 * (1.0 - 0.96 * along * along) / 1000.0
        })
        .sum();
    assert!(
        (body_m3(&skin) / rings_m3 - 1.0).abs() < 0.02,
        "{}",
        body_m3(&skin) / rings_m3
    );
}
