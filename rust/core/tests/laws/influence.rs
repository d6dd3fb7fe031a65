//! Laws of influence weights: bounded, few, smooth; and laws of the modifier's map.

use glam::{DAffine3, DQuat, DVec3};
use sinew_core::{Anchoring, MotionSource, Musculature, Regional, RestMesh, Skin, SkinOptions, Skinning};

use super::fixtures::rig::{ALONG, AROUND, PLAIN, columns, deformed, edges, gap, no_tension, weights};

fn rows(skin: &Skin) -> Vec<Vec<f32>> {
    skin.tissue_weights()
        .chunks(skin.musculature().len())
        .map(<[f32]>::to_vec)
        .collect()
}

fn bound(anchoring: Anchoring, motion_source: MotionSource, falloff_m: f64) -> Vec<Vec<f32>> {
    rows(&PLAIN.skin(&SkinOptions {
        anchoring,
        motion_source,
        falloff_m,
        ..SkinOptions::default()
    }))
}

#[test]
fn blended_rows_sum_to_at_most_one_and_have_at_most_eight_entries() {
    for motion_source in [MotionSource::Swelling, MotionSource::Full] {
        for falloff_m in [0.0, 0.01, 0.03, 1.0] {
            let rows = bound(Anchoring::Blended, motion_source, falloff_m);
            assert!(
                rows.iter()
                    .flatten()
                    .all(|weight| (0.0..=1.0001).contains(weight))
            );
            assert!(rows.iter().all(|row| row.iter().sum::<f32>() <= 1.0001));
            assert!(
                rows.iter()
                    .all(|row| row.iter().filter(|weight| **weight > 0.0).count() <= 8)
            );
        }
    }
    let many = bound(Anchoring::Blended, MotionSource::Swelling, 0.03);
    assert!(
        many.iter()
            .any(|row| row.iter().filter(|weight| **weight > 0.01).count() > 1)
    );
}

#[test]
fn nearest_rows_have_one_entry() {
    let rows = bound(Anchoring::Nearest, MotionSource::Swelling, 0.03);
    assert!(
        rows.iter()
            .all(|row| row.iter().filter(|weight| **weight > 0.0).count() <= 1)
    );
    assert!(rows.iter().any(|row| row.iter().sum::<f32>() > 0.0));
}

#[test]
fn the_nearest_row_is_the_nearest_candidate() {
    let skin = PLAIN.skin(&SkinOptions {
        anchoring: Anchoring::Nearest,
        falloff_m: 1.0,
        ..SkinOptions::default()
    });
    let musculature = skin.musculature();
    for (vertex, row) in rows(&skin)
        .iter()
        .enumerate()
        .filter(|(vertex, _)| *vertex >= AROUND)
    {
        if vertex / AROUND == ALONG - 1 {
            continue;
        }
        let point = DVec3::from_array(PLAIN.points()[vertex].map(f64::from));
        // three bones in a row: the upper arm is not a candidate for vertices of the hand; for others
        // every tissue is
        let height = point.z;
        let candidates: Vec<usize> = if height > 0.68 {
            vec![0, 1, 2, 3, 5]
        } else {
            (0..6).collect()
        };
        let distance = |tissue: usize| distance_of(musculature, tissue, point).max(0.0);
        let best = candidates
            .into_iter()
            .min_by(|&a, &b| distance(a).total_cmp(&distance(b)))
            .unwrap();
        let chosen = row.iter().position(|&weight| weight > 0.0).unwrap();
        assert!(
            (distance(chosen) - distance(best)).abs() < 1e-12,
            "vertex {vertex}: {chosen} for {best}"
        );
    }
}

