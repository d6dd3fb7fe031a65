//! Skin keeps off the bones beneath it as a joint bends; flesh yields.

use glam::DVec3;
use sinew_core::TissueKind;

use super::bodies::{Body, ELBOW_M, arm, ball, wide};
use super::rig::deformed;

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

#[test]
fn at_rest_skin_that_lies_in_a_bone_stays() {
    let mut body = padded(TissueKind::Bone);
    body.tissues[1] = ball("ball", TissueKind::Bone, 1, elbow(), 0.056);
    let skin = body.elastic(|_| {});
    let rest = deformed(&skin, &body.bent(&[]), &body.relaxed());
    for (place, due) in rest.iter().zip(&body.points) {
        assert!(wide(*place).distance(*due) < 1e-6);
    }
}
