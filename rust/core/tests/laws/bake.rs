//! A few keys represent many poses within a stated error, and act nowhere else.

use proptest::prelude::*;
use rayon::ThreadPoolBuilder;
use sinew_core::bake::{CombinationKeys, ErrorMetric, Grid, KeptSamples, MotionKeys, Samples};

const VERTICES: usize = 5;
/// Rounding of sums of f64.
const ROUNDING_M: f64 = 1e-9;
const THRESHOLD_M: f64 = 1e-5;

type Shapes = Vec<[f32; 3]>;

/// Samples of a skin that moves in waves, at values with a distance of 1.
fn waves(samples: usize) -> impl Strategy<Value = Shapes> {
    let wave = (0.0..0.02_f32, 0.0..1.0_f32, 0.0..6.0_f32);
    prop::collection::vec(wave, 3 * VERTICES).prop_map(move |waves| {
        let entry = |sample: usize, wave: (f32, f32, f32)| wave.0 * (wave.1 * sample as f32 + wave.2).sin();
        (0..samples)
            .flat_map(|sample| {
                waves
                    .as_chunks::<3>()
                    .0
                    .iter()
                    .map(move |vertex| vertex.map(|wave| entry(sample, wave)))
                    .collect::<Vec<_>>()
            })
            .collect()
    })
}

fn numbers(count: usize) -> Vec<f64> {
    (0..count).map(|sample| sample as f64).collect()
}

fn kept(shapes: &[[f32; 3]], tolerance_m: f64, candidates: &[bool]) -> KeptSamples {
    let (at, tolerances_m) = (numbers(candidates.len()), vec![tolerance_m; candidates.len()]);
    let samples = Samples::new(VERTICES, shapes, ErrorMetric::Identity, &at, &tolerances_m).unwrap();
    samples.keep(candidates).unwrap()
}

/// The error of a sample, computed directly from the definition.
fn distance_m(shapes: &[[f32; 3]], kept: &KeptSamples, sample: usize) -> f64 {
    let entry = |shown: Option<usize>, vertex: usize, axis: usize| {
        shown.map_or(0.0, |shown| f64::from(shapes[shown * VERTICES + vertex][axis]))
    };
    let after = kept.indices.iter().position(|&place| place >= sample);
    let after = after.unwrap_or(kept.indices.len() - 1);
    let before = if kept.indices[after] > sample {
        after.saturating_sub(1)
    } else {
        after
    };
    let (from, to) = (kept.indices[before] as f64, kept.indices[after] as f64);
    let share = if to > from {
        (sample as f64 - from) / (to - from)
    } else {
        0.0
    };
    let of_vertex = |vertex: usize| {
        let away = |axis: usize| {
            let (a, b) = (
                entry(kept.shown[before], vertex, axis),
                entry(kept.shown[after], vertex, axis),
            );
            entry(Some(sample), vertex, axis) - (1.0 - share) * a - share * b
        };
        (0..3).map(|axis| away(axis).powi(2)).sum::<f64>().sqrt()
    };
    (0..VERTICES).map(of_vertex).fold(0.0, f64::max)
}

