//! Law of the safeguard: no skin is worse than the Armature modifier's.

use std::collections::BTreeSet;

use glam::{DAffine3, DQuat, DVec3};
use sinew_core::measure::RestSurface;
use sinew_core::{ColumnMajor, Regional, Skin, SkinOptions};

use super::fixtures::bodies::{Body, arms, wide};
use super::fixtures::jointed_bodies::{CHAIN_M, chain, finger, tail};
use super::fixtures::rig::{deformed, gap, mapped};

/// The size of `arms`, m.
const SIZE_M: f64 = 1.6;

/// Faults of a skin in a pose. The stretch is the 99th percentile of the edges that are stretched by more than 2 %.
#[derive(Debug, Clone, Copy)]
struct Faults {
    inverted: usize,
    intersections: usize,
    stretch: f64,
}

impl Faults {
    fn of(body: &Body, surface: &RestSurface, points: &[[f32; 3]]) -> Self {
        let quality = surface.quality(&surface.deformed(points).unwrap(), &surface.whole());
        let ends = |&[a, b, c]: &[i32; 3]| [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]);
        let edges: BTreeSet<[i32; 2]> = body.triangles.iter().flat_map(ends).collect();
        let ratios = edges.iter().map(|edge| {
            let [a, b] = edge.map(|end| end as usize);
            wide(points[a]).distance(wide(points[b])).max(1e-12) / body.points[a].distance(body.points[b])
        });
        let stretches = ratios.map(|ratio| ratio.max(1.0 / ratio));
        let mut stretched: Vec<f64> = stretches.filter(|stretch| *stretch > 1.02).collect();
        stretched.sort_by(f64::total_cmp);
        let rank = 0.99 * stretched.len().saturating_sub(1) as f64;
        let at = |rank: f64| stretched.get(rank as usize).copied().unwrap_or(1.0);
        Self {
            inverted: quality.inverted,
            intersections: quality.new_intersections,
            stretch: at(rank) + (at(rank.ceil()) - at(rank)) * rank.fract(),
        }
    }

    /// The limits are those of `scripts/harm.py`.
    fn is_worse_than(&self, other: &Self) -> bool {
        let are_more = |ours: usize, theirs: usize, least: usize| ours > theirs + least.max(theirs / 20);
        are_more(self.inverted, other.inverted, 1)
            || are_more(self.intersections, other.intersections, 2)
            || self.stretch > 1.1 * other.stretch + 0.05
    }
}

fn guarded(body: &Body) -> Skin {
    body.elastic(|settings| settings.safeguards = true)
}

fn free(body: &Body) -> Skin {
    body.elastic(|_| {})
}

fn surface(body: &Body) -> RestSurface {
    let points: Vec<[f32; 3]> = body
        .points
        .iter()
        .map(|point| point.as_vec3().to_array())
        .collect();
    RestSurface::new(&points, &body.triangles).unwrap()
}

fn positions(skin: &Skin, body: &Body, pose: &[ColumnMajor]) -> Vec<[f32; 3]> {
    deformed(skin, pose, &vec![0.0; body.tissues.len()])
}

/// Poses of a body in which one joint bends or twists.
fn sweep(bones: usize, degrees: &[f64]) -> Vec<Vec<DQuat>> {
    let mut poses = vec![];
    for bone in 1..bones {
        for degrees in degrees {
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let mut turns = vec![DQuat::IDENTITY; bones];
                turns[bone] = DQuat::from_axis_angle(axis, degrees.to_radians());
                poses.push(turns);
            }
        }
    }
    poses
}

/// The poses in which a guarded skin is worse than the modifier's, and the number of those in which it differs
/// from the skin without the safeguard.
fn worse(body: &Body, poses: &[Vec<DQuat>]) -> (Vec<String>, usize) {
    let surface = surface(body);
    let modifier = SkinOptions {
        muscle_influence: Regional::of_body(0.0),
        ..body.options()
    };
    let skins = [guarded(body), body.stiff(&modifier), free(body)];
    let (mut worse, mut returned) = (vec![], 0);
    for turns in poses {
        let pose = body.pose(turns, DAffine3::IDENTITY);
        let [guarded, alone, free] = skins.each_ref().map(|skin| positions(skin, body, &pose));
        returned += usize::from(gap(&guarded, &free) > 1e-3);
        let [guarded, alone] = [&guarded, &alone].map(|points| Faults::of(body, &surface, points));
        if guarded.is_worse_than(&alone) {
            worse.push(format!("{turns:?}: {guarded:?}, alone {alone:?}"));
        }
    }
    (worse, returned)
}

/// A body whose muscles are three times as thick.
fn strong(mut body: Body) -> Body {
    for tissue in &mut body.tissues {
        tissue.semi_axes = [
            3.0 * tissue.semi_axes[0],
            3.0 * tissue.semi_axes[1],
            tissue.semi_axes[2],
        ];
    }
    body
}

#[test]
fn no_joint_is_worse_than_under_the_modifier_alone() {
    let mut returned = 0;
    for (body, bones) in [
        (arms(0.2), 5),
        (strong(chain()), 4),
        (tail(), 6),
        (finger(), 3),
        (strong(finger()).split(), 3),
    ] {
        // angles that are compared, and two between them
        let (worse, differing) = worse(&body, &sweep(bones, &[45.0, 90.0, -90.0, 145.0, 33.0, -71.0]));
        assert!(worse.is_empty(), "{worse:#?}");
        returned += differing;
    }
    assert!(returned > 0, "nothing to guard against");
}

