//! Solving a reach: one pose, from the pose before.
//!
//! The preference shapes the pose in the first descent; the next ones prefer the pose found so far, with less and less weight
//! (a proximal-point iteration), so that what is left of the miss is the goals' own and each descent is well-conditioned.

use std::f64::consts::PI;

use glam::DVec3;

use super::panoc::{Tolerance, descend};
use super::program::{Program, Workspace};
use crate::error::require_length;
use crate::error::{Result, require};

/// A goal missed by less than this share of the linkage's size is reached.
const REACHED: f64 = 1e-5;
/// Weights of the preference in the descents, as shares of the first one; the last ones end what one descent left over.
const PREFERENCE_SCHEDULE: [f64; 12] = [1.0, 0.1, 0.01, 0.01, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
/// A restart must lower the cost to this share, or the pose stays: a pose that is as good is no reason to jump.
const WORTH_A_JUMP: f64 = 0.98;
/// The greatest change of an unknown by which a pose has not moved.
const STILL: f64 = 1e-4;
/// How far the nudge out of a singular pose goes, of the way to anywhere.
const NUDGE: f64 = 0.02;
/// Greatest weight of the preference in restarts.
const WEIGHT_ELSEWHERE: f64 = 1e-3;
/// Restarts are seeded by this alone: the same program gives the same bits.
const SEED: u64 = 0x5EED;
const TOLERANCE: Tolerance = Tolerance {
    step: 1e-6,
    steps: 120,
};

/// What a person can set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReachOptions {
    /// How much the preferred pose counts against the goals, 0 not at all. It shapes what the goals leave open.
    pub preference: f64,
    /// From how many other poses to try again where the goals are missed. 0 while dragging: nothing jumps.
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

/// A pose that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Reached {
    /// Three angles a joint, rad, within their limits.
    pub angles: Vec<DVec3>,
    /// How far each goal is missed: m for positions, rad for the others.
    pub residuals: Vec<f64>,
    /// What is left of the goals' cost.
    pub cost: f64,
    /// How often the cost was computed.
    pub evaluations: usize,
}

/// The pose that meets the goals of a program best, from the linkage's own pose on.
///
/// preferred: the pose that is kept to where the goals leave a choice, three angles a joint; the linkage's own for none.
/// Goals out of reach give the nearest pose.
///
/// # Errors
/// Another number of preferred angles than joints; a preference that is negative or not finite.
pub fn reach(program: &Program, preferred: Option<&[DVec3]>, options: &ReachOptions) -> Result<Reached> {
    let weight = options.preference;
    require(
        weight.is_finite() && weight >= 0.0,
        || "reach".to_owned(),
        "the preference",
        weight,
        "finite, 0 or more",
    )?;
    let start = program.linkage().start();
    let preferred = preferred.unwrap_or(&start);
    require_length("preferred", start.len(), "three angles a joint", preferred.len())?;
    let mut search = Search::new(program);
    let mut best = search.descend_from(program.unknowns(&start), &program.unknowns(preferred), weight);
    // a straight arm feels no pull along itself: a pose that did not move may only seem to be the best
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
        // what is preferred led to where the goals are missed: from elsewhere the way is free
        let place = search.restart_point(&best.unknowns, attempt);
        let other = search.descend_from(place.clone(), &place, weight.min(WEIGHT_ELSEWHERE));
        if other.cost < WORTH_A_JUMP * best.cost {
            best = other;
        }
    }
    Ok(Reached::at(program, &best.unknowns, search.evaluations))
}

impl Reached {
    /// The pose at some unknowns.
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

/// Looks for the best pose of a program.
pub(super) struct Search<'a, 'b> {
    program: &'a Program<'b>,
    bounds: [Vec<f64>; 2],
    workspace: Workspace,
    /// How often the cost was computed.
    pub evaluations: usize,
}

/// A local minimum.
pub(super) struct Found {
    pub unknowns: Vec<f64>,
    pub cost: f64,
}

impl<'a, 'b> Search<'a, 'b> {
    pub fn new(program: &'a Program<'b>) -> Self {
        Self {
            program,
            bounds: program.bounds(),
            workspace: program.workspace(),
            evaluations: 0,
        }
    }

    /// The local minimum of the goals' cost below `unknowns`; `preferred` with `weight` shapes what they leave open.
    pub fn descend_from(&mut self, mut unknowns: Vec<f64>, preferred: &[f64], weight: f64) -> Found {
        let mut preferred = preferred.to_vec();
        let mut cost = f64::INFINITY;
        for share in PREFERENCE_SCHEDULE {
            let (program, workspace, weight) = (self.program, &mut self.workspace, share * weight);
            self.evaluations += descend(&mut unknowns, &self.bounds, TOLERANCE, |at, gradient| {
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
        Found { unknowns, cost }
    }

    /// Another place to begin: first a nudge that leaves a straight, singular pose, then anywhere.
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
    for (place, (at, preferred)) in at.iter().zip(preferred).enumerate() {
        let away = at - preferred;
        total += weight * away * away;
        if let Some(gradient) = gradient.as_deref_mut() {
            gradient[place] += 2.0 * weight * away;
        }
    }
    total
}

/// Numbers 0..1 that look random and are the same each time (Steele, Lea, Flood 2014).
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