proptest! {
    #[test]
    fn the_stated_error_is_the_error_and_within_the_tolerance(
        shapes in waves(40), tolerance_m in 1e-4..1e-2,
    ) {
        let found = kept(&shapes, tolerance_m, &[true; 40]);
        for sample in 0..40 {
            prop_assert!((found.errors_m[sample] - distance_m(&shapes, &found, sample)).abs() < ROUNDING_M);
            prop_assert!(found.errors_m[sample] <= tolerance_m);
        }
    }

    #[test]
    fn only_candidates_are_kept_and_all_errors_are_stated(shapes in waves(21), tolerance_m in 1e-4..1e-3) {
        let candidates: Vec<bool> = (0..21).map(|sample| sample % 2 == 0).collect();
        let found = kept(&shapes, tolerance_m, &candidates);
        prop_assert!(found.indices.iter().all(|place| place % 2 == 0));
        for sample in 0..21 {
            prop_assert!((found.errors_m[sample] - distance_m(&shapes, &found, sample)).abs() < ROUNDING_M);
            prop_assert!(sample % 2 == 1 || found.errors_m[sample] <= tolerance_m);
        }
    }

    #[test]
    fn without_tolerance_nothing_is_lost(shapes in waves(12)) {
        let found = kept(&shapes, 0.0, &[true; 12]);
        prop_assert!(found.errors_m.iter().all(|&error_m| error_m == 0.0));
    }

    #[test]
    fn a_constant_motion_needs_one_shape(shape in waves(1), samples in 1..30_usize) {
        let shapes = shape.repeat(samples);
        let found = kept(&shapes, 0.0, &vec![true; samples]);
        prop_assert_eq!(found.indices.len(), 1);
        prop_assert!(found.errors_m.iter().all(|&error_m| error_m == 0.0));
    }

    #[test]
    fn a_straight_motion_needs_its_two_ends(shape in waves(1), samples in 3..30_usize) {
        // rounded coarsely, so that sums are exact
        let shape: Shapes = shape.iter().map(|entry| entry.map(|part| (part * 4096.0).round() / 4096.0)).collect();
        prop_assume!(shape.iter().any(|entry| *entry != [0.0; 3]));
        let shapes: Shapes = (0..samples)
            .flat_map(|sample| shape.iter().map(move |entry| entry.map(|part| part * (sample + 1) as f32)))
            .collect();
        let found = kept(&shapes, 1e-9, &vec![true; samples]);
        prop_assert_eq!(found.indices, vec![0, samples - 1]);
    }

    #[test]
    fn a_cycle_needs_its_shapes_once(shapes in waves(7), tolerance_m in 1e-4..1e-3) {
        let twice = [shapes.as_slice(), &shapes].concat();
        let (once, again) = (kept(&shapes, tolerance_m, &[true; 7]), kept(&twice, tolerance_m, &[true; 14]));
        let distinct = |found: &KeptSamples| {
            let mut shown: Vec<_> = found.shown.iter().flatten().collect();
            shown.sort_unstable();
            shown.dedup();
            shown.len()
        };
        // where two cycles meet, one more shape of the same cycle may be needed
        prop_assert!(distinct(&again) <= distinct(&once) + 7 - once.indices.len());
        prop_assert!(again.errors_m.iter().all(|&error_m| error_m <= tolerance_m));
    }

    #[test]
    fn any_number_of_threads_keeps_the_same(shapes in waves(30), tolerance_m in 1e-4..1e-2) {
        let on = |threads: usize| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| kept(&shapes, tolerance_m, &[true; 30]))
        };
        prop_assert_eq!(on(1), on(4));
    }
}

/// A motion from -`below` to `above` with the samples `shapes`, and 0 at rest.
fn motion(shapes: &[[f32; 3]], below: usize, tolerance_m: f64) -> (Vec<f64>, Shapes, MotionKeys) {
    let count = shapes.len() / VERTICES;
    let at: Vec<f64> = (0..count)
        .map(|sample| 0.1 * (sample as f64 - below as f64))
        .collect();
    let mut shapes = shapes.to_vec();
    shapes[below * VERTICES..][..VERTICES].fill([0.0; 3]);
    // the last vertex never moves
    shapes
        .chunks_exact_mut(VERTICES)
        .for_each(|shape| shape[VERTICES - 1] = [0.0; 3]);
    let tolerances_m = vec![tolerance_m; count];
    let samples = Samples::new(VERTICES, &shapes, ErrorMetric::Identity, &at, &tolerances_m).unwrap();
    let keys = MotionKeys::new(&samples, THRESHOLD_M).unwrap();
    (at, shapes, keys)
}

fn apart_m(shown: &[[f64; 3]], due: &[[f32; 3]]) -> f64 {
    let squares = shown.iter().zip(due).map(|(shown, due)| {
        let away = |axis: usize| (shown[axis] - f64::from(due[axis])).powi(2);
        (0..3).map(away).sum::<f64>()
    });
    squares.fold(0.0, f64::max).sqrt()
}

