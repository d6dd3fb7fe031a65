//! The change of a carrier's map from rest to a pose.

use std::f64::consts::SQRT_2;

use glam::{DMat3, DVec3, Mat3A, Vec3A};

use crate::math::smoothstep::smooth_step;
use crate::muscles::musculature::Carrier;
use crate::muscles::posing::TissueTransform;

/// Change of a width, over the width, up to which the skin does not move; it is faded in up to twice this. Poses are
/// f32, so bones that move alike change a muscle by up to 1e-5. It is 5 µm at 5 cm from a belly.
const ROUNDING: f64 = 1e-4;

/// Gain in width of a muscle at half of its rest length, the shortest at which it is taut: fibres shorten to about half of their
/// optimal length (Gordon, Huxley and Julian 1966). Beyond it flesh folds instead of thickening.
const TAUT: f64 = SQRT_2 - 1.0;
/// The same of a muscle that is also fully tense, which the skin approaches.
const TAUT_AND_TENSE: f64 = 0.69;

/// The map of a carrier in a pose, less its map at rest (mathematics/binding.md, Anchors and Motion
/// source).
#[derive(Debug, Clone, Copy)]
pub(crate) struct TissueChange {
    /// Change of the widths alone, as the change of the two axes across the belly in the pose; m per m.
    pub swelling: [Vec3A; 2],
    /// Change of the map of surface points (E of the formula).
    pub stretch: Mat3A,
    /// Change of the map of fat (T of the formula).
    pub turn: Mat3A,
    /// Displacement of the centre, m.
    pub shift: Vec3A,
}

impl TissueChange {
    pub const NONE: Self = Self {
        swelling: [Vec3A::ZERO; 2],
        stretch: Mat3A::ZERO,
        turn: Mat3A::ZERO,
        shift: Vec3A::ZERO,
    };

    pub fn new(posed: &TissueTransform, rest: &Carrier) -> Self {
        let narrow = |matrix: DMat3| Mat3A::from(matrix.as_mat3());
        Self {
            swelling: width_change(posed).map(|axis| axis.as_vec3a()),
            stretch: narrow(posed.stretch - rest.axes),
            turn: narrow(posed.turn - rest.axes),
            shift: (posed.centre - rest.centre).as_vec3a(),
        }
    }
}

/// The two columns of `σ R (S - 1)` across the belly. The change of length along the belly does not move
/// the skin, which the bones hold along a limb. Measured: with it the crease of a knee opened, and the
/// knee kept 0.766 of its volume at 140° instead of 0.787.
///
/// Up to [`ROUNDING`] it is exactly 0: where bones move alike, a tissue leaves the skin where the modifier puts
/// it, to the bit.
fn width_change(posed: &TissueTransform) -> [DVec3; 2] {
    let change = posed.stretch - posed.turn;
    let beyond_rounding = |axis: DVec3| axis * smooth_step(axis.length() / ROUNDING - 1.0);
    let scale = posed.turn.z_axis.length();
    // a bone scaled to nothing has no widths
    let not_slack = |axis: DVec3| {
        if scale > 0.0 {
            axis * not_slack(axis.length() / scale)
        } else {
            DVec3::ZERO
        }
    };
    [change.x_axis, change.y_axis].map(beyond_rounding).map(not_slack)
}

/// The part of a change of width by this fraction that shows. A muscle below about half of its rest length is slack.
fn not_slack(change: f64) -> f64 {
    if change <= TAUT {
        return 1.0;
    }
    let room = TAUT_AND_TENSE - TAUT;
    (TAUT + room * (1.0 - (-(change - TAUT) / room).exp())) / change
}
