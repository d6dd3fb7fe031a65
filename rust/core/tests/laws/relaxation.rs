//! The rounds of relaxation and what may be set region by region: each setting acts, where it is set and nowhere else.

use glam::{DAffine3, DMat3, DVec3};
use proptest::prelude::*;
use rayon::ThreadPoolBuilder;
use sinew_core::{ColumnMajor, Elasticity, Energy, Regional, Skin, SkinOptions, Skinning};

use super::bodies::{Body, arm, arms, wide};
use super::rig::{
    Limb, PLAIN, SEGMENTS, deformed, edges, gap, mapped, motions, no_tension, tensions, triangles, turns,
    weighed,
};

const BENDS: [f64; 3] = [0.5, 1.2, 2.2];

/// Nothing but anchors and edges.
fn bare(told: &mut Elasticity) {
    told.volume = Some(&[0.0; 2]);
    told.crease = Some(&[0.0; 2]);
    told.collides = false;
    told.contacts = false;
    told.safeguards = false;
}

fn points<'a>(
    body: &'a Body,
    pose: &[ColumnMajor],
    change: impl FnOnce(&mut Elasticity<'a>),
) -> Vec<[f32; 3]> {
    deformed(&body.elastic(change), pose, &body.relaxed())
}

/// Where the anchors are where no muscle swells: the mesh's own weights, as dual quaternions.
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

/// The places near the elbow: there the relaxed skin shows fully.
fn shown(body: &Body, points: &[[f32; 3]]) -> Vec<[f32; 3]> {
    (0..points.len())
        .filter(|&vertex| near(body, vertex))
        .map(|vertex| points[vertex])
        .collect()
}

/// Mean deviation of the edges around the elbow from their length at rest, as a share of it.
fn strain(body: &Body, points: &[[f32; 3]]) -> f64 {
    let own: Vec<_> = body
        .edges
        .iter()
        .map(|edge| edge.map(|end| end as usize))
        .filter(|edge| edge.iter().all(|&end| near(body, end)))
        .collect();
    let strain = |&[a, b]: &[usize; 2]| {
        let rest = body.points[a].distance(body.points[b]);
        (wide(points[a]).distance(wide(points[b])) / rest - 1.0).powi(2)
    };
    (own.iter().map(strain).sum::<f64>() / own.len() as f64).sqrt()
}

#[test]
fn springs_bring_edges_nearer_to_their_length() {
    let body = arm();
    for angle in BENDS {
        let pose = body.bent(&[(1, angle)]);
        let of = |iterations| {
            let found = points(&body, &pose, |told| {
                bare(told);
                told.energy = Energy::Springs;
                told.iterations = iterations;
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
        pool.install(|| points(&body, &pose, |told| told.energy = Energy::Springs))
    };
    let one = frame(1);
    assert_eq!(one, frame(2));
    assert_eq!(one, frame(8));
    assert_ne!(one, points(&body, &pose, |_| {}));
}

/// A limb whose skin keeps the length of its edges.
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
        prop_assert!(gap(&mapped(weighed(&still), motion), weighed(&moved)) < 1e-3);
    }

    #[test]
    fn springs_of_a_mirrored_limb_move_as_its_mirror_image(turns in turns(0.8), tension in tensions()) {
        let mirror = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)));
        let mirrored = Limb { placed: mirror };
        let plain = deformed(&sprung(&PLAIN), &PLAIN.pose(&turns, DAffine3::IDENTITY), &tension);
        let other = deformed(&sprung(&mirrored), &mirrored.pose(&turns, DAffine3::IDENTITY), &tension);
        prop_assert!(gap(&mapped(&plain, mirror), &other) < 1e-3);
    }
}

