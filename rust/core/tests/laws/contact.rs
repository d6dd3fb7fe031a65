//! Laws of skin contact: two limbs that press into each other are moved apart, both by the same amount,
//! and not farther than the reach.

use glam::{DAffine3, DQuat, DVec3};
use rayon::ThreadPoolBuilder;
use sinew_core::ColumnMajor;
use sinew_core::measure::RestSurface;

use super::fixtures::bodies::{Body, ELBOW_M, RADIUS_M, arms, finger_on_wide_arm, wide};
use super::fixtures::rig::{deformed, gap};

const APART_M: f64 = 0.12;
const LENGTH_M: f64 = 2.0 * ELBOW_M;
/// Rotation of each arm at which they press slightly into each other, rad.
const SWING: f64 = 0.03;
/// Reach of contact on a body of 1.6 m (mathematics/contact.md, Skin contact), m.
const REACH_M: f64 = 0.015 * 1.6;

fn swung(body: &Body, angle: f64) -> Vec<ColumnMajor> {
    body.bent(&[(1, angle), (3, -angle)])
}

fn points(body: &Body, contacts: bool, pose: &[ColumnMajor]) -> Vec<[f32; 3]> {
    let skin = body.elastic(|settings| settings.contacts = contacts);
    deformed(&skin, pose, &body.relaxed())
}

/// Depth of the deepest vertex of one arm in the other, m, below the plane of the nearest vertex there.
/// The flat ends of the arms are left out, because their rims face nothing.
fn depth_m(body: &Body, points: &[[f32; 3]]) -> f64 {
    let normals = body.normals(points);
    let mut limbs = [body.limb([1, 2]), body.limb([3, 4])];
    for limb in &mut limbs {
        limb.retain(|&vertex| body.points[vertex].z < 0.55);
    }
    let [left, right] = limbs;
    let of = |inner: &[usize], outer: &[usize]| {
        let depths = inner.iter().map(|&vertex| {
            let position = wide(points[vertex]);
            let near = |other: &&usize| wide(points[**other]).distance_squared(position);
            let nearest = outer
                .iter()
                .min_by(|a, b| near(a).total_cmp(&near(b)))
                .copied()
                .unwrap();
            (wide(points[nearest]) - position).dot(normals[nearest])
        });
        depths.fold(f64::NEG_INFINITY, f64::max)
    };
    of(&left, &right).max(of(&right, &left))
}

/// Displacement of each vertex by contact, m.
fn shifts(body: &Body, pose: &[ColumnMajor]) -> Vec<f64> {
    let (on, off) = (points(body, true, pose), points(body, false, pose));
    let pairs = on.into_iter().zip(off);
    pairs.map(|(on, off)| wide(on).distance(wide(off))).collect()
}

fn largest_shift(shifts: &[f64], of: &[usize]) -> f64 {
    of.iter().map(|&vertex| shifts[vertex]).fold(0.0, f64::max)
}

#[test]
fn two_limbs_in_contact_are_moved_apart() {
    let body = arms(APART_M);
    let pose = swung(&body, SWING);
    let off = depth_m(&body, &points(&body, false, &pose));
    let on = depth_m(&body, &points(&body, true, &pose));
    assert!(off > 0.01);
    assert!(on < 0.1 * off);
}

#[test]
fn both_limbs_move_half_of_the_way() {
    let body = arms(APART_M);
    let shifts = shifts(&body, &swung(&body, SWING));
    let of = |bones| {
        let limb = body.limb(bones);
        limb.iter().map(|&vertex| shifts[vertex]).sum::<f64>()
    };
    let (left, right) = (of([1, 2]), of([3, 4]));
    assert!(left > 0.0);
    assert!((left / right - 1.0).abs() < 0.05);
}

/// No vertex of the arm's skin is near the finger, and none of the finger's near a vertex of the arm.
#[test]
fn a_finger_presses_the_middle_of_a_wide_triangle_inwards() {
    let body = finger_on_wide_arm(0.02);
    let surface = RestSurface::new(
        &body
            .points
            .iter()
            .map(|point| point.as_vec3().to_array())
            .collect::<Vec<_>>(),
        &body.triangles,
    )
    .unwrap();
    let pressed = DAffine3::from_translation(DVec3::X * -0.021 + body.heads[2]);
    let mut pose = body.pose(&[DQuat::IDENTITY; 3], DAffine3::IDENTITY);
    pose[2] = super::fixtures::rig::columns(pressed);
    let intersections = |contacts| {
        let found = surface.deformed(&points(&body, contacts, &pose)).unwrap();
        surface.quality(&found, &surface.whole()).new_intersections
    };
    assert!(intersections(false) > 0);
    assert_eq!(intersections(true), 0);
}

