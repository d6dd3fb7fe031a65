//! A skin grown over any tissues is a closed manifold of well-shaped faces, with their size
//! (mathematics/growing.md).

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::{DAffine3, DQuat, DVec3};
use proptest::prelude::*;
use sinew_core::{Error, GrowOptions, Progress, SkinBones, grow};

use super::fixtures::grown_ellipsoids::{
    Shape, area_and_volume, at, ball, grown, musculature, options, points, require_closed_manifold,
    require_sound, shapes, try_grow, upright,
};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn any_tissues_give_a_closed_manifold_of_well_shaped_faces(shapes in shapes(), options in options()) {
        let skin = grown(&shapes, &options);
        require_sound(&skin);
        if options.faces.is_none() {
            // within a voxel, except for rare needles whose points are drawn in by the smoothing of faces
            prop_assert!(skin.report.protrusion_m <= 1.1 * skin.report.voxel_m, "{:?}", skin.report);
        }
        if let Some(faces) = options.faces {
            prop_assert!(skin.quads.len() <= faces + faces / 4, "{} faces instead of {faces}", skin.quads.len());
        }
    }

    #[test]
    fn the_largest_piece_is_connected(shapes in shapes(), mut options in options()) {
        options.largest_only = true;
        let skin = grown(&shapes, &options);
        let euler = require_closed_manifold(&skin);
        prop_assert!(euler <= 2);
    }

    #[test]
    fn a_rigid_motion_gives_the_same_surface_to_a_voxel(
        shapes in shapes(),
        turn in prop::array::uniform3(-PI..PI),
        shift in prop::array::uniform3(-3.0..3.0),
    ) {
        let motion = DAffine3::from_rotation_translation(DQuat::from_scaled_axis(turn.into()), shift.into());
        // a layer over all tissues, so that nothing is thinner than a voxel
        let options = GrowOptions { thickness_m: 0.08, ..at(48) };
        let moved: Vec<Shape> = shapes
            .iter()
            .map(|shape| Shape(motion.transform_point3(shape.0), DQuat::from_scaled_axis(turn.into()) * shape.1, shape.2))
            .collect();
        let (still, moved) = (grown(&shapes, &options), grown(&moved, &options));
        let voxel_m = still.report.voxel_m.max(moved.report.voxel_m);
        // the filter works in voxels, so the groove of a finer lattice is filled less
        let depth = |point: DVec3, options: &GrowOptions| {
            shapes.iter().map(|shape| {
                let local = shape.1.inverse() * (point - shape.0);
                let on_it = sinew_core::nearest_on_ellipsoid(shape.2, local);
                let is_inside = (local / shape.2).length_squared() < 1.0;
                options.thickness_m + if is_inside { local.distance(on_it) } else { -local.distance(on_it) }
            }).fold(f64::NEG_INFINITY, f64::max)
        };
        let least = |points: Vec<DVec3>| points.into_iter().map(|point| depth(point, &options)).fold(f64::INFINITY, f64::min);
        let most = |points: Vec<DVec3>| points.into_iter().map(|point| depth(point, &options)).fold(f64::NEG_INFINITY, f64::max);
        let back: Vec<DVec3> = points(&moved).into_iter().map(|point| motion.inverse().transform_point3(point)).collect();
        let still = points(&still);
        prop_assert!((most(still.clone()) - most(back.clone())).abs() <= voxel_m);
        prop_assert!((least(still) - least(back)).abs() <= 5.0 * voxel_m);
    }

    #[test]
    fn symmetric_tissues_get_a_symmetric_skin(mut shapes in shapes(), mut options in options()) {
        let image = |shape: &Shape| {
            let DQuat { x, y, z, w } = shape.1;
            let flip = DVec3::new(-1.0, 1.0, 1.0);
            Shape(shape.0 * flip, DQuat::from_xyzw(x, -y, -z, w), shape.2)
        };
        shapes.extend(shapes.clone().iter().map(image));
        options.symmetric = true;
        let skin = grown(&shapes, &options);
        let lattice = |point: [f32; 3]| point.map(|at| (f64::from(at) * 1e4).round() as i64);
        let near: HashMap<_, _> = skin.points.iter().map(|&point| (lattice(point), point)).collect();
        for &[x, y, z] in &skin.points {
            let [i, j, k] = lattice([-x, y, z]);
            let steps = (-1..=1).flat_map(|a| (-1..=1).flat_map(move |b| (-1..=1).map(move |c| [i + a, j + b, k + c])));
            let found = steps.filter_map(|place| near.get(&place)).any(|other| {
                (other[0] + x).abs() < 1e-5 && (other[1] - y).abs() < 1e-5 && (other[2] - z).abs() < 1e-5
            });
            prop_assert!(found, "{:?} has no mirror image", [x, y, z]);
        }
    }
}

