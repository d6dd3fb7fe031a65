//! The computed point of an ellipsoid is the nearest one.

use glam::{DMat3, DQuat, DVec3};
use proptest::prelude::*;
use sinew_core::ellipsoid::Ellipsoid;
use sinew_core::nearest_on_ellipsoid;

const RIVALS: usize = 10_000;

/// Points evenly distributed over the unit sphere.
fn sphere(count: usize) -> impl Iterator<Item = DVec3> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..count).map(move |index| {
        let z = 1.0 - (2 * index + 1) as f64 / count as f64;
        let angle = golden * index as f64;
        let radius = (1.0 - z * z).sqrt();
        DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
    })
}

fn check(semi_axes: DVec3, point: DVec3) -> Result<(), TestCaseError> {
    let found = nearest_on_ellipsoid(semi_axes, point);
    let size = semi_axes.max_element();
    let level = (found / semi_axes).length();
    prop_assert!(
        (level - 1.0).abs() < 1e-9,
        "{found} is off the surface: {level}, {semi_axes}, {point}"
    );
    let own = found.distance(point);
    let slack = 1e-9 * (size + point.length());
    // Other points all over the surface, and close to the result, where a wrong root would show.
    let near = sphere(RIVALS / 10).map(|direction| ((found / semi_axes) + 1e-3 * direction).normalize());
    for rival in sphere(RIVALS).chain(near) {
        let other = (rival * semi_axes).distance(point);
        prop_assert!(
            own <= other + slack,
            "{found} at {own}, but {} at {other}: {semi_axes}, {point}",
            rival * semi_axes
        );
    }
    Ok(())
}

prop_compose! {
    /// From needles of 1:1e4 to flat discs, with the axes in any order.
    fn semi_axes()(exponents in prop::array::uniform3(-4.0..0.0f64)) -> DVec3 {
        DVec3::from_array(exponents.map(|exponent| 10f64.powf(exponent)))
    }
}

prop_compose! {
    /// Near the surface, deep inside, and far outside.
    fn places()(direction in prop::array::uniform3(-1.0..1.0f64), exponent in -6.0..1.0f64) -> DVec3 {
        DVec3::from_array(direction) * 10f64.powf(exponent)
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn nearest_of_any_place(semi_axes in semi_axes(), point in places()) {
        check(semi_axes, point)?;
    }

    #[test]
    fn nearest_of_any_place_inside(semi_axes in semi_axes(), share in prop::array::uniform3(-0.57..0.57f64)) {
        check(semi_axes, DVec3::from_array(share) * semi_axes)?;
    }

    #[test]
    fn nearest_on_axes_and_planes(semi_axes in semi_axes(), point in places(), kept in 0..7usize) {
        let mask = DVec3::new((kept & 1) as f64, (kept >> 1 & 1) as f64, (kept >> 2 & 1) as f64);
        check(semi_axes, point * mask)?;
    }

    #[test]
    fn nearest_with_equal_axes(width in 0.01..1.0f64, length in 0.01..1.0f64, point in places(), order in 0..3usize) {
        let mut semi_axes = DVec3::splat(width);
        semi_axes[order] = length;
        check(semi_axes, point)?;
        check(DVec3::splat(width), point)?;
    }

    #[test]
    fn inside_is_negative_and_bounds_hold(
        semi_axes in semi_axes(), point in places(), angle in -3.0..3.0f64, share in 0.0..0.99f64,
    ) {
        let axes = DMat3::from_quat(DQuat::from_rotation_x(angle));
        let ellipsoid = Ellipsoid { centre: DVec3::new(1.0, -2.0, 0.5), axes, semi_axes };
        let world = ellipsoid.centre + axes * point;
        let nearest = ellipsoid.nearest(world);
        prop_assert!((nearest.surface.distance(world) - nearest.distance_m.abs()).abs() < 1e-9);
        prop_assert!(ellipsoid.distance_bound(world) <= nearest.distance_m.max(0.0) + 1e-12);
        let inside = ellipsoid.centre + axes * (semi_axes * point.normalize_or(DVec3::X) * share);
        prop_assert!(ellipsoid.nearest(inside).distance_m < 0.0);
    }
}

#[test]
fn the_centre_goes_to_the_end_of_the_shortest_axis() {
    let at = |semi_axes: [f64; 3]| nearest_on_ellipsoid(semi_axes.into(), DVec3::ZERO).abs();
    assert_eq!(at([3.0, 2.0, 1.0]), DVec3::new(0.0, 0.0, 1.0));
    assert_eq!(at([0.5, 2.0, 1.0]), DVec3::new(0.5, 0.0, 0.0));
    assert_eq!(at([3.0, 1e-4, 1.0]), DVec3::new(0.0, 1e-4, 0.0));
}

#[test]
fn a_point_on_the_surface_stays() {
    let semi_axes = DVec3::new(0.3, 0.02, 1.0);
    for direction in sphere(200) {
        let point = direction * semi_axes;
        assert!(nearest_on_ellipsoid(semi_axes, point).distance(point) < 1e-12);
    }
}

#[test]
fn numbers_at_the_ends_of_f64_are_no_exception() {
    let semi_axes = DVec3::new(0.5, 2.0, 1.0);
    for tiny in [5e-324, 1e-300, 1e-160, 1e-120, 1e-30] {
        for point in [
            DVec3::new(tiny, 1.0, 0.0),
            DVec3::new(tiny, 1.0, tiny),
            DVec3::new(tiny, tiny, tiny),
        ] {
            let found = nearest_on_ellipsoid(semi_axes, point);
            assert!(
                ((found / semi_axes).length() - 1.0).abs() < 1e-9,
                "{found} for {point}"
            );
            assert!(
                found.distance(point)
                    <= nearest_on_ellipsoid(semi_axes, DVec3::Y * point.y).distance(point) + 1e-12
            );
        }
    }
    for huge in [1e30, 1e100, 1e200, f64::MAX] {
        let found = nearest_on_ellipsoid(semi_axes, DVec3::new(huge, -huge, 0.0));
        assert!(((found / semi_axes).length() - 1.0).abs() < 1e-9);
        let normal = (found / semi_axes / semi_axes).normalize();
        assert!(normal.abs_diff_eq(DVec3::new(1.0, -1.0, 0.0).normalize(), 1e-9));
    }
}
