//! What a grown skin keeps of its tissues: pieces, needles, grooves, bones (mathematics/growing.md).

use sinew_core::GrowOptions;

use super::fixtures::grown_ellipsoids::{
    area_and_volume, at, ball, grown, require_closed_manifold, require_sound, upright,
};

#[test]
fn one_tissue_is_one_piece_without_handles() {
    let skin = grown(&[ball(0.0, 0.4)], &at(24));
    require_sound(&skin);
    assert_eq!((skin.report.pieces, require_closed_manifold(&skin)), (1, 2));
    assert!(skin.report.thickened.is_empty());
}

#[test]
fn touching_tissues_are_one_piece_and_distant_ones_are_not() {
    let touching = grown(&[ball(-0.3, 0.3), ball(0.3, 0.3)], &at(40));
    assert_eq!(
        (touching.report.pieces, require_closed_manifold(&touching)),
        (1, 2)
    );
    let distant = [ball(-0.5, 0.3), ball(0.5, 0.2)];
    let both = grown(&distant, &at(40));
    assert_eq!((both.report.pieces, require_closed_manifold(&both)), (2, 4));
    let options = GrowOptions {
        largest_only: true,
        ..at(40)
    };
    let largest = grown(&distant, &options);
    assert_eq!(require_closed_manifold(&largest), 2);
    assert!(
        largest.points.iter().all(|point| point[0] < 0.0),
        "the larger one is at the left"
    );
}

#[test]
fn covered_tissues_and_cavities_leave_no_trace() {
    let outer = upright([0.0; 3], [0.5, 0.4, 0.3]);
    let nested = grown(&[outer, upright([0.05, 0.0, 0.0], [0.1; 3])], &at(40));
    assert_eq!(nested.points, grown(&[outer], &at(40)).points);
    // twelve balls around a cavity
    let golden = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let corners = (0..3).flat_map(|axis| {
        [(1.0, golden), (-1.0, golden), (1.0, -golden), (-1.0, -golden)].map(|(u, v)| {
            let mut corner = [0.0; 3];
            corner[(axis + 1) % 3] = u;
            corner[(axis + 2) % 3] = v;
            upright(corner, [1.25; 3])
        })
    });
    let hollow = grown(&corners.collect::<Vec<_>>(), &at(48));
    require_sound(&hollow);
    assert_eq!((hollow.report.pieces, require_closed_manifold(&hollow)), (1, 2));
}

#[test]
fn a_tissue_thinner_than_a_voxel_is_kept_and_reported() {
    let needle = upright([0.6, 0.01, 0.02], [0.6, 0.0004, 0.0007]);
    let skin = grown(&[ball(0.0, 0.2), needle], &at(30));
    require_sound(&skin);
    assert_eq!(skin.report.thickened, [1]);
    assert_eq!(skin.report.pieces, 1);
    let end = skin.points.iter().map(|point| point[0]).fold(0.0, f32::max);
    assert!(
        f64::from(end) > 1.2 - 3.0 * skin.report.voxel_m,
        "the needle ends at {end}"
    );
    // a tissue that others cover is not thickened
    let covered = grown(
        &[ball(0.0, 0.2), upright([0.0; 3], [0.1, 0.0004, 0.0007])],
        &at(30),
    );
    assert!(covered.report.thickened.is_empty());
}

#[test]
fn a_needle_is_kept_among_very_few_faces() {
    let needle = upright([0.0; 3], [0.002, 0.001, 0.7]);
    let options = GrowOptions {
        faces: Some(60),
        ..at(300)
    };
    let skin = grown(&[ball(0.0, 0.1), needle], &options);
    require_sound(&skin);
    assert_eq!(skin.report.pieces, 1);
    let length = skin.points.iter().map(|point| point[2]).fold(0.0, f32::max);
    assert!(
        f64::from(length) > 0.7 - 2.0 * skin.report.voxel_m,
        "the needle ends at {length}"
    );
}

#[test]
fn the_filter_fills_creases_and_loses_nothing() {
    let pair = [ball(-0.25, 0.3), ball(0.25, 0.3)];
    let volume = |smoothing| {
        let options = GrowOptions { smoothing, ..at(40) };
        area_and_volume(&grown(&pair, &options)).1
    };
    assert!(volume(0) < volume(5) && volume(5) < volume(20));
    // convex parts stay where they are with any amount of smoothing
    let far = |smoothing| {
        let options = GrowOptions { smoothing, ..at(40) };
        let skin = grown(&pair, &options);
        skin.points.iter().map(|point| point[0]).fold(0.0, f32::max)
    };
    assert!((far(0) - far(20)).abs() < 1e-3);
}

#[test]
fn a_vertex_follows_the_bones_of_the_tissues_near_it() {
    let skin = grown(&[ball(-0.4, 0.3), ball(0.4, 0.3)], &at(40));
    for (vertex, point) in skin.points.iter().enumerate() {
        let heaviest = skin.weights.bones[skin.weights.offsets[vertex] as usize];
        if point[0].abs() > 0.1 {
            assert_eq!(heaviest, i32::from(point[0] > 0.0), "at {point:?}");
        }
    }
}
