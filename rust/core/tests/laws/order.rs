//! Law of the vertex order: a mesh with other vertex indices gives the same skin.

use glam::{DQuat, DVec3, Vec3A};
use proptest::prelude::*;
use sinew_core::{Regional, Skin, SkinOptions};

use super::bodies::{Body, arms};
use super::rig::{corrected, deformed, gap};

/// Distance between the axes of the arms, m. They press into each other as they swing.
const APART_M: f64 = 0.12;
/// Largest difference by the rounding of f32 through all iterations, m.
const ROUNDING_M: f64 = 1e-5;

/// Two arms of irregular skin, so that no two vertices are equally near to a third, and a vertex that no
/// bone moves.
fn irregular() -> Body {
    let mut body = arms(APART_M);
    for (vertex, point) in body.points.iter_mut().enumerate() {
        let turn = vertex as f64;
        *point += 1e-3 * DVec3::new((7.1 * turn).sin(), (3.7 * turn).sin(), (5.3 * turn).sin());
    }
    body.points.push(DVec3::X);
    body.weights.push(vec![]);
    body
}

/// A permutation of the vertices of a body: the new index of each.
fn permutation(body: &Body) -> impl Strategy<Value = Vec<usize>> + use<> {
    Just((0..body.points.len()).collect::<Vec<_>>()).prop_shuffle()
}

fn permuted<T: Clone>(of_vertices: &[T], permutation: &[usize]) -> Vec<T> {
    let mut found = of_vertices.to_vec();
    for (value, &index) in of_vertices.iter().zip(permutation) {
        found[index] = value.clone();
    }
    found
}

fn with_permutation(body: &Body, permutation: &[usize]) -> Body {
    let index = |vertex: &mut i32| *vertex = permutation[*vertex as usize] as i32;
    let mut other = body.clone();
    other.points = permuted(&body.points, permutation);
    other.weights = permuted(&body.weights, permutation);
    other.edges.reverse();
    other.triangles.reverse();
    other.edges.iter_mut().flatten().for_each(index);
    other.triangles.iter_mut().flatten().for_each(index);
    other
}

/// A factor per vertex that differs between the sides.
fn painted(body: &Body) -> Vec<f32> {
    body.points
        .iter()
        .map(|point| 0.7 + 2.0 * point.x as f32)
        .collect()
}

fn factors(vertices: &[f32]) -> Regional<'_> {
    Regional {
        vertices: Some(vertices),
        ..Regional::default()
    }
}

/// The positions, the offsets and the offsets after the modifier of a skin, in a pose in which the arms
/// bend and touch.
fn frames(body: &Body, skin: &Skin) -> [Vec<[f32; 3]>; 3] {
    let turns = [0.0, 0.05, -0.6, -0.05, 1.3].map(DQuat::from_rotation_y);
    let pose = body.pose(&turns, glam::DAffine3::IDENTITY);
    let tension = vec![0.5; body.tissues.len()];
    let modifier = skin.posed_modifier(&pose).unwrap();
    let offset_of = |vertex| skin.posed_offset(&modifier, vertex, Vec3A::new(0.1, 0.2, 0.3));
    [
        deformed(skin, &pose, &tension),
        corrected(skin, &pose, &tension).0,
        (0..skin.len())
            .map(|vertex| offset_of(vertex).to_array())
            .collect(),
    ]
}

fn elastic(body: &Body) -> Skin {
    let painted = painted(body);
    body.elastic(|settings| {
        settings.anchor_stiffness = factors(&painted);
        settings.relaxation = factors(&painted);
        settings.fat_sliding = factors(&painted);
    })
}

fn stiff(body: &Body) -> Skin {
    body.stiff(&SkinOptions {
        muscle_influence: factors(&painted(body)),
        ..body.options()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn the_skin_does_not_depend_on_vertex_indices(permutation in permutation(&irregular())) {
        let body = irregular();
        let other = with_permutation(&body, &permutation);
        for skin_of in [elastic, stiff] {
            let (one, two) = (skin_of(&body), skin_of(&other));
            prop_assert_eq!(one.anchored(), two.anchored());
            for (one, two) in frames(&body, &one).iter().zip(frames(&other, &two)) {
                prop_assert!(gap(&permuted(one, &permutation), &two) < ROUNDING_M);
            }
        }
    }

    #[test]
    fn influences_do_not_depend_on_vertex_indices(permutation in permutation(&irregular())) {
        let body = irregular();
        let weights = |body: &Body| {
            let dense = stiff(body).tissue_weights();
            dense.chunks(body.tissues.len()).map(<[f32]>::to_vec).collect::<Vec<_>>()
        };
        let (one, two) = (permuted(&weights(&body), &permutation), weights(&with_permutation(&body, &permutation)));
        for (one, two) in one.iter().flatten().zip(two.iter().flatten()) {
            prop_assert!((one - two).abs() < 1e-6);
        }
    }
}

#[test]
fn the_arms_touch_in_these_frames() {
    let body = irregular();
    let on = frames(&body, &elastic(&body));
    let off = frames(&body, &body.elastic(|settings| settings.contacts = false));
    assert!(gap(&on[0], &off[0]) > 1e-3);
}
