//! Law of the safeguard: no skin is worse than the Armature modifier's.

use glam::{DAffine3, DQuat, DVec3};
use sinew_core::measure::RestSurface;
use sinew_core::{ColumnMajor, Regional, Skin, SkinOptions};

use super::fixtures::bodies::{Body, CHAIN_M, arms, chain};
use super::fixtures::rig::{deformed, gap, mapped};

/// The size of `arms`, m.
const SIZE_M: f64 = 1.6;

/// Faults of a skin in a pose.
#[derive(Debug, Clone, Copy)]
struct Faults {
    inverted: usize,
    intersections: usize,
    stretch: f64,
}

impl Faults {
    fn of(surface: &RestSurface, points: &[[f32; 3]]) -> Self {
        let quality = surface.quality(&surface.deformed(points).unwrap(), &surface.whole());
        Self {
            inverted: quality.inverted,
            intersections: quality.new_intersections,
            stretch: quality.edge.p99,
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
fn sweep(body: &Body, bones: usize) -> Vec<Vec<ColumnMajor>> {
    let mut poses = vec![];
    for bone in 1..bones {
        for degrees in [45.0_f64, 90.0, -90.0, 145.0] {
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let mut turns = vec![DQuat::IDENTITY; bones];
                turns[bone] = DQuat::from_axis_angle(axis, degrees.to_radians());
                poses.push(body.pose(&turns, DAffine3::IDENTITY));
            }
        }
    }
    poses
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
    for (body, bones) in [(arms(0.2), 5), (strong(chain()), 4)] {
        let surface = surface(&body);
        let modifier = SkinOptions {
            muscle_influence: Regional::of_body(0.0),
            ..body.options()
        };
        let (skin, alone) = (guarded(&body), body.stiff(&modifier));
        let free = free(&body);
        for (index, pose) in sweep(&body, bones).iter().enumerate() {
            let [guarded, alone, free] = [&skin, &alone, &free].map(|skin| positions(skin, &body, pose));
            returned += usize::from(gap(&guarded, &free) > 1e-3);
            let [guarded, alone] = [&guarded, &alone].map(|points| Faults::of(&surface, points));
            assert!(
                !guarded.is_worse_than(&alone),
                "pose {index}: {guarded:?}, alone {alone:?}"
            );
        }
    }
    assert!(returned > 0, "nothing to guard against");
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
