//! For any pose, size or mesh the skin stays finite, and nothing panics.

use glam::DVec3;
use sinew_core::{ColumnMajor, Energy};

use super::fixtures::bodies::{Body, arm, arms};
use super::fixtures::rig::{deformed, gap};

fn require_finite(body: &Body, pose: &[ColumnMajor], what: &str) {
    for energy in [Energy::AsRigidAsPossible, Energy::Springs] {
        let skin = body.elastic(|settings| {
            settings.energy = energy;
            settings.fat_sliding.body = 0.5;
            settings.slack_m.body = 0.001;
        });
        for frame in [pose, &body.bent(&[])] {
            let points = deformed(&skin, frame, &body.relaxed());
            let is_finite = points.as_flattened().iter().all(|number| number.is_finite());
            assert!(is_finite, "{what}, {energy:?}");
            let mut offsets = vec![[0.0; 3]; skin.len()];
            skin.correct(frame, &body.relaxed(), &mut offsets).unwrap();
            let is_finite = offsets.as_flattened().iter().all(|number| number.is_finite());
            assert!(is_finite, "{what}, {energy:?}, corrected");
        }
    }
}

#[test]
fn a_joint_may_be_folded_right_back() {
    for body in [arm(), arms(0.12)] {
        let elbow = if body.heads.len() == 2 { 1 } else { 2 };
        for degrees in [
            -180.0_f64, -179.0, 170.0, 179.0, 179.999, 180.0, 181.0, 360.0, 540.0,
        ] {
            let pose = body.bent(&[(elbow, degrees.to_radians())]);
            require_finite(&body, &pose, &format!("{degrees} degrees"));
        }
    }
}

#[test]
fn the_skin_is_as_large_as_its_body() {
    let bends = [(1, 0.01), (2, 1.6), (3, -0.02), (4, -0.4)];
    let plain = arms(0.115);
    let elastic = |body: &Body, safeguards: bool| {
        let skin = body.elastic(|settings| settings.safeguards = safeguards);
        deformed(&skin, &body.bent(&bends), &body.relaxed())
    };
    let expected = elastic(&plain, false);
    let guarded = elastic(&plain, true);
    let still = deformed(
        &plain.stiff(&plain.options()),
        &plain.bent(&bends),
        &plain.relaxed(),
    );
    assert!(gap(&expected, &still) > 1e-2);
    for scale in [0.01, 100.0] {
        let body = arms(0.115).scaled(scale);
        for (safeguards, expected) in [(false, &expected), (true, &guarded)] {
            let found = elastic(&body, safeguards);
            let back: Vec<[f32; 3]> = found
                .iter()
                .map(|position| position.map(|number| number / scale as f32))
                .collect();
            let apart = gap(&back, expected);
            assert!(apart < 2e-5, "{scale}, safeguard {safeguards}: {apart}");
        }
    }
}