proptest! {
    #[test]
    fn at_its_own_angle_a_corrective_acts_alone(shapes in waves(31), below in 0..30_usize, tolerance_m in 1e-4..1e-2) {
        let (_, shapes, keys) = motion(&shapes, below, tolerance_m);
        prop_assert_eq!(keys.shown(0.0), vec![[0.0; 3]; VERTICES]);
        for ((&at, &place), own) in keys.at().iter().zip(keys.indices()).zip(keys.corrections()) {
            prop_assert_eq!(apart_m(&keys.shown(at), own), 0.0);
            prop_assert!(apart_m(&keys.shown(at), &shapes[place * VERTICES..][..VERTICES]) <= THRESHOLD_M);
        }
    }

    #[test]
    fn correctives_stay_within_the_tolerance_between(shapes in waves(31), below in 0..30_usize, tolerance_m in 1e-4..1e-2) {
        let (at, shapes, keys) = motion(&shapes, below, tolerance_m);
        let mut worst_m = 0.0_f64;
        for (place, &value) in at.iter().enumerate() {
            worst_m = worst_m.max(apart_m(&keys.shown(value), &shapes[place * VERTICES..][..VERTICES]));
        }
        prop_assert!(worst_m <= tolerance_m + THRESHOLD_M + ROUNDING_M);
        prop_assert!((worst_m - keys.error_at_m.max(keys.error_between_m)).abs() < ROUNDING_M);
    }

    #[test]
    fn a_corrective_is_zero_where_nothing_moves(shapes in waves(31), below in 0..30_usize) {
        let (_, _, keys) = motion(&shapes, below, 1e-3);
        for own in keys.corrections() {
            prop_assert_eq!(own[VERTICES - 1], [0.0; 3]);
            let long = |entry: &[f32; 3]| entry.iter().map(|part| f64::from(*part).powi(2)).sum::<f64>().sqrt();
            prop_assert!(own.iter().all(|entry| *entry == [0.0; 3] || long(entry) > THRESHOLD_M));
        }
    }

    #[test]
    fn beyond_its_range_a_joint_keeps_its_last_corrective(shapes in waves(11), below in 0..10_usize) {
        let (at, _, keys) = motion(&shapes, below, 1e-4);
        let (first, last) = (at[0], at[at.len() - 1]);
        prop_assert_eq!(keys.shown(first - 1.0), keys.shown(first));
        prop_assert_eq!(keys.shown(last + 1.0), keys.shown(last));
    }

    #[test]
    fn two_joints_are_exact_where_both_have_their_keys_and_untouched_where_one_rests(
        shapes in waves(9), both in waves(64), tolerance_m in 1e-4..5e-3, sign in prop::bool::ANY, most in 1..16_usize,
    ) {
        let (at, _, keys) = motion(&shapes, if sign { 0 } else { 8 }, tolerance_m);
        let beside: Vec<f64> = at.iter().copied().filter(|&value| value != 0.0).collect();
        let grid = Grid {
            first: &keys, second: &keys, first_at: &beside, second_at: &beside, corrections: &both, metric: ErrorMetric::Identity,
        };
        let found = CombinationKeys::new(grid, tolerance_m, THRESHOLD_M, most).unwrap();
        prop_assert!(found.corners.len() <= most);
        prop_assert!(found.error_at_m <= THRESHOLD_M);
        let mut worst_m = 0.0_f64;
        for (row, &first) in beside.iter().enumerate() {
            prop_assert!(found.weights(first, 0.0).iter().all(|&(_, weight)| weight == 0.0));
            prop_assert!(found.weights(0.0, first).iter().all(|&(_, weight)| weight == 0.0));
            for (column, &second) in beside.iter().enumerate() {
                let mut shown = keys.shown(first);
                for (sum, more) in shown.iter_mut().zip(keys.shown(second)) {
                    (0..3).for_each(|axis| sum[axis] += more[axis]);
                }
                for (key, weight) in found.weights(first, second) {
                    for (sum, own) in shown.iter_mut().zip(&found.corrections[key]) {
                        (0..3).for_each(|axis| sum[axis] += weight * f64::from(own[axis]));
                    }
                }
                worst_m = worst_m.max(apart_m(&shown, &both[(8 * row + column) * VERTICES..][..VERTICES]));
            }
        }
        // rounding of residuals in f32
        prop_assert!((worst_m - found.error_between_m.max(found.error_at_m)).abs() < 1e-8);
        prop_assert!(!found.corners.is_empty() || found.error_before_m <= tolerance_m || found.error_before_m <= THRESHOLD_M);
    }

    #[test]
    fn two_joints_that_only_add_up_need_no_key_for_both(shapes in waves(9), tolerance_m in 1e-4..5e-3) {
        let (at, _, keys) = motion(&shapes, 0, tolerance_m);
        let sums = at[1..].iter().flat_map(|&first| at[1..].iter().map(move |&second| (first, second)));
        let both: Shapes = sums
            .flat_map(|(first, second)| {
                let pairs = keys.shown(first).into_iter().zip(keys.shown(second));
                pairs.map(|(a, b)| std::array::from_fn(|axis| (a[axis] + b[axis]) as f32)).collect::<Vec<_>>()
            })
            .collect();
        let grid = Grid {
            first: &keys, second: &keys, first_at: &at[1..], second_at: &at[1..], corrections: &both, metric: ErrorMetric::Identity,
        };
        prop_assert!(CombinationKeys::new(grid, tolerance_m, THRESHOLD_M, 16).unwrap().corners.is_empty());
    }
}

