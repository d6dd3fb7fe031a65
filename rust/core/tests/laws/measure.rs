//! The measurements are exact for cylinders and boxes, do not depend on position, and detect faults.

use std::f64::consts::{PI, TAU};

use glam::{DMat3, DQuat, DVec3};
use proptest::prelude::*;
use rayon::ThreadPoolBuilder;
use sinew_core::measure::{Motion, RestSurface, SkinQuality};

use super::fixtures::rig::rotations;

const AROUND: usize = 24;
const ALONG: usize = 31;
const RADIUS_M: f64 = 0.05;
const LENGTH_M: f64 = 0.4;
/// Accuracy of a volume from 200 x 200 rays.
const RAYS_TELL: f64 = 0.01;

type Triangles = Vec<[i32; 3]>;

fn narrow(points: &[DVec3]) -> Vec<[f32; 3]> {
    points.iter().map(|point| point.as_vec3().to_array()).collect()
}

/// A closed cylinder along z around the origin.
fn cylinder() -> (Vec<DVec3>, Triangles) {
    let mut points = vec![];
    for ring in 0..ALONG {
        let z = LENGTH_M * (ring as f64 / (ALONG - 1) as f64 - 0.5);
        for step in 0..AROUND {
            let (sin, cos) = (TAU * step as f64 / AROUND as f64).sin_cos();
            points.push(DVec3::new(RADIUS_M * cos, RADIUS_M * sin, z));
        }
    }
    points.extend([-0.5, 0.5].map(|end| DVec3::new(0.0, 0.0, end * LENGTH_M)));
    let at = |ring: usize, step: usize| (ring * AROUND + step % AROUND) as i32;
    let (bottom, top) = ((ALONG * AROUND) as i32, (ALONG * AROUND + 1) as i32);
    let mut triangles = vec![];
    for step in 0..AROUND {
        for ring in 0..ALONG - 1 {
            let [a, b] = [at(ring, step), at(ring, step + 1)];
            let [c, d] = [at(ring + 1, step + 1), at(ring + 1, step)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
        triangles.push([at(0, step + 1), at(0, step), bottom]);
        triangles.push([at(ALONG - 1, step), at(ALONG - 1, step + 1), top]);
    }
    (points, triangles)
}

/// Weight, 0..1, of the upper half at a point of the cylinder.
fn share(point: DVec3) -> f64 {
    let along = (0.5 + point.z / 0.2).clamp(0.0, 1.0);
    along * along * (3.0 - 2.0 * along)
}

/// Linear blend skinning of the two halves of the cylinder, each rotated by half of `angle` about an axis
/// through the origin.
fn skinned(points: &[DVec3], axis: DVec3, angle: f64) -> Vec<DVec3> {
    let [lower, upper] = [-0.5, 0.5].map(|half| DQuat::from_axis_angle(axis, half * angle));
    let place = |&point: &DVec3| (lower * point).lerp(upper * point, share(point));
    points.iter().map(place).collect()
}

fn boxes(apart: DVec3) -> (Vec<DVec3>, Triangles) {
    let corners =
        (0..8).map(|corner| DVec3::new((corner / 4) as f64, (corner / 2 % 2) as f64, (corner % 2) as f64));
    let one: Vec<DVec3> = corners.collect();
    #[rustfmt::skip]
    let faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let both = triangles
        .clone()
        .chain(triangles.map(|face| face.map(|corner| corner + 8)));
    let points = one
        .iter()
        .copied()
        .chain(one.iter().map(|&corner| corner + apart));
    (points.collect(), both.collect())
}

fn measured(rest: &[DVec3], posed: &[DVec3], triangles: &[[i32; 3]]) -> SkinQuality {
    let surface = RestSurface::new(&narrow(rest), triangles).unwrap();
    surface.quality(&surface.deformed(&narrow(posed)).unwrap(), &surface.whole())
}

fn near(found: f64, due: f64, tolerance: f64) -> bool {
    (found - due).abs() <= tolerance
}

#[test]
fn the_middle_of_a_cylinder_has_the_volume_that_a_prism_has() {
    let (points, triangles) = cylinder();
    let surface = RestSurface::new(&narrow(&points), &triangles).unwrap();
    let region = surface.region([0.0; 3], 0.1, None).unwrap().unwrap();
    let middles = region.faces().iter().map(|&face| {
        let corners = triangles[face as usize].map(|corner| points[corner as usize]);
        corners.iter().sum::<DVec3>() / 3.0
    });
    assert!(middles.clone().all(|middle| middle.length() < 0.1));
    // the boundary is jagged by a third of a ring, equally above and below
    let half = middles.map(|middle| middle.z.abs()).fold(0.0, f64::max) + LENGTH_M / (ALONG - 1) as f64 / 3.0;
    let section = 0.5 * AROUND as f64 * (TAU / AROUND as f64).sin() * RADIUS_M * RADIUS_M;
    assert!(near(region.rest_union() / (2.0 * half * section), 1.0, 0.03));
    assert!(section < PI * RADIUS_M * RADIUS_M);
    assert!(surface.region([9.0, 0.0, 0.0], 0.1, None).unwrap().is_none());
}

#[test]
fn only_carried_skin_belongs_to_a_region() {
    let (points, triangles) = cylinder();
    let surface = RestSurface::new(&narrow(&points), &triangles).unwrap();
    let upper: Vec<bool> = points.iter().map(|point| point.z > 0.001).collect();
    let both = surface.region([0.0; 3], 0.1, None).unwrap().unwrap();
    let one = surface.region([0.0; 3], 0.1, Some(&upper)).unwrap().unwrap();
    assert!(one.faces().len() < both.faces().len());
    assert!(one.faces().iter().all(|face| both.faces().contains(face)));
    assert!(surface.region([0.0; 3], 0.1, Some(&upper[1..])).is_err());
}

#[test]
fn two_boxes_that_meet_occupy_what_they_share_once() {
    let (rest, triangles) = boxes(DVec3::new(3.0, 0.2, 0.1));
    let (posed, _) = boxes(DVec3::new(0.5, 0.25, 0.5));
    let found = measured(&rest, &posed, &triangles);
    let shared = 0.5 * 0.75 * 0.5;
    assert!(near(found.union, (2.0 - shared) / 2.0, RAYS_TELL));
    assert!(near(found.overlap, shared / 2.0, RAYS_TELL));
    assert!(near(found.volume, 1.0, 1e-6) && found.inside_out == 0.0);
    assert!(found.new_intersections > 0);
    let apart = measured(&posed, &rest, &triangles);
    assert_eq!(apart.new_intersections, 0);
}

#[test]
fn an_intersection_at_rest_is_not_new() {
    let (rest, triangles) = boxes(DVec3::new(0.5, 0.25, 0.5));
    let surface = RestSurface::new(&narrow(&rest), &triangles).unwrap();
    assert!(surface.rest_intersection_count() > 0);
    assert_eq!(measured(&rest, &rest, &triangles).new_intersections, 0);
}

#[test]
fn a_surface_turned_inside_out_occupies_nothing() {
    let (rest, triangles) = cylinder();
    let mirrored: Vec<DVec3> = rest
        .iter()
        .map(|&point| point * DVec3::new(-1.0, 1.0, 1.0))
        .collect();
    let found = measured(&rest, &mirrored, &triangles);
    assert!(near(found.volume, -1.0, 1e-6));
    assert!(found.union == 0.0 && near(found.inside_out, 1.0, RAYS_TELL));
}

#[test]
fn a_twist_by_linear_skinning_loses_the_volume_that_the_integral_says() {
    let (rest, triangles) = cylinder();
    for angle in [0.5, 1.6, 2.6] {
        let found = measured(&rest, &skinned(&rest, DVec3::Z, angle), &triangles);
        let steps = 10_000;
        let kept = (0..steps).map(|step| {
            let own = share(DVec3::Z * LENGTH_M * ((f64::from(step) + 0.5) / f64::from(steps) - 0.5));
            1.0 - 4.0 * own * (1.0 - own) * (0.5 * angle).sin().powi(2)
        });
        // the cut cells of a twisted mesh add a term of second order
        assert!(near(found.volume, kept.sum::<f64>() / f64::from(steps), 0.02));
        assert!(near(found.union, found.volume, RAYS_TELL));
    }
}

#[test]
fn a_strongly_bent_tube_intersects_itself() {
    let (rest, triangles) = cylinder();
    assert_eq!(
        measured(&rest, &skinned(&rest, DVec3::X, 0.3), &triangles).new_intersections,
        0
    );
    let far = measured(&rest, &skinned(&rest, DVec3::X, 2.9), &triangles);
    assert!(far.new_intersections > 0 && far.bend_p99 > 30.0 && far.union < 0.95);
}

#[test]
fn a_vertex_pushed_across_a_sheet_inverts_the_faces_that_it_folds() {
    let side = 15;
    let place = |row: usize, column: usize| DVec3::new(0.01 * row as f64, 0.01 * column as f64, 0.0);
    let rest: Vec<DVec3> = (0..side * side).map(|at| place(at / side, at % side)).collect();
    let cells = (0..side - 1).flat_map(|row| (0..side - 1).map(move |column| (row * side + column) as i32));
    let down = side as i32;
    let triangles: Triangles = cells
        .flat_map(|a| [[a, a + down, a + down + 1], [a, a + down + 1, a + 1]])
        .collect();
    let mut posed = rest.clone();
    posed[7 * side + 7].x += 0.015;
    let folded = triangles.iter().filter(|triangle| {
        let [a, b, c] = triangle.map(|corner| posed[corner as usize]);
        (b - a).cross(c - a).z < 0.0
    });
    let due = folded.count();
    let turned: Vec<DVec3> = posed
        .iter()
        .map(|&point| DQuat::from_rotation_y(1.3) * point)
        .collect();
    let found = measured(&rest, &turned, &triangles);
    assert!(due > 0);
    assert_eq!(found.inverted, due);
    // a sheet has no volume to compare
    assert_eq!((found.union, found.volume), (1.0, 1.0));
}

#[test]
fn degenerate_meshes_give_finite_numbers() {
    let (mut rest, mut triangles) = cylinder();
    rest.push(DVec3::new(0.3, 0.3, 0.3)); // a loose vertex
    triangles.extend([[0, 0, 1], [5, 6, 5], [0, 1, 200], [0, 1, 300]]); // no area; an edge of four faces
    triangles.remove(100); // a hole
    rest[40] = rest[41]; // an edge without length
    let flat: Vec<DVec3> = rest.iter().map(|point| DVec3::new(point.x, 0.0, 0.0)).collect();
    let point = vec![DVec3::ZERO; rest.len()];
    for posed in [&rest, &flat, &point, &skinned(&rest, DVec3::X, PI)] {
        for (from, to) in [(&rest, posed), (posed, &rest)] {
            let found = measured(from, to, &triangles);
            #[rustfmt::skip]
            let numbers = [
                found.union, found.overlap, found.inside_out, found.unreadable, found.volume, found.edge.p50,
                found.edge.p99, found.edge.max, found.area_p99, found.bend_p99,
            ];
            assert!(numbers.iter().all(|number| number.is_finite()), "{found:?}");
        }
    }
    let alone = measured(&[DVec3::ONE], &[DVec3::ONE], &[]);
    assert_eq!((alone.union, alone.edge.max, alone.bend_p99), (1.0, 1.0, 0.0));
    assert!(RestSurface::new(&[], &[]).is_err());
    assert!(RestSurface::new(&[[0.0; 3]], &[[0, 0, 1]]).is_err());
}

#[test]
fn any_number_of_threads_gives_the_same_numbers() {
    let (rest, triangles) = cylinder();
    let posed = skinned(&rest, DVec3::X, 2.6);
    let on = |threads: usize| {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| measured(&rest, &posed, &triangles))
    };
    assert_eq!(on(1), on(2));
    assert_eq!(on(1), on(7));
}

/// Frames of points that rotate about x by a degree per frame.
fn turning(points: &[DVec3], frames: usize) -> Vec<[f32; 3]> {
    let turned = |frame: usize| {
        points
            .iter()
            .map(move |&point| DQuat::from_rotation_x((frame as f64).to_radians()) * point)
    };
    (0..frames)
        .flat_map(|frame| narrow(&turned(frame).collect::<Vec<_>>()))
        .collect()
}

#[test]
fn steady_motion_neither_jitters_nor_pops_and_a_jump_does() {
    let points = [DVec3::new(0.0, 0.5, 0.0), DVec3::new(0.1, 0.2, 0.3)];
    let frames = turning(&points, 40);
    let motion = |skin| Motion {
        vertices: 2,
        skin,
        reference: &frames,
        counted: None,
    };
    let (jitter, pop) = (motion(&frames).jitter(), motion(&frames).pop());
    let chord = 2.0 * (0.5_f64.to_radians()).sin();
    assert!(near(jitter.p99_m, 0.5 * chord * chord, 1e-6) && jitter.excess_p99_m == 0.0);
    assert!(near(pop.max_m, 0.5 * chord, 1e-6) && pop.excess_m == 0.0 && pop.persistence == 0.0);
    let mut jumping = frames.clone();
    for frame in 20..40 {
        jumping[2 * frame + 1][2] += 0.05;
    }
    let pop = motion(&jumping).pop();
    assert!(near(pop.excess_m, 0.05, 1e-6) && near(pop.persistence, 1.0, 1e-6));
    assert_eq!((pop.frame, pop.vertex), (19, 1));
    assert!(motion(&jumping).jitter().excess_p99_m > 0.01);
    let only_first = [true, false];
    let counted = Motion {
        counted: Some(&only_first),
        ..motion(&jumping)
    };
    assert_eq!(counted.pop().excess_m, 0.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_rigid_motion_changes_nothing(turn in rotations(3.1), shift in prop::array::uniform3(-2.0..2.0)) {
        let (rest, triangles) = cylinder();
        let moved: Vec<DVec3> = rest.iter().map(|&point| turn * point + DVec3::from_array(shift)).collect();
        let found = measured(&rest, &moved, &triangles);
        prop_assert!(near(found.volume, 1.0, 1e-4) && near(found.union, 1.0, RAYS_TELL));
        prop_assert!(near(found.edge.max, 1.0, 1e-3) && near(found.area_p99, 1.0, 1e-3));
        prop_assert!(found.bend_p99 < 0.05);
        prop_assert_eq!((found.inverted, found.new_intersections), (0, 0));
    }

    #[test]
    fn a_scale_stretches_edges_by_itself_faces_by_its_square_and_volume_by_its_cube(scale in 0.3..3.0) {
        let (rest, triangles) = cylinder();
        let scaled: Vec<DVec3> = rest.iter().map(|&point| scale * point).collect();
        let found = measured(&rest, &scaled, &triangles);
        let stretch = f64::max(scale, 1.0 / scale);
        prop_assert!(near(found.edge.p50, stretch, 1e-4 * stretch) && near(found.edge.max, stretch, 1e-4 * stretch));
        prop_assert!(near(found.area_p99 / stretch.powi(2), 1.0, 1e-3));
        prop_assert!(near(found.volume / scale.powi(3), 1.0, 1e-4));
        prop_assert!(near(found.union / scale.powi(3), 1.0, 1e-6));
    }

    #[test]
    fn the_mirror_image_has_the_same_numbers(turn in rotations(3.1), angle in 0.0..2.9) {
        let (rest, triangles) = cylinder();
        let rest: Vec<DVec3> = rest.iter().map(|&point| turn * point).collect();
        let posed = skinned(&rest, turn * DVec3::X, angle);
        let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
        let other = |points: &[DVec3]| points.iter().map(|&point| mirror * point).collect::<Vec<_>>();
        let flipped: Triangles = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        let (one, two) = (
            measured(&rest, &posed, &triangles),
            measured(&other(&rest), &other(&posed), &flipped),
        );
        prop_assert_eq!((one.inverted, one.new_intersections), (two.inverted, two.new_intersections));
        prop_assert!(near(one.edge.max, two.edge.max, 1e-9) && near(one.area_p99, two.area_p99, 1e-9));
        prop_assert!(near(one.bend_p99, two.bend_p99, 1e-6) && near(one.volume, two.volume, 1e-9));
        prop_assert!(near(one.union, two.union, RAYS_TELL) && near(one.overlap, two.overlap, RAYS_TELL));
    }
}
