//! Do no harm: a skin is no worse than what the Armature modifier alone makes of it.

use glam::{DAffine3, DQuat, DVec3};
use sinew_core::measure::RestSurface;
use sinew_core::{ColumnMajor, Skin};

use super::bodies::{Body, arms, chain};
use super::rig::{deformed, gap};

/// Inverted faces and new hits.
fn faults(surface: &RestSurface, points: &[[f32; 3]]) -> (usize, usize) {
    let quality = surface.quality(&surface.deformed(points).unwrap(), &surface.whole());
    (quality.inverted, quality.new_intersections)
}

fn surface(body: &Body) -> RestSurface {
    let points: Vec<[f32; 3]> = body
        .points
        .iter()
        .map(|point| point.as_vec3().to_array())
        .collect();
    RestSurface::new(&points, &body.triangles).unwrap()
}

fn places(skin: &Skin, body: &Body, pose: &[ColumnMajor]) -> Vec<[f32; 3]> {
    deformed(skin, pose, &vec![0.0; body.tissues.len()])
}

/// Bends and twists of every joint of a body by itself.
fn sweep(body: &Body, bones: usize) -> Vec<Vec<ColumnMajor>> {
    let mut poses = vec![];
    for bone in 1..bones {
        for degrees in [45.0_f64, 90.0, -90.0, 130.0] {
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let mut turns = vec![DQuat::IDENTITY; bones];
                turns[bone] = DQuat::from_axis_angle(axis, degrees.to_radians());
                poses.push(body.pose(&turns, DAffine3::IDENTITY));
            }
        }
    }
    poses
}

#[test]
fn no_joint_is_worse_than_under_the_modifier_alone() {
    for (body, bones) in [(arms(0.2), 5), (chain(), 4)] {
        let surface = surface(&body);
        let (skin, alone) = (body.elastic(|_| {}), body.stiff(&body.options()));
        for (index, pose) in sweep(&body, bones).iter().enumerate() {
            let (own, bare) = (
                faults(&surface, &places(&skin, &body, pose)),
                faults(&surface, &places(&alone, &body, pose)),
            );
            let is_worse = |own: usize, bare: usize, least: usize| own > bare + least.max(bare / 20);
            assert!(
                !is_worse(own.0, bare.0, 1),
                "pose {index}: inverted {own:?}, alone {bare:?}"
            );
            assert!(
                !is_worse(own.1, bare.1, 2),
                "pose {index}: hits {own:?}, alone {bare:?}"
            );
        }
    }
}

#[test]
fn a_good_skin_is_left_as_it_is() {
    let body = arms(0.2);
    let (guarded, free) = (
        body.elastic(|_| {}),
        body.elastic(|settings| settings.safeguards = false),
    );
    for bend in [0.3, 0.8, 1.1] {
        let pose = body.bent(&[(2, bend)]);
        let apart = gap(&places(&guarded, &body, &pose), &places(&free, &body, &pose));
        assert!(apart == 0.0, "bent by {bend}: {apart} m");
    }
}

#[test]
fn what_is_driven_through_itself_returns_to_the_modifier_without_a_jump() {
    let body = chain();
    let skin = body.elastic(|_| {});
    let mut before: Option<Vec<[f32; 3]>> = None;
    for step in 0..60 {
        let turn = f64::from(step) * 0.05;
        let mut turns = vec![DQuat::IDENTITY; 4];
        turns[2] = DQuat::from_rotation_z(turn);
        let pose = body.pose(&turns, DAffine3::IDENTITY);
        let now = places(&skin, &body, &pose);
        if let Some(before) = before {
            assert!(gap(&before, &now) < 0.02, "step {step}: {}", gap(&before, &now));
        }
        before = Some(now);
    }
}