#[test]
fn impossible_samples_are_refused() {
    let shapes = vec![[0.0; 3]; 2 * VERTICES];
    let refused = |at: &[f64], tolerances_m: &[f64]| {
        Samples::new(VERTICES, &shapes, ErrorMetric::Identity, at, tolerances_m).is_err()
    };
    assert!(!refused(&[0.0, 1.0], &[0.0, 0.0]));
    assert!(refused(&[1.0, 1.0], &[0.0, 0.0]));
    assert!(refused(&[0.0, 1.0], &[0.0, -1.0]));
    assert!(refused(&[0.0, 1.0], &[0.0]));
    assert!(refused(&[0.0], &[0.0]));
    let samples = Samples::new(VERTICES, &shapes, ErrorMetric::Identity, &[1.0, 2.0], &[0.1, 0.1]).unwrap();
    let message = MotionKeys::new(&samples, 0.0).unwrap_err().to_string();
    assert!(message.contains("rest pose"), "{message}");
    let rest = Samples::new(VERTICES, &shapes, ErrorMetric::Identity, &[0.0, 2.0], &[0.1, 0.1]).unwrap();
    let keys = MotionKeys::new(&rest, 0.0).unwrap();
    let grid = |first_at| Grid {
        first: &keys,
        second: &keys,
        first_at,
        second_at: &[1.0],
        corrections: &shapes,
        metric: ErrorMetric::Identity,
    };
    assert!(CombinationKeys::new(grid(&[-1.0, 1.0]), 0.1, 0.0, 4).is_err());
    assert!(CombinationKeys::new(grid(&[1.0]), 0.1, 0.0, 4).is_err());
    assert!(CombinationKeys::new(grid(&[1.0, 2.0]), 0.1, 0.0, 4).is_ok());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn keys_at_given_samples_show_these_samples(shapes in waves(9), first in 0..4usize, second in 5..9usize) {
        let at: Vec<f64> = (0..9).map(|sample| f64::from(sample) - 4.0).collect();
        let samples = Samples::new(VERTICES, &shapes, ErrorMetric::Identity, &at, &[0.0; 9]).unwrap();
        let keys = MotionKeys::at_samples(&samples, &[first, second], 0.0).unwrap();
        prop_assert_eq!(keys.at(), &[at[first], at[second]]);
        prop_assert!(keys.error_at_m < ROUNDING_M);
        for wrong in [vec![4], vec![second, first], vec![first, 9]] {
            prop_assert!(MotionKeys::at_samples(&samples, &wrong, 0.0).is_err());
        }
    }
}