#[test]
fn a_stiff_anchor_and_a_limp_edge_leave_the_skin_on_its_anchors() {
    let body = arm();
    for energy in [Energy::AsRigidAsPossible, Energy::Springs] {
        for angle in BENDS {
            let pose = body.bent(&[(1, angle)]);
            let due = shown(&body, &anchors(&body, &pose));
            let off = |anchor: f64, edge: f64| {
                let found = points(&body, &pose, |told| {
                    bare(told);
                    told.energy = energy;
                    told.anchor_stiffness.body = anchor;
                    told.edge_stiffness.body = edge;
                });
                gap(&shown(&body, &found), &due)
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
fn no_share_of_the_rounds_is_no_rounds() {
    let body = arm();
    let pose = body.bent(&[(1, 1.2)]);
    let none = points(&body, &pose, |told| told.iterations = 0);
    let shares: Vec<f32> = (0..body.points.len())
        .map(|vertex| if vertex % 3 == 0 { 0.0 } else { 1.0 })
        .collect();
    let still = points(&body, &pose, |told| {
        bare(told);
        told.relaxation.body = 0.0;
    });
    assert_eq!(still, none);
    // where one vertex stands still, the next does not
    let painted = points(&body, &pose, |told| {
        bare(told);
        told.relaxation.vertices = Some(&shares);
    });
    for (vertex, share) in shares.iter().enumerate() {
        if *share == 0.0 {
            assert_eq!(painted[vertex], none[vertex]);
        }
    }
    assert!(gap(&painted, &none) > 1e-3);
    // a share of one half takes part in the first half of the rounds
    let half = |iterations, share| {
        points(&body, &pose, |told| {
            bare(told);
            told.iterations = iterations;
            told.relaxation.body = share;
        })
    };
    assert_eq!(half(8, 0.5), half(4, 1.0));
    assert_ne!(half(8, 0.5), half(8, 1.0));
}

#[test]
fn anchors_with_slack_enough_pull_at_nothing() {
    let body = arm();
    let pose = body.bent(&[(1, 1.2)]);
    let slack = points(&body, &pose, |told| told.rest_distance_m.body = 1.0);
    let loose = points(&body, &pose, |told| told.anchor_stiffness.body = 0.0);
    assert_eq!(slack, loose);
    let some = points(&body, &pose, |told| told.rest_distance_m.body = 0.002);
    let plain = points(&body, &pose, |_| {});
    assert!(gap(&some, &plain) > 1e-5);
    assert!(gap(&some, &slack) > 1e-5);
}

#[test]
fn sliding_skin_goes_along_itself() {
    let body = arm();
    let pose = body.bent(&[(1, 1.2)]);
    let place = |sliding: f64| {
        points(&body, &pose, |told| {
            bare(told);
            told.fat_sliding.body = sliding;
        })
    };
    let (held, free) = (place(0.0), place(1.0));
    let normals = body.normals(&held);
    let (mut along, mut across) = (0.0, 0.0);
    for vertex in 0..held.len() {
        let way = wide(free[vertex]) - wide(held[vertex]);
        let out = way.dot(normals[vertex]);
        across += out * out;
        along += way.length_squared() - out * out;
    }
    assert!(along.sqrt() > 1e-3);
    assert!(along > across);
    let stretch = [strain(&body, &held), strain(&body, &free)];
    assert!(stretch[1] < stretch[0], "{stretch:?}");
}

#[test]
fn shares_above_one_count_as_one() {
    let body = arm();
    let pose = body.bent(&[(1, 1.2)]);
    let place = |change: fn(&mut Elasticity, f64), value| points(&body, &pose, |told| change(told, value));
    let changes: [fn(&mut Elasticity, f64); 2] = [
        |told, value| told.relaxation.body = value,
        |told, value| told.fat_sliding.body = value,
    ];
    for change in changes {
        assert_eq!(place(change, 5.0), place(change, 1.0));
        assert_ne!(place(change, 0.3), place(change, 1.0));
    }
}

/// Without contact, so that what one limb does is nothing to the other.
fn alone<'a>(
    body: &'a Body,
    pose: &[ColumnMajor],
    change: impl FnOnce(&mut Elasticity<'a>),
) -> Vec<[f32; 3]> {
    points(body, pose, |told| {
        told.contacts = false;
        change(told);
    })
}

#[test]
fn a_bones_settings_act_on_its_own_limb() {
    let body = arms(0.2);
    let pose = body.bent(&[(2, 2.5), (4, 2.5)]);
    let plain = alone(&body, &pose, |_| {});
    let of_left = Regional {
        bones: Some(&[1.0, 9.0, 9.0, 1.0, 1.0]),
        ..Regional::of_body(1.0)
    };
    let strengths: &[f32] = &[1.0, 1.0, 0.0, 1.0, 1.0];
    let of_changed = [
        alone(&body, &pose, |told| told.anchor_stiffness = of_left),
        alone(&body, &pose, |told| told.edge_stiffness = of_left),
        alone(&body, &pose, |told| told.volume = Some(strengths)),
        alone(&body, &pose, |told| told.crease = Some(strengths)),
    ];
    let (left, right) = (body.limb([1, 2]), body.limb([3, 4]));
    for (index, found) in of_changed.iter().enumerate() {
        let moved = |vertices: &[usize]| vertices.iter().any(|&vertex| found[vertex] != plain[vertex]);
        assert!(moved(&left), "{index}");
        assert!(!moved(&right), "{index}");
    }
}
