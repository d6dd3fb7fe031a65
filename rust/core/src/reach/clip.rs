//! Reaching over a clip: all frames in one program, with a term that keeps the motion smooth from frame to frame.

use super::panoc::{Tolerance, descend};
use super::program::{Program, Workspace};
use super::solve::{ReachOptions, Reached, Search, reach};
use crate::error::require_length;
use crate::error::{Error, Result, require};

/// How much a frame keeps to the pose that it was given by itself.
const KEEPING: f64 = 1e-5;
/// A change of an angle from frame to frame, rad, that no motion makes.
const ANOTHER_NAME_RAD: f64 = 2.0;
const TOLERANCE: Tolerance = Tolerance {
    step: 1e-6,
    steps: 400,
};

/// What a person can set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClipOptions {
    /// For each frame by itself; restarts are for the first.
    pub reach: ReachOptions,
    /// How much the squared second difference of the angles (over their multipliers) counts against the goals; 0: each frame
    /// as it follows from the one before.
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

/// The poses of consecutive frames. `programs`: one a frame, of the same joints; what each prefers is its linkage's own pose.
///
/// Every frame is first solved from the one before, moved as the linkages' own poses moved; then all are relaxed together.
///
/// # Errors
/// No frames, frames with other freedoms than the first, options out of range.
pub fn reach_clip(programs: &[Program], options: &ClipOptions) -> Result<Vec<Reached>> {
    let smoothness = options.smoothness;
    let fits = smoothness.is_finite() && smoothness >= 0.0;
    require(
        fits,
        || "reach".to_owned(),
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
            "freedoms, as in the first frame",
            program.len(),
        )?;
    }
    let opening = reach(first, None, &options.reach)?;
    let mut unknowns = first.unknowns(&opening.angles);
    let mut evaluations = vec![opening.evaluations];
    for pair in programs.windows(2) {
        let own = [&pair[0], &pair[1]].map(|program| program.unknowns(&program.linkage().start()));
        let before = &unknowns[unknowns.len() - first.len()..];
        let start = before
            .iter()
            .zip(own[1].iter().zip(&own[0]))
            .map(|(at, (now, then))| at + now - then);
        let start: Vec<f64> = start.collect();
        let mut search = Search::new(&pair[1]);
        let found = search.descend_from(start, &own[1], options.reach.preference);
        unknowns.extend(found.unknowns);
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

/// Relaxes all frames together, from where each is by itself.
fn relax(programs: &[Program], unknowns: &mut [f64], smoothness: f64) {
    let width = programs[0].len();
    let [mut lower, mut upper] = [vec![], vec![]];
    for [low, high] in programs.iter().map(Program::bounds) {
        lower.extend(low);
        upper.extend(high);
    }
    let kept = unknowns.to_vec();
    let mut workspaces: Vec<Workspace> = programs.iter().map(Program::workspace).collect();
    let mut spare = vec![0.0; unknowns.len()];
    // a ball joint that turns on past half a turn has another name from then on, which is no jump to be smoothed
    let is_named_alike = |place: usize| {
        let (joint, _) = programs[0].linkage().freedoms()[place % width];
        let moved = (kept[place] - kept[place - width]).abs();
        moved * programs[0].linkage().joints()[joint].multiplier < ANOTHER_NAME_RAD
    };
    let smooth: Vec<usize> = (width..unknowns.len().saturating_sub(width))
        .filter(|&middle| is_named_alike(middle) && is_named_alike(middle + width))
        .collect();
    descend(unknowns, &[lower, upper], TOLERANCE, |at, gradient| {
        let gradient = gradient.unwrap_or(&mut spare);
        let mut cost = 0.0;
        for (frame, (program, workspace)) in programs.iter().zip(&mut workspaces).enumerate() {
            let own = frame * width..(frame + 1) * width;
            cost += program.cost_in(workspace, &at[own.clone()], Some(&mut gradient[own]));
        }
        for (entry, (at, kept)) in gradient.iter_mut().zip(at.iter().zip(&kept)) {
            cost += KEEPING * (at - kept).powi(2);
            *entry += 2.0 * KEEPING * (at - kept);
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
