//! Law of determinism: the same bits on any number of threads and in any order of frames.

use glam::{DAffine3, DQuat};
use rayon::ThreadPoolBuilder;
use sinew_core::{MotionSource, SkinOptions, Skinning};

use super::rig::{PLAIN, corrected, deformed};

type Bits = (Vec<f32>, Vec<Vec<[f32; 3]>>);

fn frames(threads: usize, order: &[u32], options: &SkinOptions) -> Bits {
    let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let skin = PLAIN.skin(options);
        let mut results = vec![vec![]; order.len()];
        for &frame in order {
            let angle = 0.3 * f64::from(frame);
            let pose = PLAIN.pose(
                &[0.1, angle, -angle].map(DQuat::from_rotation_x),
                DAffine3::IDENTITY,
            );
            let tension = vec![0.1 * frame as f32; 6];
            let mut positions = deformed(&skin, &pose, &tension);
            positions.extend(corrected(&skin, &pose, &tension).0);
            results[frame as usize] = positions;
        }
        (skin.tissue_weights(), results)
    })
}

#[test]
fn any_number_of_threads_and_any_order_of_frames_give_the_same_bits() {
    for skinning in [Skinning::Linear, Skinning::PreserveVolume] {
        for motion_source in [MotionSource::Swelling, MotionSource::Full] {
            let options = SkinOptions {
                skinning,
                motion_source,
                ..SkinOptions::default()
            };
            let one = frames(1, &[0, 1, 2, 3, 4, 5], &options);
            assert_eq!(one, frames(2, &[5, 3, 1, 0, 2, 4], &options));
            assert_eq!(one, frames(8, &[4, 5, 0, 3, 2, 1], &options));
            assert_ne!(one.1[0], one.1[5]);
        }
    }
}

#[test]
fn one_skin_may_be_computed_from_many_threads_at_once() {
    let skin = PLAIN.skin(&SkinOptions::default());
    let pose = |turn: f64| PLAIN.pose(&[0.0, turn, 0.0].map(DQuat::from_rotation_x), DAffine3::IDENTITY);
    let expected: Vec<_> = (0..8)
        .map(|frame| deformed(&skin, &pose(f64::from(frame)), &[0.0; 6]))
        .collect();
    std::thread::scope(|scope| {
        for frame in 0..8 {
            let (skin, expected, pose) = (&skin, &expected, pose(f64::from(frame)));
            scope.spawn(move || {
                for _ in 0..20 {
                    assert_eq!(deformed(skin, &pose, &[0.0; 6]), expected[frame as usize]);
                }
            });
        }
    });
}
