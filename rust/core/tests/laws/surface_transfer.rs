//! Laws of surface transfer, and the invalid input that the fit and the transfer refuse.

use glam::{DAffine3, DQuat, DVec3};
use proptest::prelude::*;
use sinew_core::fit::{
    PlacedTissue, Placement, PolygonMesh, Polygons, SkinSurface, SurfaceTransfer, fit_all,
};
use sinew_core::{Error, Polyline, TissueKind, nearest_on_segment};

use super::fit_bodies::{limb, limbs, polygons, surface, vectors};

fn plane(size: usize) -> (Vec<DVec3>, Vec<Vec<u32>>) {
    let at = |x: usize, y: usize| (y * (size + 1) + x) as u32;
    let points = (0..(size + 1) * (size + 1))
        .map(|index| DVec3::new((index % (size + 1)) as f64, (index / (size + 1)) as f64, 0.0) / size as f64);
    let faces = (0..size * size).map(|index| {
        let (x, y) = (index % size, index / size);
        vec![at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)]
    });
    (points.collect(), faces.collect())
}

/// A value that is linear in the position.
fn linear(point: DVec3) -> [f32; 2] {
    [0.3 + point.x - 2.0 * point.y, point.y + 0.5 * point.z].map(|number| number as f32)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn linear_values_on_a_plane_are_kept(size in 1_usize..5, positions in proptest::collection::vec([0.0..1.0, 0.0..1.0, -0.1..0.1_f64], 3..20)) {
        let (points, faces) = plane(size);
        let new_points: Vec<DVec3> = positions.into_iter().map(DVec3::from_array).collect();
        let new = polygons(&new_points, &[vec![0, 1, 2]], None);
        let transfer = SurfaceTransfer::new(&polygons(&points, &faces, None), &new, 1.0).unwrap();
        let values: Vec<f32> = faces.iter().flatten().flat_map(|&vertex| linear(points[vertex as usize])).collect();
        let mixed = transfer.mixed(&values, 2).unwrap();
        for (point, found) in new_points.iter().zip(mixed.chunks(2)) {
            let expected = linear(DVec3::new(point.x, point.y, 0.0));
            prop_assert!((found[0] - expected[0]).abs() < 1e-4 && (found[1] - expected[1]).abs() < 1e-4, "{found:?} {expected:?}");
        }
    }

    #[test]
    fn positions_mix_to_the_nearest_position(limb in limbs(), points in proptest::collection::vec(vectors(0.5), 3..20)) {
        let old = limb.polygons();
        let new = polygons(&points, &[vec![0, 1, 2]], None);
        let corners = limb.faces.iter().flatten().map(|&vertex| limb.points[vertex as usize].as_vec3().to_array());
        let positions: Vec<f32> = corners.flatten().collect();
        let mixed = SurfaceTransfer::new(&old, &new, 10.0).unwrap().mixed(&positions, 3).unwrap();
        let skin = surface(&[limb]);
        for (point, found) in new.points().iter().zip(mixed.as_chunks::<3>().0) {
            let found = DVec3::from_array(found.map(f64::from));
            prop_assert!(skin.nearest(*point).point.distance(found) < 1e-6);
        }
    }

    #[test]
    fn a_surface_takes_everything_from_itself(limb in limbs()) {
        let body = limb.polygons();
        let transfer = SurfaceTransfer::new(&body, &body, 1e-5).unwrap();
        let vertices: Vec<u32> = limb.faces.iter().flatten().copied().collect();
        let values: Vec<f32> = vertices.iter().map(|&vertex| vertex as f32).collect();
        let mixed = transfer.mixed(&values, 1).unwrap();
        for (vertex, &corner) in transfer.nearest_corners().iter().enumerate() {
            prop_assert_eq!(vertices[corner as usize] as usize, vertex);
            prop_assert!((mixed[vertex] - vertex as f32).abs() < 1e-3);
        }
        prop_assert!(transfer.is_near().iter().all(|near| *near));
        // at the ends, the middle of a polygon's fan can be on an edge of a neighbour
        let same = transfer.nearest_faces().iter().zip(0_u32..).filter(|(found, face)| *found == face).count();
        prop_assert!(same * 10 >= limb.faces.len() * 9);
    }

    #[test]
    fn values_stay_between_those_of_the_corners(limb in limbs(), points in proptest::collection::vec(vectors(0.3), 3..20)) {
        let old = limb.polygons();
        let new = polygons(&points, &[vec![0, 1, 2]], None);
        let transfer = SurfaceTransfer::new(&old, &new, 10.0).unwrap();
        let values: Vec<f32> = (0..old.corner_count()).map(|corner| (corner % 7) as f32).collect();
        let ones = vec![1.0; old.corner_count()];
        let mixed = transfer.mixed(&values, 1).unwrap();
        prop_assert!(mixed.iter().all(|value| (-0.01..=6.01).contains(value)), "{mixed:?}");
        prop_assert!(transfer.mixed(&ones, 1).unwrap().iter().all(|sum| (sum - 1.0).abs() < 1e-5));
    }

    #[test]
    fn a_vertex_beyond_the_largest_distance_takes_nothing(limb in limbs(), points in proptest::collection::vec(vectors(1.0), 3..9), max_distance in 0.0..0.5_f64) {
        let old = limb.polygons();
        let new = polygons(&points, &[vec![0, 1, 2]], None);
        let transfer = SurfaceTransfer::new(&old, &new, max_distance).unwrap();
        let mixed = transfer.mixed(&vec![1.0; old.corner_count()], 1).unwrap();
        let skin = surface(&[limb]);
        for (point, found) in new.points().iter().zip(mixed) {
            let is_near = skin.nearest(*point).distance_m <= max_distance;
            prop_assert_eq!(found > 0.5, is_near);
        }
    }

    #[test]
    fn the_nearest_arc_length_is_that_of_brute_force(points in proptest::collection::vec(vectors(1.0), 2..8), point in vectors(1.5)) {
        let mut path = Polyline::default();
        points.iter().for_each(|&point| path.line_to(point));
        let found = path.at(path.nearest_length(point)).distance(point);
        let least = (0..=4000)
            .map(|step| path.at(path.length() * step as f64 / 4000.0).distance(point))
            .fold(f64::INFINITY, f64::min);
        prop_assert!(found <= least + 1e-9, "{found} {least}");
        let (nearest, fraction) = nearest_on_segment(point, points[0], points[1]);
        prop_assert!(nearest.distance(points[0].lerp(points[1], fraction)) < 1e-12 && (0.0..=1.0).contains(&fraction));
    }
}