/// Distance of a point from a tissue: from its nearest carrier, m.
fn distance_of(musculature: &Musculature, tissue: usize, point: DVec3) -> f64 {
    let carriers = musculature.carriers().iter().enumerate();
    let carriers = carriers.filter(|(_, carrier)| carrier.tissue == tissue);
    carriers
        .map(|(carrier, _)| musculature.nearest(carrier, point).distance_m)
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn influence_is_exactly_zero_at_the_falloff() {
    let skin = PLAIN.skin(&SkinOptions {
        anchoring: Anchoring::Nearest,
        falloff_m: 0.02,
        ..SkinOptions::default()
    });
    let musculature = skin.musculature();
    let (mut outside, mut inside) = (0, 0);
    for (vertex, row) in rows(&skin).iter().enumerate() {
        let point = DVec3::from_array(PLAIN.points()[vertex].map(f64::from));
        let distance_m = (0..musculature.len())
            .map(|tissue| distance_of(musculature, tissue, point))
            .fold(f64::INFINITY, f64::min);
        if distance_m >= 0.02 {
            assert_eq!(row.iter().sum::<f32>(), 0.0);
            outside += 1;
        } else if distance_m < 0.01 && vertex / AROUND > 0 && vertex / AROUND < ALONG - 10 {
            assert!(row.iter().sum::<f32>() >= 0.49);
            inside += 1;
        }
    }
    assert!(outside > 0 && inside > 0);
}

#[test]
fn smoothing_keeps_neighbours_alike() {
    let blended = bound(Anchoring::Blended, MotionSource::Swelling, 0.03);
    let nearest = bound(Anchoring::Nearest, MotionSource::Swelling, 0.03);
    let step = |rows: &[Vec<f32>]| {
        let jump = |[a, b]: [i32; 2]| {
            let (a, b) = (&rows[a as usize], &rows[b as usize]);
            a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
        };
        edges().into_iter().map(jump).fold(0.0, f32::max)
    };
    assert!(step(&blended) < 0.35, "{}", step(&blended));
    assert!(step(&nearest) > step(&blended));
}

#[test]
fn repeated_and_degenerate_edges_change_nothing() {
    let (offsets, bones, fractions) = weights();
    let plain = edges();
    let mut odd = plain.clone();
    odd.extend(plain.iter().map(|&[a, b]| [b, a]));
    odd.extend((0..30).map(|vertex| [vertex, vertex]));
    let (points, identity) = (PLAIN.points(), columns(DAffine3::IDENTITY));
    let skin = |edges: &[[i32; 2]]| {
        let mesh = RestMesh {
            points: &points,
            edges,
            mesh_to_armature: &identity,
            weight_offsets: &offsets,
            weight_bones: &bones,
            weights: &fractions,
        };
        Skin::new(PLAIN.musculature(), &mesh, &SkinOptions::default())
            .unwrap()
            .tissue_weights()
    };
    assert_eq!(skin(&plain), skin(&odd));
    assert_ne!(skin(&plain), skin(&[]));
}

#[test]
fn linear_skinning_is_the_weighted_mean_of_the_bones() {
    let turns = [0.2, -0.9, 0.5].map(DQuat::from_rotation_x);
    let pose = PLAIN.pose(&turns, DAffine3::from_translation(DVec3::X));
    let skin = PLAIN.skin(&SkinOptions {
        muscle_influence: Regional::of_body(0.0),
        ..SkinOptions::default()
    });
    let (offsets, bones, fractions) = weights();
    let expected: Vec<[f32; 3]> = PLAIN
        .points()
        .iter()
        .enumerate()
        .map(|(vertex, point)| {
            let point = DVec3::from_array(point.map(f64::from));
            let row = offsets[vertex] as usize..offsets[vertex + 1] as usize;
            let sum: f64 = fractions[row.clone()].iter().copied().map(f64::from).sum();
            if sum == 0.0 {
                return point.as_vec3().to_array();
            }
            let blended = row.map(|entry| {
                let bone = bones[entry] as usize;
                let posed = DAffine3::from_mat4(glam::Mat4::from_cols_array(&pose[bone]).as_dmat4());
                let rest =
                    DAffine3::from_mat4(glam::Mat4::from_cols_array(&PLAIN.rest_pose()[bone]).as_dmat4());
                (posed * rest.inverse()).transform_point3(point) * f64::from(fractions[entry])
            });
            (blended.fold(DVec3::ZERO, |sum, next| sum + next) / sum)
                .as_vec3()
                .to_array()
        })
        .collect();
    assert!(gap(&expected, &deformed(&skin, &pose, &no_tension())) < 1e-6);
}

#[test]
fn dual_quaternions_keep_the_radius_of_a_twisted_tube() {
    let twist = DQuat::from_rotation_z(150f64.to_radians());
    let pose = PLAIN.pose(&[DQuat::IDENTITY, twist, DQuat::IDENTITY], DAffine3::IDENTITY);
    let thinnest = |skinning| {
        let skin = PLAIN.skin(&SkinOptions {
            skinning,
            muscle_influence: Regional::of_body(0.0),
            ..SkinOptions::default()
        });
        let positions = deformed(&skin, &pose, &no_tension());
        let ring = |ring: usize| {
            let positions = &positions[ring * AROUND..(ring + 1) * AROUND];
            let centre = positions
                .iter()
                .map(|position| DVec3::from_array(position.map(f64::from)))
                .sum::<DVec3>()
                / AROUND as f64;
            positions
                .iter()
                .map(|position| DVec3::from_array(position.map(f64::from)).distance(centre))
                .fold(f64::MAX, f64::min)
        };
        (10..22).map(ring).fold(f64::MAX, f64::min)
    };
    assert!(thinnest(Skinning::PreserveVolume) > 0.05);
    assert!(thinnest(Skinning::Linear) < 0.03);
}

#[test]
fn both_skinnings_agree_for_a_single_bone() {
    let turns = [0.7, 0.0, 0.0].map(DQuat::from_rotation_y);
    let scaled: Vec<_> = PLAIN.pose(&turns, DAffine3::from_scale(DVec3::new(1.0, 1.4, 0.7)));
    let blended = |skinning| {
        let skin = PLAIN.skin(&SkinOptions {
            skinning,
            muscle_influence: Regional::of_body(0.0),
            ..SkinOptions::default()
        });
        deformed(&skin, &scaled, &no_tension())
    };
    assert!(gap(&blended(Skinning::Linear), &blended(Skinning::PreserveVolume)) < 1e-6);
}

/// The rows of a limb cut in two pieces: rings 8 to 12, whose vertices have `fractions` of bones 1 and 0, and the
/// rest.
fn rows_of_pieces(
    fractions: [f32; 2],
    motion_source: MotionSource,
) -> (Vec<Vec<f32>>, std::ops::Range<usize>) {
    let piece = 8 * AROUND..13 * AROUND;
    let (whole_offsets, whole_bones, whole_weights) = weights();
    let (mut offsets, mut bones, mut shares) = (vec![0], vec![], vec![]);
    for vertex in 0..AROUND * ALONG {
        if piece.contains(&vertex) {
            bones.extend([1, 0]);
            shares.extend(fractions);
        } else {
            let row = whole_offsets[vertex] as usize..whole_offsets[vertex + 1] as usize;
            bones.extend(&whole_bones[row.clone()]);
            shares.extend(&whole_weights[row]);
        }
        offsets.push(bones.len() as i32);
    }
    let is_within = |&[a, b]: &[i32; 2]| piece.contains(&(a as usize)) == piece.contains(&(b as usize));
    let edges: Vec<[i32; 2]> = edges().into_iter().filter(is_within).collect();
    let (points, identity) = (PLAIN.points(), columns(DAffine3::IDENTITY));
    let mesh = RestMesh {
        points: &points,
        edges: &edges,
        mesh_to_armature: &identity,
        weight_offsets: &offsets,
        weight_bones: &bones,
        weights: &shares,
    };
    let options = SkinOptions {
        motion_source,
        ..SkinOptions::default()
    };
    (
        rows(&Skin::new(PLAIN.musculature(), &mesh, &options).unwrap()),
        piece,
    )
}

#[test]
fn a_piece_that_one_bone_moves_is_rigid() {
    let moved = |fractions, source| {
        let (rows, piece) = rows_of_pieces(fractions, source);
        let is_moved = |row: &Vec<f32>| row.iter().any(|&weight| weight > 0.0);
        let (inside, outside) = (
            &rows[piece.clone()],
            [&rows[..piece.start], &rows[piece.end..]].concat(),
        );
        (inside.iter().any(is_moved), outside.iter().any(is_moved))
    };
    assert_eq!(moved([0.8, 0.0], MotionSource::Swelling), (false, true));
    // a weight of 1/255 is what rounding leaves
    assert_eq!(moved([254.0, 1.0], MotionSource::Swelling), (false, true));
    assert_eq!(moved([0.9, 0.1], MotionSource::Swelling), (true, true));
    assert_eq!(moved([0.8, 0.0], MotionSource::Full), (true, true));
}
