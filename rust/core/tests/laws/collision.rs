//! Laws of tissue collision: skin stays out of bones and spheres as a joint bends; muscles and stuffing
//! yield.

use glam::DVec3;
use sinew_core::TissueKind;

use super::bodies::{Body, ELBOW_M, RADIUS_M, arm, ball, wide};
use super::rig::{deformed, gap};

const BEND: f64 = 1.9;
/// Radius of a ball in the elbow, just below the skin, m.
const BALL_M: f64 = 0.046;
/// Error of f32 and of one Newton step, m. Each iteration ends with the collision.
const TOLERANCE_M: f64 = 1e-5;

fn elbow() -> DVec3 {
    DVec3::Z * ELBOW_M
}

fn padded(kind: TissueKind) -> Body {
    let mut body = arm();
    body.tissues.push(ball("ball", kind, 1, elbow(), BALL_M));
    body
}

/// Largest depth of a vertex in the ball, less its depth at rest, m. Crease planes act last and are off.
fn deeper_m(body: &Body, collides: bool, angle: f64) -> f64 {
    let skin = body.elastic(|settings| {
        settings.crease = Some(&[0.0; 2]);
        settings.collides = collides;
    });
    let points = deformed(&skin, &body.bent(&[(1, angle)]), &body.relaxed());
    let weights = skin.tissue_weights();
    let tissues = body.tissues.len();
    let deeper = (0..points.len()).filter_map(|vertex| {
        let is_influenced = weights[vertex * tissues + tissues - 1] > 0.0;
        let least = body.points[vertex].distance(elbow()).min(BALL_M);
        is_influenced.then(|| least - wide(points[vertex]).distance(elbow()))
    });
    deeper.fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn skin_stays_out_of_bones_and_spheres() {
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

/// Skin that is in a bone at rest may stay there: it is not pushed out when the joint moves.
#[test]
fn skin_in_a_bone_at_rest_stays_as_deep() {
    let mut body = arm();
    body.tissues
        .push(ball("ball", TissueKind::Bone, 1, elbow(), 1.12 * RADIUS_M));
    let pose = body.bent(&[(1, 0.2)]);
    let position = |collides| {
        let skin = body.elastic(|settings| settings.collides = collides);
        deformed(&skin, &pose, &body.relaxed())
    };
    let deepest_m = |points: Vec<[f32; 3]>| {
        let depths = points
            .into_iter()
            .map(|position| wide(position).distance(elbow()));
        depths.fold(f64::INFINITY, f64::min)
    };
    assert!(deepest_m(position(true)) < 0.95 * 1.12 * RADIUS_M);
    assert!(gap(&position(true), &position(false)) > 1e-4);
}