/// Faults of a mesh.
fn spoilt() -> Vec<(&'static str, Body)> {
    let spoil = |what, spoil: fn(&mut Body)| {
        let mut body = arm();
        spoil(&mut body);
        (what, body)
    };
    vec![
        spoil("edges without length", |body| {
            let position = body.points[390];
            body.points[385..430].fill(position);
        }),
        spoil("all in one position", |body| body.points.fill(DVec3::Z * 0.3)),
        spoil("all in one line", |body| {
            for point in &mut body.points {
                (point.x, point.y) = (0.0, 0.0);
            }
        }),
        spoil("flat", |body| {
            body.points.iter_mut().for_each(|point| point.y = 0.0)
        }),
        spoil("isolated vertices", |body| {
            let is_kept = |end: &i32| end % 5 != 0;
            body.edges.retain(|edge| edge.iter().all(is_kept));
            body.triangles.retain(|triangle| triangle.iter().all(is_kept));
        }),
        spoil("triangles twice and turned over", |body| {
            let twice = body.triangles.clone();
            body.triangles.extend(twice.iter().map(|&[a, b, c]| [c, b, a]));
            body.triangles.extend(twice);
        }),
        spoil("triangles of one or two vertices", |body| {
            let degenerate = body
                .triangles
                .iter()
                .flat_map(|&[a, b, _]| [[a, a, a], [a, b, a]]);
            body.triangles = degenerate.chain(body.triangles.iter().copied()).collect();
        }),
        spoil("edges to itself", |body| {
            body.edges.extend((0..800).map(|vertex| [vertex, vertex]));
        }),
        spoil("edges of many triangles", |body| {
            let fans = body
                .triangles
                .iter()
                .step_by(3)
                .map(|&[a, b, c]| [a, b, (c + 37) % 800]);
            body.triangles = fans.chain(body.triangles.iter().copied()).collect();
        }),
        spoil("no triangles", |body| body.triangles.clear()),
        spoil("no edges and no triangles", |body| {
            body.edges.clear();
            body.triangles.clear();
        }),
        spoil("one vertex", |body| cut(body, 1)),
        spoil("four vertices, all between the bones", |body| {
            cut(body, 4);
            body.weights.fill(vec![(0, 0.5), (1, 0.5)]);
        }),
        spoil("vertices without weights", |body| {
            body.weights.iter_mut().step_by(2).for_each(Vec::clear);
        }),
        spoil("no weights at all", |body| body.weights.fill(vec![])),
        spoil("bones without length", |body| {
            body.heads[1] = body.heads[0];
            *body = body.clone().with_lengths(0.0);
        }),
    ]
}

fn cut(body: &mut Body, vertices: usize) {
    body.points.truncate(vertices);
    body.weights.truncate(vertices);
    let is_there = |end: &i32| (*end as usize) < vertices;
    body.edges.retain(|edge| edge.iter().all(is_there));
    body.triangles.retain(|triangle| triangle.iter().all(is_there));
}

#[test]
fn any_faulty_mesh_gives_finite_results() {
    for (what, body) in spoilt() {
        for angle in [0.4, 2.0, std::f64::consts::PI] {
            require_finite(&body, &body.bent(&[(1, angle)]), what);
        }
    }
}

/// Limbs that meet, although some of their skin has no faces, no area or no edges.
#[test]
fn bad_meshes_may_meet() {
    let mut body = arms(0.115);
    let is_kept = |end: &i32| end % 5 != 0;
    body.triangles
        .retain(|triangle| triangle.iter().all(is_kept) || triangle[0] > 900);
    body.edges.retain(|edge| edge.iter().all(|end| end % 11 != 0));
    let position = body.points[1401];
    body.points[1400..1460].fill(position);
    let pose = body.bent(&[(1, 0.03), (3, -0.03)]);
    let points = |contacts| {
        let skin = body.elastic(|settings| settings.contacts = contacts);
        deformed(&skin, &pose, &body.relaxed())
    };
    assert!(gap(&points(true), &points(false)) > 1e-4, "nothing met");
    require_finite(&body, &pose, "limbs of bad skin");
}

#[test]
fn slack_may_end_anywhere() {
    let body = arm();
    let slack: Vec<f32> = (0..body.points.len()).map(|vertex| (vertex % 2) as f32).collect();
    let skin = body.elastic(|settings| {
        settings.slack_m.body = 0.01;
        settings.slack_m.vertices = Some(&slack);
    });
    for angle in [0.2, 2.0] {
        let points = deformed(&skin, &body.bent(&[(1, angle)]), &body.relaxed());
        assert!(points.as_flattened().iter().all(|number| number.is_finite()));
    }
}

#[test]
fn a_bone_may_shrink_to_nothing() {
    let body = arm();
    for scale in [0.0, 1e-6, 1e6] {
        let mut pose = body.bent(&[(1, 1.0)]);
        pose[1][..12].iter_mut().for_each(|number| *number *= scale);
        require_finite(&body, &pose, &format!("scaled by {scale}"));
    }
}