#[test]
fn area_and_volume_of_an_ellipsoid_converge_in_the_second_order() {
    let (a, b, c) = (0.5_f64, 0.3_f64, 0.2_f64);
    let volume = 4.0 / 3.0 * PI * a * b * c;
    // the integral of the surface element, by the midpoint rule
    let steps = 2000;
    let mut area = 0.0;
    for i in 0..steps {
        let theta = PI * (f64::from(i) + 0.5) / f64::from(steps);
        for j in 0..400 {
            let phi = 2.0 * PI * (f64::from(j) + 0.5) / 400.0;
            let n = DVec3::new(
                b * c * theta.sin() * phi.cos(),
                a * c * theta.sin() * phi.sin(),
                a * b * theta.cos(),
            );
            area += theta.sin() * n.length() * (PI / f64::from(steps)) * (2.0 * PI / 400.0);
        }
    }
    let turn = DQuat::from_scaled_axis(DVec3::new(0.3, 0.7, -0.4));
    let errors: Vec<_> = [16, 32, 64, 128]
        .map(|resolution| {
            let skin = grown(&[Shape(DVec3::ZERO, turn, DVec3::new(a, b, c))], &at(resolution));
            let found = area_and_volume(&skin);
            ((found.0 / area - 1.0).abs(), (found.1 / volume - 1.0).abs())
        })
        .to_vec();
    for pair in errors.windows(2) {
        // half the voxel size gives a quarter of the error; a third is required, since the position of the
        // lattice is random
        assert!(pair[1].0 < pair[0].0 / 3.0, "area: {errors:?}");
        assert!(pair[1].1 < pair[0].1 / 3.0, "volume: {errors:?}");
    }
    assert!(errors[3].0 < 1e-3 && errors[3].1 < 1e-3, "{errors:?}");
}

#[test]
fn thickness_is_added_outward() {
    let options = GrowOptions {
        thickness_m: 0.1,
        ..at(40)
    };
    let (_, volume) = area_and_volume(&grown(&[ball(0.0, 0.3)], &options));
    assert!((volume / (4.0 / 3.0 * PI * 0.4_f64.powi(3)) - 1.0).abs() < 0.01);
}

#[test]
fn too_fine_a_lattice_is_refused_with_the_memory_it_needs() {
    let limited = GrowOptions {
        memory_limit_bytes: 2e7,
        ..at(500)
    };
    let Err(Error::Memory {
        resolution,
        needed_mb,
        fits,
        ..
    }) = try_grow(&[ball(0.0, 0.4)], &limited)
    else {
        panic!("20 MB are a limit");
    };
    assert_eq!(resolution, 500);
    assert!((100..500).contains(&needed_mb), "{needed_mb}");
    let fitting = GrowOptions {
        memory_limit_bytes: 2e7,
        ..at(fits as u32)
    };
    assert!(try_grow(&[ball(0.0, 0.4)], &fitting).is_ok(), "{fits}");
}

#[test]
fn it_can_be_stopped() {
    let progress = Progress::default();
    progress.cancel();
    let musculature = musculature(&[ball(0.0, 0.4)]);
    let bones = SkinBones {
        lengths_m: &[0.1],
        weight_bones: &[0],
    };
    let stopped = grow(&musculature, &[0.0], bones, &at(40), &progress);
    assert!(matches!(stopped, Err(Error::Cancelled)));
    assert!(progress.done() < 0.5);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let shapes = [
        ball(-0.2, 0.3),
        upright([0.3, 0.1, 0.0], [0.4, 0.1, 0.05]),
        ball(0.5, 0.2),
    ];
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let options = GrowOptions {
            faces: Some(500),
            ..at(40)
        };
        let skin = pool.install(|| grown(&shapes, &options));
        (skin.points, skin.quads, skin.weights.weights, skin.weights.bones)
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn invalid_input_is_refused_by_name() {
    let refused = |change: fn(&mut GrowOptions)| {
        let mut options = at(20);
        change(&mut options);
        try_grow(&[ball(0.0, 0.4)], &options).unwrap_err().to_string()
    };
    assert!(refused(|options| options.resolution = 2).contains("the resolution"));
    assert!(refused(|options| options.thickness_m = -1.0).contains("the thickness"));
    assert!(refused(|options| options.decay = f64::NAN).contains("the decay"));
    assert!(refused(|options| options.radius = 9).contains("the radius"));
    assert!(refused(|options| options.faces = Some(3)).contains("the number of faces"));
    assert!(matches!(try_grow(&[], &at(20)), Err(Error::NoTissues)));
}