#[test]
fn a_segment_without_length_is_its_start() {
    assert_eq!(nearest_on_segment(DVec3::X, DVec3::Y, DVec3::Y), (DVec3::Y, 0.0));
}

#[test]
fn invalid_meshes_are_refused() {
    let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let good = PolygonMesh {
        points: &points,
        corners: &[0, 1, 2],
        face_offsets: &[0, 3],
        to_space: None,
    };
    let refused = |mesh: PolygonMesh| Polygons::new(&mesh).unwrap_err();
    assert!(Polygons::new(&good).is_ok());
    assert!(matches!(
        refused(PolygonMesh {
            corners: &[0, 1, 3],
            ..good
        }),
        Error::Index { found: 3, .. }
    ));
    assert!(matches!(
        refused(PolygonMesh {
            corners: &[0, 1, -1],
            ..good
        }),
        Error::Index { found: -1, .. }
    ));
    for face_offsets in [&[][..], &[1, 3], &[0, 2], &[0, 2, 3], &[0, 4], &[0]] {
        let error = refused(PolygonMesh { face_offsets, ..good });
        assert!(
            matches!(error, Error::FaceOffsets { limit: 3, .. }),
            "{face_offsets:?}"
        );
    }
    let not_finite = [[0.0; 3], [f32::NAN, 0.0, 0.0], [0.0, 1.0, 0.0]];
    assert!(matches!(
        refused(PolygonMesh {
            points: &not_finite,
            ..good
        }),
        Error::Value { .. }
    ));
    let mut row_major = super::fixtures::rig::columns(DAffine3::IDENTITY);
    row_major[3] = 1.0;
    let projective = PolygonMesh {
        to_space: Some(&row_major),
        ..good
    };
    assert!(matches!(refused(projective), Error::Projective { .. }));
}

#[test]
fn a_mesh_without_faces_is_refused() {
    let limb = limb(7, 6, [0.0; 4]).polygons();
    let bare = polygons(&[], &[], None);
    assert!(matches!(SkinSurface::new(&[]), Err(Error::NoFaces { mesh: 0 })));
    assert!(matches!(
        SkinSurface::new(&[&limb, &bare]),
        Err(Error::NoFaces { mesh: 1 })
    ));
    assert!(matches!(
        SurfaceTransfer::new(&bare, &limb, 0.1),
        Err(Error::NoFaces { .. })
    ));
    assert!(matches!(
        SurfaceTransfer::new(&limb, &limb, f64::NAN),
        Err(Error::Value { .. })
    ));
    assert!(matches!(
        SurfaceTransfer::new(&limb, &limb, -0.1),
        Err(Error::Value { .. })
    ));
    let transfer = SurfaceTransfer::new(&limb, &bare, 0.1).unwrap();
    assert!(matches!(transfer.mixed(&[0.0], 1), Err(Error::Length { .. })));
}

#[test]
fn invalid_tissues_and_twins_are_refused() {
    let good = Placement {
        kind: TissueKind::Muscle,
        centre: DVec3::ZERO,
        rotation: DQuat::IDENTITY,
        semi_axes: DVec3::ONE,
        origin_tendon_m: 0.0,
        insertion_tendon_m: 0.0,
        via_points: vec![],
    };
    let new = |at: Placement| PlacedTissue::new(at, || "biceps".to_owned());
    let bad = [
        Placement {
            centre: DVec3::NAN,
            ..good.clone()
        },
        Placement {
            rotation: DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0),
            ..good.clone()
        },
        Placement {
            semi_axes: DVec3::new(1.0, 0.0, 1.0),
            ..good.clone()
        },
        Placement {
            origin_tendon_m: -1.0,
            ..good.clone()
        },
        Placement {
            insertion_tendon_m: f64::INFINITY,
            ..good.clone()
        },
        Placement {
            via_points: vec![DVec3::NAN],
            ..good.clone()
        },
    ];
    for at in bad {
        assert!(new(at).unwrap_err().to_string().contains("biceps"));
    }
    let skin = surface(&[limb(7, 6, [0.0; 4])]);
    let tissue = new(good).unwrap();
    let tissues = [tissue.clone(), tissue];
    assert!(matches!(
        fit_all(&tissues, &[None], &skin),
        Err(Error::Length { .. })
    ));
    assert!(matches!(
        fit_all(&tissues, &[None, Some(2)], &skin),
        Err(Error::Index { .. })
    ));
}
