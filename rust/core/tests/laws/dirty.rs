//! Law of dirty tracking: no frame depends on another. With any content of the buffers, a frame has the
//! bits that a new skin gives.

use glam::{DAffine3, DQuat};
use proptest::prelude::*;
use sinew_core::{ColumnMajor, Elasticity, Energy, Skin};

use super::fixtures::bodies::{Body, arms};
use super::fixtures::jointed_bodies::chain;

/// Most bones and muscles of a body.
const BONES: usize = 5;
const MUSCLES: usize = 3;
/// Distance between the axes of the arms, m. They touch as soon as an elbow bends.
const APART_M: f64 = 0.115;

/// The changes from one frame to the next.
#[derive(Debug, Clone)]
struct Change {
    /// New angles of some bones about y and x, rad.
    turns: Vec<Option<(f64, f64)>>,
    /// New tension of some muscles.
    tension: Vec<Option<f32>>,
    corrects: bool,
    /// A faulty frame in between.
    spoilt: Option<Spoilt>,
}

#[derive(Debug, Clone, Copy)]
enum Spoilt {
    /// Refused: a matrix that is not affine.
    Pose,
    /// Refused: a tension above 1.
    Tension,
    /// Computed: a pose that is not finite.
    NotFinite,
}

fn changes() -> impl Strategy<Value = Vec<Change>> {
    let angle = || prop_oneof![Just(0.0), -0.05..0.05, -2.2..2.2];
    let turn = prop_oneof![2 => Just(None), 1 => (angle(), angle()).prop_map(Some)];
    let tension = prop_oneof![2 => Just(None), 1 => (0.0f32..=1.0).prop_map(Some)];
    let spoilt = prop_oneof![Just(Spoilt::Pose), Just(Spoilt::Tension), Just(Spoilt::NotFinite)];
    let change = (
        prop::collection::vec(turn, BONES),
        prop::collection::vec(tension, MUSCLES),
        any::<bool>(),
        prop_oneof![3 => Just(None), 1 => spoilt.prop_map(Some)],
    );
    prop::collection::vec(
        change.prop_map(|(turns, tension, corrects, spoilt)| Change {
            turns,
            tension,
            corrects,
            spoilt,
        }),
        2..7,
    )
}

fn frame(skin: &Skin, pose: &[ColumnMajor], tension: &[f32], corrects: bool) -> (Vec<[u32; 3]>, usize) {
    let mut out = vec![[f32::NAN; 3]; skin.len()];
    let report = if corrects {
        skin.correct(pose, tension, &mut out)
    } else {
        skin.deform(pose, tension, &mut out)
    };
    let bits = out.into_iter().map(|point| point.map(f32::to_bits));
    (bits.collect(), report.unwrap().damped)
}

fn spoil(skin: &Skin, pose: &[ColumnMajor], tension: &[f32], spoilt: Spoilt) {
    let (mut pose, mut tension) = (pose.to_vec(), tension.to_vec());
    match spoilt {
        Spoilt::Pose => pose[2][15] = 2.0,
        Spoilt::Tension => tension[0] = 2.0,
        Spoilt::NotFinite => pose[2][12] = f32::NAN,
    }
    let mut out = vec![[7.0; 3]; skin.len()];
    let report = skin.deform(&pose, &tension, &mut out);
    if report.is_err() {
        assert!(out.iter().all(|point| *point == [7.0; 3]));
    }
    assert_eq!(report.is_ok(), matches!(spoilt, Spoilt::NotFinite));
}

fn require_unchanged(body: &Body, energy: Energy, changes: &[Change]) -> Result<(), TestCaseError> {
    let new_skin = || {
        body.elastic(|settings: &mut Elasticity| {
            settings.energy = energy;
            settings.iterations = 3;
        })
    };
    let skin = new_skin();
    let mut turns = vec![DQuat::IDENTITY; body.heads.len()];
    let mut tension = body.relaxed();
    for change in changes {
        for (turn, new) in turns.iter_mut().zip(&change.turns) {
            if let Some((y, x)) = new {
                *turn = DQuat::from_rotation_y(*y) * DQuat::from_rotation_x(0.3 * x);
            }
        }
        for (tension, new) in tension.iter_mut().zip(&change.tension) {
            *tension = new.unwrap_or(*tension);
        }
        let pose = body.pose(&turns, DAffine3::IDENTITY);
        if let Some(spoilt) = change.spoilt {
            spoil(&skin, &pose, &tension, spoilt);
        }
        let expected = frame(&new_skin(), &pose, &tension, change.corrects);
        prop_assert!(frame(&skin, &pose, &tension, change.corrects) == expected);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn a_frame_has_the_bits_that_a_new_skin_gives(changes in changes()) {
        require_unchanged(&arms(APART_M), Energy::AsRigidAsPossible, &changes)?;
    }

    #[test]
    fn a_frame_of_touching_joints_has_the_bits_that_a_new_skin_gives(changes in changes()) {
        require_unchanged(&chain(), Energy::AsRigidAsPossible, &changes)?;
    }

    #[test]
    fn a_frame_with_springs_has_the_bits_that_a_new_skin_gives(changes in changes()) {
        require_unchanged(&arms(APART_M), Energy::Springs, &changes)?;
    }
}

/// One joint becomes inactive while the other stays active, and one limb leaves the other: no trace of
/// either may stay.
#[test]
fn inactive_joints_and_parted_limbs_leave_no_trace() {
    let body = arms(APART_M);
    let new_skin = || body.elastic(|_| {});
    let skin = new_skin();
    let touching = [(1, 0.03), (3, -0.03)];
    for bends in [
        &[(2, 1.5), (4, 1.0)][..],
        &[(4, 1.0)],
        &touching,
        &[],
        &[(2, 1.5)],
        &[(1, 0.03), (3, -0.03), (2, 0.2)],
        &[(1, 0.03), (3, -0.03), (2, 0.2)],
        &[(2, 0.2)],
    ] {
        let pose = body.bent(bends);
        for corrects in [false, true] {
            let expected = frame(&new_skin(), &pose, &body.relaxed(), corrects);
            assert_eq!(
                frame(&skin, &pose, &body.relaxed(), corrects),
                expected,
                "{bends:?}"
            );
        }
    }
}

/// From every set of bent joints to every other: an island that gains or loses a joint is computed again.
#[test]
fn joints_may_become_active_and_inactive_in_any_order() {
    let body = chain();
    let new_skin = || body.elastic(|settings| settings.iterations = 3);
    let poses: Vec<_> = (0..8)
        .map(|set| {
            let bent = (1..4).filter(|joint| set >> (joint - 1) & 1 == 1);
            body.bent(&bent.map(|joint| (joint, 1.1)).collect::<Vec<_>>())
        })
        .collect();
    let expected: Vec<_> = poses
        .iter()
        .map(|pose| frame(&new_skin(), pose, &body.relaxed(), false))
        .collect();
    let skin = new_skin();
    for first in 0..8 {
        for second in 0..8 {
            for set in [first, second] {
                assert!(
                    frame(&skin, &poses[set], &body.relaxed(), false) == expected[set],
                    "{first} to {second}"
                );
            }
        }
    }
}
