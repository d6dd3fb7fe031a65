//! Benchmarks of the fit: a skin of ten closed meshes of 100,000 quads each, and 200 muscles under it.
//!
//! Measured in November 2026 on two free cores, `cargo bench -p sinew-core --bench fit`, medians of wall time:
//!
//! | benchmark | time |
//! |---|---|
//! | surface of ten meshes | 0.28 s |
//! | fit of 200 muscles | 0.30 s |
//! | both | 0.62 s |
//! | protrusions of 200 muscles (160,000 rays) | 0.50 s |
//! | transfer between meshes of 100,000 faces | 0.085 s |
#![allow(clippy::unwrap_used, missing_docs)]

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use divan::Bencher;
use glam::{DQuat, DVec3};
use sinew_core::TissueKind;
use sinew_core::fit::{
    PlacedTissue, Placement, PolygonMesh, Polygons, SkinSurface, SurfaceTransfer, fit_all, protrusion_m,
};

const MESHES: usize = 10;
const MUSCLES_PER_MESH: usize = 20;
const AROUND: usize = 250;
const RINGS: usize = 400;
/// Half the length of a limb, m.
const HALF_LENGTH_M: f64 = 0.3;
/// Radius of a limb, m.
const RADIUS_M: f64 = 0.08;

/// A mesh as Blender stores it.
struct RawMesh {
    points: Vec<[f32; 3]>,
    corners: Vec<i32>,
    face_offsets: Vec<i32>,
}

/// Limb number `index`, with bumps, along z: a closed tube of quads with polygons as ends.
fn limb(index: usize, around: usize, rings: usize) -> RawMesh {
    let middle = DVec3::new(0.12 * index as f64, 0.0, 0.0); // limbs overlap
    let mut points = vec![];
    for ring in 0..=rings {
        let along = 2.0 * ring as f64 / rings as f64 - 1.0;
        let relative_width = (1.0 - 0.95 * along * along).sqrt();
        for step in 0..around {
            let angle = TAU * step as f64 / around as f64;
            let bump = 1.0 + 0.1 * (3.0 * angle + 5.0 * along).sin() * (PI * along).cos();
            let across = DVec3::new(angle.cos(), angle.sin(), 0.0) * (RADIUS_M * relative_width * bump);
            let point = middle + across + DVec3::Z * (HALF_LENGTH_M * along);
            points.push(point.to_array().map(|number| number as f32));
        }
    }
    let at = |ring: usize, step: usize| (ring * around + step % around) as i32;
    let mut corners: Vec<i32> = vec![];
    let mut face_offsets = vec![0];
    for ring in 0..rings {
        for step in 0..around {
            corners.extend([
                at(ring, step),
                at(ring, step + 1),
                at(ring + 1, step + 1),
                at(ring + 1, step),
            ]);
            face_offsets.push(corners.len() as i32);
        }
    }
    corners.extend((0..around).rev().map(|step| at(0, step)));
    face_offsets.push(corners.len() as i32);
    corners.extend((0..around).map(|step| at(rings, step)));
    face_offsets.push(corners.len() as i32);
    RawMesh {
        points,
        corners,
        face_offsets,
    }
}

fn polygons(raw: &RawMesh) -> Polygons {
    Polygons::new(&PolygonMesh {
        points: &raw.points,
        corners: &raw.corners,
        face_offsets: &raw.face_offsets,
        to_space: None,
    })
    .unwrap()
}

static LIMBS: LazyLock<Vec<RawMesh>> =
    LazyLock::new(|| (0..MESHES).map(|index| limb(index, AROUND, RINGS)).collect());

fn surface() -> SkinSurface {
    let all: Vec<Polygons> = LIMBS.iter().map(polygons).collect();
    SkinSurface::new(&all.iter().collect::<Vec<_>>()).unwrap()
}

/// Muscles around each limb, some too thick and some protruding; every second one has a via point.
fn muscles() -> Vec<PlacedTissue> {
    let mut placements = vec![];
    for limb in 0..MESHES {
        for number in 0..MUSCLES_PER_MESH {
            let angle = TAU * number as f64 / MUSCLES_PER_MESH as f64;
            let along = 0.5 * HALF_LENGTH_M * (2.0 * number as f64 / MUSCLES_PER_MESH as f64 - 1.0);
            let outward = DVec3::new(angle.cos(), angle.sin(), 0.0);
            let centre = DVec3::new(0.12 * limb as f64, 0.0, along) + outward * (0.6 * RADIUS_M);
            let lean = DQuat::from_axis_angle(outward, 0.15 * (number % 3) as f64);
            let via_points = if number % 2 == 0 {
                vec![centre + outward * 0.01]
            } else {
                vec![]
            };
            placements.push(Placement {
                kind: TissueKind::Muscle,
                centre,
                rotation: lean * DQuat::from_rotation_z(angle),
                semi_axes: DVec3::new(0.015, 0.03, 0.1),
                origin_tendon_m: 0.02,
                insertion_tendon_m: 0.02,
                via_points,
            });
        }
    }
    placements
        .into_iter()
        .map(|at| PlacedTissue::new(at, || "muscle".to_owned()).unwrap())
        .collect()
}

#[divan::bench(sample_count = 10)]
fn surface_of_ten_meshes(bencher: Bencher) {
    LazyLock::force(&LIMBS);
    bencher.bench_local(surface);
}

#[divan::bench(sample_count = 10)]
fn fit_of_200_muscles(bencher: Bencher) {
    let (skin, muscles) = (surface(), muscles());
    let left_twins = vec![None; muscles.len()];
    bencher.bench_local(|| fit_all(&muscles, &left_twins, &skin).unwrap());
}

#[divan::bench(sample_count = 10)]
fn whole_fit_over_ten_meshes(bencher: Bencher) {
    LazyLock::force(&LIMBS);
    let muscles = muscles();
    let left_twins = vec![None; muscles.len()];
    bencher.bench_local(|| fit_all(&muscles, &left_twins, &surface()).unwrap());
}

#[divan::bench(sample_count = 10)]
fn protrusions_of_200_muscles(bencher: Bencher) {
    let (skin, muscles) = (surface(), muscles());
    let fitted = fit_all(&muscles, &vec![None; muscles.len()], &skin).unwrap();
    bencher.bench_local(|| {
        fitted
            .iter()
            .map(|muscle| protrusion_m(muscle, &skin))
            .fold(0.0, f64::max)
    });
}

#[divan::bench(sample_count = 10)]
fn transfer_between_meshes_of_100_000_faces(bencher: Bencher) {
    let (old, new) = (polygons(&limb(0, AROUND, RINGS)), polygons(&limb(0, 240, 420)));
    bencher.bench_local(|| SurfaceTransfer::new(&old, &new, 0.01).unwrap());
}

fn main() {
    divan::main();
}