/// Only single joints are compared, so two at once may be worse: in at most 2 % of the poses.
#[test]
fn a_bone_that_carries_no_skin_but_moves_a_muscle_is_guarded() {
    let mut body = strong(arms(0.12));
    for row in &mut body.weights {
        // the lower arms carry nothing, and no piece is rigid
        for (bone, _) in row.iter_mut() {
            *bone = if *bone == 2 || *bone == 4 {
                *bone - 1
            } else {
                *bone
            };
        }
    }
    let first = body.limb([1, 1])[0];
    body.weights[first] = vec![(0, 0.5), (1, 0.5)];
    let bent: Vec<Vec<DQuat>> = sweep(5, &[60.0, 90.0])
        .into_iter()
        .filter(|turns| turns[2] != DQuat::IDENTITY)
        .collect();
    let (worse, returned) = worse(&body, &bent);
    assert!(returned > 0, "nothing to guard");
    assert!(worse.is_empty(), "{worse:#?}");
}

#[test]
fn two_joints_are_seldom_worse() {
    let (mut poses, mut all_worse) = (0, vec![]);
    for (body, bones) in [(strong(chain()), 4), (tail(), 6), (strong(finger()).split(), 3)] {
        let mut pairs = vec![];
        for first in 1..bones - 1 {
            for (one, other) in [(45.0_f64, 60.0_f64), (80.0, -50.0), (-65.0, -90.0)] {
                for axis in [DVec3::X, DVec3::new(0.6, 0.0, 0.8)] {
                    let mut turns = vec![DQuat::IDENTITY; bones];
                    turns[first] = DQuat::from_axis_angle(axis, one.to_radians());
                    turns[first + 1] = DQuat::from_axis_angle(axis, other.to_radians());
                    pairs.push(turns);
                }
            }
        }
        poses += pairs.len();
        all_worse.extend(worse(&body, &pairs).0);
    }
    assert!(
        all_worse.len() * 50 <= poses,
        "{} of {poses}: {all_worse:#?}",
        all_worse.len()
    );
}

#[test]
fn skin_that_is_nowhere_worse_is_unchanged() {
    let body = arms(0.2);
    let (guarded, free) = (guarded(&body), free(&body));
    let rest: Vec<[f32; 3]> = positions(&free, &body, &body.bent(&[]));
    for bend in [0.1, 0.2, 0.3] {
        let pose = body.bent(&[(2, bend)]);
        let expected = positions(&free, &body, &pose);
        assert!(gap(&expected, &rest) > 1e-3);
        let apart = gap(&positions(&guarded, &body, &pose), &expected);
        assert!(apart < 1e-6 * SIZE_M, "bent by {bend}: {apart}");
    }
}

#[test]
fn the_order_of_poses_does_not_matter() {
    let body = chain();
    let poses: Vec<Vec<ColumnMajor>> = [0.3, 2.4, 1.2, 0.0, 2.9]
        .iter()
        .map(|&bend| {
            let turns = [0.0, 0.4 * bend, bend, 0.2].map(DQuat::from_rotation_z);
            body.pose(&turns, DAffine3::IDENTITY)
        })
        .collect();
    let forwards = guarded(&body);
    let found: Vec<_> = poses
        .iter()
        .map(|pose| positions(&forwards, &body, pose))
        .collect();
    let backwards = guarded(&body);
    for (pose, expected) in poses.iter().zip(&found).rev() {
        assert_eq!(&positions(&backwards, &body, pose), expected);
    }
    for (pose, expected) in poses.iter().zip(&found) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        assert_eq!(
            &pool.install(|| positions(&guarded(&body), &body, pose)),
            expected
        );
    }
}

#[test]
fn it_moves_with_the_whole_rig() {
    let body = chain();
    let skin = guarded(&body);
    let motion = DAffine3::from_rotation_translation(DQuat::from_rotation_x(0.8), DVec3::new(0.1, -0.4, 0.3));
    for bend in [0.9, 1.9, 2.6] {
        let turns = [0.0, 0.3, bend, 0.1].map(DQuat::from_rotation_z);
        let still = positions(&skin, &body, &body.pose(&turns, DAffine3::IDENTITY));
        let moved = positions(&skin, &body, &body.pose(&turns, motion));
        let apart = gap(&mapped(&still, motion), &moved);
        assert!(apart < 1e-5 * CHAIN_M, "bent by {bend}: {apart}");
    }
}

#[test]
fn a_joint_returns_without_a_jump() {
    let body = strong(chain());
    let (skin, free) = (guarded(&body), free(&body));
    let mut before: Option<Vec<[f32; 3]>> = None;
    let mut largest_return = 0.0_f64;
    for step in 0..300 {
        let turn = f64::from(step) * 0.01;
        let turns = [0.0, 0.0, turn, 0.0].map(DQuat::from_rotation_x);
        let pose = body.pose(&turns, DAffine3::IDENTITY);
        let now = positions(&skin, &body, &pose);
        largest_return = largest_return.max(gap(&now, &positions(&free, &body, &pose)));
        if let Some(before) = before {
            // the bone itself moves by up to 4 mm a step
            assert!(gap(&before, &now) < 0.012, "step {step}: {}", gap(&before, &now));
        }
        before = Some(now);
    }
    assert!(largest_return > 1e-3, "it never returned");
}
