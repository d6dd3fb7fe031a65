//! How a mesh numbers its vertices means nothing: numbered otherwise, it gives the same skin.

use glam::{DQuat, DVec3, Vec3A};
use proptest::prelude::*;
use sinew_core::{Regional, Skin, SkinOptions};

use super::bodies::{Body, arms};
use super::rig::{corrected, deformed, gap};

/// The axes of the arms, m apart: they press into each other as they swing.
const APART_M: f64 = 0.12;
/// What f32 rounds off a place, through all rounds of relaxation, m.
const ROUNDED_M: f64 = 1e-5;

/// Two arms of irregular skin, so that no two vertices are equally near to a third, with a vertex that no bone moves.
fn irregular() -> Body {
    let mut body = arms(APART_M);
    for (vertex, place) in body.points.iter_mut().enumerate() {
        let turn = vertex as f64;
        *place += 1e-3 * DVec3::new((7.1 * turn).sin(), (3.7 * turn).sin(), (5.3 * turn).sin());
    }
    body.points.push(DVec3::X);
    body.weights.push(vec![]);
    body
}

/// Other numbers for the vertices of a body: the new ones, vertex by vertex.
fn numbers(body: &Body) -> impl Strategy<Value = Vec<usize>> + use<> {
    Just((0..body.points.len()).collect::<Vec<_>>()).prop_shuffle()
}

fn numbered<T: Clone>(of_vertices: &[T], numbers: &[usize]) -> Vec<T> {
    let mut found = of_vertices.to_vec();
    for (own, &number) in of_vertices.iter().zip(numbers) {
        found[number] = own.clone();
    }
    found
}

fn renumbered(body: &Body, numbers: &[usize]) -> Body {
    let number = |vertex: &mut i32| *vertex = numbers[*vertex as usize] as i32;
    let mut other = body.clone();
    other.points = numbered(&body.points, numbers);
    other.weights = numbered(&body.weights, numbers);
    other.edges.reverse();
    other.triangles.reverse();
    other.edges.iter_mut().flatten().for_each(number);
    other.triangles.iter_mut().flatten().for_each(number);
    other
}

/// A factor for each vertex, other on either side.
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

/// The places and the offsets of a skin in a pose in which the arms bend and meet, and where its modifier takes an offset.
fn frames(body: &Body, skin: &Skin) -> [Vec<[f32; 3]>; 3] {
    let turns = [0.0, 0.05, -0.6, -0.05, 1.3].map(DQuat::from_rotation_y);
    let pose = body.pose(&turns, glam::DAffine3::IDENTITY);
    let tension = vec![0.5; body.tissues.len()];
    let modifier = skin.posed_modifier(&pose).unwrap();
    let taken = |vertex| skin.posed_offset(&modifier, vertex, Vec3A::new(0.1, 0.2, 0.3));
    [
        deformed(skin, &pose, &tension),
        corrected(skin, &pose, &tension).0,
        (0..skin.len()).map(|vertex| taken(vertex).to_array()).collect(),
    ]
}

fn elastic(body: &Body) -> Skin {
    let own = painted(body);
    body.elastic(|told| {
        told.anchor_stiffness = factors(&own);
        told.relaxation = factors(&own);
        told.fat_sliding = factors(&own);
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
    fn a_skin_goes_along_with_its_mesh_however_that_is_numbered(numbers in numbers(&irregular())) {
        let body = irregular();
        let other = renumbered(&body, &numbers);
        for skin_of in [elastic, stiff] {
            let (one, two) = (skin_of(&body), skin_of(&other));
            prop_assert_eq!(one.anchored(), two.anchored());
            for (one, two) in frames(&body, &one).iter().zip(frames(&other, &two)) {
                prop_assert!(gap(&numbered(one, &numbers), &two) < ROUNDED_M);
            }
        }
    }

    #[test]
    fn influences_go_along_with_their_vertices(numbers in numbers(&irregular())) {
        let body = irregular();
        let weights = |body: &Body| {
            let dense = stiff(body).tissue_weights();
            dense.chunks(body.tissues.len()).map(<[f32]>::to_vec).collect::<Vec<_>>()
        };
        let (one, two) = (numbered(&weights(&body), &numbers), weights(&renumbered(&body, &numbers)));
        for (one, two) in one.iter().flatten().zip(two.iter().flatten()) {
            prop_assert!((one - two).abs() < 1e-6);
        }
    }
}

#[test]
fn the_arms_meet_in_these_frames() {
    let body = irregular();
    let on = frames(&body, &elastic(&body));
    let off = frames(&body, &body.elastic(|told| told.contacts = false));
    assert!(gap(&on[0], &off[0]) > 1e-3);
}
