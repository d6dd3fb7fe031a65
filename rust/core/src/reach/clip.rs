//! Reaching over a clip: all frames in one program, with a term that keeps the motion smooth
//! (mathematics/reach.md, Clips).

use super::panoc::{Panoc, Tolerance};
use super::program::{Program, Workspace};
use super::solve::{ReachOptions, Reached, Search, reach};
use crate::error::require_length;
use crate::error::{Error, Result, require};

/// Weight of the difference from the pose that a frame had on its own.
const KEEP_WEIGHT: f64 = 1e-5;
/// A change of an angle from frame to frame, rad, that is larger than any motion. It is a change to an
/// equivalent rotation vector.
const LARGEST_CHANGE_RAD: f64 = 2.0;
const TOLERANCE: Tolerance = Tolerance {
    step: 1e-6,
    steps: 400,
};

/// Settings of [`reach_clip`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClipOptions {
    /// For each frame on its own; restarts apply to the first frame.
    pub reach: ReachOptions,
    /// Weight of the squared second difference of the unknowns (angles over eagerness). 0: each frame is
    /// solved from the one before it only.
    pub smoothness: f64,
}

impl Default for ClipOptions {
    fn default() -> Self {
        Self {
            reach: ReachOptions::default(),
            smoothness: 0.01,
        }
    }
}

/// The poses of consecutive frames. `programs` has one program per frame, all of the same joints; each
/// prefers the pose of its linkage.
///
/// Each frame is first solved from the one before it, moved by the change of the preferred poses. Then all
/// frames are relaxed together.
///
/// # Errors
/// [`Error::Length`] if there are no frames or frames have different free angles; [`Error::Value`] for
/// options outside their limits.
pub fn reach_clip(programs: &[Program], options: &ClipOptions) -> Result<Vec<Reached>> {
    let smoothness = options.smoothness;
    let fits = smoothness.is_finite() && smoothness >= 0.0;
    require(
        fits,
        || "Reach".to_owned(),
        "the smoothness",
        smoothness,
        "finite, 0 or more",
    )?;
    let Some(first) = programs.first() else {
        return Err(Error::Length {
            list: "frames",
            expected: 1,
            reason: "at least",
            found: 0,
        });
    };
    for program in programs {
        require_length(
            "frames",
            first.len(),
            "free angles, as in the first frame",
            program.len(),
        )?;
    }
    let opening = reach(first, None, &options.reach)?;
    let mut unknowns = first.unknowns(&opening.angles);
    let mut evaluations = vec![opening.evaluations];
    for pair in programs.windows(2) {
        let preferred = [&pair[0], &pair[1]].map(|program| program.unknowns(&program.linkage().start()));
        let before = &unknowns[unknowns.len() - first.len()..];
        let start = before
            .iter()
            .zip(preferred[1].iter().zip(&preferred[0]))
            .map(|(at, (now, then))| at + now - then);
        let start: Vec<f64> = start.collect();
        let mut search = Search::new(&pair[1]);
        let minimum = search.descend_from(start, &preferred[1], options.reach.preference);
        unknowns.extend(minimum.unknowns);
        evaluations.push(search.evaluations);
    }
    if smoothness > 0.0 {
        relax(programs, &mut unknowns, smoothness);
    }
    let frames = programs.iter().zip(
        unknowns
            .chunks(first.len().max(1))
            .chain(std::iter::repeat(&[][..])),
    );
    Ok(frames
        .zip(evaluations)
        .map(|((program, unknowns), evaluations)| Reached::at(program, unknowns, evaluations))
        .collect())
}

/// Relaxes all frames together, starting from the pose of each frame on its own.
fn relax(programs: &[Program], unknowns: &mut [f64], smoothness: f64) {
    let width = programs[0].len();
    let [mut lower, mut upper] = [vec![], vec![]];
    for [low, high] in programs.iter().map(Program::bounds) {
        lower.extend(low);
        upper.extend(high);
    }
    let kept = unknowns.to_vec();
    let mut workspaces: Vec<Workspace> = programs.iter().map(Program::workspace).collect();
    let mut scratch = vec![0.0; unknowns.len()];
    // a ball joint that rotates past half a turn continues with an equivalent rotation vector; that jump is
    // not smoothed
    let is_continuous = |index: usize| {
        let (joint, _) = programs[0].linkage().free_angles()[index % width];
        let moved = (kept[index] - kept[index - width]).abs();
        moved * programs[0].linkage().joints()[joint].eagerness < LARGEST_CHANGE_RAD
    };
    let smooth: Vec<usize> = (width..unknowns.len().saturating_sub(width))
        .filter(|&middle| is_continuous(middle) && is_continuous(middle + width))
        .collect();
    let mut solver = Panoc::new(unknowns.len(), TOLERANCE);
    solver.descend(unknowns, &[lower, upper], |at, gradient| {
        let gradient = gradient.unwrap_or(&mut scratch);
        let mut cost = 0.0;
        for (frame, (program, workspace)) in programs.iter().zip(&mut workspaces).enumerate() {
            let range = frame * width..(frame + 1) * width;
            cost += program.cost_in(workspace, &at[range.clone()], Some(&mut gradient[range]));
        }
        for (entry, (at, kept)) in gradient.iter_mut().zip(at.iter().zip(&kept)) {
            cost += KEEP_WEIGHT * (at - kept).powi(2);
            *entry += 2.0 * KEEP_WEIGHT * (at - kept);
        }
        for &middle in &smooth {
            let (before, after) = (middle - width, middle + width);
            let bend = at[before] - 2.0 * at[middle] + at[after];
            cost += smoothness * bend * bend;
            gradient[before] += 2.0 * smoothness * bend;
            gradient[middle] -= 4.0 * smoothness * bend;
            gradient[after] += 2.0 * smoothness * bend;
        }
        cost
    });
}
