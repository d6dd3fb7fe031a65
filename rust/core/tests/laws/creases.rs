//! Laws of a bent joint: its volume stays, its skin stays on its side of the crease plane, and no vertex
//! jumps as it bends.

use glam::{DQuat, DVec3};

use super::bodies::{Body, ELBOW_M, arm, wide};
use super::rig::{deformed, gap};

/// Radius of the elbow: half of either bone, m.
const REACH_M: f64 = 0.15;
/// Distance by which a vertex in the middle of the transition may pass the plane, m
/// (mathematics/contact.md, Crease plane).
const SLACK_M: f64 = 0.1 * 0.032 * REACH_M;

fn positions(body: &Body, angle: f64, volume: &'static [f32], crease: &'static [f32]) -> Vec<[f32; 3]> {
    let skin = body.elastic(|settings| (settings.volume, settings.crease) = (Some(volume), Some(crease)));
    deformed(&skin, &body.bent(&[(1, angle)]), &body.relaxed())
}

/// Largest distance by which a vertex near the elbow has passed the plane between its bones, m.
fn crossing_m(body: &Body, points: &[[f32; 3]], angle: f64) -> f64 {
    let elbow = DVec3::Z * ELBOW_M;
    let normal = DQuat::from_rotation_y(0.5 * angle) * DVec3::Z;
    let crossings = body.points.iter().zip(points).filter_map(|(rest, &now)| {
        let side = (*rest - elbow).z.signum();
        let is_near = rest.distance(elbow) < REACH_M;
        is_near.then(|| -side * (wide(now) - elbow).dot(normal))
    });
    crossings.fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn a_bent_joint_keeps_its_volume() {
    let body = arm();
    let rest: Vec<[f32; 3]> = body
        .points
        .iter()
        .map(|point| point.as_vec3().to_array())
        .collect();
    let rest_volume = body.volume(&rest);
    let stiff = body.stiff(&body.options());
    for angle in [-2.1, 0.3, 0.8, 1.57, 2.1, 2.6] {
        let lost = |points: &[[f32; 3]]| 1.0 - body.volume(points) / rest_volume;
        let kept = lost(&positions(&body, angle, &[1.0; 2], &[1.0; 2]));
        let none = lost(&positions(&body, angle, &[0.0; 2], &[1.0; 2]));
        let linear = lost(&deformed(&stiff, &body.bent(&[(1, angle)]), &body.relaxed()));
        assert!(kept.abs() < 0.01, "{angle}: {kept}");
        if angle.abs() > 1.5 {
            assert!(none.abs() > 0.01 && linear > 0.01, "{angle}: {none} {linear}");
        }
    }
}

#[test]
fn skin_stays_on_its_side_of_the_crease() {
    let body = arm();
    for degrees in [120.0_f64, 130.0, 140.0, 150.0] {
        let angle = degrees.to_radians();
        let constrained = crossing_m(&body, &positions(&body, angle, &[1.0; 2], &[1.0; 2]), angle);
        let free = crossing_m(&body, &positions(&body, angle, &[1.0; 2], &[1.0, 0.0]), angle);
        assert!(constrained < SLACK_M + 1e-4, "{degrees}: {constrained}");
        if degrees >= 140.0 {
            assert!(free > 4.0 * SLACK_M, "{degrees}: {free}");
        }
    }
}

#[test]
fn no_vertex_jumps_as_a_joint_bends() {
    let (body, step) = (arm(), 0.25_f64.to_radians());
    let skin = body.elastic(|_| {});
    let mut before = deformed(&skin, &body.bent(&[]), &body.relaxed());
    let mut worst = (0.0_f64, 0);
    for index in 1..=600 {
        let now = deformed(
            &skin,
            &body.bent(&[(1, f64::from(index) * step)]),
            &body.relaxed(),
        );
        let jump = gap(&before, &now) / (step * ELBOW_M);
        if jump > worst.0 {
            worst = (jump, index);
        }
        before = now;
    }
    assert!(worst.0 < 1.1, "{worst:?}");
}

/// An arm with a flap on one side of its upper part that hangs down past the elbow, as an arm hangs
/// beside a waist; and the vertices of the flap's end.
fn flapped() -> (Body, Vec<usize>) {
    let mut body = arm().with_lengths(0.6);
    let mut end = vec![];
    for (vertex, point) in body.points.iter_mut().enumerate() {
        let out =
            ((point.x - 0.02) / 0.02).clamp(0.0, 1.0) * (1.0 - (point.z - 0.45).abs() / 0.1).clamp(0.0, 1.0);
        *point += DVec3::new(0.14, 0.0, -0.3) * out;
        if out > 0.7 {
            end.push(vertex);
        }
    }
    (body, end)
}

#[test]
fn the_plane_releases_skin_that_hangs_beside_the_limb() {
    let (body, end) = flapped();
    let below = |vertex: &&usize| body.points[**vertex].z < ELBOW_M - 0.02;
    assert!(end.iter().filter(below).count() > 10, "{}", end.len());
    for angle in [0.5_f64, 1.0] {
        let constrained = positions(&body, angle, &[0.0; 2], &[1.0; 2]);
        let free = positions(&body, angle, &[0.0; 2], &[1.0, 0.0]);
        let moved = end
            .iter()
            .map(|&vertex| wide(constrained[vertex]).distance(wide(free[vertex])));
        let most = moved.fold(0.0, f64::max);
        assert!(most < 0.002, "{angle}: {most}");
    }
}
