//! Laws of the relaxation and of its settings by region: each setting acts where it is set and nowhere
//! else.

use glam::{DAffine3, DMat3, DVec3};
use proptest::prelude::*;
use rayon::ThreadPoolBuilder;
use sinew_core::{ColumnMajor, Elasticity, Energy, Regional, Skin, SkinOptions, Skinning};

use super::fixtures::bodies::{Body, arm, arms, wide};
use super::fixtures::rig::{
    LENGTH_M, Limb, PLAIN, SEGMENTS, deformed, edges, gap, mapped, motions, no_tension, tensions, triangles,
    turns, weighted,
};

const BENDS: [f64; 3] = [0.5, 1.2, 2.2];

/// Only anchors and edges: no constraints.
fn bare(settings: &mut Elasticity) {
    settings.volume = Some(&[0.0; 2]);
    settings.crease = Some(&[0.0; 2]);
    settings.contacts = false;
    settings.safeguards = false;
}

fn points<'a>(
    body: &'a Body,
    pose: &[ColumnMajor],
    change: impl FnOnce(&mut Elasticity<'a>),
) -> Vec<[f32; 3]> {
    deformed(&body.elastic(change), pose, &body.relaxed())
}

/// The anchors if no muscle swells: the mesh's bone weights, blended as dual quaternions.
fn anchors(body: &Body, pose: &[ColumnMajor]) -> Vec<[f32; 3]> {
    let options = SkinOptions {
        skinning: Skinning::PreserveVolume,
        ..body.options()
    };
    deformed(&body.stiff(&options), pose, &body.relaxed())
}

fn near(body: &Body, vertex: usize) -> bool {
    body.points[vertex].distance(DVec3::Z * 0.3) < 0.15
}

/// The positions near the elbow, where the relaxed skin shows fully.
fn shown(body: &Body, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    (0..points.len())
        .filter(|&vertex| near(body, vertex))
        .map(|vertex| points[vertex])
        .collect()
}

/// Root mean square of the edges' strain around the elbow.
fn strain(body: &Body, points: &[[f32; 3]]) -> f64 {
    let edges: Vec<_> = body
        .edges
        .iter()
        .map(|edge| edge.map(|end| end as usize))
        .filter(|edge| edge.iter().all(|&end| near(body, end)))
        .collect();
    let strain = |&[a, b]: &[usize; 2]| {
        let rest = body.points[a].distance(body.points[b]);
        (wide(points[a]).distance(wide(points[b])) / rest - 1.0).powi(2)
    };
    (edges.iter().map(strain).sum::<f64>() / edges.len() as f64).sqrt()
}

#[test]
fn springs_move_edges_towards_their_length() {
    let body = arm();
    for angle in BENDS {
        let pose = body.bent(&[(1, angle)]);
        let of = |iterations| {
            let found = points(&body, &pose, |settings| {
                bare(settings);
                settings.energy = Energy::Springs;
                settings.iterations = iterations;
            });
            strain(&body, &found)
        };
        let strains = [0, 2, 10].map(of);
        assert!(strains[2] < 0.8 * strains[0]);
        assert!(strains[1] < strains[0]);
    }
}

#[test]
fn springs_are_the_same_bits_on_any_number_of_threads() {
    let body = arms(0.12);
    let pose = body.bent(&[(2, 1.4), (4, -0.8)]);
    let frame = |threads: usize| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| points(&body, &pose, |settings| settings.energy = Energy::Springs))
    };
    let one = frame(1);
    assert_eq!(one, frame(2));
    assert_eq!(one, frame(8));
    assert_ne!(one, points(&body, &pose, |_| {}));
}

/// A limb with the energy of length springs.
fn sprung(limb: &Limb) -> Skin {
    let (edges, triangles) = (edges(), triangles());
    let springs = Elasticity {
        energy: Energy::Springs,
        ..Elasticity::new(&edges, &triangles, SEGMENTS, 8)
    };
    limb.skin_with(&SkinOptions::default(), &springs).unwrap()
}

#[test]
fn springs_at_rest_move_nothing() {
    let rest = deformed(&sprung(&PLAIN), &PLAIN.rest_pose(), &no_tension());
    assert!(gap(&rest, &PLAIN.points()) <= 1e-6);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn springs_move_with_the_whole_rig(turns in turns(0.8), motion in motions(), tension in tensions()) {
        let skin = sprung(&PLAIN);
        let still = deformed(&skin, &PLAIN.pose(&turns, DAffine3::IDENTITY), &tension);
        let moved = deformed(&skin, &PLAIN.pose(&turns, motion), &tension);
        prop_assert!(gap(&mapped(weighted(&still), motion), weighted(&moved)) < 1e-5 * LENGTH_M);
    }

    #[test]
    fn springs_of_a_mirrored_limb_move_as_its_mirror_image(turns in turns(0.8), tension in tensions()) {
        let mirror = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)));
        let mirrored = Limb { placed: mirror };
        let plain = deformed(&sprung(&PLAIN), &PLAIN.pose(&turns, DAffine3::IDENTITY), &tension);
        let other = deformed(&sprung(&mirrored), &mirrored.pose(&turns, DAffine3::IDENTITY), &tension);
        prop_assert!(gap(&mapped(&plain, mirror), &other) < 1e-5 * LENGTH_M);
    }
}

