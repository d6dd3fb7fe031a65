//! The rotations of a joint in which its skin is compared, and how much each comparison counts at any rotation
//! (mathematics/safeguard.md, Samples).

use std::f64::consts::{FRAC_PI_4, PI};

use glam::{DQuat, DVec3};

use crate::math::smoothstep::smooth_step;

/// Angles that one sample covers, rad: 15°. In each it is compared at [`COMPARED`] rotations.
const COVERED: f64 = PI / 12.0;
pub(crate) const COMPARED: usize = 3;
/// Samples of one direction: up to a half turn.
const ANGLES: usize = 12;
/// Directions in which a bone swings: 45° from one to the next.
const SWINGS: usize = 8;
/// Directions in which a bone twists about its own axis.
const TWISTS: usize = 2;
/// Samples of a joint.
pub(crate) const SAMPLES: usize = (SWINGS + TWISTS) * ANGLES;
/// Most samples that count at one rotation: two angles of two swings, and two of a twist.
pub(crate) const MOST_COUNTED: usize = 6;
/// Rotation, as a fraction of [`COVERED`], at which the first sample starts to count, and the range to its full
/// weight. A joint that is nearly at rest needs no sample.
const COUNTS_FROM: f64 = 0.25;
const COUNTS_OVER: f64 = 0.5;

/// A sample that counts at a rotation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Counted {
    pub sample: u32,
    /// 0 to 1: 1 where the sample covers the rotation.
    pub weight: f32,
}

/// The rotations at which a sample is compared, in the axes of the bone, of which Y is along the bone. The last
/// angle that it covers is the first of the next.
pub(crate) fn compared(sample: usize) -> [DQuat; COMPARED] {
    std::array::from_fn(|index| {
        let first = if sample.is_multiple_of(ANGLES) { 1 } else { 0 }; // at rest there is nothing to compare
        let steps = (sample % ANGLES * COMPARED + index + first) as f64;
        in_direction(sample / ANGLES, steps * COVERED / COMPARED as f64)
    })
}

fn in_direction(direction: usize, angle: f64) -> DQuat {
    match direction {
        swing if swing < SWINGS => {
            let direction = swing as f64 * FRAC_PI_4;
            DQuat::from_axis_angle(DVec3::new(direction.cos(), 0.0, direction.sin()), angle)
        }
        twist if twist == SWINGS => DQuat::from_rotation_y(angle),
        _ => DQuat::from_rotation_y(-angle),
    }
}

/// Calls `count` with the samples that count at a rotation, at most [`MOST_COUNTED`].
pub(crate) fn counted(rotation: DQuat, mut count: impl FnMut(Counted)) {
    let rotation = if rotation.w < 0.0 { -rotation } else { rotation };
    let twist_angle = 2.0 * rotation.y.atan2(rotation.w);
    let swing = rotation * DQuat::from_rotation_y(-twist_angle);
    let swing_angle = 2.0 * swing.x.hypot(swing.z).atan2(swing.w.abs());
    let mut add = |direction: usize, weight: f64, angle: f64| {
        for (index, at_angle) in angles(angle) {
            if weight * at_angle > 0.0 {
                count(Counted {
                    sample: (direction * ANGLES + index) as u32,
                    weight: (weight * at_angle) as f32,
                });
            }
        }
    };
    let sign = if swing.w < 0.0 { -1.0 } else { 1.0 };
    let turns = ((sign * swing.z).atan2(sign * swing.x) / FRAC_PI_4).rem_euclid(SWINGS as f64);
    let (first, beyond) = (turns.floor(), turns.fract());
    add(first as usize % SWINGS, plateau(beyond), swing_angle);
    add((first as usize + 1) % SWINGS, plateau(1.0 - beyond), swing_angle);
    let twist = if twist_angle < 0.0 { SWINGS + 1 } else { SWINGS };
    add(twist, 1.0, twist_angle.abs());
}

/// The two samples that count at `angle`, as indices and weights: the one that covers it, and the nearer of its
/// neighbours.
fn angles(angle: f64) -> [(usize, f64); 2] {
    let samples = angle / COVERED;
    let covering = (samples.floor() as usize).min(ANGLES - 1);
    let beyond = samples - covering as f64;
    let weight = if covering == 0 {
        smooth_step((samples - COUNTS_FROM) / COUNTS_OVER)
    } else {
        1.0
    };
    let neighbour = if beyond < 0.5 {
        covering.checked_sub(1)
    } else {
        Some(covering + 1)
    };
    match neighbour.filter(|&neighbour| neighbour < ANGLES) {
        // falls to 0 where this sample is compared next: a blend can be worse than both
        Some(neighbour) => {
            let distance = if beyond < 0.5 { beyond } else { 1.0 - beyond };
            [
                (covering, weight),
                (neighbour, smooth_step(1.0 - COMPARED as f64 * distance)),
            ]
        }
        None => [(covering, weight), (covering, 0.0)],
    }
}

/// 1 up to half the distance to the next direction, then falling to 0 at the next.
fn plateau(distance: f64) -> f64 {
    smooth_step(2.0 * (1.0 - distance))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(rotation: DQuat) -> Vec<Counted> {
        let mut found = vec![];
        counted(rotation, |entry| found.push(entry));
        found
    }

    #[test]
    fn a_compared_rotation_counts_its_sample_fully() {
        for sample in 0..SAMPLES {
            for rotation in compared(sample) {
                let found = all(rotation);
                let is_own = |entry: &&Counted| entry.sample == sample as u32 && entry.weight > 0.999;
                let is_small = rotation.to_axis_angle().1 < 0.75 * COVERED;
                assert!(
                    is_small || found.iter().any(|entry| is_own(&entry)),
                    "{sample}: {found:?}"
                );
                let direction = sample / ANGLES;
                let others = found
                    .iter()
                    .filter(|entry| entry.sample as usize / ANGLES != direction);
                assert!(
                    others.clone().all(|entry| entry.weight < 1e-5),
                    "{sample}: {found:?}"
                );
            }
        }
    }

    #[test]
    fn some_sample_counts_fully_at_any_larger_rotation() {
        for degrees in 12..178 {
            for direction in 0..90 {
                let direction = (f64::from(direction) * 4.0).to_radians();
                let axis = DVec3::new(direction.cos(), 0.0, direction.sin());
                let found = all(DQuat::from_axis_angle(axis, f64::from(degrees).to_radians()));
                assert!(found.len() <= MOST_COUNTED);
                let largest = found.iter().map(|entry| entry.weight).fold(0.0, f32::max);
                assert!(largest > 0.999, "{degrees}: {found:?}");
            }
        }
        assert!(all(DQuat::IDENTITY).is_empty());
    }

    #[test]
    fn weights_are_continuous() {
        let weights = |rotation: DQuat| {
            let mut weights = [0.0_f32; SAMPLES];
            counted(rotation, |entry| weights[entry.sample as usize] += entry.weight);
            weights
        };
        let mut before: Option<[f32; SAMPLES]> = None;
        for step in 0..34_000 {
            let along = f64::from(step) * 1e-4;
            let (y, x, z) = (0.6 * along, 0.7 * along, 0.3 * (5.0 * along).sin());
            let now = weights(DQuat::from_euler(glam::EulerRot::YXZ, y, x, z));
            if let Some(before) = before {
                let jumps = now.iter().zip(before).map(|(now, before)| (now - before).abs());
                let jump = jumps.fold(0.0, f32::max);
                assert!(jump < 0.03, "at {along}: {jump}");
            }
            before = Some(now);
        }
    }
}
