//! Solving a reach: one pose, starting from the previous pose (mathematics/reach.md, Solver).
//!
//! In the first descent the preference shapes the pose. Each later descent prefers the pose found so far,
//! with decreasing weight (a proximal-point iteration). So the remaining residual is due to the goals only,
//! and each descent is well-conditioned.

use std::f64::consts::PI;

use glam::DVec3;

use super::panoc::{Panoc, Tolerance};
use super::program::{Program, Workspace};
use crate::error::require_length;
use crate::error::{Result, require};

/// A goal whose residual is below this fraction of the linkage's size is reached.
const REACHED: f64 = 1e-5;
/// Weights of the preference in successive descents, as fractions of the first. The last descents finish what
/// one did not.
const PREFERENCE_SCHEDULE: [f64; 12] = [1.0, 0.1, 0.01, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
/// A restart must lower the cost to this fraction; otherwise the pose stays, since a jump to an equally good
/// pose is undesirable.
const WORTH_A_JUMP: f64 = 0.98;
/// Largest change of an unknown in a pose that has not moved.
const STILL: f64 = 1e-4;
/// Length of the step out of a singular pose, as a fraction of the distance to a random pose.
const NUDGE: f64 = 0.02;
/// Largest weight of the preference in a restart.
const RESTART_PREFERENCE: f64 = 1e-3;
/// The seed of the restarts, constant so that the same program gives the same bits.
const SEED: u64 = 0x5EED;
const TOLERANCE: Tolerance = Tolerance {
    step: 1e-6,
    steps: 120,
};

/// Settings of [`reach`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReachOptions {
    /// Weight of the preferred pose against the goals, 0 or more. It decides what the goals leave open.
    pub preference: f64,
    /// Number of restarts from other poses if the goals are missed. 0 while dragging, so that nothing jumps.
    pub restarts: usize,
}

impl Default for ReachOptions {
    fn default() -> Self {
        Self {
            preference: 1e-3,
            restarts: 0,
        }
    }
}

/// The result of a reach.
#[derive(Debug, Clone, PartialEq)]
pub struct Reached {
    /// Three angles per joint, rad, within their limits.
    pub angles: Vec<DVec3>,
    /// The residual of each goal: m for positions, rad otherwise.
    pub residuals: Vec<f64>,
    /// The cost of the goals that remains.
    pub cost: f64,
    /// Number of evaluations of the cost.
    pub evaluations: usize,
}

/// The pose that meets the goals of a program best, starting from the pose of its linkage. If goals are out
/// of reach, the nearest pose.
///
/// `preferred`: the pose to keep where the goals leave a choice, three angles per joint, rad; `None` for the
/// pose of the linkage.
///
/// # Errors
/// [`crate::Error::Length`] for a number of preferred angles other than the number of joints;
/// [`crate::Error::Value`] for a preference that is negative or not finite.
pub fn reach(program: &Program, preferred: Option<&[DVec3]>, options: &ReachOptions) -> Result<Reached> {
    let weight = options.preference;
    require(
        weight.is_finite() && weight >= 0.0,
        || "Reach".to_owned(),
        "the preference",
        weight,
        "finite, 0 or more",
    )?;
    let start = program.linkage().start();
    let preferred = preferred.unwrap_or(&start);
    require_length(
        "preferred",
        start.len(),
        "three angles per joint",
        preferred.len(),
    )?;
    let mut search = Search::new(program);
    let mut best = search.descend_from(program.unknowns(&start), &program.unknowns(preferred), weight);
    // the gradient has no component along a straight arm: a pose that did not move may only seem optimal
    let start = program.unknowns(&start);
    let moved = best
        .unknowns
        .iter()
        .zip(&start)
        .any(|(now, then)| (now - then).abs() > STILL);
    for attempt in usize::from(moved)..=options.restarts {
        if best.cost.sqrt() <= REACHED {
            break;
        }
        // the preferred pose led to a local minimum, so a restart prefers its own start
        let start = search.restart_point(&best.unknowns, attempt);
        let second = search.descend_from(start.clone(), &start, weight.min(RESTART_PREFERENCE));
        if second.cost < WORTH_A_JUMP * best.cost {
            best = second;
        }
    }
    Ok(Reached::at(program, &best.unknowns, search.evaluations))
}

