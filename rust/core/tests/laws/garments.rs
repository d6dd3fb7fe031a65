//! Laws of a skin that is worn over a bound one: it follows the body's correction and keeps its distance.

use std::sync::Arc;

use glam::{DAffine3, DQuat, Vec3};
use proptest::prelude::*;
use sinew_core::{Error, Regional, Skin, SkinOptions, Skinning};

use super::fixtures::rig::{
    AROUND, PLAIN, corrected, deformed, gap, no_tension, options, tensions, triangles, turns,
};

/// The body's options: swelling of several times its true size.
fn swollen(skinning: Skinning) -> SkinOptions<'static> {
    SkinOptions {
        skinning,
        muscle_influence: Regional::of_body(2.0),
        ..SkinOptions::default()
    }
}

/// The tube of the limb, wider by `by_m`, in armature space.
fn wider(by_m: f32) -> Vec<[f32; 3]> {
    let out = |[x, y, z]: [f32; 3]| {
        let across = Vec3::new(x, y, 0.0);
        (Vec3::new(x, y, z) + across.normalize_or_zero() * by_m).to_array()
    };
    PLAIN.points().into_iter().map(out).collect()
}

fn garment(body: &Arc<Skin>, by_m: f32, skinning: Skinning) -> Skin {
    PLAIN
        .skin_of(&wider(by_m), &DAffine3::IDENTITY, &swollen(skinning))
        .worn_over(body.clone(), &triangles(), &triangles())
        .unwrap()
}

/// The vertex of a garment that is lowest above the vertex of the body with the same index, along the body's
/// normal, and its height. The rings at the ends of the tube have no bones, so what they stretch is
/// skipped.
fn lowest(garment: &[[f32; 3]], body: &[[f32; 3]]) -> (usize, f32) {
    let mut normals = vec![Vec3::ZERO; body.len()];
    for triangle in triangles() {
        let [a, b, c] = triangle.map(|corner| Vec3::from_array(body[corner as usize]));
        for corner in triangle {
            normals[corner as usize] += (b - a).cross(c - a);
        }
    }
    let height = |vertex: usize| {
        let above = Vec3::from_array(garment[vertex]) - Vec3::from_array(body[vertex]);
        (vertex, above.dot(normals[vertex].normalize_or_zero()))
    };
    let inner = 4 * AROUND..body.len() - 4 * AROUND;
    inner.map(height).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn at_rest_a_garment_is_not_corrected(options in options(), by_m in 0.001..0.1f32) {
        let body = Arc::new(PLAIN.skin(&options));
        let pose = PLAIN.pose(&[DQuat::IDENTITY; 3], DAffine3::IDENTITY);
        let (offsets, _) = corrected(&garment(&body, by_m, Skinning::Linear), &pose, &no_tension());
        prop_assert!(gap(&offsets, &vec![[0.0; 3]; offsets.len()]) < 1e-6);
    }

    #[test]
    fn the_modifier_moves_the_corrected_garment_to_where_it_is_deformed(
        turns in turns(0.8), tension in tensions(), by_m in 0.002..0.02f32,
    ) {
        let body = Arc::new(PLAIN.skin(&swollen(Skinning::Linear)));
        let pose = PLAIN.pose(&turns, DAffine3::IDENTITY);
        let worn = garment(&body, by_m, Skinning::Linear);
        let (offsets, damped) = corrected(&worn, &pose, &tension);
        prop_assume!(damped == 0);
        let moved: Vec<[f32; 3]> = wider(by_m)
            .iter()
            .zip(&offsets)
            .map(|(point, offset)| std::array::from_fn(|axis| point[axis] + offset[axis]))
            .collect();
        let still = SkinOptions { muscle_influence: Regional::of_body(0.0), ..SkinOptions::default() };
        let shown = deformed(&PLAIN.skin_of(&moved, &DAffine3::IDENTITY, &still), &pose, &no_tension());
        prop_assert!(gap(&shown, &deformed(&worn, &pose, &tension)) < 1e-5);
    }

    #[test]
    fn a_garment_keeps_its_height_above_a_bent_body(
        angle in -1.0..1.0f64, tension in tensions(), by_m in 0.003..0.015f32,
    ) {
        let body = Arc::new(PLAIN.skin(&swollen(Skinning::PreserveVolume)));
        let turns = [DQuat::IDENTITY, DQuat::from_rotation_x(angle), DQuat::IDENTITY];
        let pose = PLAIN.pose(&turns, DAffine3::IDENTITY);
        let worn = deformed(&garment(&body, by_m, Skinning::PreserveVolume), &pose, &tension);
        let under = deformed(&body, &pose, &tension);
        let (vertex, height_m) = lowest(&worn, &under);
        prop_assert!(height_m > 0.9 * by_m, "vertex {vertex} (ring {}): {height_m} m", vertex / AROUND);
    }

    #[test]
    fn a_garment_far_from_the_body_is_not_corrected(turns in turns(1.0), tension in tensions()) {
        let body = Arc::new(PLAIN.skin(&swollen(Skinning::Linear)));
        let pose = PLAIN.pose(&turns, DAffine3::IDENTITY);
        let (offsets, _) = corrected(&garment(&body, 0.3, Skinning::Linear), &pose, &tension);
        prop_assert_eq!(offsets.clone(), vec![[0.0; 3]; offsets.len()]);
    }

    #[test]
    fn order_and_repetition_of_frames_do_not_matter(first in turns(1.0), second in turns(1.0), tension in tensions()) {
        let body = Arc::new(PLAIN.elastic_skin(&swollen(Skinning::Linear)));
        let worn = garment(&body, 0.01, Skinning::Linear);
        let poses = [first, second].map(|turns| PLAIN.pose(&turns, DAffine3::IDENTITY));
        let alone = corrected(&worn, &poses[1], &tension).0;
        corrected(&worn, &poses[0], &tension);
        corrected(&body, &poses[0], &tension);
        prop_assert_eq!(corrected(&worn, &poses[1], &tension).0, alone);
    }
}

