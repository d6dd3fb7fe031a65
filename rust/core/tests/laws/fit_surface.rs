//! Laws of rays, inside tests and nearest points of a skin.

use std::f64::consts::TAU;

use glam::DVec3;
use proptest::prelude::*;
use sinew_core::fit::SkinSurface;

use super::fit_bodies::{Limb, limb, placed_limbs, surface, vectors};

/// Upper bound for the rounding of a coordinate to f32, m.
const ROUNDING_M: f64 = 1e-6;

/// The winding number of closed triangles around a point (A. Van Oosterom and J. Strackee, "The Solid Angle of a Plane Triangle",
/// 1983).
fn winding_number(triangles: &[[DVec3; 3]], point: DVec3) -> f64 {
    let angle = |corners: &[DVec3; 3]| {
        let [a, b, c] = corners.map(|corner| corner - point);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        2.0 * a
            .dot(b.cross(c))
            .atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
    };
    triangles.iter().map(angle).sum::<f64>() / (2.0 * TAU)
}

/// The distance from a point to a triangle: to its plane if the projection is inside the triangle, otherwise to its edges.
fn distance_m(point: DVec3, triangle: &[DVec3; 3]) -> f64 {
    let [a, b, c] = *triangle;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let edges = [[a, b], [b, c], [c, a]];
    let within = edges
        .iter()
        .all(|[from, to]| normal.dot((*to - *from).cross(point - *from)) >= 0.0);
    if within && normal != DVec3::ZERO {
        return normal.dot(point - a).abs();
    }
    let to_edge = |[from, to]: [DVec3; 2]| {
        let along = to - from;
        let fraction = ((point - from).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        (from + along * fraction).distance(point)
    };
    edges.map(to_edge).into_iter().fold(f64::INFINITY, f64::min)
}

fn all_triangles(limbs: &[Limb]) -> Vec<[DVec3; 3]> {
    limbs.iter().flat_map(Limb::triangles).collect()
}

fn bodies() -> impl Strategy<Value = Vec<Limb>> {
    proptest::collection::vec(placed_limbs(), 1..4)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn the_nearest_point_is_that_of_brute_force(limbs in bodies(), point in vectors(0.8)) {
        let found = surface(&limbs).nearest(point);
        let triangles = all_triangles(&limbs);
        let least = triangles.iter().map(|triangle| distance_m(point, triangle)).fold(f64::INFINITY, f64::min);
        prop_assert!((found.distance_m - least).abs() < 1e-9, "{} {least}", found.distance_m);
        prop_assert!((found.point.distance(point) - found.distance_m).abs() < 1e-12);
    }

    #[test]
    fn inside_is_where_the_winding_number_is_above_0(
        limbs in bodies(),
        points in proptest::collection::vec(vectors(0.3), 12),
    ) {
        let (skin, triangles) = (surface(&limbs), all_triangles(&limbs));
        for point in points {
            prop_assume!(skin.nearest(point).distance_m > ROUNDING_M);
            prop_assert_eq!(skin.is_inside(point), winding_number(&triangles, point) > 0.5, "{}", point);
        }
    }

    #[test]
    fn a_ray_from_inside_ends_on_the_skin_and_not_before(
        limbs in bodies(), point in vectors(0.2), direction in vectors(1.0),
    ) {
        let (skin, triangles) = (surface(&limbs), all_triangles(&limbs));
        let direction = direction.normalize_or(DVec3::Z);
        match skin.distance_along(point, direction) {
            Some(m) if m > 0.0 => {
                prop_assert!(skin.nearest(point + direction * m).distance_m < 1e-9);
                for fraction in [0.01, 0.3, 0.7, 0.99] {
                    prop_assert!(winding_number(&triangles, point + direction * (m * fraction)) > 0.5);
                }
                prop_assert!((skin.distance_along(point, direction * 4.0).unwrap() * 4.0 - m).abs() < 1e-9);
            }
            _ => prop_assert!(winding_number(&triangles, point) < 0.5),
        }
    }

    #[test]
    fn the_order_of_meshes_and_faces_does_not_matter(
        limbs in bodies(), point in vectors(0.3), direction in vectors(1.0), turn in 0_usize..500,
    ) {
        let direction = direction.normalize_or(DVec3::Z);
        let skin = surface(&limbs);
        let mut others = limbs.clone();
        others.reverse();
        for limb in &mut others {
            let count = limb.faces.len();
            limb.faces.rotate_left(turn % count);
            limb.faces.swap(0, count / 2);
        }
        let other = surface(&others);
        prop_assert_eq!(skin.distance_along(point, direction), other.distance_along(point, direction));
        prop_assert_eq!(skin.nearest(point), other.nearest(point));
        prop_assert_eq!(skin.size_m(), other.size_m());
    }

    #[test]
    fn normals_that_point_inward_change_nothing(limbs in bodies(), point in vectors(0.2), direction in vectors(1.0)) {
        let direction = direction.normalize_or(DVec3::Z);
        let mut inward = limbs.clone();
        inward[0].faces.iter_mut().for_each(|face| face.reverse());
        let found = [&limbs, &inward].map(|limbs| surface(limbs).distance_along(point, direction));
        match found {
            [Some(one), Some(other)] => prop_assert!((one - other).abs() < 1e-9),
            [one, other] => prop_assert_eq!(one, other),
        }
    }
}

/// A grid of rays, some along edges and through vertices.
fn rays() -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let at = |index: usize| [index % 5, index / 5 % 5, index / 25].map(|step| step as f64 - 2.0);
    let origins = (0..125).map(|index| at(index).map(|step| 0.03 * step));
    let directions = (0..125).map(|index| at((7 * index + 1) % 125));
    (origins.collect(), directions.collect())
}

#[test]
fn many_rays_at_once_are_the_same_bits_on_any_number_of_threads() {
    let body = [
        limb(12, 14, [0.2, 0.3, 1.0, 0.05]),
        limb(9, 10, [0.1, 2.0, -1.0, 0.0]),
    ];
    let (origins, directions) = rays();
    let found = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let skin: SkinSurface = surface(&body);
            let distances = skin.distances_along(&origins, &directions).unwrap();
            let distances: Vec<u64> = distances.into_iter().map(f64::to_bits).collect();
            (
                distances,
                skin.are_inside(&origins),
                skin.nearest_to_all(&origins),
            )
        })
    };
    assert_eq!(found(1), found(3));
    assert!(found(1).1.iter().any(|inside| *inside));
}

#[test]
fn rays_through_edges_and_vertices_hit_the_skin() {
    let skin = surface(&[limb(8, 8, [0.0; 4])]);
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        for direction in [axis, -axis] {
            assert!(
                skin.distance_along(DVec3::ZERO, direction)
                    .is_some_and(|m| m > 0.05)
            );
        }
    }
    assert!(skin.is_inside(DVec3::ZERO));
    assert_eq!(skin.distance_along(DVec3::ZERO, DVec3::ZERO), None);
    assert_eq!(skin.distance_along(DVec3::new(0.0, 0.0, 3.0), DVec3::Z), None);
    assert_eq!(
        skin.distance_along(DVec3::new(0.0, 0.0, -3.0), DVec3::Z),
        Some(0.0)
    );
}