#[test]
fn stiff_anchors_or_weak_edges_leave_the_skin_on_its_anchors() {
    let body = arm();
    for energy in [Energy::AsRigidAsPossible, Energy::Springs] {
        for angle in BENDS {
            let pose = body.bent(&[(1, angle)]);
            let expected = shown(&body, &anchors(&body, &pose));
            let off = |anchor: f64, edge: f64| {
                let found = points(&body, &pose, |settings| {
                    bare(settings);
                    settings.energy = energy;
                    settings.anchor_stiffness.body = anchor;
                    settings.edge_stiffness.body = edge;
                });
                gap(&shown(&body, &found), &expected)
            };
            let plain = off(1.0, 1.0);
            assert!(plain > 2e-4);
            assert!(off(1e6, 1.0) < 0.01 * plain);
            assert!(off(1.0, 1e-6) < 0.01 * plain);
            assert!(off(1.0, 0.0) < 1e-6);
            assert!(off(10.0, 1.0) < 0.9 * plain);
            assert!(off(0.0, 1.0) > plain);
        }
    }
}

#[test]
fn a_relaxation_of_zero_is_no_iterations() {
    let body = arm();
    let pose = body.bent(&[(1, 1.2)]);
    let none = points(&body, &pose, |settings| settings.iterations = 0);
    let fractions: Vec<f32> = (0..body.points.len())
        .map(|vertex| if vertex % 3 == 0 { 0.0 } else { 1.0 })
        .collect();
    let still = points(&body, &pose, |settings| {
        bare(settings);
        settings.relaxation.body = 0.0;
    });
    assert_eq!(still, none);
    // a vertex that does not take part may have a neighbour that does
    let painted = points(&body, &pose, |settings| {
        bare(settings);
        settings.relaxation.vertices = Some(&fractions);
    });
    for (vertex, fraction) in fractions.iter().enumerate() {
        if *fraction == 0.0 {
            assert_eq!(painted[vertex], none[vertex]);
        }
    }
    assert!(gap(&painted, &none) > 1e-3);
    // a relaxation of one half takes part in the first half of the iterations
    let half = |iterations, fraction| {
        points(&body, &pose, |settings| {
            bare(settings);
            settings.iterations = iterations;
            settings.relaxation.body = fraction;
        })
    };
    assert_eq!(half(8, 0.5), half(4, 1.0));
    assert_ne!(half(8, 0.5), half(8, 1.0));
}

#[test]
fn anchors_with_enough_slack_do_not_pull() {
    let body = arm();
    let pose = body.bent(&[(1, 1.2)]);
    let slack = points(&body, &pose, |settings| settings.slack_m.body = 1.0);
    let loose = points(&body, &pose, |settings| settings.anchor_stiffness.body = 0.0);
    assert_eq!(slack, loose);
    let some = points(&body, &pose, |settings| settings.slack_m.body = 0.002);
    let plain = points(&body, &pose, |_| {});
    assert!(gap(&some, &plain) > 1e-5);
    assert!(gap(&some, &slack) > 1e-5);
}

#[test]
fn sliding_skin_moves_along_itself() {
    let body = arm();
    let pose = body.bent(&[(1, 1.2)]);
    let position = |sliding: f64| {
        points(&body, &pose, |settings| {
            bare(settings);
            settings.fat_sliding.body = sliding;
        })
    };
    let (held, free) = (position(0.0), position(1.0));
    let normals = body.normals(&held);
    let (mut along, mut across) = (0.0, 0.0);
    for vertex in 0..held.len() {
        let vector = wide(free[vertex]) - wide(held[vertex]);
        let out = vector.dot(normals[vertex]);
        across += out * out;
        along += vector.length_squared() - out * out;
    }
    assert!(along.sqrt() > 1e-3);
    assert!(along > across);
    let stretch = [strain(&body, &held), strain(&body, &free)];
    assert!(stretch[1] < stretch[0], "{stretch:?}");
}

#[test]
fn fractions_above_one_count_as_one() {
    let body = arm();
    let pose = body.bent(&[(1, 1.2)]);
    let position =
        |change: fn(&mut Elasticity, f64), value| points(&body, &pose, |settings| change(settings, value));
    let changes: [fn(&mut Elasticity, f64); 2] = [
        |settings, value| settings.relaxation.body = value,
        |settings, value| settings.fat_sliding.body = value,
    ];
    for change in changes {
        assert_eq!(position(change, 5.0), position(change, 1.0));
        assert_ne!(position(change, 0.3), position(change, 1.0));
    }
}

/// Without contact, so that the limbs do not affect each other.
fn alone<'a>(
    body: &'a Body,
    pose: &[ColumnMajor],
    change: impl FnOnce(&mut Elasticity<'a>),
) -> Vec<[f32; 3]> {
    points(body, pose, |settings| {
        settings.contacts = false;
        change(settings);
    })
}

#[test]
fn settings_of_a_bone_act_on_its_limb_only() {
    let body = arms(0.2);
    let pose = body.bent(&[(2, 2.5), (4, 2.5)]);
    let plain = alone(&body, &pose, |_| {});
    let of_left = Regional {
        bones: Some(&[1.0, 9.0, 9.0, 1.0, 1.0]),
        ..Regional::of_body(1.0)
    };
    let strengths: &[f32] = &[1.0, 1.0, 0.0, 1.0, 1.0];
    let of_changed = [
        alone(&body, &pose, |settings| settings.anchor_stiffness = of_left),
        alone(&body, &pose, |settings| settings.edge_stiffness = of_left),
        alone(&body, &pose, |settings| settings.volume = Some(strengths)),
        alone(&body, &pose, |settings| settings.crease = Some(strengths)),
    ];
    let (left, right) = (body.limb([1, 2]), body.limb([3, 4]));
    for (index, found) in of_changed.iter().enumerate() {
        let moved = |vertices: &[usize]| vertices.iter().any(|&vertex| found[vertex] != plain[vertex]);
        assert!(moved(&left), "{index}");
        assert!(!moved(&right), "{index}");
    }
}