#[test]
fn skin_far_away_keeps_its_bits() {
    let body = arms(APART_M);
    let shifts = shifts(&body, &swung(&body, SWING));
    assert_eq!(largest_shift(&shifts, &body.limb([0, 0])), 0.0);
    assert!(largest_shift(&shifts, &body.limb([1, 2])) > 1e-3);
}

#[test]
fn limbs_at_any_depth_stay_within_the_reach() {
    let body = arms(APART_M);
    for angle in [0.05, 0.08, 0.12, 0.2, 0.3, 0.6] {
        let pose = swung(&body, angle);
        let (on, off) = (points(&body, true, &pose), points(&body, false, &pose));
        assert!(on.as_flattened().iter().all(|number| number.is_finite()));
        assert!(gap(&on, &off) < REACH_M, "{angle}");
    }
}

#[test]
fn a_limb_without_strength_does_not_move() {
    let body = arms(APART_M);
    let pose = swung(&body, SWING);
    let skin = body.elastic(|settings| settings.contact = Some(&[1.0, 0.0, 0.0, 1.0, 1.0]));
    let (on, off) = (
        deformed(&skin, &pose, &body.relaxed()),
        points(&body, false, &pose),
    );
    let moved = |bones| body.limb(bones).iter().any(|&vertex| on[vertex] != off[vertex]);
    assert!(!moved([1, 2]));
    assert!(moved([3, 4]));
}

#[test]
fn a_limb_of_partial_strength_moves_partially() {
    let body = arms(APART_M);
    let pose = swung(&body, SWING);
    let off = points(&body, false, &pose);
    let left = |strength| {
        let skin = body.elastic(|settings| settings.contact = Some(strength));
        let on = deformed(&skin, &pose, &body.relaxed());
        let limb = body.limb([1, 2]).into_iter();
        limb.map(|vertex| wide(on[vertex]).distance(wide(off[vertex])))
            .sum::<f64>()
    };
    let (some, all) = (left(&[1.0, 0.3, 0.3, 1.0, 1.0]), left(&[1.0; 5]));
    assert!(0.0 < some && some < 0.8 * all, "{some} of {all}");
}

#[test]
fn limbs_that_touch_at_rest_do_not_move() {
    for apart_m in [0.102, 0.1, 0.095, 0.08] {
        let body = arms(apart_m);
        let skin = body.elastic(|_| {});
        let rest: Vec<[f32; 3]> = body
            .points
            .iter()
            .map(|point| point.as_vec3().to_array())
            .collect();
        let motion =
            DAffine3::from_rotation_translation(DQuat::from_rotation_x(0.8), DVec3::new(0.1, -0.4, 0.3));
        let pose = |after| body.pose(&[DQuat::IDENTITY; 5], after);
        let found = deformed(&skin, &pose(DAffine3::IDENTITY), &body.relaxed());
        assert!(gap(&found, &rest) <= 1e-6);
        let moved = deformed(&skin, &pose(motion), &body.relaxed());
        assert!(gap(&moved, &super::fixtures::rig::mapped(&rest, motion)) <= 1e-6);
        // swung apart, they do not affect each other
        let apart = swung(&body, -0.2);
        assert_eq!(points(&body, true, &apart), points(&body, false, &apart));
    }
}

#[test]
fn contact_has_the_same_bits_on_any_number_of_threads() {
    let frame = |threads: usize| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let body = arms(APART_M);
        let pose = body.bent(&[(1, SWING), (2, -0.4), (3, -SWING), (4, 0.7)]);
        pool.install(|| points(&body, true, &pose))
    };
    let one = frame(1);
    assert_eq!(one, frame(2));
    assert_eq!(one, frame(8));
}

/// Within the reach no vertex moves farther in a step than the arm does. Beyond it, where contact is
/// released, vertices move farther.
#[test]
fn no_vertex_jumps_as_limbs_touch_and_part() {
    let body = arms(APART_M);
    let skin = body.elastic(|_| {});
    let step = 0.25_f64.to_radians();
    let mut before = deformed(&skin, &swung(&body, 0.0), &body.relaxed());
    let mut has_met = false;
    for index in 1..60 {
        let angle = f64::from(index) * step;
        let now = deformed(&skin, &swung(&body, angle), &body.relaxed());
        let jump = gap(&before, &now) / (step * LENGTH_M);
        let deep_m = 2.0 * LENGTH_M * angle.sin() - (APART_M - 2.0 * RADIUS_M);
        has_met |= deep_m > 0.0 && deep_m < REACH_M;
        assert!(jump < if deep_m < REACH_M { 1.2 } else { 5.0 }, "{index}: {jump}");
        before = now;
    }
    assert!(has_met);
}