impl Reached {
    /// The result at `unknowns`.
    pub(super) fn at(program: &Program, unknowns: &[f64], evaluations: usize) -> Self {
        let angles = program.angles(unknowns);
        Self {
            residuals: program.residuals(&angles),
            angles,
            cost: program.cost_in(&mut program.workspace(), unknowns, None),
            evaluations,
        }
    }
}

/// A search for the best pose of a program.
pub(super) struct Search<'a, 'b> {
    program: &'a Program<'b>,
    bounds: [Vec<f64>; 2],
    workspace: Workspace,
    solver: Panoc,
    /// Number of evaluations of the cost.
    pub evaluations: usize,
}

/// A local minimum of the cost.
pub(super) struct Minimum {
    pub unknowns: Vec<f64>,
    pub cost: f64,
}

impl<'a, 'b> Search<'a, 'b> {
    pub fn new(program: &'a Program<'b>) -> Self {
        Self {
            program,
            bounds: program.bounds(),
            workspace: program.workspace(),
            solver: Panoc::new(program.len(), TOLERANCE),
            evaluations: 0,
        }
    }

    /// The local minimum of the goals' cost reached from `unknowns`. `preferred`, with `weight`, decides what
    /// the goals leave open.
    pub fn descend_from(&mut self, mut unknowns: Vec<f64>, preferred: &[f64], weight: f64) -> Minimum {
        let mut preferred = preferred.to_vec();
        let mut cost = f64::INFINITY;
        for factor in PREFERENCE_SCHEDULE {
            let (program, workspace, weight) = (self.program, &mut self.workspace, factor * weight);
            self.evaluations += self.solver.descend(&mut unknowns, &self.bounds, |at, gradient| {
                with_preference(weight, &preferred, at, gradient, |at, gradient| {
                    program.cost_in(workspace, at, gradient)
                })
            });
            let unwound = program.unwind(&mut unknowns);
            let now = program.cost_in(&mut self.workspace, &unknowns, None);
            self.evaluations += 1;
            let settled = now.sqrt() > cost.sqrt() - REACHED.max(1e-3 * cost.sqrt());
            cost = now;
            if (settled && !unwound) || cost.sqrt() <= 0.1 * REACHED {
                break;
            }
            preferred.copy_from_slice(&unknowns);
        }
        Minimum { unknowns, cost }
    }

    /// The start of a restart: for attempt 0 a small step out of a straight, singular pose, then random
    /// poses.
    fn restart_point(&self, from: &[f64], attempt: usize) -> Vec<f64> {
        let mut random = SplitMix(SEED.wrapping_add(attempt as u64));
        let [lower, upper] = &self.bounds;
        let each = from.iter().zip(lower.iter().zip(upper));
        each.map(|(&from, (&lower, &upper))| {
            let (lower, upper) = (lower.max(from - PI), upper.min(from + PI));
            let anywhere = lower + (upper - lower) * random.next();
            if attempt == 0 {
                from + NUDGE * (anywhere - from)
            } else {
                anywhere
            }
        })
        .collect()
    }
}

/// Adds `weight |at - preferred|²` to a cost and its gradient.
fn with_preference(
    weight: f64,
    preferred: &[f64],
    at: &[f64],
    mut gradient: Option<&mut [f64]>,
    cost: impl FnOnce(&[f64], Option<&mut [f64]>) -> f64,
) -> f64 {
    let mut total = cost(at, gradient.as_deref_mut());
    for (index, (at, preferred)) in at.iter().zip(preferred).enumerate() {
        let away = at - preferred;
        total += weight * away * away;
        if let Some(gradient) = gradient.as_deref_mut() {
            gradient[index] += 2.0 * weight * away;
        }
    }
    total
}

/// Reproducible pseudo-random numbers, 0..1 (Steele, Lea, Flood 2014).
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^= mixed >> 31;
        (mixed >> 11) as f64 / (1_u64 << 53) as f64
    }
}