#[test]
fn a_body_whose_triangles_point_inward_carries_as_well() {
    let body = Arc::new(PLAIN.skin(&swollen(Skinning::Linear)));
    let flipped: Vec<[i32; 3]> = triangles().iter().map(|&[a, b, c]| [a, c, b]).collect();
    let bound = |under: &[[i32; 3]]| {
        let garment = PLAIN.skin_of(&wider(0.01), &DAffine3::IDENTITY, &swollen(Skinning::Linear));
        garment.worn_over(body.clone(), under, &triangles()).unwrap()
    };
    let pose = PLAIN.pose(
        &[DQuat::IDENTITY, DQuat::from_rotation_x(0.9), DQuat::IDENTITY],
        DAffine3::IDENTITY,
    );
    let tension = no_tension();
    let (one, other) = (bound(&triangles()), bound(&flipped));
    assert!(
        gap(
            &deformed(&one, &pose, &tension),
            &deformed(&other, &pose, &tension)
        ) < 1e-5
    );
}

#[test]
fn a_body_without_triangles_is_refused() {
    let body = Arc::new(PLAIN.skin(&SkinOptions::default()));
    let garment = || PLAIN.skin_of(&wider(0.01), &DAffine3::IDENTITY, &SkinOptions::default());
    assert!(matches!(
        garment().worn_over(body.clone(), &[], &triangles()),
        Err(Error::NoFaces { .. })
    ));
    let wrong = [[0, 1, 1_000_000]];
    assert!(matches!(
        garment().worn_over(body.clone(), &wrong, &triangles()),
        Err(Error::Index { .. })
    ));
    assert!(matches!(
        garment().worn_over(body, &triangles(), &wrong),
        Err(Error::Index { .. })
    ));
}
