//! Law of welding: a mesh split along seams deforms like the unsplit mesh.

use glam::{DAffine3, DQuat, DVec3};
use proptest::prelude::*;
use sinew_core::{Regional, SkinOptions};

use super::fixtures::bodies::{Body, arms};
use super::fixtures::rig::{corrected, deformed, gap};

/// Largest difference of positions by rounding in f32, through all iterations of relaxation, m.
const ROUNDED_M: f64 = 1e-5;
/// Largest gap between split vertices of the posed mesh, m.
const CLOSED_M: f64 = 1e-6;

/// The body with a separate vertex for each corner of every triangle that `is_apart`, and the vertex that
/// each vertex was split from.
fn split(body: &Body, is_apart: impl Fn(usize) -> bool) -> (Body, Vec<usize>) {
    let mut other = body.clone();
    let mut origins: Vec<usize> = (0..body.points.len()).collect();
    for (triangle, corners) in other.triangles.iter_mut().enumerate() {
        if !is_apart(triangle) {
            continue;
        }
        for corner in corners.iter_mut() {
            let origin = *corner as usize;
            *corner = origins.len() as i32;
            origins.push(origin);
            other.points.push(body.points[origin]);
            other.weights.push(body.weights[origin].clone());
        }
        let [a, b, c] = *corners;
        other.edges.extend([[a, b], [b, c], [c, a]]);
    }
    (other, origins)
}

fn poses(body: &Body) -> [Vec<sinew_core::ColumnMajor>; 2] {
    [[0.0, 0.05, -0.6, -0.05, 1.3], [0.2, 0.6, 2.0, -0.3, -1.8]].map(|turns| {
        let turns = turns.map(DQuat::from_rotation_y);
        body.pose(&turns, DAffine3::from_translation(DVec3::X))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn a_split_mesh_deforms_like_the_merged_one(seed in 1_usize..1000, sinks in 2_usize..5) {
        let body = arms(0.12);
        let (other, origins) = split(&body, |triangle| (triangle * seed) % sinks == 0);
        let (one, two) = (body.elastic(|_| {}), other.elastic(|_| {}));
        for pose in poses(&body) {
            let tension = vec![0.5; body.tissues.len()];
            let (whole, apart) = (deformed(&one, &pose, &tension), deformed(&two, &pose, &tension));
            let expected: Vec<_> = origins.iter().map(|&origin| whole[origin]).collect();
            prop_assert!(gap(&expected, &apart) < ROUNDED_M);
            let firsts: Vec<_> = origins.iter().map(|&origin| apart[origin]).collect();
            prop_assert_eq!(firsts, apart, "coincident vertices separate");
        }
    }
}

#[test]
fn split_vertices_with_slightly_different_weights_stay_together() {
    let body = arms(0.12);
    let (mut other, origins) = split(&body, |triangle| triangle % 3 == 0);
    for (vertex, weights) in other.weights.iter_mut().enumerate().skip(body.points.len()) {
        if let [one, two] = &mut weights[..] {
            let shift = 0.01 * (vertex as f32).sin() * one.1.min(two.1);
            (one.1, two.1) = (one.1 + shift, two.1 - shift);
        }
    }
    let skin = other.elastic(|_| {});
    for pose in poses(&other) {
        let tension = vec![0.5; other.tissues.len()];
        let modifier = skin.posed_modifier(&pose).unwrap();
        let offsets = corrected(&skin, &pose, &tension).0;
        let bare = deformed(&skin, &pose, &tension);
        let worst = origins.iter().enumerate().map(|(vertex, &origin)| {
            let taken = |vertex: usize| skin.posed_offset(&modifier, vertex, offsets[vertex].into());
            assert!(taken(vertex).is_finite());
            gap(&[bare[vertex]], &[bare[origin]])
        });
        assert!(worst.fold(0.0, f64::max) < CLOSED_M);
    }
}

#[test]
fn coincident_vertices_with_other_weights_stay_where_the_modifier_puts_them() {
    let mut body = arms(0.12);
    let (one, other) = (body.limb([1, 2])[40], body.limb([1, 2])[0]);
    body.points[other] = body.points[one];
    body.weights[one] = vec![(1, 0.6), (2, 0.4)];
    body.weights[other] = vec![(1, 0.7), (2, 0.3)];
    let skin = body.stiff(&SkinOptions {
        muscle_influence: Regional::of_body(0.0),
        ..body.options()
    });
    let pose = body.bent(&[(2, 1.5)]);
    let offsets = corrected(&skin, &pose, &vec![0.0; body.tissues.len()]).0;
    assert!(offsets.iter().all(|offset| *offset == [0.0; 3]));
}

#[test]
fn coincident_vertices_that_move_apart_are_not_welded() {
    let mut body = arms(0.12);
    // a vertex of the left lower arm at the position of one of the trunk
    let vertex = body.points.len() - 5;
    let position = body.points[0];
    body.points[vertex] = position;
    let skin = body.stiff(&SkinOptions {
        muscle_influence: Regional::default(),
        ..body.options()
    });
    let pose = &poses(&body)[1];
    let positions = deformed(&skin, pose, &vec![0.0; body.tissues.len()]);
    assert!(gap(&[positions[0]], &[positions[vertex]]) > 0.01);
}
