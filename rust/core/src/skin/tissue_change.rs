//! What a pose does to the skin around one carrier.

use glam::{DMat3, DVec3, Mat3A, Vec3A};

use crate::muscles::musculature::Carrier;
use crate::muscles::posing::TissueTransform;

/// What a pose does to the skin around one carrier, less what is there at rest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TissueChange {
    /// Change of the widths alone, in the posed axes: what the two axes across the belly become longer by.
    pub swelling: [Vec3A; 2],
    /// Change of the map of surface points.
    pub stretch: Mat3A,
    /// Change of the map of fat.
    pub turn: Mat3A,
    /// Change of place, m.
    pub shift: Vec3A,
}

impl TissueChange {
    pub const NONE: Self = Self {
        swelling: [Vec3A::ZERO; 2],
        stretch: Mat3A::ZERO,
        turn: Mat3A::ZERO,
        shift: Vec3A::ZERO,
    };

    pub fn new(carry: &TissueTransform, rest: &Carrier) -> Self {
        let narrow = |matrix: DMat3| Mat3A::from(matrix.as_mat3());
        Self {
            swelling: widening(carry).map(|axis| axis.as_vec3a()),
            stretch: narrow(carry.stretch - rest.axes),
            turn: narrow(carry.turn - rest.axes),
            shift: (carry.centre - rest.centre).as_vec3a(),
        }
    }
}

/// The two columns of `σ R (S - 1)` across the belly. The bones hold the skin along a limb; taking it along with the ends of
/// the bellies as well opened the crook of the knee and lost volume: at 140° the body's knee kept 0.766 of it, without 0.787.
fn widening(carry: &TissueTransform) -> [DVec3; 2] {
    let change = carry.stretch - carry.turn;
    [change.x_axis, change.y_axis]
}
