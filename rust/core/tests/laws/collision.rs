//! Skin keeps off the bones beneath it as a joint bends; flesh yields.

use glam::DVec3;
use sinew_core::TissueKind;

use super::bodies::{Body, ELBOW_M, RADIUS_M, arm, ball, wide};
use super::rig::{deformed, gap};

const BEND: f64 = 1.9;
/// A ball in the elbow, just under the skin.
const BALL_M: f64 = 0.046;
/// What f32 and a Newton step may leave, m: the rounds end with the collision.
const TOLERANCE_M: f64 = 1e-5;

fn elbow() -> DVec3 {
    DVec3::Z * ELBOW_M
}

fn padded(kind: TissueKind) -> Body {
    let mut body = arm();
    body.tissues.push(ball("ball", kind, 1, elbow(), BALL_M));
    body
}

/// How much deeper in the ball than at rest the deepest vertex lies, m; without crease planes, which act last.
fn deeper_m(body: &Body, collides: bool, angle: f64) -> f64 {
    let skin = body.elastic(|told| {
        told.crease = Some(&[0.0; 2]);
        told.collides = collides;
    });
    let points = deformed(&skin, &body.bent(&[(1, angle)]), &body.relaxed());
    let weights = skin.tissue_weights();
    let tissues = body.tissues.len();
    let deeper = (0..points.len()).filter_map(|vertex| {
        let lies_on = weights[vertex * tissues + tissues - 1] > 0.0;
        let least = body.points[vertex].distance(elbow()).min(BALL_M);
        lies_on.then(|| least - wide(points[vertex]).distance(elbow()))
    });
    deeper.fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn skin_keeps_off_bone_and_sphere() {
    for kind in [TissueKind::Bone, TissueKind::Sphere] {
        let body = padded(kind);
        for angle in [0.8, 1.2, BEND] {
            let (on, off) = (deeper_m(&body, true, angle), deeper_m(&body, false, angle));
            assert!(on < TOLERANCE_M, "{kind:?} {angle}: {on}");
            assert!(off > 1e-3, "{kind:?} {angle}: {off}");
        }
    }
}

#[test]
fn flesh_yields_in_a_closed_joint() {
    let (flesh, bone) = (padded(TissueKind::Stuffing), padded(TissueKind::Bone));
    let (soft, hard) = (deeper_m(&flesh, true, BEND), deeper_m(&bone, true, BEND));
    assert!(soft > 1e-3 && hard < TOLERANCE_M);
}

/// What lies in a bone at rest may lie there: it is not pushed out as soon as the joint moves.
#[test]
fn skin_that_lies_in_a_bone_at_rest_stays_as_deep() {
    let mut body = arm();
    body.tissues
        .push(ball("ball", TissueKind::Bone, 1, elbow(), 1.12 * RADIUS_M));
    let pose = body.bent(&[(1, 0.2)]);
    let place = |collides| {
        let skin = body.elastic(|told| told.collides = collides);
        deformed(&skin, &pose, &body.relaxed())
    };
    let deepest_m = |points: Vec<[f32; 3]>| {
        let depths = points.into_iter().map(|place| wide(place).distance(elbow()));
        depths.fold(f64::INFINITY, f64::min)
    };
    assert!(deepest_m(place(true)) < 0.95 * 1.12 * RADIUS_M);
    assert!(gap(&place(true), &place(false)) > 1e-4);
}
