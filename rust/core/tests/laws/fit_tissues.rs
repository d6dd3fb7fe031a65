//! Laws of the fit of tissues under a skin.

use std::f64::consts::FRAC_PI_8;

use glam::{DAffine3, DQuat, DVec2, DVec3};
use proptest::prelude::*;
use sinew_core::TissueKind;
use sinew_core::fit::{PlacedTissue, Placement, SkinSurface, fit, fit_all, protrusion_m};

use super::fit_bodies::{
    changed, difference_m, exact_motions, limbs, placed, surface, tissues, tissues_within,
};

/// Largest difference by rounding, m.
const ROUNDING_M: f64 = 1e-7;

/// The stations at which a fit trims a belly.
const STATIONS: [f64; 17] = [
    -0.98, -0.94, -0.88, -0.8, -0.7, -0.55, -0.4, -0.2, 0.0, 0.2, 0.4, 0.55, 0.7, 0.8, 0.88, 0.94, 0.98,
];

/// The smallest width factor of a tissue: the clearance around its axis, over its width there.
fn smallest_width_factor(tissue: &PlacedTissue, skin: &SkinSurface) -> f64 {
    let at = tissue.placement();
    let mut smallest = f64::INFINITY;
    for station in STATIONS {
        let on_axis = at.centre + at.rotation * (DVec3::Z * (station * at.semi_axes.z));
        let relative_width = (1.0 - station * station).sqrt();
        for spoke in 0..16 {
            let across =
                DVec2::from_angle(spoke as f64 * FRAC_PI_8) * at.semi_axes.truncate() * relative_width;
            let spoke = at.rotation * across.extend(0.0);
            if let Some(m) = skin.distance_along(on_axis, spoke.normalize()) {
                smallest = smallest.min((m - skin.margin_m()) / spoke.length());
            }
        }
    }
    smallest
}

// Known fault: about one in a thousand bellies gets up to 3 % narrower in a second fit.
proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn fitting_twice_changes_little(limb in limbs(), tissue in tissues_within()) {
        let skin = surface(&[limb]);
        let once = fit(&tissue, &skin);
        prop_assume!(skin.is_inside(once.placement().centre));
        let twice = fit(&once, &skin);
        let narrower = once.placement().semi_axes / twice.placement().semi_axes;
        prop_assert!(twice.placement().centre.distance(once.placement().centre) < 1e-9);
        prop_assert!(narrower.max_element() < 1.02, "{narrower}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn a_rigid_motion_changes_nothing(limb in limbs(), tissue in tissues_within(), motion in exact_motions()) {
        // quarter turns only: the margin depends on the box around the skin, and that box does not rotate with the skin
        let fitted = fit(&tissue, &surface(std::slice::from_ref(&limb)));
        let moved = fit(&changed(&tissue, &motion, 1.0), &surface(&[limb.transformed(&motion)]));
        let difference = difference_m(&changed(&fitted, &motion, 1.0), &moved);
        prop_assert!(difference < ROUNDING_M, "{difference}");
    }

    #[test]
    fn scale_scales(limb in limbs(), tissue in tissues_within(), doublings in -4..5) {
        let scale = 2.0_f64.powi(doublings);
        let larger = DAffine3::from_scale(DVec3::splat(scale));
        let fitted = fit(&tissue, &surface(std::slice::from_ref(&limb)));
        let scaled = fit(&changed(&tissue, &larger, scale), &surface(&[limb.transformed(&larger)]));
        let difference = difference_m(&changed(&fitted, &larger, scale), &scaled) / scale;
        prop_assert!(difference < ROUNDING_M, "{difference}");
    }

    #[test]
    fn a_mirror_gives_the_mirror_image(limb in limbs(), tissue in tissues_within()) {
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let fitted = fit(&tissue, &surface(std::slice::from_ref(&limb)));
        let mirrored = fit(&changed(&tissue, &mirror, 1.0), &surface(&[limb.transformed(&mirror)]));
        let difference = difference_m(&changed(&fitted, &mirror, 1.0), &mirrored);
        prop_assert!(difference < ROUNDING_M, "{difference}");
    }

    #[test]
    fn a_fitted_belly_keeps_its_margin_under_the_skin(limb in limbs(), tissue in tissues_within()) {
        let skin = surface(&[limb]);
        let fitted = fit(&tissue, &skin);
        prop_assume!(skin.is_inside(fitted.placement().centre));
        prop_assume!(fitted.placement().kind != TissueKind::Sphere);
        let factor = smallest_width_factor(&fitted, &skin);
        prop_assert!(factor > 1.0 - 1.1e-4, "{factor}");
        // between the rays of a fit, the edges of such a coarse mesh can be nearer
        let distance_m = protrusion_m(&fitted, &skin);
        prop_assert!(distance_m < 2.0 * skin.margin_m(), "{distance_m}");
    }

    #[test]
    fn a_sphere_keeps_its_margin_under_the_skin(limb in limbs(), tissue in tissues()) {
        let skin = surface(&[limb]);
        let at = Placement { kind: TissueKind::Sphere, via_points: vec![], ..tissue.placement().clone() };
        let fitted = fit(&placed(at), &skin);
        let at = fitted.placement();
        prop_assume!(skin.is_inside(at.centre));
        let clearance_m = (skin.nearest(at.centre).distance_m - skin.margin_m()).max(skin.margin_m());
        prop_assert!(at.semi_axes.max_element() <= clearance_m * (1.0 + 1e-12));
    }

    #[test]
    fn via_points_stay_under_the_skin(limb in limbs(), tissue in tissues()) {
        let skin = surface(&[limb]);
        let fitted = fit(&tissue, &skin);
        prop_assume!(skin.is_inside(fitted.placement().centre));
        let at = fitted.placement();
        let length_m = at.semi_axes.z + at.origin_tendon_m;
        let origin = at.centre - at.rotation * (DVec3::Z * length_m);
        for &point in &at.via_points {
            // a via point along a tendon may be outside
            let along = (point - origin).dot(at.rotation * DVec3::Z);
            let on_belly = along > at.origin_tendon_m + 0.1 * at.semi_axes.z && along < length_m + 0.9 * at.semi_axes.z;
            prop_assert!(!on_belly || skin.is_inside(point) || skin.nearest(point).distance_m < 0.02);
        }
    }

    #[test]
    fn the_order_of_tissues_does_not_matter(
        limb in limbs(), tissues in proptest::collection::vec(tissues(), 2..6), turn in 0_usize..6,
    ) {
        let skin = surface(&[limb]);
        let mut others = tissues.clone();
        others.rotate_left(turn % tissues.len());
        let left_twins = vec![None; tissues.len()];
        let fitted = fit_all(&tissues, &left_twins, &skin).unwrap();
        let mut expected = fitted.clone();
        expected.rotate_left(turn % tissues.len());
        prop_assert_eq!(fit_all(&others, &left_twins, &skin).unwrap(), expected);
        for (tissue, together) in tissues.iter().zip(&fitted) {
            prop_assert_eq!(&fit(tissue, &skin), together);
        }
    }

    #[test]
    fn the_right_is_the_exact_mirror_image_of_the_left(limb in limbs(), tissue in tissues()) {
        let aside = DAffine3::from_translation(DVec3::X * 0.3);
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let left_limb = limb.transformed(&aside);
        let right_limb = left_limb.transformed(&mirror);
        let skin = surface(&[left_limb, right_limb]);
        let left = changed(&tissue, &aside, 1.0);
        let right = changed(&left, &mirror, 1.0);
        for indices in [[0, 1], [1, 0]] {
            let mut both = [left.clone(), right.clone()];
            both.rotate_left(indices[0]);
            let mut left_twins = [None; 2];
            left_twins[indices[1]] = Some(indices[0]);
            let fitted = fit_all(&both, &left_twins, &skin).unwrap();
            let (left, right) = (fitted[indices[0]].placement(), fitted[indices[1]].placement());
            let flip = |point: DVec3| DVec3::new(-point.x, point.y, point.z);
            prop_assert_eq!(flip(left.centre), right.centre);
            prop_assert_eq!(left.semi_axes, right.semi_axes);
        }
    }
}

fn muscle(centre: DVec3) -> Placement {
    Placement {
        kind: TissueKind::Muscle,
        centre,
        rotation: DQuat::IDENTITY,
        semi_axes: DVec3::new(0.02, 0.03, 0.1),
        origin_tendon_m: 0.0,
        insertion_tendon_m: 0.0,
        via_points: vec![DVec3::new(9.0, 9.0, 9.0)],
    }
}

#[test]
fn a_tissue_that_no_skin_covers_is_unchanged() {
    let skin = surface(&[super::fit_bodies::limb(10, 10, [0.0; 4])]);
    let far = placed(muscle(DVec3::new(0.0, -1.0, 0.0)));
    assert_eq!(fit(&far, &skin), far);
}

#[test]
fn a_belly_near_the_skin_grows_up_to_it() {
    let skin = surface(&[super::fit_bodies::limb(24, 24, [0.0; 4])]);
    let at = Placement {
        semi_axes: DVec3::new(0.065, 0.065, 0.1),
        via_points: vec![],
        ..muscle(DVec3::ZERO)
    };
    let fitted = fit(&placed(at), &skin);
    assert!(fitted.placement().semi_axes.x > 0.07, "{fitted:?}");
    assert_eq!(protrusion_m(&fitted, &skin), 0.0);
}

#[test]
fn a_protrusion_is_measured() {
    let skin = surface(&[super::fit_bodies::limb(24, 24, [0.0; 4])]);
    let at = Placement {
        semi_axes: DVec3::new(0.12, 0.03, 0.1),
        ..muscle(DVec3::ZERO)
    };
    let distance_m = protrusion_m(&placed(at), &skin);
    assert!((0.015..0.025).contains(&distance_m), "{distance_m}");
}
